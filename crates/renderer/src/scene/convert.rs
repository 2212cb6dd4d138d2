//! Scenes as files of other kinds.

use super::Scene;
use super::content::{PointLight, Shape, Surface};
use super::error::SceneError;
use super::model::is_model;
use super::text::one_line;
use glam::DVec3;
use std::fmt::Write;
use std::path::Path;

/// Sides of a sphere's or disc's equator when it becomes triangles.
const SIDES: u32 = 48;

/// What a scene is turned into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// A scene file around a model, to go on from.
    Toml,
    /// All surfaces as triangles, without materials.
    Ply,
}

impl Target {
    /// What the file's ending asks for.
    ///
    /// # Errors
    /// If it is not one of the known ones.
    pub fn of(path: &Path) -> Result<Self, SceneError> {
        match path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).as_deref() {
            Some("toml") => Ok(Self::Toml),
            Some("ply") => Ok(Self::Ply),
            _ => Err(SceneError::Ending { path: one_line(&path.to_string_lossy()) }),
        }
    }
}

/// The bytes of the scene of `input` as a file at `output`.
pub(super) fn convert(scene: &Scene, input: &str, output: &Path, target: Target) -> Result<Vec<u8>, SceneError> {
    match target {
        Target::Ply => Ok(ply(scene)),
        Target::Toml if is_model(Path::new(input)) => Ok(toml(scene, input, output).into_bytes()),
        Target::Toml => Err(SceneError::AlreadyToml { path: one_line(input) }),
    }
}

/// A binary PLY of all surfaces as triangles.
fn ply(scene: &Scene) -> Vec<u8> {
    let triangles: Vec<[DVec3; 3]> =
        scene.content.surfaces.iter().flat_map(triangles).map(|t| t.map(|v| v - scene.content.origin)).collect();
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\ncomment {}\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
         element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
        one_line(&scene.name),
        3 * triangles.len(),
        triangles.len()
    )
    .into_bytes();
    for corner in triangles.iter().flatten() {
        bytes.extend(corner.to_array().iter().flat_map(|x| x.to_le_bytes()));
    }
    for i in 0..triangles.len() as u32 {
        bytes.push(3);
        bytes.extend([3 * i, 3 * i + 1, 3 * i + 2].iter().flat_map(|index| index.to_le_bytes()));
    }
    bytes
}

fn triangles(surface: &Surface) -> Vec<[DVec3; 3]> {
    let around = |i: u32| (f64::from(i % SIDES) / f64::from(SIDES) * std::f64::consts::TAU).sin_cos();
    match surface.shape {
        Shape::Triangle { corners } => vec![corners],
        Shape::Quad { corner, edge_u, edge_v } => {
            let [b, c, d] = [corner + edge_u, corner + edge_u + edge_v, corner + edge_v];
            vec![[corner, b, c], [corner, c, d]]
        }
        Shape::Disc { corner, edge_u, edge_v } => {
            let centre = corner + (edge_u + edge_v) / 2.0;
            let at = |i| {
                let (sin, cos) = around(i);
                centre + edge_u * (cos / 2.0) + edge_v * (sin / 2.0)
            };
            (0..SIDES).map(|i| [centre, at(i), at(i + 1)]).collect()
        }
        Shape::Sphere { centre, radius } => {
            let at = |i: u32, k: u32| {
                let (sin, cos) = around(i);
                let (height, ring) = match k {
                    0 => (-1.0, 0.0),
                    k if 2 * k == SIDES => (1.0, 0.0),
                    k => {
                        let (s, c) = (f64::from(k) / f64::from(SIDES) * std::f64::consts::TAU).sin_cos();
                        (-c, s)
                    }
                };
                centre + DVec3::new(ring * cos, height, -ring * sin) * radius
            };
            let mut all = Vec::new();
            for k in 0..SIDES / 2 {
                for i in 0..SIDES {
                    let [a, b, c, d] = [at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1)];
                    if k > 0 {
                        all.push([a, b, c]);
                    }
                    if k + 1 < SIDES / 2 {
                        all.push([a, c, d]);
                    }
                }
            }
            all
        }
    }
}

/// A scene file that has the model as a mesh, and what was put around it.
fn toml(scene: &Scene, input: &str, output: &Path) -> String {
    let text = |v: DVec3| format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z);
    let string = |text: &str| toml::Value::String(text.to_string()).to_string();
    // As the new file sees it.
    let beside = output.parent().is_some_and(|folder| Path::new(input).parent() == Some(folder));
    let file = match Path::new(input).file_name() {
        Some(name) if beside => name.to_string_lossy().into_owned(),
        _ => std::path::absolute(input).map_or(input.to_string(), |path| path.to_string_lossy().into_owned()),
    };
    let (view, origin) = (&scene.content.camera, scene.content.origin);
    let mut out = String::new();
    let _ = writeln!(out, "# A scene around a model; docs/scene-format.md has what else it may say.");
    let _ = writeln!(out, "description = {}\n", string(&scene.description));
    let _ = writeln!(
        out,
        "[camera]\nposition = {}\ntarget = {}\nup = {}\nvertical_fov_degrees = {:?}\n",
        text(view.position - origin),
        text(view.target - origin),
        text(view.up),
        view.vertical_fov_degrees
    );
    if let Some(radius) = scene.defaults.radius {
        let _ = writeln!(out, "[render]\nradius = {radius:?}\n");
    }
    let _ = writeln!(
        out,
        "# It brings its own materials; `material = \"NAME\"` would put one of this file in their place."
    );
    let _ = writeln!(out, "[[meshes]]\nname = \"model\"\nfile = {}\n", string(&file));
    for surface in &scene.content.surfaces {
        if let (Shape::Quad { corner, edge_u, edge_v }, Some(radiance)) = (surface.shape, surface.radiance) {
            let _ = writeln!(
                out,
                "[[quads]]\nname = \"lamp\"\ncorner = {}\nedge_u = {}\nedge_v = {}\nradiance = {}\n",
                text(corner - origin),
                text(edge_u),
                text(edge_v),
                text(radiance)
            );
        }
    }
    for PointLight { position, intensity, spot } in &scene.content.points {
        let kind = if spot.is_some() { "spot" } else { "point" };
        let _ = writeln!(
            out,
            "[[lights]]\nkind = \"{kind}\"\nposition = {}\nintensity = {}",
            text(*position - origin),
            text(*intensity)
        );
        if let Some(spot) = spot {
            let angle = |depth: f64| (1.0 - depth).acos().to_degrees();
            let (axis, inner, outer) = (text(spot.axis), angle(spot.inner), angle(spot.outer).clamp(0.1, 90.0));
            let _ = writeln!(out, "direction = {axis}\ninner_degrees = {inner:?}\nouter_degrees = {outer:?}");
        }
        out.push('\n');
    }
    for sun in &scene.content.suns {
        let _ = writeln!(
            out,
            "[[lights]]\nkind = \"directional\"\ndirection = {}\nirradiance = {}\n",
            text(sun.direction),
            text(sun.irradiance)
        );
    }
    out
}
