//! Checks of `[camera]` and `[render]`.

use super::RenderDefaults;
use super::check::{LARGEST, PARALLEL, SHORTEST, number, vector, whole};
use super::content::Viewpoint;
use super::document::{Document, Path};
use super::error::SceneError;
use super::file::{CameraTable, Numbers, RenderTable};
use super::limits::{MAX_K, MAX_PHOTONS, MAX_SIDE, MAX_SPP};
use glam::DVec3;

/// Checks `[camera]`.
pub(super) fn camera(document: &Document<'_>, table: &CameraTable) -> Result<Viewpoint, SceneError> {
    let path = Path::default().key("camera");
    let position = vector(document, &path.key("position"), table.position)?;
    let target = vector(document, &path.key("target"), table.target)?;
    let up = match table.up {
        Some(up) => vector(document, &path.key("up"), up)?,
        None => DVec3::Y,
    };
    let vertical_fov_degrees = number(
        document,
        &path.key("vertical_fov_degrees"),
        table.vertical_fov_degrees,
        (0.01, 179.0),
        "the angle of view (degrees)",
    )?;
    let view = target - position;
    if view.length() < SHORTEST {
        return Err(document.field_error(
            &path.key("target"),
            "is where the camera stands; move one of them, so that it looks somewhere",
        ));
    }
    let at = if table.up.is_some() { path.key("up") } else { path.clone() };
    if up.length() < SHORTEST {
        return Err(
            document.field_error(&at, "has no length, so it does not say where up is; use [0, 1, 0], for example")
        );
    }
    if view.normalize().cross(up.normalize()).length() < PARALLEL {
        return Err(if table.up.is_some() {
            document
                .field_error(&at, "is parallel to the view, so it does not say where up is; choose one across the view")
        } else {
            document.field_error(&at, "looks straight up or down, along +y, which is up where `up` is not given; add one across the view, such as `up = [0, 0, -1]`")
        });
    }
    let lens_radius = match table.lens_radius {
        Some(radius) => number(document, &path.key("lens_radius"), radius, (0.0, LARGEST), "the radius of a lens (m)")?,
        None => 0.0,
    };
    let focus = match table.focus_distance {
        Some(focus) => {
            number(document, &path.key("focus_distance"), focus, (SHORTEST, LARGEST), "the distance in focus (m)")?
        }
        // Along the view: the target is in its middle.
        None => view.length(),
    };
    Ok(Viewpoint { position, target, up, vertical_fov_degrees, lens_radius, focus })
}

/// Checks `[render]`.
pub(super) fn render(document: &Document<'_>, table: &RenderTable) -> Result<RenderDefaults, SceneError> {
    let path = Path::default().key("render");
    let count = |key: &str, value: Option<i64>, bounds: (u32, u32), what: &str| {
        value.map(|value| whole(document, &path.key(key), value, bounds, what)).transpose()
    };
    let mut size = None;
    if let Some(Numbers([width, height])) = table.size {
        let side = |i: usize, value: f64| {
            let at = path.key("size").index(i);
            let value = number(document, &at, value, (1.0, f64::from(MAX_SIDE)), "a side of the picture (pixels)")?;
            if value.fract() == 0.0 {
                Ok(value as u32)
            } else {
                Err(document.field_error(&at, format!("is {value}, but pixels come whole")))
            }
        };
        size = Some([side(0, width)?, side(1, height)?]);
    }
    let radius = match table.radius {
        Some(radius) => {
            Some(number(document, &path.key("radius"), radius, (SHORTEST, LARGEST), "the radius (m)")? as f32)
        }
        None => None,
    };
    Ok(RenderDefaults {
        size,
        photons: count("photons", table.photons, (1, MAX_PHOTONS), "the number of photons")?,
        caustic_photons: count("caustic_photons", table.caustic_photons, (0, MAX_PHOTONS), "the number of photons")?,
        k: count("k", table.k, (1, MAX_K), "the number of photons in an estimate")?,
        radius,
        spp: count("spp", table.spp, (1, MAX_SPP), "the samples a pixel")?,
    })
}
