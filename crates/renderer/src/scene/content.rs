//! What a scene holds once it is checked: everything in f64, as it was given.

use super::sky::Sky;
use caustic_kernels::trace::{Corners, Texel, Texture, texel_at};
use glam::DVec3;

/// Everything but names and settings.
#[derive(Clone, Debug)]
pub(super) struct Content {
    pub camera: Viewpoint,
    /// In the order of their names; the black of lights without a material, if there are such, is last.
    pub materials: Vec<Substance>,
    /// Materials that have names.
    pub names: Vec<(String, usize)>,
    /// Pictures on each material.
    pub pictures: Vec<Pictures>,
    /// Quads, then spheres, discs and triangles, each in the file's order; those that have corners last, in the order of these.
    pub surfaces: Vec<Surface>,
    /// Normals and texture coordinates of triangles.
    pub corners: Vec<Corners>,
    /// Pictures.
    pub textures: Vec<Texture>,
    pub texels: Vec<Texel>,
    pub points: Vec<PointLight>,
    pub suns: Vec<Sun>,
    pub sky: Option<Sky>,
    /// Where the origin of all coordinates lies in the file's, m.
    pub origin: DVec3,
}

/// Bounds of nothing.
pub(super) const NOTHING: (DVec3, DVec3) = (DVec3::INFINITY, DVec3::NEG_INFINITY);

impl Content {
    /// Moves the origin to the scene, if that is farther away than it is large, along each axis for itself.
    ///
    /// The kernels compute in f32, which 10⁶ m from the origin knows steps of 6 cm only. A file's numbers are f64, whose steps
    /// there are a ten-millionth of a millimetre; so the scene is moved before it is rounded. One that stands at the origin stays as it is.
    pub fn localised(mut self) -> Self {
        let (low, high) = self.bounds();
        let extent = (high - low).max_element();
        let along = |low: f64, high: f64| if low > extent || high < -extent { low } else { 0.0 };
        let origin = DVec3::new(along(low.x, high.x), along(low.y, high.y), along(low.z, high.z));
        for surface in &mut self.surfaces {
            match &mut surface.shape {
                Shape::Quad { corner, .. } | Shape::Disc { corner, .. } => *corner -= origin,
                Shape::Sphere { centre, .. } => *centre -= origin,
                Shape::Triangle { corners } => corners.iter_mut().for_each(|corner| *corner -= origin),
            }
        }
        for point in &mut self.points {
            point.position -= origin;
        }
        self.camera.position -= origin;
        self.camera.target -= origin;
        self.origin += origin;
        self
    }

    /// The mean of a picture over a surface that is no sphere: of the middles of 64 equal parts.
    pub fn mean_texel(&self, surface: usize, picture: u32) -> DVec3 {
        const SIDE: u32 = 8;
        let first = self.surfaces.len() - self.corners.len();
        let corners = surface.checked_sub(first).map(|at| self.corners[at].uv);
        let mut sum = DVec3::ZERO;
        for i in 0..SIDE * SIDE {
            let (x, y) = (i % SIDE, i / SIDE);
            let at = |k: u32, part: f64| (f64::from(k) + part) / f64::from(SIDE);
            let uv = match corners {
                None => [at(x, 0.5), at(y, 0.5)],
                Some([a, b, c]) => {
                    // Small triangles that stand as the large one does, and between them those that are turned.
                    let (u, v) = if x + y < SIDE {
                        (at(x, 1.0 / 3.0), at(y, 1.0 / 3.0))
                    } else {
                        (at(SIDE - 1 - x, 2.0 / 3.0), at(SIDE - 1 - y, 2.0 / 3.0))
                    };
                    [0, 1].map(|k| {
                        let [a, b, c] = [a[k], b[k], c[k]].map(f64::from);
                        a + (b - a) * u + (c - a) * v
                    })
                }
            };
            let texel = texel_at(&self.textures[picture as usize], uv.map(|x| x as f32), &self.texels);
            sum += texel.truncate().as_dvec3();
        }
        sum / f64::from(SIDE * SIDE)
    }

    /// The box around all surfaces, m.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        self.surfaces.iter().map(Surface::bounds).fold(NOTHING, |all, one| (all.0.min(one.0), all.1.max(one.1)))
    }

    /// The largest coordinate of anything in the scene, m.
    pub fn reach(&self) -> f64 {
        let surfaces = self.surfaces.iter().map(Surface::bounds).map(|(low, high)| low.abs().max(high.abs()));
        let points = self.points.iter().map(|point| point.position.abs());
        surfaces.chain(points).fold(self.camera.position.abs(), DVec3::max).max_element()
    }
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
    /// Radius of the lens, m; 0 of a pinhole.
    pub lens_radius: f64,
    /// Distance of the plane that is in focus, m.
    pub focus: f64,
}

/// Indices of the pictures on a material.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Pictures {
    /// Multiplies the reflectance.
    pub colour: Option<u32>,
    /// Multiplies the roughness by its green and the share of metal by its blue.
    pub roughness: Option<u32>,
    /// Bends the normal.
    pub normal: Option<u32>,
    /// What that multiplies its red and green with, less 1.
    pub normal_excess: f64,
    /// Multiplies what the surface emits.
    pub emission: Option<u32>,
    /// The alpha of the colour's picture below which there are holes; 0 if there are none.
    pub cutoff: f64,
}

impl Pictures {
    /// Whether there are any, so that texture coordinates are needed.
    pub fn any(self) -> bool {
        [self.colour, self.roughness, self.normal, self.emission].iter().any(Option::is_some)
    }
}

/// What a surface does with light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Substance {
    /// Reflectances of red, green and blue.
    Lambertian(DVec3),
    /// Reflectances of red, green and blue.
    Mirror(DVec3),
    /// What is within its surface.
    Dielectric(Glass),
    /// A coat over a base.
    Layered(Layers),
}

impl Substance {
    /// Whether it reflects or refracts light in other than diffuse ways, so that caustics may come of it.
    pub fn is_specular(&self) -> bool {
        !matches!(self, Self::Lambertian(_))
    }

    /// Whether a surface of it may be a light.
    pub fn may_emit(&self) -> bool {
        matches!(self, Self::Lambertian(_) | Self::Layered(_))
    }

    /// Whether it has a diffuse part, black ones too.
    pub fn is_diffuse(&self) -> bool {
        match self {
            Self::Lambertian(_) => true,
            Self::Layered(layers) => layers.metallic < 1.0,
            Self::Mirror(_) | Self::Dielectric(_) => false,
        }
    }
}

/// A dielectric.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Glass {
    /// Index of refraction.
    pub ior: f64,
    /// GGX α.
    pub alpha: f64,
    /// Absorption coefficients inside, m⁻¹.
    pub absorption: DVec3,
}

/// Metal, plastic, or what glTF has between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Layers {
    /// Base colour: what the metal reflects head on, or the reflectance of what is under the coat.
    pub base: DVec3,
    /// Share of metal.
    pub metallic: f64,
    /// Index of refraction of the coat.
    pub ior: f64,
    /// GGX α of the coat.
    pub alpha: f64,
}

/// A surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surface {
    pub shape: Shape,
    /// Index of its material.
    pub material: usize,
    /// What the front or the outside emits, W·sr⁻¹·m⁻².
    pub radiance: Option<DVec3>,
    /// What it is a part of: the triangles of a mesh are one object.
    pub object: u32,
    /// Whether it has [`Corners`].
    pub has_corners: bool,
}

impl Surface {
    /// The lowest and the highest corner of the box around it.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        match self.shape {
            Shape::Sphere { centre, radius } => (centre - radius, centre + radius),
            Shape::Triangle { corners: [a, b, c] } => (a.min(b).min(c), a.max(b).max(c)),
            // A disc's is the box of its square.
            Shape::Quad { corner, edge_u, edge_v } | Shape::Disc { corner, edge_u, edge_v } => {
                let opposite = corner + edge_u + edge_v;
                let (u, v) = (corner + edge_u, corner + edge_v);
                (corner.min(opposite).min(u).min(v), corner.max(opposite).max(u).max(v))
            }
        }
    }
}

/// A surface's shape; lengths in m.
#[derive(Clone, Copy, Debug)]
pub(super) enum Shape {
    Quad {
        corner: DVec3,
        edge_u: DVec3,
        edge_v: DVec3,
    },
    Sphere {
        centre: DVec3,
        radius: f64,
    },
    /// Inscribed in the square that these edges span.
    Disc {
        corner: DVec3,
        edge_u: DVec3,
        edge_v: DVec3,
    },
    /// Counter-clockwise as its front is seen.
    Triangle {
        corners: [DVec3; 3],
    },
}

/// Lights that are not surfaces.
#[derive(Clone, Debug, Default)]
pub(super) struct Lamps {
    pub points: Vec<PointLight>,
    pub suns: Vec<Sun>,
    /// The environment.
    pub sky: Option<Sky>,
}

/// A light that is a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct PointLight {
    /// m.
    pub position: DVec3,
    /// W·sr⁻¹; of a spot, on its axis.
    pub intensity: DVec3,
    /// The cone of a spot.
    pub spot: Option<Spot>,
}

/// The cone within which a spot shines.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    /// Unit vector.
    pub axis: DVec3,
    /// 1 − cos of the angle from the axis up to which it has its full intensity.
    pub inner: f64,
    /// 1 − cos of the angle from which on it is dark.
    pub outer: f64,
}

/// Light from infinitely far away.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sun {
    /// Unit vector: the way it travels.
    pub direction: DVec3,
    /// Irradiance on what faces it, W·m⁻².
    pub irradiance: DVec3,
}
