//! Checks of `[materials]`.

use super::check::{number, triple};
use super::content::{Glass, Layers, Substance};
use super::document::{Document, Path};
use super::error::SceneError;
use super::file::{MaterialKind, MaterialTable};
use glam::DVec3;

/// Largest absorption coefficient, m⁻¹: a micrometre of it is black.
const MOST_ABSORBING: f64 = 1e7;
/// How far the index of a rough dielectric is from 1 at least: nearer, its rough surface bends light so little that f32 loses the angle.
const LEAST_BENDING: f64 = 0.05;

/// Checks a material.
pub(super) fn material(document: &Document<'_>, path: &Path, table: &MaterialTable) -> Result<Substance, SceneError> {
    use MaterialKind::{Conductor, Dielectric, Lambertian, MetallicRoughness, Mirror, Plastic};
    let kind = table.kind;
    let name = match kind {
        Lambertian | Mirror => "lambertian or mirror",
        Dielectric => "dielectric",
        Conductor => "conductor",
        Plastic => "plastic",
        MetallicRoughness => "metallic-roughness material",
    };
    let given = [
        (
            "reflectance",
            table.reflectance.is_some(),
            kind != Dielectric,
            "remove it: how much glass reflects follows from `ior`",
        ),
        (
            "ior",
            table.ior.is_some(),
            matches!(kind, Dielectric | Plastic | MetallicRoughness),
            "remove it, or use `kind = \"dielectric\"`",
        ),
        (
            "roughness",
            table.roughness.is_some(),
            !matches!(kind, Lambertian | Mirror),
            "remove it, or use `kind = \"conductor\"` for a rough mirror",
        ),
        (
            "metallic",
            table.metallic.is_some(),
            kind == MetallicRoughness,
            "remove it, or use `kind = \"metallic-roughness\"`",
        ),
        (
            "absorption",
            table.absorption.is_some(),
            kind == Dielectric,
            "remove it: only the inside of a dielectric absorbs",
        ),
    ];
    for (key, is_given, has_meaning, instead) in given {
        if is_given && !has_meaning {
            return Err(document.field_error(&path.key(key), format!("means nothing for a {name}; {instead}")));
        }
    }
    let share = |key: &str, value: Option<f64>, default: f64, what: &str| match value {
        Some(value) => number(document, &path.key(key), value, (0.0, 1.0), what),
        None => Ok(default),
    };
    // glTF's default is a roughness of 1; glass, metal and plastic are smooth unless it is said that they are not.
    let smooth = if kind == MetallicRoughness { 1.0 } else { 0.0 };
    let roughness = share("roughness", table.roughness, smooth, "a roughness")?;
    let alpha = roughness * roughness;
    if kind == Dielectric {
        let Some(ior) = table.ior else {
            return Err(
                document.field_error(path, "is a dielectric and lacks the field `ior`; add `ior = 1.5` for glass")
            );
        };
        let ior = number(document, &path.key("ior"), ior, (0.1, 10.0), "an index of refraction")?;
        if alpha >= smoothest() && (ior - 1.0).abs() < LEAST_BENDING {
            let problem = format!(
                "is {ior}, but that of a rough dielectric must be 1 or more than {LEAST_BENDING} away from 1 and not nearer; remove `roughness` or change it"
            );
            return Err(document.field_error(&path.key("ior"), problem));
        }
        let absorption = match table.absorption {
            Some(absorption) => triple(
                document,
                &path.key("absorption"),
                absorption,
                (0.0, MOST_ABSORBING),
                "an absorption coefficient (1/m)",
            )?,
            None => DVec3::ZERO,
        };
        return Ok(Substance::Dielectric(Glass { ior, alpha, absorption }));
    }
    let Some(reflectance) = table.reflectance else {
        return Err(document
            .field_error(path, "lacks the field `reflectance`; add `reflectance = [r, g, b]`, each from 0 to 1"));
    };
    let what = "a reflectance, the share of the light that comes back,";
    let base = triple(document, &path.key("reflectance"), reflectance, (0.0, 1.0), what)?;
    let ior = match table.ior {
        Some(ior) => number(document, &path.key("ior"), ior, (1.0, 10.0), "the index of refraction of a coat")?,
        None => 1.5,
    };
    // glTF's default of metallic is 1.
    let metallic = share("metallic", table.metallic, 1.0, "the share of metal")?;
    Ok(match kind {
        Mirror => Substance::Mirror(base),
        Conductor => Substance::Layered(Layers { base, metallic: 1.0, ior: 1.5, alpha }),
        Plastic => Substance::Layered(Layers { base, metallic: 0.0, ior, alpha }),
        MetallicRoughness => Substance::Layered(Layers { base, metallic, ior, alpha }),
        Lambertian | Dielectric => Substance::Lambertian(base),
    })
}

/// The α below which the kernels take a surface for smooth.
pub(super) fn smoothest() -> f64 {
    f64::from(caustic_kernels::trace::bsdf::SMOOTHEST)
}
