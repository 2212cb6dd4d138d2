//! Bounds of numbers, and the sentences about numbers outside of them.

use super::document::{Document, Path};
use super::error::SceneError;
use super::file::Numbers;
use glam::DVec3;

/// Farthest from 0 that any number of a scene may be.
pub(super) const LARGEST: f64 = 1e9;
/// Shortest edge or radius, m.
pub(super) const SHORTEST: f64 = 1e-6;

/// Sine of the smallest angle at which two directions still span a plane.
pub(super) const PARALLEL: f64 = 1e-6;

/// A number from `min` to `max`; `what` says in words what it is.
pub(super) fn number(
    document: &Document<'_>,
    path: &Path,
    value: f64,
    (min, max): (f64, f64),
    what: &str,
) -> Result<f64, SceneError> {
    if value >= min && value <= max {
        return Ok(value);
    }
    Err(document.field_error(path, format!("is {value}, but {what} must be from {min} to {max}")))
}

/// A whole number from `min` to `max`.
pub(super) fn whole(
    document: &Document<'_>,
    path: &Path,
    value: i64,
    (min, max): (u32, u32),
    what: &str,
) -> Result<u32, SceneError> {
    match u32::try_from(value) {
        Ok(value) if value >= min && value <= max => Ok(value),
        _ => Err(document.field_error(path, format!("is {value}, but {what} must be from {min} to {max}"))),
    }
}

/// Three numbers from `min` to `max`.
pub(super) fn triple(
    document: &Document<'_>,
    path: &Path,
    value: Numbers<3>,
    bounds: (f64, f64),
    what: &str,
) -> Result<DVec3, SceneError> {
    for (i, component) in value.0.into_iter().enumerate() {
        number(document, &path.index(i), component, bounds, what)?;
    }
    Ok(DVec3::from_array(value.0))
}

/// A point or a direction.
pub(super) fn vector(document: &Document<'_>, path: &Path, value: Numbers<3>) -> Result<DVec3, SceneError> {
    triple(document, path, value, (-LARGEST, LARGEST), "a coordinate")
}

/// Radiance or intensity, of which at least one colour is not 0.
pub(super) fn emission(
    document: &Document<'_>,
    path: &Path,
    value: Numbers<3>,
    what: &str,
) -> Result<DVec3, SceneError> {
    let emission = triple(document, path, value, (0.0, LARGEST), what)?;
    if emission.max_element() < 1e-9 {
        return Err(document.field_error(
            path,
            format!("is dark, but {what} must have a colour of at least 1e-9; remove it or make it shine"),
        ));
    }
    Ok(emission)
}
