//! From the fields of a file to a scene that can be rendered, or to the first thing that is wrong.

use super::RenderDefaults;
use super::content::{Content, Shape, Substance};
use super::document::{Document, Path};
use super::error::SceneError;
use super::file::SceneFile;
use super::lamps::{Lamp, lamp};
use super::limits::{MAX_LIGHTS, MAX_SURFACES};
use super::surfaces::{Palette, quad, sphere};
use super::view::{camera, render};
use glam::DVec3;

/// Checks everything but the syntax.
pub(super) fn validate(document: &Document<'_>, file: &SceneFile) -> Result<(RenderDefaults, Content), SceneError> {
    let top = Path::default();
    let camera = camera(document, &file.camera)?;
    let defaults = render(document, &file.render)?;
    let mut palette = Palette::default();
    for (name, table) in &file.materials {
        palette.add(document, &top.key("materials"), name, table)?;
    }
    let mut surfaces = Vec::new();
    for (i, table) in file.quads.iter().enumerate() {
        let path = named(&top.key("quads").index(i), table.name.as_ref());
        surfaces.push(quad(document, &path, table, &mut palette)?);
    }
    for (i, table) in file.spheres.iter().enumerate() {
        let path = named(&top.key("spheres").index(i), table.name.as_ref());
        surfaces.push(sphere(document, &path, table, &mut palette)?);
    }
    let (mut points, mut suns) = (Vec::new(), Vec::new());
    for (i, table) in file.lights.iter().enumerate() {
        let path = named(&top.key("lights").index(i), table.name.as_ref());
        match lamp(document, &path, table)? {
            Lamp::Point(point) => points.push(point),
            Lamp::Sun(sun) => suns.push(sun),
        }
    }
    let content = Content {
        camera,
        materials: palette.materials,
        surfaces,
        corners: Vec::new(),
        textures: Vec::new(),
        texels: Vec::new(),
        points,
        suns,
        origin: glam::DVec3::ZERO,
    };
    whole_scene(document, &content)?;
    Ok((defaults, content.localised()))
}

fn named(path: &Path, name: Option<&String>) -> Path {
    match name {
        Some(name) => path.named(name),
        None => path.clone(),
    }
}

/// Checks that concern more than one object.
fn whole_scene(document: &Document<'_>, content: &Content) -> Result<(), SceneError> {
    let top = Path::default();
    let error = |problem: String| Err(document.field_error(&top, problem));
    let surfaces = content.surfaces.len();
    if surfaces == 0 {
        return error("has no surface, so there is nothing to see; add [[quads]] or [[spheres]]".to_string());
    }
    if surfaces > MAX_SURFACES {
        return error(format!("has {surfaces} surfaces, but may have {MAX_SURFACES} at most; remove some"));
    }
    let lights = content.points.len()
        + content.suns.len()
        + content.surfaces.iter().filter(|surface| surface.radiance.is_some()).count();
    if lights == 0 {
        return error("has no light, so it would be black; give a quad a `radiance` or add [[lights]]".to_string());
    }
    if lights > MAX_LIGHTS {
        return error(format!("has {lights} lights, but may have {MAX_LIGHTS} at most; remove some"));
    }
    // The kernels leave out the factors by which radiance changes in and out of glass, because they cancel on paths that
    // begin and end outside.
    if inside_glass(content, content.camera.position) {
        let problem = "is inside a dielectric sphere; put the camera outside of it";
        return Err(document.field_error(&top.key("camera").key("position"), problem));
    }
    for (i, point) in content.points.iter().enumerate() {
        if inside_glass(content, point.position) {
            let problem = "is inside a dielectric sphere; put the light outside of it";
            return Err(document.field_error(&top.key("lights").index(i).key("position"), problem));
        }
    }
    Ok(())
}

fn inside_glass(content: &Content, point: DVec3) -> bool {
    content.surfaces.iter().any(|surface| match surface.shape {
        Shape::Sphere { centre, radius } => {
            matches!(content.materials[surface.material], Substance::Dielectric(_)) && point.distance(centre) < radius
        }
        Shape::Quad { .. } | Shape::Disc { .. } | Shape::Triangle { .. } => false,
    })
}
