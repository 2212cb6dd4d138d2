//! Checks of `[materials]`, `[[quads]]` and `[[spheres]]`.

use super::check::{LARGEST, PARALLEL, SHORTEST, emission, number, vector};
use super::content::{Shape, Substance, Surface};
use super::document::{Document, Path};
use super::error::SceneError;
use super::file::{MaterialTable, Numbers, QuadTable, SphereTable};
use super::substances::material;
use super::text::{nearest, one_line};
use glam::DVec3;
use std::collections::BTreeMap;

/// The materials of a scene.
#[derive(Default)]
pub(super) struct Palette<'a> {
    /// Indices by name.
    names: BTreeMap<&'a str, usize>,
    /// The materials.
    pub materials: Vec<Substance>,
    /// Index of the black of lights without a material, once there is one.
    black: Option<usize>,
}

impl<'a> Palette<'a> {
    /// Checks and adds a material.
    pub fn add(
        &mut self,
        document: &Document<'_>,
        path: &Path,
        name: &'a str,
        table: &MaterialTable,
    ) -> Result<(), SceneError> {
        self.names.insert(name, self.materials.len());
        self.materials.push(material(document, &path.key(name), table)?);
        Ok(())
    }

    /// The index of the material that the field `path` names.
    fn find(&self, document: &Document<'_>, path: &Path, name: &str) -> Result<usize, SceneError> {
        if let Some(&index) = self.names.get(name) {
            return Ok(index);
        }
        let meant = nearest(name, self.names.keys().copied());
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
    fn black(&mut self) -> usize {
        *self.black.get_or_insert_with(|| {
            self.materials.push(Substance::Lambertian(DVec3::ZERO));
            self.materials.len() - 1
        })
    }
}

/// Checks a quad.
pub(super) fn quad(
    document: &Document<'_>,
    path: &Path,
    table: &QuadTable,
    palette: &mut Palette<'_>,
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
    palette: &mut Palette<'_>,
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
    if radiance.is_some() && !matches!(palette.materials[material], Substance::Lambertian(_) | Substance::Layered(_)) {
        let problem = "is a mirror or dielectric, but what emits must not be; choose another or remove `radiance`";
        return Err(document.field_error(&path.key("material"), problem));
    }
    Ok((material, radiance))
}

/// Checks a sphere.
pub(super) fn sphere(
    document: &Document<'_>,
    path: &Path,
    table: &SphereTable,
    palette: &mut Palette<'_>,
) -> Result<Surface, SceneError> {
    let centre = vector(document, &path.key("centre"), table.centre)?;
    let radius = number(document, &path.key("radius"), table.radius, (SHORTEST, LARGEST), "a radius (m)")?;
    let (material, radiance) = look(document, path, table.material.as_ref(), table.radiance, palette)?;
    Ok(Surface { shape: Shape::Sphere { centre, radius }, material, radiance, object: 0, has_corners: false })
}
