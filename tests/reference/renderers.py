#!/usr/bin/env python3
"""caustic beside Mitsuba 3 (path tracer) and Radiance (photon mapper): mean radiance of four scenes (see README.md).

    renderers.py --caustic target/release/caustic [--work DIR] [--out renderers.json] [SCENE ...]

Scenes of quads, spheres, matt, mirror and glass, area and point lights are read from the built-in scene files and written for the other two.
"""
import argparse, json, math, os, subprocess, sys, tempfile, tomllib
import numpy as np

RES = 64
SCENES = {"cornell": "cornell", "cornell without balls": "cornell", "cornell with matt balls": "cornell", "cornell with mirror balls": "cornell",
          "micro": "micro"}
MITSUBA_SEEDS, MITSUBA_SPP = 6, 256
CAUSTIC_SEEDS, CAUSTIC_PASSES = 4, 8
GLOBAL, CAUSTICS, K, GATHER = "500k", "300k", 100, 256


def read(name):
    root = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../..")
    path = os.path.join(root, "crates/renderer/scenes", SCENES[name] + ".toml")
    with open(path, "rb") as file:
        scene = tomllib.load(file)
    text = open(path).read()
    if name.endswith("without balls"):
        scene["spheres"] = []
        text = text[:text.index("[[spheres]]")]
        assert "[[quads]]" not in open(path).read()[len(text):], "spheres are the last"
    for ending, other in [("matt balls", "white"), ("mirror balls", "mirror")]:
        for ball in scene["spheres"] if name.endswith(ending) else []:
            text = text.replace(f'material = "{ball["material"]}"', f'material = "{other}"')
            ball["material"] = other
    return scene, text


# ------------------------------------------------------------------ caustic

def caustic(program, text, radius, work):
    path = os.path.join(work, "scene.toml")
    open(path, "w").write(text)
    pictures = []
    for seed in range(CAUSTIC_SEEDS):
        out = os.path.join(work, f"caustic{seed}.exr")
        subprocess.run([program, "render", path, "-o", out, "--size", f"{RES}x{RES}", "--integrator", "progressive", "--surface", "own",
                        "--radius", str(radius), "--passes", str(CAUSTIC_PASSES), "--spp", "16", "--seed", str(seed), "--quiet"], check=True)
        pictures.append(exr(out))
    return pictures


def exr(path):
    import mitsuba as mi
    return np.array(mi.Bitmap(path).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, srgb_gamma=False), dtype=np.float64)


# ------------------------------------------------------------------ Mitsuba

def mitsuba(scene):
    import mitsuba as mi
    T, camera = mi.ScalarTransform4f, scene["camera"]

    def bsdf(name):
        if name is None:
            return {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}}
        material = scene["materials"][name]
        if material["kind"] == "mirror":
            return {"type": "conductor", "material": "none"}
        if material["kind"] == "dielectric":
            return {"type": "dielectric", "int_ior": material["ior"], "ext_ior": 1.0}
        return {"type": "twosided", "inner": {"type": "diffuse", "reflectance": {"type": "rgb", "value": material["reflectance"]}}}

    low, high = np.array(camera["position"]), np.array(camera["target"])
    near = float(np.linalg.norm(high - low)) * 1e-3
    world = {"type": "scene", "sensor": {
        "type": "perspective", "fov": camera["vertical_fov_degrees"], "fov_axis": "y", "near_clip": near, "far_clip": near * 1e6,
        "to_world": T().look_at(origin=camera["position"], target=camera["target"], up=camera.get("up", [0, 1, 0])),
        "sampler": {"type": "independent"},
        "film": {"type": "hdrfilm", "width": RES, "height": RES, "pixel_format": "rgb", "component_format": "float32", "rfilter": {"type": "box"}}}}
    for i, quad in enumerate(scene.get("quads", [])):
        corner, u, v = (np.array(quad[key], dtype=float) for key in ("corner", "edge_u", "edge_v"))
        normal = np.cross(u, v)
        middle = corner + (u + v) / 2
        # A rectangle spans [-1, 1]² of its own plane.
        columns = np.stack([u / 2, v / 2, normal / np.linalg.norm(normal), middle], axis=1)
        shape = {"type": "rectangle", "to_world": T(np.vstack([columns, [0, 0, 0, 1]]).tolist()), "bsdf": bsdf(quad.get("material"))}
        if "radiance" in quad:
            shape["emitter"] = {"type": "area", "radiance": {"type": "rgb", "value": quad["radiance"]}}
        world[f"quad{i}"] = shape
    for i, ball in enumerate(scene.get("spheres", [])):
        world[f"ball{i}"] = {"type": "sphere", "center": ball["centre"], "radius": ball["radius"], "bsdf": bsdf(ball["material"])}
    for i, light in enumerate(scene.get("lights", [])):
        world[f"light{i}"] = {"type": "point", "position": light["position"], "intensity": {"type": "rgb", "value": light["intensity"]}}
    loaded = mi.load_dict(world)
    path = mi.load_dict({"type": "path", "max_depth": -1, "rr_depth": 8})
    return [np.array(mi.render(loaded, integrator=path, spp=MITSUBA_SPP, seed=seed), dtype=np.float64) for seed in range(MITSUBA_SEEDS)]


# ------------------------------------------------------------------ Radiance

def radiance(scene, work):
    import pyradiance
    tools = os.path.join(os.path.dirname(pyradiance.__file__), "bin")
    environment = {**os.environ, "RAYPATH": os.path.join(os.path.dirname(pyradiance.__file__), "lib")}
    run = lambda words, **more: subprocess.run([os.path.join(tools, words[0]), *map(str, words[1:])], cwd=work, env=environment, check=True, **more)
    numbers = lambda values: " ".join(f"{value:.9g}" for value in values)
    text = ""
    for name, material in scene["materials"].items():
        if material["kind"] == "mirror":
            text += f"void metal {name}\n0\n0\n5 1 1 1 1 0\n"
        elif material["kind"] == "dielectric":
            text += f"void dielectric {name}\n0\n0\n5 1 1 1 {material['ior']} 0\n"
        else:
            text += f"void plastic {name}\n0\n0\n5 {numbers(material['reflectance'])} 0 0\n"
    for i, quad in enumerate(scene.get("quads", [])):
        corner, u, v = (np.array(quad[key], dtype=float) for key in ("corner", "edge_u", "edge_v"))
        material = quad.get("material")
        if "radiance" in quad:
            material = f"glow{i}"
            text += f"void light {material}\n0\n0\n3 {numbers(quad['radiance'])}\n"
        text += f"{material} polygon quad{i}\n0\n0\n12 {numbers([*corner, *(corner + u), *(corner + u + v), *(corner + v)])}\n"
    for i, ball in enumerate(scene.get("spheres", [])):
        text += f"{ball['material']} sphere ball{i}\n0\n0\n4 {numbers([*ball['centre'], ball['radius']])}\n"
    for i, light in enumerate(scene.get("lights", [])):
        # No points there: a small ball of the same intensity.
        radius = 0.01
        text += f"void light point{i}\n0\n0\n3 {numbers(np.array(light['intensity']) / (math.pi * radius ** 2))}\n"
        text += f"point{i} sphere spot{i}\n0\n0\n4 {numbers([*light['position'], radius])}\n"
    open(os.path.join(work, "scene.rad"), "w").write(text)
    with open(os.path.join(work, "scene.oct"), "wb") as file:
        run(["oconv", "scene.rad"], stdout=file)
    balls = any(scene["materials"][ball["material"]]["kind"] != "lambertian" for ball in scene.get("spheres", []))
    maps = ["-apg", "global.pm", GLOBAL] + (["-apc", "caustic.pm", CAUSTICS] if balls else [])
    run(["mkpmap", "-fo+", *maps, "scene.oct"], stderr=subprocess.DEVNULL)
    camera = scene["camera"]
    towards = np.array(camera["target"], dtype=float) - np.array(camera["position"], dtype=float)
    fov = camera["vertical_fov_degrees"]
    view = ["-vtv", "-vp", *camera["position"], "-vd", *towards, "-vu", *camera.get("up", [0, 1, 0]), "-vh", fov, "-vv", fov]
    use = ["-ap", "global.pm", K] + (["-ap", "caustic.pm", K] if balls else [])
    exact = ["-ab", 1, "-ad", GATHER, "-as", 0, "-aa", 0, "-dt", 0, "-dc", 1, "-dj", 0.9, "-ds", 0.05, "-st", 0, "-lr", 12, "-lw", 1e-5, "-ps", 1, "-pj", 1]
    with open(os.path.join(work, "radiance.hdr"), "wb") as file:
        run(["rpict", *view, "-x", 2 * RES, "-y", 2 * RES, *use, *exact, "scene.oct"], stdout=file, stderr=subprocess.DEVNULL)
    return exr(os.path.join(work, "radiance.hdr"))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--caustic", required=True)
    parser.add_argument("--work")
    parser.add_argument("--out")
    parser.add_argument("scenes", nargs="*", default=list(SCENES))
    arguments = parser.parse_args()
    import mitsuba as mi
    mi.set_variant("scalar_rgb")
    work = arguments.work or tempfile.mkdtemp()
    os.makedirs(work, exist_ok=True)
    found = {}
    if arguments.out and os.path.exists(arguments.out):
        with open(arguments.out) as file:
            found = json.load(file)
    for name in arguments.scenes:
        scene, text = read(name)
        means = lambda pictures: np.array([picture.mean(axis=(0, 1)) for picture in pictures])
        error = lambda values: values.std(axis=0, ddof=1) / math.sqrt(len(values))
        truth, ours = means(mitsuba(scene)), means(caustic(os.path.abspath(arguments.caustic), text, scene["render"]["radius"], work))
        try:
            theirs = radiance(scene, work).mean(axis=(0, 1))
        except subprocess.CalledProcessError:
            # Its smallest distance is 10⁻⁶, of whatever unit.
            theirs = np.full(3, math.nan)
        row = {"mitsuba": truth.mean(axis=0), "mitsuba_se": error(truth), "caustic": ours.mean(axis=0), "caustic_se": error(ours), "radiance": theirs}
        row["caustic_over_mitsuba"], row["radiance_over_mitsuba"] = row["caustic"] / row["mitsuba"], theirs / row["mitsuba"]
        found[name] = {key: [None if math.isnan(x) else float(f"{x:.5g}") for x in value] for key, value in row.items()}
        print(name, found[name], flush=True)
    if arguments.out:
        with open(arguments.out, "w") as file:
            json.dump(found, file, indent=1)
            file.write("\n")


if __name__ == "__main__":
    sys.exit(main())
