//! Meshes: from the parts of models to triangles of a scene.

use super::content::{Content, Lamps, Shape, Surface, Viewpoint};
use super::limits::MAX_SURFACES;
use super::model::{Finish, Model, Part, Picture};
use super::surfaces::Palette;
use caustic_kernels::trace::vector::pack_direction;
use caustic_kernels::trace::{Corners, Texel, Texture, texel_at};
use glam::{DVec3, Vec3};

/// Twice the area of a triangle whose longest side is 1, below which it is none.
const NO_AREA: f64 = 1e-10;
/// 1 − cos of the angle up to which the normals at a triangle's corners are its own.
const FLAT: f64 = 1e-8;
/// Most texels of a scene: 2 GiB.
const MAX_TEXELS: usize = 1 << 28;

/// Surfaces, and what belongs to them, while a scene is put together.
#[derive(Default)]
pub(super) struct Assembly {
    pub surfaces: Vec<Surface>,
    pub corners: Vec<Corners>,
    pub textures: Vec<Texture>,
    pub texels: Vec<Texel>,
    /// Triangles that were left out because they have no area.
    degenerate: usize,
    objects: u32,
}

/// How the triangles of a part look.
#[derive(Clone, Copy)]
pub(super) struct Look {
    /// Index of the material.
    pub material: usize,
    /// Whether it has a picture, so that texture coordinates are needed.
    pub textured: bool,
    /// W·sr⁻¹·m⁻².
    pub radiance: Option<DVec3>,
    /// Index of the picture that it is multiplied with.
    pub emission: Option<u32>,
    /// Whether triangles look as flat as they are.
    pub flat: bool,
}

impl Assembly {
    /// Adds a surface that is an object by itself.
    pub fn add(&mut self, surface: Surface) {
        self.objects += 1;
        self.surfaces.push(Surface { object: self.objects, ..surface });
    }

    /// Adds a picture and returns its index.
    pub fn add_picture(&mut self, picture: &Picture) -> Result<u32, String> {
        let first = self.add_texels(picture.texels.iter().copied())?;
        self.textures.push(Texture { first, width: picture.width, height: picture.height, wrap: picture.wrap });
        Ok(self.textures.len() as u32 - 1)
    }

    /// Adds texels, and returns the index of the first.
    pub fn add_texels(&mut self, texels: impl IntoIterator<Item = Texel>) -> Result<u32, String> {
        let first = self.texels.len();
        self.texels.extend(texels);
        if self.texels.len() > MAX_TEXELS {
            return Err(format!("makes more than {MAX_TEXELS} texels of pictures; use smaller ones"));
        }
        Ok(first as u32)
    }

    /// Adds the triangles of a part, which is an object.
    pub fn add_part(&mut self, part: &Part, look: Look) -> Result<(), String> {
        self.objects += 1;
        let all = self.surfaces.len() + part.triangles.len();
        if all > MAX_SURFACES {
            return Err(format!(
                "makes {all} surfaces, but a scene may have {MAX_SURFACES} at most; use a coarser mesh"
            ));
        }
        let has_uv = look.textured && !part.uv.is_empty();
        for triangle in &part.triangles {
            let indices = triangle.map(|index| index as usize);
            let corners = indices.map(|index| part.positions[index]);
            let [a, b, c] = corners;
            let normal = (b - a).cross(c - a);
            let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
            if !(normal.length() > NO_AREA * longest) {
                self.degenerate += 1;
                continue;
            }
            let normal = normal.normalize();
            let own = |index: usize| match part.normals.get(index) {
                Some(given) if !look.flat && given.length() > 0.0 => given.normalize(),
                _ => normal,
            };
            let normals = indices.map(own);
            let has_corners = has_uv || look.emission.is_some() || normals.iter().any(|n| 1.0 - n.dot(normal) > FLAT);
            if has_corners {
                self.corners.push(Corners {
                    normals: normals.map(|normal| pack_direction(normal.as_vec3())),
                    uv: if has_uv { indices.map(|index| part.uv[index].map(|x| x as f32)) } else { [[0.0; 2]; 3] },
                });
            }
            let uv = indices.map(|index| part.uv.get(index).copied().unwrap_or_default());
            let dark = look.emission.is_some_and(|picture| self.is_black(picture, uv));
            self.surfaces.push(Surface {
                shape: Shape::Triangle { corners },
                material: look.material,
                radiance: look.radiance.filter(|_| !dark),
                object: self.objects,
                has_corners,
            });
        }
        Ok(())
    }

    /// Whether a picture is black wherever a triangle of these coordinates shows it. Those that show much of it are not looked at.
    fn is_black(&self, picture: u32, uv: [[f64; 2]; 3]) -> bool {
        const MOST: f64 = 4096.0;
        let texture = &self.textures[picture as usize];
        let sides = [f64::from(texture.width), f64::from(texture.height)];
        // Texels that bilinear mixing may touch.
        let range = |k: usize| {
            let along = uv.map(|at| at[k] * sides[k]);
            let [low, high] = [f64::min, f64::max].map(|pick| pick(pick(along[0], along[1]), along[2]));
            ((low - 1.0).floor(), (high + 1.0).ceil())
        };
        let ((x0, x1), (y0, y1)) = (range(0), range(1));
        if !((x1 - x0 + 1.0) * (y1 - y0 + 1.0) <= MOST) {
            return false;
        }
        let middle = |i: i64, side: f64| ((i as f64 + 0.5) / side) as f32;
        (y0 as i64..=y1 as i64).all(|y| {
            (x0 as i64..=x1 as i64).all(|x| {
                let texel = texel_at(texture, [middle(x, sides[0]), middle(y, sides[1])], &self.texels);
                texel.truncate() == Vec3::ZERO
            })
        })
    }

    /// The scene of these surfaces, those with corners last as the kernels want them, and what is worth a note.
    pub fn finish(mut self, camera: Viewpoint, palette: Palette, lamps: Lamps) -> (Content, Option<String>) {
        self.surfaces.sort_by_key(|surface| surface.has_corners);
        let count = self.degenerate;
        let note = (count > 0).then(|| format!("{count} triangles have no area and were left out"));
        let content = Content {
            camera,
            origin: DVec3::ZERO,
            names: palette.names.into_iter().collect(),
            materials: palette.materials,
            pictures: palette.pictures,
            surfaces: self.surfaces,
            corners: self.corners,
            textures: self.textures,
            texels: self.texels,
            points: lamps.points,
            suns: lamps.suns,
            sky: lamps.sky,
        };
        (content, note)
    }
}

/// What a model has that is not rendered, in a sentence; or nothing.
pub(super) fn left_out(file: &str, model: &Model) -> Option<String> {
    let what: Vec<&str> = model.left_out.iter().map(String::as_str).collect();
    (!what.is_empty()).then(|| format!("{file}: left out: {}", what.join("; ")))
}

/// What a finish emits.
pub(super) fn emission(finish: &Finish) -> Option<DVec3> {
    (finish.emission.max_element() >= 1e-9 && finish.emission.is_finite()).then_some(finish.emission)
}
