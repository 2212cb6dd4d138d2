//! Denoising by Intel Open Image Denoise (Áfra, 2019–), through the crate `oidn`: a filter of a neural network that is shown the picture, and
//! what it is a picture of. Only with the cargo feature `denoise`, since it needs that library.
//!
//! A denoised picture is pleasant and biased, and no longer bit for bit the same on every machine: it is not for measuring.

use super::{Image, Layer, LayerKind, OutputError};

/// Layers that the filter wants to see.
pub const LAYERS: [LayerKind; 2] = [LayerKind::Albedo, LayerKind::Normal];

/// Whether this program was built with a denoiser.
#[must_use]
pub const fn can_denoise() -> bool {
    cfg!(feature = "denoise")
}

/// A denoised picture. `layers` hold those of [`LAYERS`].
///
/// # Errors
/// [`OutputError::NoDenoiser`] in a program without one, [`OutputError::Denoise`] if a layer is missing or the library fails.
pub fn denoise(image: &Image, layers: &[Layer]) -> Result<Image, OutputError> {
    let [albedo, normal] = LAYERS.map(|kind| layers.iter().find(|layer| layer.kind == kind));
    match (albedo, normal) {
        (Some(albedo), Some(normal)) => filter(image, &albedo.values, &normal.values),
        _ => Err(OutputError::Denoise { reason: "it needs the layers albedo and normal".to_string() }),
    }
}

#[cfg(not(feature = "denoise"))]
fn filter(_image: &Image, _albedo: &[f32], _normal: &[f32]) -> Result<Image, OutputError> {
    Err(OutputError::NoDenoiser)
}

#[cfg(feature = "denoise")]
fn filter(image: &Image, albedo: &[f32], normal: &[f32]) -> Result<Image, OutputError> {
    let failed = |error: oidn::Error| OutputError::Denoise { reason: error.message().to_string() };
    // The CPU: the same library on a GPU gives another picture.
    let device = oidn::Device::cpu().map_err(failed)?;
    let mut rgb = image.rgb.clone();
    // Guides are means over samples, with the noise of edges and of glass: not clean. Its own bound for albedo is 1.
    let albedo: Vec<f32> = albedo.iter().map(|x| x.clamp(0.0, 1.0)).collect();
    oidn::RayTracing::try_new(&device)
        .map_err(failed)?
        .hdr(true)
        .albedo_normal(&albedo, normal)
        .image_dimensions(image.width as usize, image.height as usize)
        .filter_in_place(rgb.as_flattened_mut())
        .map_err(failed)?;
    Ok(Image { rgb, ..image.clone() })
}

#[cfg(all(test, feature = "denoise"))]
mod tests {
    use super::*;
    use caustic_kernels::num::{pcg4d, u32_to_unit};

    /// A grey wall under noise of a half: less of it is left, and its mean is kept.
    #[test]
    fn noise_goes_and_the_mean_stays() {
        let (width, height) = (96u32, 80u32);
        let noise = |i: u32| 0.5 + u32_to_unit(pcg4d([i, 7, 0, 0])[0]);
        let rgb: Vec<[f32; 3]> =
            (0..width * height).map(|i| [noise(3 * i), noise(3 * i + 1), noise(3 * i + 2)]).collect();
        let image = Image { width, height, rgb };
        let layers = [
            Layer { kind: LayerKind::Albedo, values: vec![0.5; image.rgb.len() * 3] },
            Layer { kind: LayerKind::Normal, values: [0.0, 1.0, 0.0].repeat(image.rgb.len()) },
        ];
        let denoised = denoise(&image, &layers).unwrap();
        let moments = |image: &Image| {
            let values = image.rgb.as_flattened();
            let mean = values.iter().sum::<f32>() / values.len() as f32;
            (mean, values.iter().map(|x| (x - mean).powi(2)).sum::<f32>() / values.len() as f32)
        };
        let (before, after) = (moments(&image), moments(&denoised));
        assert!(after.1 < 0.1 * before.1, "variance {} of {}", after.1, before.1);
        // The library promises no mean: it keeps this one within a few percent.
        assert!((after.0 / before.0 - 1.0).abs() < 0.05, "mean {} of {}", after.0, before.0);
    }
}
