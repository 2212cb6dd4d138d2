#!/usr/bin/env python3
"""Independent, unbiased reference of the Cornell scene (see README.md).

    cornell_mitsuba.py path   [--spp N --seeds K --res R]   Mitsuba's own `path` integrator: the total
    cornell_mitsuba.py parts  [--spp N --seeds K --res R]   small Mitsuba/Dr.Jit integrator: direct, caustic, global
    cornell_mitsuba.py numpy  [--spp N --seeds K --res R]   path tracer in numpy alone, no Mitsuba: the parts again
    cornell_mitsuba.py check                                conventions: reflectances, mirror, emitter, orientation
    cornell_mitsuba.py merge  [--out cornell_reference.json]

Each of the first three writes one float64 image per seed into --work; `merge` makes the JSON of them.
"""
import argparse, glob, json, math, os, time
import numpy as np

LEFT = (0.570068, 0.0430135, 0.0443706)
RIGHT = (0.105421, 0.37798, 0.0764250)
WHITE = (0.885809, 0.698859, 0.666422)
LE = (18.4, 15.6, 8.0)
MIRROR = ((-0.45, 0.35, -0.35), 0.35)
GLASS = ((0.45, 0.35, 0.25), 0.35)
IOR = 1.5
LIGHT_Y, LIGHT_H = 1.99, 0.25
EYE, FOV_Y = (0.0, 1.0, 4.2), 35.0
PARTS = ("direct", "caustic", "global")
VARIANT = "llvm_ad_rgb"


# ------------------------------------------------------------------ Mitsuba

def mitsuba():
    global mi, dr                       # module globals: dr.syntax functions cannot see closures
    import mitsuba as mi
    mi.set_variant(VARIANT)
    import drjit as dr
    return mi


def scene_dict(res):
    T = mi.ScalarTransform4f

    def wall(rgb, origin, target, up):
        # `rectangle` spans [-1,1]^2 in its xy plane and its normal is +z: look_at puts +z towards target.
        return {"type": "rectangle", "to_world": T().look_at(origin=origin, target=target, up=up),
                "bsdf": {"type": "twosided", "inner": {"type": "diffuse", "reflectance": {"type": "rgb", "value": list(rgb)}}}}

    return {
        "type": "scene",
        "left": wall(LEFT, [-1, 1, 0], [0, 1, 0], [0, 1, 0]),
        "right": wall(RIGHT, [1, 1, 0], [0, 1, 0], [0, 1, 0]),
        "floor": wall(WHITE, [0, 0, 0], [0, 1, 0], [0, 0, 1]),
        "ceiling": wall(WHITE, [0, 2, 0], [0, 1, 0], [0, 0, 1]),
        "back": wall(WHITE, [0, 1, -1], [0, 1, 0], [0, 1, 0]),
        "mirror": {"type": "sphere", "center": list(MIRROR[0]), "radius": MIRROR[1],
                   "bsdf": {"type": "conductor", "material": "none"}},
        "glass": {"type": "sphere", "center": list(GLASS[0]), "radius": GLASS[1],
                  "bsdf": {"type": "dielectric", "int_ior": IOR, "ext_ior": 1.0}},
        "light": {"type": "rectangle",
                  "to_world": T().look_at(origin=[0, LIGHT_Y, 0], target=[0, 0, 0], up=[0, 0, 1])
                  @ T().scale([LIGHT_H, LIGHT_H, 1]),
                  "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}},
                  "emitter": {"type": "area", "radiance": {"type": "rgb", "value": list(LE)}}},
        "sensor": {"type": "perspective", "fov": FOV_Y, "fov_axis": "y", "near_clip": 0.01, "far_clip": 100.0,
                   "to_world": T().look_at(origin=list(EYE), target=[0, 1, 0], up=[0, 1, 0]),
                   "sampler": {"type": "independent"},
                   "film": {"type": "hdrfilm", "width": res, "height": res, "pixel_format": "rgb",
                            "component_format": "float32", "rfilter": {"type": "box"}}},
    }


def path_integrator():
    return mi.load_dict({"type": "path", "max_depth": -1, "rr_depth": 8, "hide_emitters": False})


def parts_integrator():
    """Path tracer that sorts its contributions; next-event estimation only, no MIS (light hit by a ray
    that left a diffuse surface is not counted: the light sample at that surface stands for it)."""
    class Parts(mi.SamplingIntegrator):
        def __init__(self, props=mi.Properties()):
            super().__init__(props)

        def aov_names(self):
            return [f"{p}.{c}" for p in PARTS for c in "RGB"]

        @dr.syntax
        def sample(self, scene, sampler, ray_, medium=None, active=True):
            ray = mi.Ray3f(dr.detach(ray_))
            ctx = mi.BSDFContext()
            active = mi.Bool(active)
            beta = mi.Spectrum(1.0)
            eta = mi.Float(1.0)
            depth = mi.UInt32(0)
            ndiff = mi.UInt32(0)            # diffuse bounces so far
            prev_spec = mi.Bool(True)       # last bounce specular (or camera)
            direct, caustic, glob = mi.Spectrum(0.0), mi.Spectrum(0.0), mi.Spectrum(0.0)
            while active:
                si = scene.ray_intersect(ray, ray_flags=mi.RayFlags.All, coherent=(depth == 0), active=active)
                active &= si.is_valid()
                bsdf = si.bsdf(ray)
                # emitter met: from the camera or through specular bounces only
                Le = dr.select(active & prev_spec, si.emitter(scene).eval(si, active), 0.0)
                direct += dr.select(ndiff == 0, beta * Le, 0.0)
                caustic += dr.select(ndiff == 1, beta * Le, 0.0)
                glob += dr.select(ndiff > 1, beta * Le, 0.0)
                # light sample
                smooth = active & mi.has_flag(bsdf.flags(), mi.BSDFFlags.Smooth)
                ds, w = scene.sample_emitter_direction(si, sampler.next_2d(), True, smooth)
                use = smooth & (ds.pdf != 0.0)
                f = bsdf.eval(ctx, si, si.to_local(ds.d), use)
                L = dr.select(use, beta * f * w, 0.0)
                direct += dr.select(ndiff == 0, L, 0.0)
                glob += dr.select(ndiff > 0, L, 0.0)
                # next direction
                bs, bw = bsdf.sample(ctx, si, sampler.next_1d(), sampler.next_2d(), active)
                ray = si.spawn_ray(si.to_world(bs.wo))
                beta *= bw
                eta *= bs.eta
                spec = mi.has_flag(bs.sampled_type, mi.BSDFFlags.Delta)
                ndiff += dr.select(active & ~spec, mi.UInt32(1), mi.UInt32(0))
                prev_spec = spec
                depth += 1
                bmax = dr.max(beta)
                active &= bmax > 0.0
                q = dr.minimum(bmax * eta * eta, 0.95)
                rr = depth >= 8
                live = sampler.next_1d() < q
                beta = dr.select(rr, beta / q, beta)
                active &= ~rr | live
            total = direct + caustic + glob
            return total, mi.Bool(True), [x for s in (direct, caustic, glob) for x in (s.x, s.y, s.z)]

    mi.register_integrator("parts", lambda props: Parts(props))
    return mi.load_dict({"type": "parts"})


def run_mitsuba(mode, a):
    mitsuba()
    scene = mi.load_dict(scene_dict(a.res), optimize=False)
    integ = path_integrator() if mode == "path" else parts_integrator()
    per = min(a.spp, max(1, (1 << 22) // (a.res * a.res)))      # samples of a render call: 4 M paths
    n = max(1, a.spp // per)
    for s in range(a.first, a.first + a.seeds):
        t, acc = time.time(), 0.0
        for k in range(n):
            seed = (1 if mode == "path" else 2) * 1000000 + s * 1000 + k
            img = np.array(mi.render(scene, integrator=integ, spp=per, seed=seed), dtype=np.float64)
            acc = acc + img
        acc = acc / n
        assert np.isfinite(acc).all()
        save(a, mode, s, per * n, acc if mode == "path" else acc[..., -9:])
        tot = acc[..., :3].mean((0, 1))
        print(mode, "seed", s, "spp", per * n, tot, f"{time.time() - t:.1f}s", flush=True)


def check(a):
    mitsuba()
    scene = mi.load_dict(scene_dict(128), optimize=False)
    print("mitsuba", mi.__version__, VARIANT)
    shapes = {s.id(): s for s in scene.shapes()}
    si = dr.zeros(mi.SurfaceInteraction3f)
    si.wi = mi.Vector3f(0, 0, 1)
    for n, want in (("left", LEFT), ("right", RIGHT), ("floor", WHITE), ("ceiling", WHITE), ("back", WHITE)):
        for z in (1.0, -1.0):
            si.wi = mi.Vector3f(0, 0, z)
            v = np.array(shapes[n].bsdf().eval(mi.BSDFContext(), si, mi.Vector3f(0, 0, z))).ravel() * math.pi
            assert np.allclose(v, want, rtol=1e-5), (n, v)
    print("wall reflectances: as given, on both sides")
    si.wi = mi.Vector3f(0.6, 0.0, 0.8)
    bs, w = shapes["mirror"].bsdf().sample(mi.BSDFContext(), si, 0.5, mi.Point2f(0.3, 0.7))
    assert np.allclose(np.array(w).ravel(), 1) and np.allclose(np.array(bs.wo).ravel(), [-0.6, 0, 0.8])
    print("mirror: weight", np.array(w).ravel())
    si.wi = mi.Vector3f(0, 0, 1)
    for u in (0.01, 0.5):
        bs, w = shapes["glass"].bsdf().sample(mi.BSDFContext(), si, u, mi.Point2f(0.3, 0.7))
        print("glass at normal incidence: pdf", np.array(bs.pdf), "eta", np.array(bs.eta), "weight", np.array(w).ravel())
    def first(o, d):
        r = scene.ray_intersect(mi.Ray3f(mi.Point3f(*o), mi.Vector3f(*d)))
        sh = r.shape if isinstance(r.shape, mi.Shape) else r.shape[0]
        return sh.id(), np.array(r.p).ravel(), np.array(r.n).ravel(), np.array(r.emitter(scene).eval(r)).ravel()
    for o, d in (((0, 1, 0), (-1, 0, 0)), ((0, 1, 0), (1, 0, 0)), ((0, 1, 0), (0, -1, 0)), ((.9, 1, .9), (0, 1, 0)),
                 ((0, 1, 0), (0, 0, -1)), ((0, 1, 0), (0, 1, 0)), ((0, 1.995, 0), (0, -1, 0)), ((.249, 1, .249), (0, 1, 0)),
                 ((.251, 1, .249), (0, 1, 0)), ((-1.5, 1, 0), (1, 0, 0))):
        print(o, d, "->", *first(o, d))
    img = np.array(mi.render(scene, integrator=path_integrator(), spp=512, seed=7))
    y, x = project((0, LIGHT_Y, 0), 128)
    print("pixel of the light", (y, x), img[y, x], "expected", LE)
    print("left edge of image", img[64, 4], "right edge", img[64, 123])
    assert np.allclose(img[y, x], LE, rtol=1e-4) and img[64, 4, 0] > 3 * img[64, 4, 1] and img[64, 123, 1] > img[64, 123, 0]
    png = (np.clip(img / (1 + img), 0, 1) * 1.5).clip(0, 1) ** (1 / 2.2)
    mi.Bitmap((png * 255).astype(np.uint8)).write("/tmp/mitsuba_cornell_check.png")


def project(p, res):
    h = math.tan(math.radians(FOV_Y) / 2) * (EYE[2] - p[2])
    return int((0.5 - (p[1] - EYE[1]) / (2 * h)) * res), int((0.5 + (p[0] - EYE[0]) / (2 * h)) * res)


# ------------------------------------------------------------------ numpy

def np_hit(o, d):
    """Nearest surface of each ray: (t, id); 0 left 1 right 2 floor 3 ceiling 4 back 5 light 6 mirror 7 glass, -1 none."""
    n = o.shape[1]
    best, idx = np.full(n, np.inf), np.full(n, -1, np.int8)
    with np.errstate(divide="ignore", invalid="ignore"):
        inv = 1.0 / d

    def take(t, ok, i):
        ok = ok & (t > 1e-7) & (t < best)
        best[ok] = t[ok]
        idx[ok] = i

    with np.errstate(invalid="ignore", over="ignore"):
        for i, (ax, c) in enumerate(((0, -1.), (0, 1.), (1, 0.), (1, 2.), (2, -1.), (1, LIGHT_Y))):
            t = (c - o[ax]) * inv[ax]
            ok = np.ones(n, bool)
            for b in range(3):
                if b != ax:
                    q = o[b] + t * d[b]
                    lo, hi = (0., 2.) if b == 1 else (-1., 1.)
                    if i == 5:
                        lo, hi = -LIGHT_H, LIGHT_H
                    ok &= (q >= lo) & (q <= hi)
            take(t, ok, i)
    for i, (c, r) in ((6, MIRROR), (7, GLASS)):
        oc = o - np.array(c)[:, None]
        b = (oc * d).sum(0)
        perp = oc - b * d
        disc = r * r - (perp * perp).sum(0)
        ok = disc > 0
        s = np.sqrt(np.where(ok, disc, 0))
        take(-b - s, ok, i)
        take(-b + s, ok, i)
    return best, idx


ALBEDO = np.array([LEFT, RIGHT, WHITE, WHITE, WHITE, (0, 0, 0), (1, 1, 1), (1, 1, 1)]).T
FLAT_N = np.array([(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, -1, 0)], float).T
AREA = (2 * LIGHT_H) ** 2
LEV = np.array(LE)[:, None]


def np_chunk(rng, res, reps):
    """`reps` paths through each pixel; sums [3 parts, rgb, res*res]."""
    npx = res * res
    pix = np.tile(np.arange(npx), reps)
    n = pix.size
    h = math.tan(math.radians(FOV_Y) / 2)
    sx = ((pix % res + rng.random(n)) / res * 2 - 1) * h
    sy = (1 - (pix // res + rng.random(n)) / res * 2) * h
    d = np.stack([sx, sy, -np.ones(n)])
    d /= np.sqrt((d * d).sum(0))
    o = np.repeat(np.array(EYE)[:, None], n, 1)
    beta = np.ones((3, n))
    nd = np.zeros(n, np.int32)
    spec = np.ones(n, bool)
    out = np.zeros((3, 3, npx))

    def add(part, sel_pix, val):
        for c in range(3):
            out[part, c] += np.bincount(sel_pix, val[c], npx)

    for depth in range(1000):
        if not pix.size:
            break
        t, idx = np_hit(o, d)
        # the light, met from below
        e = np.flatnonzero((idx == 5) & (d[1] > 0) & spec)
        for part in range(3):
            k = e[np.minimum(nd[e], 2) == part]
            add(part, pix[k], beta[:, k] * LEV)
        k = np.flatnonzero((idx >= 0) & (idx != 5))
        o, d, beta, nd, pix, idx, t = o[:, k], d[:, k], beta[:, k], nd[k], pix[k], idx[k], t[k]
        p = o + t * d
        nrm = FLAT_N[:, np.minimum(idx, 5)]
        for i, (c, r) in ((6, MIRROR), (7, GLASS)):
            m = idx == i
            nrm[:, m] = (p[:, m] - np.array(c)[:, None]) / r
        new_d = np.empty_like(d)
        # --- diffuse
        m = np.flatnonzero(idx < 5)
        if m.size:
            pm, nm = p[:, m], nrm[:, m]
            nm = np.where((nm * d[:, m]).sum(0) > 0, -nm, nm)
            beta[:, m] *= ALBEDO[:, idx[m]]
            l = np.stack([rng.uniform(-LIGHT_H, LIGHT_H, m.size), np.full(m.size, LIGHT_Y),
                          rng.uniform(-LIGHT_H, LIGHT_H, m.size)]) - pm
            r2 = (l * l).sum(0)
            r1 = np.sqrt(r2)
            w = l / r1
            g = np.maximum((w * nm).sum(0), 0) * np.maximum(w[1], 0) / r2 * AREA / math.pi
            c = np.flatnonzero(g > 0)
            ts, _ = np_hit(pm[:, c], w[:, c])
            c = c[ts > r1[c] * (1 - 1e-6)]
            val = beta[:, m[c]] * LEV * g[c]
            first = nd[m[c]] == 0
            add(0, pix[m[c[first]]], val[:, first])
            add(2, pix[m[c[~first]]], val[:, ~first])
            # cosine lobe: unit sphere point + normal
            z = rng.uniform(-1, 1, m.size)
            ph = rng.uniform(0, 2 * math.pi, m.size)
            s = np.sqrt(1 - z * z)
            nw = nm + np.stack([s * np.cos(ph), s * np.sin(ph), z])
            new_d[:, m] = nw / np.sqrt((nw * nw).sum(0))
            nd[m] += 1
        # --- mirror
        m = np.flatnonzero(idx == 6)
        new_d[:, m] = d[:, m] - 2 * (d[:, m] * nrm[:, m]).sum(0) * nrm[:, m]
        # --- glass: Fresnel, one of the two at random (the eta^2 of in and out cancel)
        m = np.flatnonzero(idx == 7)
        if m.size:
            dm, nm = d[:, m], nrm[:, m]
            ci = -(dm * nm).sum(0)
            ent = ci > 0
            nm = np.where(ent, nm, -nm)
            ci = np.abs(ci)
            k_ = np.where(ent, 1 / IOR, IOR)
            s2 = k_ * k_ * (1 - ci * ci)
            ct = np.sqrt(np.maximum(1 - s2, 0))
            rs = (k_ * ci - ct) / (k_ * ci + ct)
            rp = (ci - k_ * ct) / (ci + k_ * ct)
            F = np.where(s2 >= 1, 1.0, 0.5 * (rs * rs + rp * rp))
            refl = rng.random(m.size) < F
            new_d[:, m] = np.where(refl, dm + 2 * ci * nm, k_ * dm + (k_ * ci - ct) * nm)
        spec = idx >= 6
        o, d = p, new_d / np.sqrt((new_d * new_d).sum(0))
        if depth >= 3:
            q = np.minimum(beta.max(0), 0.95)
            live = rng.random(pix.size) < q
            beta /= q
            o, d, beta, nd, pix, spec = o[:, live], d[:, live], beta[:, live], nd[live], pix[live], spec[live]
    return out


def run_numpy(a):
    reps = max(1, 32768 // (a.res * a.res))
    n = max(1, a.spp // reps)
    for s in range(a.first, a.first + a.seeds):
        rng, t = np.random.default_rng([20240611, s]), time.time()
        acc = sum(np_chunk(rng, a.res, reps) for _ in range(n)) / (n * reps)
        assert np.isfinite(acc).all()
        save(a, "numpy", s, n * reps, acc.reshape(9, a.res, a.res).transpose(1, 2, 0))
        print("numpy seed", s, "spp", n * reps, acc.sum(0).mean(1), f"{time.time() - t:.1f}s", flush=True)


# ------------------------------------------------------------------ statistics

def save(a, mode, seed, spp, img):
    np.savez(os.path.join(a.work, f"{mode}_{seed:03d}.npz"), img=img, spp=spp)


def load(a, mode):
    f = sorted(glob.glob(os.path.join(a.work, f"{mode}_*.npz")))
    z = [np.load(x) for x in f]
    spp = {int(x["spp"]) for x in z}
    assert len(spp) <= 1, "seeds of unequal weight"
    return (np.stack([x["img"] for x in z]), spp.pop()) if z else (None, 0)


def stat(x):
    """mean and its standard error over axis 0 (independent seeds of equal weight)"""
    return x.mean(0), x.std(0, ddof=1) / math.sqrt(len(x))


def est(x, b=1):
    """Mean and standard error of b x b blocks of images x [seed, row, column, channel]. The samples of different
    pixels are independent, so the variance of a block's mean is taken from its pixels' variances between seeds:
    many more degrees of freedom than the scatter of a few seeds' block means has."""
    k, r = x.shape[:2]
    f = lambda v: v.reshape(b, r // b, b, r // b, -1).mean((1, 3))
    return f(x.mean(0)), np.sqrt(f(x.var(0, ddof=1)) / (k * (r // b) ** 2))


def pool(sets, b=1):
    """est() of independent sets of seeds [(x, spp per seed)], weighted by their samples"""
    n = np.array([len(x) * spp for x, spp in sets], float)
    w = n / n.sum()
    st = [est(x, b) for x, _ in sets]
    return sum(w_ * m for w_, (m, _) in zip(w, st)), np.sqrt(sum((w_ * e) ** 2 for w_, (_, e) in zip(w, st)))


def lst(x, nd=7):
    return [float(f"{v:.{nd}g}") for v in np.ravel(x)]


def ms(st):
    return {"mean": lst(st[0]), "se": lst(st[1], 3)}


def block_json(st):
    m, e = st
    return {"mean": [[lst(c, 6) for c in r] for r in m], "se": [[lst(c, 3) for c in r] for r in e]}


def parts_of(x):
    d = {p: ms(est(x[..., 3 * i:3 * i + 3])) for i, p in enumerate(PARTS)}
    d["total"] = ms(est(total(x)))
    return d


def total(x):
    return x[..., 0:3] + x[..., 3:6] + x[..., 6:9]


def compare(a_, b_, b=1):
    """z values of two independent sets of images"""
    (ma, ea), (mb, eb) = est(a_, b), est(b_, b)
    s = np.sqrt(ea ** 2 + eb ** 2)
    return np.where(s > 0, (ma - mb) / np.where(s > 0, s, 1), 0)


def merge(a):
    import mitsuba as mi
    path, spp = load(a, "path")
    res = path.shape[1]
    m, e = stat(path.mean((1, 2)))
    out = {
        "tool": "mitsuba", "version": mi.__version__, "variant": VARIANT, "integrator": "path, max_depth -1, rr_depth 8",
        "resolution": [res, res], "spp": spp * len(path), "spp_per_seed": spp, "seeds": len(path),
        "units": "linear RGB radiance, W/(sr m^2), box filter, no tonemapping",
        "mean_rgb": lst(m), "standard_error_rgb": lst(e, 3),
        "standard_error_rgb_from_pixels": lst(est(path)[1], 3),
        "se_made_by": "standard_error_rgb: scatter of the seeds' means; every other se: the pixels' variances between "
                      "seeds (pixels are independent)",
        "blocks_layout": "8x8 equal blocks of the image, [row from top][column from left][r,g,b]",
        "blocks": block_json(est(path, 8)),
        "quadrants": {},
    }
    h = res // 2
    for n, sl in (("top_left", np.s_[:, :h, :h]), ("top_right", np.s_[:, :h, h:]),
                  ("bottom_left", np.s_[:, h:, :h]), ("bottom_right", np.s_[:, h:, h:])):
        out["quadrants"][n] = ms(est(path[sl]))
    sets = {n: load(a, n) for n in ("parts", "numpy")}
    sets = {n: v for n, v in sets.items() if v[0] is not None}
    checks = {}

    def versus(name, x, y):
        z = compare(x, y, 8)
        z1 = z[z != 0]
        checks[name] = {"mean_z": lst(compare(x, y), 3),
                        "blocks_rms_z": float(f"{np.sqrt((z1 ** 2).mean()):.3g}"),
                        "blocks_max_abs_z": float(f"{np.abs(z1).max():.3g}")}

    names = {"parts": "parts_mitsuba", "numpy": "parts_numpy"}
    if sets:
        out["parts"], out["parts_blocks"] = {}, {}
        for i, p in enumerate(PARTS):
            x = [(v[..., 3 * i:3 * i + 3], n) for v, n in sets.values()]
            out["parts"][p] = ms(pool(x))
            out["parts_blocks"][p] = block_json(pool(x, 8))
        out["parts_made_by"] = "both tracers of cornell_mitsuba.py, pooled by their samples: " + ", ".join(names[n] for n in sets)
    for n, (v, spp_) in sets.items():
        assert v.shape[1] == res
        out[names[n]] = dict(parts_of(v), spp=spp_ * len(v), seeds=len(v))
        versus(f"path - {names[n]}, total", path, total(v))
    if len(sets) == 2:
        for i, p in enumerate(PARTS):
            c = np.s_[..., 3 * i:3 * i + 3]
            versus(f"parts_mitsuba - parts_numpy, {p}", sets["parts"][0][c], sets["numpy"][0][c])
    out["checks"] = checks
    with open(a.out, "w") as f:
        text = json.dumps(out, indent=1)
        # one line for each triple of numbers
        import re
        text = re.sub(r"\[\s*(-?[\d.e+-]+),\s*(-?[\d.e+-]+),\s*(-?[\d.e+-]+)\s*\]", r"[\1, \2, \3]", text)
        f.write(text + "\n")
    im, ie = stat(path)
    np.savez_compressed(a.out.replace(".json", f"_{res}.npz"), mean=im.astype(np.float32), se=ie.astype(np.float16))
    print("mean", m, "se", e, "rel", e / m)
    print(json.dumps({k: out.get(k) for k in ("parts", "parts_mitsuba", "parts_numpy", "checks")}, indent=None))
    try:
        mi.set_variant("scalar_rgb")
        png = ((im / (1 + im)) * 1.5).clip(0, 1) ** (1 / 2.2)
        mi.Bitmap(np.repeat(np.repeat((png * 255).astype(np.uint8), 6, 0), 6, 1)).write("/tmp/mitsuba_cornell.png")
    except Exception as ex:
        print("no png:", ex)


if __name__ == "__main__":
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument("mode", choices=["path", "parts", "numpy", "check", "merge"])
    ap.add_argument("--spp", type=int, default=2048, help="samples per pixel of one seed")
    ap.add_argument("--seeds", type=int, default=24)
    ap.add_argument("--first", type=int, default=0, help="first seed")
    ap.add_argument("--res", type=int, default=64)
    ap.add_argument("--work", default="/tmp/mitsuba_work")
    ap.add_argument("--out", default=os.path.join(os.path.dirname(os.path.abspath(__file__)), "cornell_reference.json"))
    a = ap.parse_args()
    os.makedirs(a.work, exist_ok=True)
    {"path": lambda: run_mitsuba("path", a), "parts": lambda: run_mitsuba("parts", a), "numpy": lambda: run_numpy(a),
     "check": lambda: check(a), "merge": lambda: merge(a)}[a.mode]()
