//! What a scene holds once it is checked: everything in f64, as it was given.

use glam::DVec3;

/// Everything but names and settings.
#[derive(Clone, Debug)]
pub(super) struct Content {
    pub camera: Viewpoint,
    /// In the order of their names; the black of lights without a material, if there are such, is last.
    pub materials: Vec<Substance>,
    /// Quads, then spheres, each in the file's order.
    pub surfaces: Vec<Surface>,
    pub points: Vec<PointLight>,
}

/// Where the picture is taken from.
#[derive(Clone, Copy, Debug)]
pub(super) struct Viewpoint {
    /// m.
    pub position: DVec3,
    /// m.
    pub target: DVec3,
    /// Of any length, not along the view.
    pub up: DVec3,
    pub vertical_fov_degrees: f64,
}

/// What a surface does with light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Substance {
    /// Reflectances of red, green and blue.
    Lambertian(DVec3),
    /// Reflectances of red, green and blue.
    Mirror(DVec3),
    /// Index of refraction.
    Dielectric(f64),
}

/// A surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surface {
    pub shape: Shape,
    /// Index of its material.
    pub material: usize,
    /// What a quad's front emits, W·sr⁻¹·m⁻².
    pub radiance: Option<DVec3>,
}

/// A surface's shape; lengths in m.
#[derive(Clone, Copy, Debug)]
pub(super) enum Shape {
    Quad { corner: DVec3, edge_u: DVec3, edge_v: DVec3 },
    Sphere { centre: DVec3, radius: f64 },
}

/// A light that is a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct PointLight {
    /// m.
    pub position: DVec3,
    /// W·sr⁻¹.
    pub intensity: DVec3,
}
