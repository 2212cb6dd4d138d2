use super::*;
use caustic_kernels::trace::{LIGHT_AREA, LIGHT_POINT, MATERIAL_DIELECTRIC, NO_LIGHT};
use glam::{DVec3, Vec3};

fn cornell() -> CompiledScene {
    Scene::load("cornell").unwrap().compile()
}

fn close(a: [f32; 3], b: [f32; 3]) -> bool {
    (Vec3::from_array(a) - Vec3::from_array(b)).length() < 1e-6
}

#[test]
fn every_built_in_scene_is_right() {
    for scene in BUILT_IN {
        let parsed = Scene::load(scene.name).unwrap();
        assert_eq!(parsed.name, scene.name);
        assert!(!parsed.description.is_empty() && parsed.description.len() < 90);
        assert_eq!(scene.description(), parsed.description);
        assert!(parsed.defaults.size.is_some() && parsed.defaults.spp.is_some());
    }
}

#[test]
fn cornell_has_the_numbers_of_the_thesis() {
    let scene = cornell();
    assert_eq!((scene.info.primitives, scene.info.lights, scene.info.targets), (8, 1, 2));
    assert!(scene.has_specular && scene.has_diffuse);
    let names = ["glass", "green", "mirror", "red", "white", "black"];
    assert_eq!(scene.materials.len(), names.len());
    let of = |name: &str| scene.materials[names.iter().position(|&n| n == name).unwrap()];
    assert_eq!(of("white").reflectance, [0.885809, 0.698859, 0.666422]);
    assert_eq!(of("red").reflectance, [0.570068, 0.0430135, 0.0443706]);
    assert_eq!(of("green").reflectance, [0.105421, 0.37798, 0.0764250]);
    assert_eq!(of("white").survival, 0.885809);
    assert_eq!((of("glass").kind, of("glass").ior, of("glass").survival), (MATERIAL_DIELECTRIC, 1.5, 1.0));
    assert_eq!((of("black").reflectance, of("black").survival), ([0.0; 3], 0.0));

    let light = scene.lights[0];
    assert_eq!(light.emission, [18.4, 15.6, 8.0]);
    assert_eq!((light.kind, light.normal, light.area), (LIGHT_AREA, [0.0, -1.0, 0.0], 0.25));
    assert_eq!((light.probability, light.cumulative), (1.0, 1.0));
    assert_eq!(scene.primitives[light.primitive as usize].light, 0);
    assert_eq!(scene.primitives.iter().filter(|primitive| primitive.light != NO_LIGHT).count(), 1);
    for (power, radiance) in scene.emitted_power_w.into_iter().zip([18.4, 15.6, 8.0]) {
        assert!((power - std::f64::consts::PI * 0.25 * radiance).abs() < 1e-12);
    }
    // The room's walls face inside.
    for wall in &scene.primitives[..5] {
        let inwards = Vec3::new(0.0, 1.0, 0.0) - Vec3::from_array(wall.position);
        assert!(Vec3::from_array(wall.normal).dot(inwards) > 0.99);
    }
    let (low, high) = scene.diffuse_bounds;
    assert!(low[0] < -1.0 && low[1] < 0.0 && low[2] < -1.0 && high[0] > 1.0 && high[1] > 2.0 && high[2] > 1.0);
    assert!(close(low, [-1.0, 0.0, -1.0].map(|x: f32| x - 2.1e-5)) && high[1] < 2.001);
    assert_eq!((scene.targets[1].centre, scene.targets[1].radius), ([0.45, 0.35, 0.25], 0.35));
}

#[test]
fn duals_give_coordinates_along_skew_edges() {
    let text = "[camera]\nposition=[0,0,9]\ntarget=[0,0,0]\nvertical_fov_degrees=30\n[materials.m]\nkind='mirror'\nreflectance=[1,0.5,0]\n\
        [[quads]]\ncorner=[1,2,3]\nedge_u=[3,0.5,-1]\nedge_v=[1,2,0.25]\nmaterial='m'\n\
        [[quads]]\ncorner=[0,0,0]\nedge_u=[1,0,0]\nedge_v=[0,1,0]\nradiance=[1,1,1]\n\
        [[lights]]\nkind='point'\nposition=[0,0,5]\nintensity=[0.25,0.25,0.25]\n";
    let scene = Scene::parse("skew.toml", text).unwrap().compile();
    let quad = scene.primitives[0];
    let (u, v) = (Vec3::new(3.0, 0.5, -1.0), Vec3::new(1.0, 2.0, 0.25));
    let [du, dv] = quad.sides.map(Vec3::from_array);
    let n = Vec3::from_array(quad.normal);
    for (product, value) in [
        (du.dot(u), 1.0),
        (du.dot(v), 0.0),
        (du.dot(n), 0.0),
        (dv.dot(v), 1.0),
        (dv.dot(u), 0.0),
        (dv.dot(n), 0.0),
        (n.length(), 1.0),
        (n.dot(u.cross(v)) / u.cross(v).length(), 1.0),
    ] {
        assert!((product - value).abs() < 1e-6);
    }
    // The sphere around a mirror touches its farther corners.
    let target = scene.targets[0];
    let centre = Vec3::from_array(target.centre);
    for corner in [Vec3::ZERO, u, v, u + v].map(|edge| Vec3::new(1.0, 2.0, 3.0) + edge) {
        assert!(centre.distance(corner) <= target.radius * 1.000_001);
    }
    // π·1·1 W of the quad against 4π/4 W of the point.
    assert_eq!(scene.lights.iter().map(|light| light.probability).collect::<Vec<_>>(), [0.5, 0.5]);
    assert_eq!((scene.lights[1].kind, scene.lights[1].cumulative), (LIGHT_POINT, 1.0));
}

#[test]
fn the_furnace_is_closed_and_faces_inside() {
    let scene = Scene::load("furnace").unwrap().compile();
    assert_eq!((scene.info.primitives, scene.info.lights), (6, 6));
    let mut sum = Vec3::ZERO;
    for (i, wall) in scene.primitives.iter().enumerate() {
        assert_eq!(wall.light, i as u32);
        let normal = Vec3::from_array(wall.normal);
        assert_eq!(normal.dot(Vec3::from_array(wall.position)), -1.0, "1 m from the middle, which is in front");
        sum += normal;
    }
    assert_eq!(sum, Vec3::ZERO);
    assert_eq!(scene.lights[5].cumulative, 1.0);
}

#[test]
fn the_camera_sees_its_target_in_the_middle_and_its_angle_from_edge_to_edge() {
    let camera = Scene::load("cornell").unwrap().camera(300, 200);
    let at = |x: f32, y: f32| {
        Vec3::from_array(camera.corner) + Vec3::from_array(camera.right) * x + Vec3::from_array(camera.down) * y
    };
    assert!((at(150.0, 100.0) - Vec3::NEG_Z).length() < 1e-6);
    assert!((at(150.0, 0.0).angle_between(at(150.0, 200.0)).to_degrees() - 35.0).abs() < 1e-3);
    assert!(at(0.0, 0.0).x < 0.0 && at(0.0, 0.0).y > 0.0, "the first pixel is at the top left");
    assert_eq!((camera.width, camera.height), (300, 200));
    let plane = Scene::load("plane").unwrap().camera(64, 64);
    let right = DVec3::from_array(plane.right.map(f64::from));
    assert!((right * 64.0 * 4.0 - DVec3::X * 4.0).length() < 1e-5, "4 m wide on the ground");
}

/// Cornell with `from` replaced by `to`.
fn broken(from: &str, to: &str) -> String {
    let text = BUILT_IN[0].text;
    assert!(text.contains(from), "{from}");
    Scene::parse("box.toml", &text.replacen(from, to, 1)).unwrap_err().to_string()
}

#[test]
fn errors_name_place_field_bound_and_remedy() {
    for (from, to, expected) in [
        ("target = [0, 1, 0]", "target = [0, 1, 0", "box.toml:8:"),
        ("target =", "taget =", "box.toml:7:1: `camera.taget` is not a known field (did you mean `target`?)"),
        ("[camera]", "[camra]", "did you mean `camera`?"),
        ("target = [0, 1, 0]\n", "", "box.toml:5:1: `camera` lacks the field `target`; add `target = [x, y, z]`"),
        ("kind = \"mirror\"", "kind = \"mirorr\"", "cannot be \"mirorr\" (did you mean `mirror`?); it must be one of"),
        (
            "vertical_fov_degrees = 35",
            "vertical_fov_degrees = \"35\"",
            "box.toml:9:24: `camera.vertical_fov_degrees` has the wrong type",
        ),
        ("vertical_fov_degrees = 35", "vertical_fov_degrees = 180", "`camera.vertical_fov_degrees` is 180, but"),
        (
            "vertical_fov_degrees = 35",
            "vertical_fov_degrees = nan",
            "is NaN, but the angle of view (degrees) must be from 0.01 to 179",
        ),
        ("position = [0, 1, 4.2]", "position = [0, 1]", "box.toml:6:12: `camera.position` has the wrong type"),
        ("position = [0, 1, 4.2]", "position = [0, 1, 4.2, 1]", "expected an array of 3 numbers"),
        (
            "position = [0, 1, 4.2]",
            "position = [0, inf, 4.2]",
            "`camera.position[1]` is inf, but a coordinate must be from -1000000000",
        ),
        ("position = [0, 1, 4.2]", "position = [0, 1, 0]", "`camera.target` is where the camera stands"),
        ("position = [0, 1, 4.2]", "position = [0.5, 0.4, 0.2]", "is inside a dielectric sphere"),
        ("up = [0, 1, 0]", "up = [0, 0, -2]", "`camera.up` is parallel to the view"),
        ("up = [0, 1, 0]", "up = [0, 0, 0]", "`camera.up` has no length"),
        ("up = [0, 1, 0]\n", "", ""),
        (
            "size = [512, 512]",
            "size = [0, 512]",
            "`render.size[0]` is 0, but a side of the picture (pixels) must be from 1 to 65536",
        ),
        ("size = [512, 512]", "size = [512, 5.5]", "pixels come whole"),
        ("photons = 1_000_000", "photons = -1", "`render.photons` is -1, but the number of photons must be from 1 to"),
        ("k = 100", "k = 100000000", "`render.k` is 100000000"),
        ("k = 100", "k = 1e2", "a whole number"),
        ("radius = 0.05", "radius = 0", "`render.radius` is 0"),
        ("0.0764250]", "1.5]", "box.toml:29:35: `materials.green.reflectance[2]` is 1.5, but a reflectance"),
        ("0.0764250]", "-1]", "must be from 0 to 1"),
        ("ior = 1.5", "ior = 0", "`materials.glass.ior` is 0"),
        ("ior = 1.5", "", "`materials.glass` is a dielectric and lacks the field `ior`; add `ior = 1.5`"),
        (
            "ior = 1.5",
            "ior = 1.5\nreflectance = [1, 1, 1]",
            "`materials.glass.reflectance` means nothing for a dielectric",
        ),
        ("reflectance = [1, 1, 1]", "", "`materials.mirror` lacks the field `reflectance`"),
        ("reflectance = [1, 1, 1]", "reflectance = [1, 1, 1]\nior = 2", "`materials.mirror.ior` means nothing"),
        (
            "material = \"white\"",
            "material = \"whit\"",
            "`quads[2].material` (floor) names the unknown material \"whit\" (did you mean \"white\"?)",
        ),
        ("edge_u = [2, 0, 0]", "edge_u = [0, 0, 0]", "`quads[3].edge_u` (ceiling) is shorter than"),
        ("edge_u = [2, 0, 0]", "edge_u = [0, 0, 7]", "`quads[3].edge_v` (ceiling) is parallel to `edge_u`"),
        ("radiance = [18.4, 15.6, 8.0]", "", "`quads[5]` (light) lacks the field `material`"),
        ("radiance = [18.4, 15.6, 8.0]", "radiance = [0, 0, 0]", "is dark"),
        ("radiance = [18.4, 15.6, 8.0]", "radiance = [18.4, -1, 8.0]", "`quads[5].radiance[1]` (light) is -1"),
        ("radiance = [18.4, 15.6, 8.0]", "radiance = [1, 1, 1]\nmaterial = \"glass\"", "what emits must not be"),
        ("radiance = [18.4, 15.6, 8.0]", "material = \"white\"", "the scene has no light"),
        ("radius = 0.35", "radius = -0.35", "`spheres[0].radius` (mirror ball) is -0.35"),
        ("centre =", "center =", "did you mean `centre`?"),
        ("# The test scene", "[lights]\n#", "`lights`"),
    ] {
        if expected.is_empty() {
            assert!(Scene::parse("box.toml", &BUILT_IN[0].text.replacen(from, to, 1)).is_ok());
            continue;
        }
        let message = broken(from, to);
        assert!(message.contains(expected), "{from} -> {to}\n  {message}\n  {expected}");
        assert!(!message.contains('\n') && message.len() < 500, "{message}");
    }
    let top = "[camera]\nposition=[0,0,9]\ntarget=[0,0,0]\nvertical_fov_degrees=30\n";
    assert!(Scene::parse("a.toml", top).unwrap_err().to_string().contains("no surface"));
    assert!(Scene::parse("a.toml", " \n").unwrap_err().to_string().contains("is empty"));
    assert!(Scene::parse("a.toml", "# nothing\n").unwrap_err().to_string().contains("lacks the field `camera`"));
}

#[test]
fn files_that_are_no_scenes_are_errors() {
    let folder = std::env::temp_dir().join(format!("caustic-scene-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = |name: &str, bytes: &[u8]| {
        let path = folder.join(name);
        std::fs::write(&path, bytes).unwrap();
        Scene::load(path.to_str().unwrap())
    };
    assert_eq!(file("good.toml", BUILT_IN[0].text.as_bytes()).unwrap().name, "good");
    assert!(matches!(file("empty.toml", b""), Err(SceneError::Empty { .. })));
    assert!(matches!(file("garbage.toml", &[b'a', 0xff, 0xfe]), Err(SceneError::NotText { offset: 1, .. })));
    assert!(matches!(file("nul.toml", &[0; 100]), Err(SceneError::Syntax { .. })));
    let large = vec![b'#'; limits::MAX_FILE_BYTES as usize + 1];
    assert!(matches!(file("large.toml", &large), Err(SceneError::TooLarge { .. })));
    let missing = Scene::load(folder.join("none.toml").to_str().unwrap()).unwrap_err().to_string();
    assert!(missing.contains("cannot read") && missing.contains("`cornell`"), "{missing}");
    assert!(Scene::load(folder.to_str().unwrap()).unwrap_err().to_string().contains("it is a folder"));
    let unknown = Scene::load("cornel").unwrap_err().to_string();
    assert!(unknown.contains("did you mean `cornell`?") && unknown.contains("`plane`"), "{unknown}");
    assert!(matches!(Scene::load(""), Err(SceneError::Unknown { .. })));
    assert!(matches!(Scene::load("a\0b.toml"), Err(SceneError::Unreadable { .. })));
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn no_text_makes_it_panic() {
    let text = BUILT_IN[0].text.as_bytes();
    let spare = b"[]{}=\"'.,-_e+\n#\0\xff\xc3 9x";
    let mut state = 1u64;
    let mut random = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    let mut accepted = 0;
    for _ in 0..4000 {
        let mut bytes = text.to_vec();
        for _ in 0..=random(3) {
            let at = random(bytes.len());
            match random(4) {
                0 => bytes[at] = spare[random(spare.len())],
                1 => bytes.insert(at, spare[random(spare.len())]),
                2 => drop(bytes.drain(at..(at + 1 + random(40)).min(bytes.len()))),
                _ => bytes[at] ^= 1 << random(8),
            }
        }
        match Scene::parse("fuzz.toml", &String::from_utf8_lossy(&bytes)) {
            Ok(scene) => {
                accepted += 1;
                let compiled = scene.compile();
                let numbers: &[f32] = bytemuck::cast_slice(&compiled.targets);
                assert!(numbers.iter().all(|number| number.is_finite()));
                assert!(compiled.primitives.iter().flat_map(|p| p.sides).flatten().all(f32::is_finite));
                assert!(compiled.lights.iter().all(|light| light.area.is_finite() && light.probability > 0.0));
                assert!(scene.camera(65_536, 1).corner.iter().all(|number| number.is_finite()));
            }
            Err(error) => assert!(!error.to_string().contains('\n'), "{error}"),
        }
    }
    assert!(accepted > 100, "comments and digits may change: {accepted}");
    for nested in ["[", "{a=", "a."] {
        assert!(Scene::parse("deep.toml", &format!("x = {}", nested.repeat(200_000))).is_err());
        assert!(Scene::parse("deep.toml", &nested.repeat(200_000)).is_err());
    }
    assert!(Scene::parse("long.toml", &format!("{} = 1", "x".repeat(1 << 20))).is_err());
}

/// `caustic scene schema --page > docs/scene-reference.md` makes it anew.
#[test]
fn the_reference_page_in_the_docs_is_that_of_the_types() {
    let page = Scene::reference();
    assert_eq!(include_str!("../../../../docs/scene-reference.md"), page);
    // Every field says what it means.
    assert!(page.lines().filter(|line| line.starts_with("| `")).count() > 80);
    assert!(!page.lines().any(|line| line.starts_with("| `") && line.ends_with("|  |")), "{page}");
}

/// `caustic scene schema > docs/scene.schema.json` makes it anew.
#[test]
fn the_schema_in_the_docs_is_that_of_the_types() {
    assert_eq!(include_str!("../../../../docs/scene.schema.json"), Scene::schema());
}

#[test]
fn the_example_of_the_reference_is_a_scene() {
    let reference = include_str!("../../../../docs/scene-format.md");
    let example = reference.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let scene = Scene::parse("example.toml", example).unwrap().compile();
    assert_eq!((scene.info.primitives, scene.info.lights, scene.info.targets), (3, 1, 1));
    assert_eq!(scene.primitives[0].normal, [0.0, 1.0, 0.0]);
    assert_eq!(scene.lights[0].normal, [0.0, -1.0, 0.0]);
}
