//! Tests of models: what small files give, and that no file makes the reader panic, hang or take all memory.

use super::*;
use crate::scene::Scene;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::fs;
use std::path::PathBuf;

const PLY: &str = "ply\nformat ascii 1.0\ncomment a square\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
    element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";

const OBJ: &str = "mtllib none.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\n\
    usemtl red\nf 1/1/1 2/2/1 3/3/1 4/4/1\nf -4/1/1 -3/2/1 -2/3/1\n";

/// A square in the plane z = 0, twice as wide by its node, with a point light and a camera.
fn gltf_text(change: impl Fn(String) -> String) -> String {
    let mut bytes: Vec<u8> = [[0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]
        .iter()
        .flatten()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    bytes.extend([0u16, 1, 2, 0, 2, 3].iter().flat_map(|x| x.to_le_bytes()));
    change(format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0,1,2]}}],
        "nodes":[{{"mesh":0,"scale":[2,2,2]}},{{"camera":0,"translation":[0,0,5]}},
        {{"translation":[0,0,3],"extensions":{{"KHR_lights_punctual":{{"light":0}}}}}}],
        "extensionsUsed":["KHR_lights_punctual"],
        "extensions":{{"KHR_lights_punctual":{{"lights":[{{"type":"point","intensity":683}}]}}}},
        "cameras":[{{"type":"perspective","perspective":{{"yfov":0.5,"znear":0.1}}}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1,"material":0}}]}}],
        "materials":[{{"pbrMetallicRoughness":{{"baseColorFactor":[0.5,0.25,0.125,1],"metallicFactor":0}}}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}},
        {{"bufferView":1,"componentType":5123,"count":6,"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":12}}],
        "buffers":[{{"byteLength":{},"uri":"data:application/octet-stream;base64,{}"}}]}}"#,
        bytes.len(),
        STANDARD.encode(&bytes)
    ))
}

fn here() -> PathBuf {
    std::env::temp_dir().join(format!("caustic-no-such-folder-{}", std::process::id())).join("model")
}

#[test]
fn small_files_give_their_triangles() {
    let model = ply::read(PLY.as_bytes()).unwrap();
    assert_eq!(model.parts[0].triangles, [[0, 1, 2], [0, 2, 3]]);
    let model = obj::read(OBJ.as_bytes(), &here()).unwrap();
    assert_eq!(model.parts.iter().map(|part| part.triangles.len()).sum::<usize>(), 3);
    assert_eq!(model.parts[0].normals[0], DVec3::Z);
    assert_eq!(model.parts[0].uv[0], [0.0, 1.0], "v is turned round");
    assert!(model.left_out.iter().any(|what| what.contains("none.mtl")), "{:?}", model.left_out);
    let model = gltf::read(gltf_text(|text| text).as_bytes(), &here()).unwrap();
    assert_eq!(model.parts[0].triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(model.parts[0].positions[2], DVec3::new(2.0, 2.0, 0.0), "the node scales it");
    assert_eq!(model.finishes[0].base, DVec3::new(0.5, 0.25, 0.125));
    assert_eq!(model.points[0].intensity, DVec3::ONE, "683 lm/sr");
    assert_eq!((model.cameras[0].position, model.cameras[0].target), (DVec3::Z * 5.0, DVec3::Z * 4.0));
}

/// A picture of one pixel, (255, 128, 64, 192).
const PIXEL: &str = "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR4nGP43+BwAAAGwQKAz/YrcQAAAABJRU5ErkJggg==";

/// Pictures of normals and emission, an alpha that cuts and a transform of texture coordinates; and what is left out is said.
#[test]
fn materials_of_gltf_have_their_pictures() {
    let old = r#""materials":[{"pbrMetallicRoughness":{"baseColorFactor":[0.5,0.25,0.125,1],"metallicFactor":0}}]"#;
    let with = |material: &str| {
        let text = gltf_text(|text| {
            assert!(text.contains(old));
            let pictures = format!(
                r#""textures":[{{"source":0}}],"images":[{{"uri":"data:image/png;base64,{PIXEL}"}}],"materials":[{material}]"#
            );
            // Positions are coordinates of textures as well.
            let attributes = "\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":2}";
            let uv = r#"{"bufferView":0,"componentType":5126,"count":4,"type":"VEC2"}"#;
            text.replace(old, &pictures)
                .replace("\"attributes\":{\"POSITION\":0}", attributes)
                .replace("\"type\":\"SCALAR\"}]", &format!("\"type\":\"SCALAR\"}},{uv}]"))
                .replace("\"extensionsUsed\":[", "\"extensionsUsed\":[\"KHR_texture_transform\",")
        });
        gltf::read(text.as_bytes(), &here()).unwrap()
    };
    let turned =
        r#""extensions":{"KHR_texture_transform":{"offset":[0.5,0.25],"rotation":1.5707963705062866,"scale":[2,1]}}"#;
    let model = with(&format!(
        r#"{{"pbrMetallicRoughness":{{"baseColorFactor":[1,1,1,0.5],"baseColorTexture":{{"index":0,{turned}}}}},
        "normalTexture":{{"index":0,"scale":0.5}},"alphaMode":"MASK","alphaCutoff":0.25}}"#
    ));
    let finish = &model.finishes[0];
    assert_eq!((finish.picture.is_some(), finish.normal_picture.map(|(_, scale)| scale)), (true, Some(0.5)));
    // Linear light once, and numbers as they are.
    assert_eq!(model.pictures.len(), 2);
    assert_eq!((finish.cutoff, finish.pictures(&[7, 8]).cutoff), (0.5, 0.5), "the factor of ½ is in it");
    // (u, v) of the four corners are the first numbers of the points: (0, 0), (0, 1), … as floats follow each other.
    let [u, v] = model.parts[0].uv[1];
    assert!((u - 0.5 - 1.0).abs() < 1e-6 && (v - 0.25).abs() < 1e-6, "a quarter turn of (0, 1): {u}, {v}");
    let [u, v] = model.parts[0].uv[0];
    assert_eq!([u, v], [0.5, 0.25]);
    let model = with(r#"{"emissiveFactor":[1,1,0.5],"emissiveTexture":{"index":0},"alphaMode":"BLEND"}"#);
    assert_eq!(model.finishes[0].emission_picture, Some(0));
    assert!(model.left_out.iter().any(|what| what.contains("blends")), "{:?}", model.left_out);
    let model = with(
        r#"{"emissiveFactor":[1,1,0.5],"alphaMode":"MASK","pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}"#,
    );
    assert_eq!(model.finishes[0].cutoff, 0.0);
    assert!(model.left_out.iter().any(|what| what.contains("holes")), "{:?}", model.left_out);
    let model = with(r#"{"pbrMetallicRoughness":{"baseColorTexture":{"index":0,"texCoord":1}}}"#);
    assert_eq!(model.finishes[0].picture, None);
    assert!(model.left_out.iter().any(|what| what.contains("coordinates of their own")), "{:?}", model.left_out);
}

#[test]
fn a_mirrored_part_keeps_its_front() {
    let part = ply::read(PLY.as_bytes()).unwrap().parts.remove(0);
    let moved = part.moved(&DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0)));
    let [a, b, c] = moved.triangles[0].map(|index| moved.positions[index as usize]);
    assert!((b - a).cross(c - a).z > 0.0);
}

#[test]
fn what_is_wrong_is_said_in_a_sentence_with_a_remedy() {
    let ply = |from: &str, to: &str| ply::read(PLY.replacen(from, to, 1).as_bytes()).err();
    let gltf = |from: &str, to: &str| {
        let text = gltf_text(|text| {
            assert!(text.contains(from), "{from}");
            text.replacen(from, to, 1)
        });
        gltf::read(text.as_bytes(), &here()).err()
    };
    for (error, expected) in [
        (ply("4 0 1 2 3\n", ""), "is not a whole PLY file"),
        (ply("ply", "plx"), "is not a whole PLY file"),
        (ply("vertex 4", "vertex 99999999999"), "more than its bytes"),
        (ply("1 0 0", "1 0 zero"), "is not a whole PLY file"),
        (ply("property float z\n", "property float w\n"), "without `x`, `y` and `z`"),
        (gltf("\"version\":\"2.0\"", "\"version\":2"), "is not valid glTF 2.0"),
        (gltf("\"bufferView\":0", "\"bufferView\":7"), "is not valid glTF 2.0"),
        (gltf("\"byteLength\":48", "\"byteLength\":4800"), "reaches beyond"),
        (gltf("\"count\":4", "\"count\":4000000000"), "reach beyond"),
        (gltf("\"type\":\"VEC3\"", "\"type\":\"VEC2\""), "2 numbers each where 3 are wanted"),
        (gltf("base64,AAAA", "base64,A?AA"), "not base64"),
        (gltf("data:application/octet-stream;base64,", "missing.bin#"), "refers to the file `missing.bin#"),
        (gltf("\"scale\":[2,2,2]", "\"children\":[0]"), "nodes in a circle"),
        (
            gltf("\"extensionsUsed\"", "\"extensionsRequired\":[\"KHR_draco\"],\"extensionsUsed\""),
            "Unsupported extension",
        ),
        (gltf("\"scenes\":[{\"nodes\":[0,1,2]}],", ""), ""),
    ] {
        let error = error.unwrap_or_else(|| panic!("no error: {expected}"));
        assert!(error.contains(expected), "{error}\n  {expected}");
        assert!(!error.contains('\n') && error.len() < 500, "{error}");
    }
}

#[test]
fn a_model_is_a_scene_with_what_it_lacks_put_around_it() {
    let folder = std::env::temp_dir().join(format!("caustic-model-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let load = |name: &str, bytes: &[u8]| {
        let path = folder.join(name);
        fs::write(&path, bytes).unwrap();
        Scene::load(path.to_str().unwrap())
    };
    let scene = load("square.ply", PLY.as_bytes()).unwrap();
    let compiled = scene.compile();
    assert_eq!((compiled.info.primitives, compiled.info.lights), (3, 1), "a lamp was added");
    assert!(scene.notes.iter().any(|note| note.contains("lamp")), "{:?}", scene.notes);
    let scene = load("square.gltf", gltf_text(|text| text).as_bytes()).unwrap();
    assert_eq!((scene.compile().info.primitives, scene.compile().info.lights), (2, 1), "its own light");
    let far = PLY.replacen("1 0 0", "1e30 0 0", 1);
    for (name, bytes, expected) in [
        ("far.ply", far.as_bytes(), "is not from"),
        ("index.ply", PLY.replacen("4 0 1 2 3", "4 0 1 2 9", 1).as_bytes(), "has corner 9, but there are 4 points"),
        ("negative.ply", PLY.replacen("4 0 1 2 3", "4 0 1 2 -1", 1).as_bytes(), "but there are 4 points"),
        ("flat.ply", PLY.replace("1 1 0\n0 1 0", "2 0 0\n3 0 0").as_bytes(), "no triangle with an area"),
        ("none.obj", b"v 0 0 0\n", "has no triangles"),
        ("empty.glb", b"", "is not valid glTF"),
    ] {
        let error = load(name, bytes).unwrap_err().to_string();
        assert!(error.contains(expected) && error.contains(name) && !error.contains('\n'), "{error}\n  {expected}");
    }
    fs::remove_dir_all(&folder).unwrap();
}

/// Changed bytes: an error or a model, but no panic.
#[test]
fn no_bytes_make_a_reader_panic() {
    let mut state = 1u64;
    let mut random = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    let gltf_bytes = gltf_text(|text| text).into_bytes();
    let spare = b"0123456789-.e/[]{}\",: \n\0\xff";
    let mut read = [0; 3];
    for i in 0..6000 {
        let kind = i % 3;
        let mut bytes = [PLY.as_bytes(), OBJ.as_bytes(), &gltf_bytes][kind].to_vec();
        for _ in 0..=random(3) {
            let at = random(bytes.len());
            match random(4) {
                0 => bytes[at] = spare[random(spare.len())],
                1 => bytes.insert(at, spare[random(spare.len())]),
                2 => drop(bytes.drain(at..(at + 1 + random(20)).min(bytes.len()))),
                _ => bytes[at] ^= 1 << random(8),
            }
        }
        let model = match kind {
            0 => ply::read(&bytes),
            1 => obj::read(&bytes, &here()),
            _ => gltf::read(&bytes, &here()),
        };
        match model {
            Ok(model) => {
                read[kind] += 1;
                let _ = model.parts.iter().find_map(Part::fault);
            }
            Err(error) => assert!(!error.contains('\n'), "{error}"),
        }
    }
    assert!(read.iter().all(|&read| read > 20), "{read:?}");
}

/// A texel that is read back is sRGB's curve of the file's bytes, rounded to a half.
#[test]
fn a_picture_is_decoded_into_linear_light() {
    let mut png = Vec::new();
    let image = image::RgbImage::from_fn(256, 2, |x, y| image::Rgb([x as u8, 255 - x as u8, (y * 200) as u8]));
    image.write_to(&mut std::io::Cursor::new(&mut png), image::ImageFormat::Png).unwrap();
    let linear = picture::decode(&png, 0, true).unwrap();
    let data = picture::decode(&png, 0, false).unwrap();
    assert_eq!((linear.width, linear.height), (256, 2));
    for code in 0..256u32 {
        let expected = {
            let x = f64::from(code) / 255.0;
            if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
        };
        let read = |picture: &Picture| {
            f64::from(caustic_kernels::trace::half_to_f32(picture.texels[code as usize].rg & 0xffff))
        };
        assert!((read(&linear) - expected).abs() <= expected / 2048.0 + 1e-7, "{code}");
        assert!((read(&data) - f64::from(code) / 255.0).abs() <= 1.0 / 2048.0, "{code}");
    }
    assert!(picture::decode(b"no picture", 0, true).unwrap_err().contains("give a PNG or JPEG"));
    png.truncate(png.len() / 2);
    assert!(picture::decode(&png, 0, true).is_err());
}

const TOP: &str = "[camera]\nposition=[0,0,9]\ntarget=[0,0,0]\nvertical_fov_degrees=30\n[materials.m]\nkind='lambertian'\nreflectance=[1,1,1]\n\
    [[lights]]\nkind='point'\nposition=[0,0,5]\nintensity=[1,1,1]\n";

/// An instance is what its triangles would be if they were written where it is.
#[test]
fn an_instance_is_the_mesh_in_another_place() {
    let mesh = "[[meshes]]\nname='a'\nmaterial='m'\nvertices=[[0,0,0],[1,0,0],[0,1,0]]\ntriangles=[[0,1,2]]\n";
    let place = "place={translate=[1,2,3],rotate_degrees=[0,0,90],scale=2}\n";
    let with = |text: &str| Scene::parse("a.toml", &format!("{TOP}{text}")).unwrap().compile();
    let instanced = with(&format!("{mesh}hidden=true\n[[instances]]\nmesh='a'\n{place}"));
    let placed = with(&format!("{mesh}{place}"));
    assert_eq!(instanced.primitives, placed.primitives);
    let written = with(&mesh.replace("[0,0,0],[1,0,0],[0,1,0]", "[1,2,3],[1,4,3],[-1,2,3]"));
    for (a, b) in placed.primitives[0].sides.iter().flatten().zip(written.primitives[0].sides.iter().flatten()) {
        assert!((a - b).abs() < 1e-6, "{a}, {b}");
    }
    let matrix = with(&format!("{mesh}place={{matrix=[[0,-2,0,1],[2,0,0,2],[0,0,2,3]]}}\n"));
    assert_eq!(matrix.primitives, written.primitives);
}

#[test]
fn tables_of_meshes_are_checked() {
    let mesh = "[[meshes]]\nname='a'\nmaterial='m'\nvertices=[[0,0,0],[1,0,0],[0,1,0]]\ntriangles=[[0,1,2]]\n";
    for (text, expected) in [
        (mesh.replace("[0,1,2]", "[0,1,3]"), "`meshes[0].triangles[0][2]` (a) is 3"),
        (mesh.replace("[0,1,2]", "[0,1,0.5]"), "counted whole"),
        (mesh.replace("vertices", "points"), "is not a known field"),
        (mesh.replace("triangles=[[0,1,2]]\n", ""), "must have either a `file` or"),
        (format!("{mesh}file='a.ply'\n"), "must have either a `file` or"),
        (format!("{mesh}uv=[[0,0]]\n"), "has 1 entries, but there are 3 vertices"),
        (mesh.replace("material='m'\n", ""), "lacks the field `material`"),
        (format!("{mesh}place={{matrix=[[1,0,0,0],[0,1,0,0],[0,0,0,0]]}}\n"), "has no inverse"),
        (format!("{mesh}place={{scale=0}}\n"), "`meshes[0].place.scale` (a) is 0"),
        (format!("{mesh}[[instances]]\nmesh='b'\nplace={{}}\n"), "unknown mesh \"b\" (did you mean \"a\"?)"),
        ("[[meshes]]\nfile='built-in:hal'\nmaterial='m'\n".to_string(), "\"built-in:hall\""),
        ("[[meshes]]\nfile='no/such.ply'\nmaterial='m'\n".to_string(), "which cannot be read"),
        ("[[discs]]\ncentre=[0,0,0]\nnormal=[0,0,0]\nradius=1\nmaterial='m'\n".to_string(), "has no length"),
    ] {
        let error = Scene::parse("a.toml", &format!("{TOP}{text}")).unwrap_err().to_string();
        assert!(error.contains(expected) && !error.contains('\n'), "{text}\n  {error}\n  {expected}");
    }
    let included = format!("include=['nothing.toml']\n{TOP}{mesh}");
    let error = Scene::parse("a.toml", &included).unwrap_err().to_string();
    assert!(error.contains("`include[0]`") && error.contains("cannot be read"), "{error}");
}

#[test]
fn an_included_file_brings_its_surfaces_and_no_camera() {
    let folder = std::env::temp_dir().join(format!("caustic-include-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let write = |name: &str, text: &str| fs::write(folder.join(name), text).unwrap();
    write(
        "part.toml",
        "[materials.n]\nkind='mirror'\nreflectance=[1,1,1]\n[[discs]]\ncentre=[0,0,0]\nnormal=[0,0,1]\nradius=1\nmaterial='n'\n",
    );
    write("main.toml", &format!("include=['part.toml']\n{TOP}[[spheres]]\ncentre=[2,0,0]\nradius=1\nmaterial='n'\n"));
    write("self.toml", &format!("include=['loop.toml']\n{TOP}"));
    write("loop.toml", "include=['loop.toml']\n");
    write("camera.toml", &format!("include=['main.toml']\n{TOP}"));
    let load = |name: &str| Scene::load(folder.join(name).to_str().unwrap());
    assert_eq!(load("main.toml").unwrap().compile().info.primitives, 2);
    assert!(load("self.toml").unwrap_err().to_string().contains("does one include itself?"));
    assert!(load("camera.toml").unwrap_err().to_string().contains("the camera belongs into"));
    fs::remove_dir_all(&folder).unwrap();
}
