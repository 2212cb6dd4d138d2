//! Checks of `[[lights]]`.

use super::check::{SHORTEST, emission, number, vector};
use super::content::{PointLight, Spot, Sun};
use super::document::{Document, Path};
use super::error::SceneError;
use super::file::{LightKind, LightTable, Numbers};
use super::generated::{self, SKY};
use super::sky::Panorama;
use glam::DVec3;
use std::path::Path as FilePath;

/// A light that is not a surface.
pub(super) enum Lamp {
    Point(PointLight),
    Sun(Sun),
    /// An environment: what its pixels are multiplied with, and the angle by which it is turned, radians.
    Sky(Panorama, DVec3, f64),
}

/// Narrowest cone of a spot, degrees.
const NARROWEST: f64 = 0.1;

/// Checks a light of a file in `folder`.
pub(super) fn lamp(
    document: &Document<'_>,
    path: &Path,
    table: &LightTable,
    folder: &FilePath,
) -> Result<Lamp, SceneError> {
    let kind = table.kind;
    let name = match kind {
        LightKind::Point => "a point",
        LightKind::Spot => "a spot",
        LightKind::Directional => "a directional light",
        LightKind::Environment => "an environment",
    };
    let (spot, directional) = (kind == LightKind::Spot, kind == LightKind::Directional);
    let environment = kind == LightKind::Environment;
    let given = [
        ("position", table.position.is_some(), spot || kind == LightKind::Point),
        ("intensity", table.intensity.is_some(), spot || kind == LightKind::Point),
        ("direction", table.direction.is_some(), spot || directional),
        ("inner_degrees", table.inner_degrees.is_some(), spot),
        ("outer_degrees", table.outer_degrees.is_some(), spot),
        ("irradiance", table.irradiance.is_some(), directional),
        ("radiance", table.radiance.is_some(), environment),
        ("file", table.file.is_some(), environment),
        ("rotation_degrees", table.rotation_degrees.is_some(), environment),
    ];
    for (key, is_given, has_meaning) in given {
        if is_given && !has_meaning {
            return Err(document.field_error(&path.key(key), format!("means nothing for {name}; remove it")));
        }
    }
    if environment {
        return sky(document, path, table, folder);
    }
    let needed = |key: &str, value: Option<Numbers<3>>, how: &str| {
        value.ok_or_else(|| document.field_error(path, format!("lacks the field `{key}`; add {how}")))
    };
    let direction = || {
        let value = needed("direction", table.direction, "`direction = [x, y, z]`, the way its light travels")?;
        let direction = vector(document, &path.key("direction"), value)?;
        if direction.length() < SHORTEST {
            return Err(document
                .field_error(&path.key("direction"), "has no length, so it points nowhere; use [0, -1, 0] for down"));
        }
        Ok(direction.normalize())
    };
    if directional {
        let value = needed("irradiance", table.irradiance, "`irradiance = [r, g, b]`, in W/m²")?;
        let irradiance = emission(document, &path.key("irradiance"), value, "an irradiance (W/m²)")?;
        return Ok(Lamp::Sun(Sun { direction: direction()?, irradiance }));
    }
    let position = needed("position", table.position, "`position = [x, y, z]`, in metres")?;
    let position = vector(document, &path.key("position"), position)?;
    let intensity = needed("intensity", table.intensity, "`intensity = [r, g, b]`, in W/sr")?;
    let intensity = emission(document, &path.key("intensity"), intensity, "an intensity (W/sr)")?;
    let spot = if spot { Some(cone(document, path, table, direction()?)?) } else { None };
    Ok(Lamp::Point(PointLight { position, intensity, spot }))
}

fn sky(document: &Document<'_>, path: &Path, table: &LightTable, folder: &FilePath) -> Result<Lamp, SceneError> {
    let radiance = match table.radiance {
        Some(radiance) => emission(document, &path.key("radiance"), radiance, "a radiance (W/sr/m²) or its factor")?,
        None if table.file.is_some() => DVec3::ONE,
        None => {
            let problem = "lacks the field `radiance`; add `radiance = [r, g, b]`, in W/sr/m², or a `file`";
            return Err(document.field_error(path, problem));
        }
    };
    let turned = table.rotation_degrees.unwrap_or(0.0);
    let turned = number(document, &path.key("rotation_degrees"), turned, (-36e3, 36e3), "an angle (degrees)")?;
    let panorama = match &table.file {
        None => Panorama::even(),
        Some(name) if name == SKY => generated::sky(),
        Some(file) => {
            let refuse = |problem: String| document.field_error(&path.key("file"), problem);
            if file.starts_with("built-in:") {
                return Err(refuse(format!("is no environment that is built in; \"{SKY}\" is one")));
            }
            Panorama::read(&folder.join(file)).map_err(refuse)?
        }
    };
    Ok(Lamp::Sky(panorama, radiance, turned.to_radians()))
}

fn cone(document: &Document<'_>, path: &Path, table: &LightTable, axis: DVec3) -> Result<Spot, SceneError> {
    let Some(outer) = table.outer_degrees else {
        return Err(document.field_error(path, "lacks the field `outer_degrees`; add the angle from its axis from which on it is dark, for example `outer_degrees = 30`"));
    };
    let what = "the angle between a spot's axis and its rim (degrees)";
    let outer = number(document, &path.key("outer_degrees"), outer, (NARROWEST, 90.0), what)?;
    let inner = number(
        document,
        &path.key("inner_degrees"),
        table.inner_degrees.unwrap_or(0.0),
        (0.0, outer),
        "the angle up to which a spot is bright (degrees, not above `outer_degrees`)",
    )?;
    // Without a rim between the two, the falloff would divide by nothing.
    let inner = inner.min(outer * 0.999);
    let one_minus_cos = |degrees: f64| 2.0 * (degrees.to_radians() / 2.0).sin().powi(2);
    Ok(Spot { axis, inner: one_minus_cos(inner), outer: one_minus_cos(outer) })
}
