//! Checks of `[materials]`, `[[quads]]`, `[[spheres]]` and `[[discs]]`.

use super::check::{LARGEST, PARALLEL, SHORTEST, emission, number, vector};
use super::content::{Pictures, Shape, Substance, Surface};
use super::document::{Document, Path};
use super::error::SceneError;
use super::file::{DiscTable, MaterialTable, Numbers, QuadTable, SphereTable};
use super::substances::material;
use super::text::{nearest, one_line};
use glam::DVec3;
use std::collections::BTreeMap;

/// The materials of a scene.
#[derive(Default)]
pub(super) struct Palette {
    /// Indices by name.
    pub names: BTreeMap<String, usize>,
    /// The materials.
    pub materials: Vec<Substance>,
    /// Pictures on each.
    pub pictures: Vec<Pictures>,
    /// Index of the black of lights without a material, once there is one.
    black: Option<usize>,
}

impl Palette {
    /// Checks and adds a material.
    pub fn add(
        &mut self,
        document: &Document<'_>,
        path: &Path,
        name: &str,
        table: &MaterialTable,
        pictures: Pictures,
    ) -> Result<(), SceneError> {
        let path = path.key(name);
        if self.names.insert(name.to_string(), self.materials.len()).is_some() {
            return Err(document.field_error(&path, "is there twice, here and in an included file; rename one"));
        }
        let material = material(document, &path, table)?;
        if pictures.colour.is_some() && matches!(material, Substance::Dielectric(_)) {
            return Err(document.field_error(&path.key("texture"), "means nothing for a dielectric; remove it"));
        }
        if pictures.roughness.is_some() && !matches!(material, Substance::Layered(_)) {
            let problem = "means nothing for this kind; remove it, or use `kind = \"metallic-roughness\"`";
            return Err(document.field_error(&path.key("roughness_texture"), problem));
        }
        let bounded = |key: &str, value: Option<f64>, default: f64, bounds, what: &str| match value {
            Some(value) => number(document, &path.key(key), value, bounds, what),
            None => Ok(default),
        };
        if table.normal_scale.is_some() && pictures.normal.is_none() {
            let problem = "means nothing without a `normal_texture`; remove it or add one";
            return Err(document.field_error(&path.key("normal_scale"), problem));
        }
        if table.alpha_cutoff.is_some() && pictures.colour.is_none() {
            let problem = "means nothing without a `texture` that has an alpha; remove it or add one";
            return Err(document.field_error(&path.key("alpha_cutoff"), problem));
        }
        let scale =
            bounded("normal_scale", table.normal_scale, 1.0, (0.0, 100.0), "a factor on the slopes of normals")?;
        let cutoff =
            bounded("alpha_cutoff", table.alpha_cutoff, 0.0, (1e-3, 1.0), "the alpha below which there are holes")?;
        self.push(material, Pictures { normal_excess: scale - 1.0, cutoff, ..pictures });
        Ok(())
    }

    /// Adds a material without a name and returns its index.
    pub fn push(&mut self, material: Substance, pictures: Pictures) -> usize {
        self.materials.push(material);
        self.pictures.push(pictures);
        self.materials.len() - 1
    }

    /// The index of the material that the field `path` names.
    pub fn find(&self, document: &Document<'_>, path: &Path, name: &str) -> Result<usize, SceneError> {
        if let Some(&index) = self.names.get(name) {
            return Ok(index);
        }
        let meant = nearest(name, self.names.keys().map(String::as_str));
        let meant = meant.map_or(String::new(), |name| format!(" (did you mean \"{}\"?)", one_line(name)));
        let known: Vec<String> = self.names.keys().map(|name| format!("\"{name}\"")).collect();
        let known = if known.is_empty() {
            "there are none yet: add [materials.NAME]".to_string()
        } else {
            format!("there are {}", one_line(&known.join(", ")))
        };
        Err(document.field_error(path, format!("names the unknown material \"{}\"{meant}; {known}", one_line(name))))
    }

    /// The index of a material that reflects nothing.
    pub fn black(&mut self) -> usize {
        if let Some(black) = self.black {
            return black;
        }
        let black = self.push(Substance::Lambertian(DVec3::ZERO), Pictures::default());
        *self.black.insert(black)
    }
}

/// Checks a quad.
pub(super) fn quad(
    document: &Document<'_>,
    path: &Path,
    table: &QuadTable,
    palette: &mut Palette,
) -> Result<Surface, SceneError> {
    let corner = vector(document, &path.key("corner"), table.corner)?;
    let edge = |key: &str, value| {
        let edge = vector(document, &path.key(key), value)?;
        if edge.length() < SHORTEST {
            let problem = format!(
                "is shorter than {SHORTEST} m, so the quad has no area; give the way from the corner to the next one"
            );
            return Err(document.field_error(&path.key(key), problem));
        }
        Ok(edge)
    };
    let (edge_u, edge_v) = (edge("edge_u", table.edge_u)?, edge("edge_v", table.edge_v)?);
    if edge_u.normalize().cross(edge_v.normalize()).length() < PARALLEL {
        let problem = "is parallel to `edge_u`, so the quad has no area; give two edges at an angle";
        return Err(document.field_error(&path.key("edge_v"), problem));
    }
    let (material, radiance) = look(document, path, table.material.as_ref(), table.radiance, palette)?;
    Ok(Surface { shape: Shape::Quad { corner, edge_u, edge_v }, material, radiance, object: 0, has_corners: false })
}

/// The material and the radiance of a surface, of which it needs one at least.
fn look(
    document: &Document<'_>,
    path: &Path,
    material: Option<&String>,
    radiance: Option<Numbers<3>>,
    palette: &mut Palette,
) -> Result<(usize, Option<DVec3>), SceneError> {
    let radiance = match radiance {
        Some(radiance) => Some(emission(document, &path.key("radiance"), radiance, "a radiance (W/sr/m²)")?),
        None => None,
    };
    let material = match (material, radiance) {
        (Some(name), _) => palette.find(document, &path.key("material"), name)?,
        (None, Some(_)) => palette.black(),
        (None, None) => {
            let problem = "lacks the field `material`; add the name of a material, or a `radiance` to make it a light";
            return Err(document.field_error(path, problem));
        }
    };
    if radiance.is_some() && !palette.materials[material].may_emit() {
        let problem = "is a mirror or dielectric, but what emits must not be; choose another or remove `radiance`";
        return Err(document.field_error(&path.key("material"), problem));
    }
    if radiance.is_some() && palette.pictures[material].cutoff > 0.0 {
        let problem = "has holes, but what emits must not; choose another or remove `radiance`";
        return Err(document.field_error(&path.key("material"), problem));
    }
    Ok((material, radiance))
}

/// Checks a sphere.
pub(super) fn sphere(
    document: &Document<'_>,
    path: &Path,
    table: &SphereTable,
    palette: &mut Palette,
) -> Result<Surface, SceneError> {
    let centre = vector(document, &path.key("centre"), table.centre)?;
    let radius = number(document, &path.key("radius"), table.radius, (SHORTEST, LARGEST), "a radius (m)")?;
    let (material, radiance) = look(document, path, table.material.as_ref(), table.radiance, palette)?;
    if palette.pictures[material].emission.is_some() && radiance.is_some() {
        let problem = "has an `emission_texture`, but spheres have no texture coordinates; choose another";
        return Err(document.field_error(&path.key("material"), problem));
    }
    Ok(Surface { shape: Shape::Sphere { centre, radius }, material, radiance, object: 0, has_corners: false })
}

/// Checks a disc.
pub(super) fn disc(
    document: &Document<'_>,
    path: &Path,
    table: &DiscTable,
    palette: &mut Palette,
) -> Result<Surface, SceneError> {
    let centre = vector(document, &path.key("centre"), table.centre)?;
    let normal = vector(document, &path.key("normal"), table.normal)?;
    if normal.length() < SHORTEST {
        return Err(document.field_error(&path.key("normal"), "has no length; use [0, 1, 0], for example"));
    }
    let radius = number(document, &path.key("radius"), table.radius, (SHORTEST, LARGEST), "a radius (m)")?;
    let (material, radiance) = look(document, path, table.material.as_ref(), table.radiance, palette)?;
    let edge_u = normal.normalize().any_orthonormal_vector() * (2.0 * radius);
    let edge_v = normal.normalize().cross(edge_u);
    let shape = Shape::Disc { corner: centre - (edge_u + edge_v) / 2.0, edge_u, edge_v };
    Ok(Surface { shape, material, radiance, object: 0, has_corners: false })
}
