//! A model file as a scene: with its own camera and lights, or with ones that show it.

use super::check::SHORTEST;
use super::content::{Glass, Lamps, Layers, NOTHING, Shape, Substance, Surface, Viewpoint};
use super::error::SceneError;
use super::limits::MAX_LIGHTS;
use super::meshes::{self, Assembly, Look};
use super::model::{self, Finish, Model};
use super::surfaces::Palette;
use super::text::one_line;
use super::{RenderDefaults, Scene, load};
use glam::DVec3;
use std::path::Path;

/// Angle of view of a camera that is put in front of a model, degrees.
const FOV: f64 = 40.0;
/// Where such a camera stands, from the middle of the model.
const FROM: DVec3 = DVec3::new(0.45, 0.4, 1.0);
/// What the lamp over a model without a light makes a white surface in its middle reflect, W·sr⁻¹·m⁻².
const BRIGHTNESS: f64 = 0.8;

/// Roughness of glass whose surface is taken for smooth.
const SMOOTH: f64 = 0.03;

/// What a finish is among the materials of a scene.
pub(super) fn substance(finish: &Finish) -> Substance {
    let base = finish.base.clamp(DVec3::ZERO, DVec3::ONE);
    let alpha = finish.roughness.clamp(0.0, 1.0).powi(2);
    if finish.transmission > 0.5 {
        let ior = finish.ior.clamp(1.0, 10.0);
        // Rough glass has to bend light.
        let alpha = if finish.roughness < SMOOTH || ior < 1.06 { 0.0 } else { alpha };
        return Substance::Dielectric(Glass { ior, alpha, absorption: DVec3::ZERO });
    }
    if !finish.coated && finish.metallic == 0.0 {
        return Substance::Lambertian(base);
    }
    let ior = finish.ior.clamp(1.0, 10.0);
    Substance::Layered(Layers { base, metallic: finish.metallic.clamp(0.0, 1.0), ior, alpha })
}

/// The scene of a model file.
pub(super) fn scene(path: &Path) -> Result<Scene, SceneError> {
    let name = path.to_string_lossy();
    let model = model::read(path)?;
    let refuse = |problem: String| SceneError::Model { path: one_line(&name), problem };
    let mut notes: Vec<String> = meshes::left_out(&one_line(&name), &model).into_iter().collect();
    let mut palette = Palette::default();
    let mut assembly = Assembly::default();
    add(&model, &mut palette, &mut assembly).map_err(refuse)?;
    let (low, high) =
        assembly.surfaces.iter().map(Surface::bounds).fold(NOTHING, |all, one| (all.0.min(one.0), all.1.max(one.1)));
    let (centre, radius) = ((low + high) / 2.0, (high - low).length() / 2.0);
    if !(radius >= SHORTEST) {
        return Err(refuse(format!("is {radius} m large, but a scene must be {SHORTEST} m at least; scale it up")));
    }
    let points: Vec<_> = model.points.iter().filter(|point| point.intensity.max_element() >= 1e-9).copied().collect();
    let suns: Vec<_> = model.suns.iter().filter(|sun| sun.irradiance.max_element() >= 1e-9).copied().collect();
    let shining = assembly.surfaces.iter().filter(|surface| surface.radiance.is_some()).count();
    if points.len() + suns.len() + shining > MAX_LIGHTS {
        let lights = points.len() + suns.len() + shining;
        return Err(refuse(format!(
            "has {lights} lights, emissive triangles among them, but a scene may have {MAX_LIGHTS}; make it emit from fewer"
        )));
    }
    if points.is_empty() && suns.is_empty() && shining == 0 {
        notes.push(
            "no light in the file: a square lamp was put above it; write a scene file around it to light it yourself"
                .into(),
        );
        let black = palette.black();
        assembly.add(lamp(centre, radius, black));
    }
    let camera = match model.cameras.first() {
        Some(camera) if usable(camera) => *camera,
        _ => {
            notes.push("no camera in the file: it is seen from the front, a little from above".into());
            framed(centre, radius)
        }
    };
    let (content, note) = assembly.finish(camera, palette, Lamps { points, suns, sky: None });
    notes.extend(note);
    Ok(Scene {
        name: load::stem(&name),
        description: format!("the model {}", one_line(&name)),
        defaults: RenderDefaults { radius: Some((radius / 20.0) as f32), ..RenderDefaults::default() },
        notes,
        content: content.localised(),
    })
}

fn add(model: &Model, palette: &mut Palette, assembly: &mut Assembly) -> Result<(), String> {
    let mut pictures = Vec::new();
    for picture in &model.pictures {
        pictures.push(assembly.add_picture(picture)?);
    }
    let mut looks = Vec::new();
    for finish in &model.finishes {
        let pictures = finish.pictures(&pictures);
        let radiance = meshes::emission(finish);
        let mut substance = substance(finish);
        if radiance.is_some() && !substance.may_emit() {
            substance = Substance::Lambertian(finish.base.clamp(DVec3::ZERO, DVec3::ONE));
        }
        let material = palette.push(substance, pictures);
        looks.push(Look { material, textured: pictures.any(), radiance, emission: pictures.emission, flat: false });
    }
    for part in &model.parts {
        let look = looks[part.finish.unwrap_or(0)];
        // A picture without coordinates shows the colour of its corner.
        assembly.add_part(part, look)?;
    }
    if assembly.surfaces.is_empty() {
        return Err("has no triangle with an area, so there is nothing to see; export it again".to_string());
    }
    Ok(())
}

/// A square as wide as the model, above it, that shines down.
fn lamp(centre: DVec3, radius: f64, black: usize) -> Surface {
    let height = 2.5 * radius;
    let corner = centre + DVec3::new(-radius, height, -radius);
    let (edge_u, edge_v) = (DVec3::X * (2.0 * radius), DVec3::Z * (2.0 * radius));
    // E = L·A / d² below a small lamp, of which white reflects E / π.
    let radiance = BRIGHTNESS * std::f64::consts::PI * height * height / (4.0 * radius * radius);
    Surface {
        shape: Shape::Quad { corner, edge_u, edge_v },
        material: black,
        radiance: Some(DVec3::splat(radiance)),
        object: 0,
        has_corners: false,
    }
}

fn framed(centre: DVec3, radius: f64) -> Viewpoint {
    let distance = 1.05 * radius / (FOV / 2.0).to_radians().sin();
    Viewpoint {
        position: centre + FROM.normalize() * distance,
        target: centre,
        up: DVec3::Y,
        vertical_fov_degrees: FOV,
        lens_radius: 0.0,
        focus: distance,
    }
}

/// Whether a camera of a file looks somewhere.
fn usable(camera: &Viewpoint) -> bool {
    let view = (camera.target - camera.position).normalize_or_zero();
    view.cross(camera.up.normalize_or_zero()).length() > 1e-6
        && (0.01..=179.0).contains(&camera.vertical_fov_degrees)
        && camera.position.is_finite()
}
