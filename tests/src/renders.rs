//! Renders that several tests make, and what they measure in them.

use caustic_device::Device;
use caustic_kernels::trace::Camera;
use caustic_renderer::output::Image;
use caustic_renderer::scene::Scene;
use caustic_renderer::{Rendered, Settings, render};

/// A square lamp of side 1 and radiance 4, 1 m above a plane of reflectance 0.5, with the camera between them: it sees
/// x and z from −1 to 1.
pub const LAMP: &str = r#"
[camera]
position = [0, 0.75, 0]
target = [0, 0, 0]
up = [0, 0, -1]
vertical_fov_degrees = 106.26020470831196

[materials.grey]
kind = "lambertian"
reflectance = [0.5, 0.5, 0.5]

[[quads]]
corner = [-50, 0, -50]
edge_u = [0, 0, 100]
edge_v = [100, 0, 0]
material = "grey"

[[quads]]
name = "lamp"
corner = [-0.5, 1, -0.5]
edge_u = [1, 0, 0]
edge_v = [0, 0, 1]
radiance = [4, 4, 4]
"#;

/// Reflectance of the planes.
pub const REFLECTANCE: f64 = 0.5;

/// A built-in scene.
pub fn load(name: &str) -> Scene {
    Scene::load(name).expect("a built-in scene")
}

/// A scene of a test.
pub fn parse(text: &str) -> Scene {
    Scene::parse("test.toml", text).expect("a scene")
}

/// Cheap settings for a scene, to be changed where a test needs more.
pub fn small(scene: &Scene) -> Settings {
    Settings { size: [48, 32], photons: 3000, caustic_photons: 1500, k: 50, radius: 0.2, spp: 2, ..Settings::of(scene) }
}

/// Renders a scene.
pub fn run(scene: &Scene, settings: &Settings, device: &Device) -> Rendered {
    render(scene, settings, device, &mut |_| true).expect("a render")
}

/// The whole picture of a scene.
pub fn image(scene: &Scene, settings: &Settings, device: &Device) -> Image {
    let rendered = run(scene, settings, device);
    assert!(rendered.report.complete);
    rendered.image
}

/// The picture's floats, three a pixel.
pub fn floats(image: &Image) -> &[f32] {
    image.rgb.as_flattened()
}

/// The mean of each channel.
pub fn mean_rgb(image: &Image) -> [f64; 3] {
    let n = image.rgb.len() as f64;
    std::array::from_fn(|c| image.rgb.iter().map(|rgb| f64::from(rgb[c])).sum::<f64>() / n)
}

/// The mean.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The mean of independent values and its standard error, from their scatter.
pub fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let mean = mean(values);
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    let n = values.len() as f64;
    (mean, (squares / (n - 1.0) / n).sqrt())
}

/// Origin and direction of the camera's ray through a point of the film, in pixels.
pub fn ray(camera: &Camera, x: f64, y: f64) -> ([f64; 3], [f64; 3]) {
    let at = |axis| {
        let [corner, right, down] = [camera.corner, camera.right, camera.down].map(|v: [f32; 3]| f64::from(v[axis]));
        corner + right * x + down * y
    };
    (camera.origin.map(f64::from), [at(0), at(1), at(2)])
}

/// Where the ray through a point of the film meets the plane y = 0.
pub fn on_floor(camera: &Camera, x: f64, y: f64) -> [f64; 2] {
    let (origin, direction) = ray(camera, x, y);
    let t = -origin[1] / direction[1];
    [origin[0] + t * direction[0], origin[2] + t * direction[2]]
}
