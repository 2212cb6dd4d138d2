//! Direct visualisation of photons by any technique (section 5.5).

use crate::case::Case;
use crate::figure::Results;
use crate::measure::Measured;
use crate::stage::Stage;
use crate::store::Outcome;
use crate::subject::Subject;
use caustic_bench::Trouble;
use caustic_metrics as metrics;
use caustic_renderer::output::{self, Image};
use image::ImageEncoder;
use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::{Path, PathBuf};

/// Where the picture of a case is.
pub(crate) fn path(folder: &Path, case: &Case) -> PathBuf {
    let name = case.to_string().replace(' ', "-");
    folder.join("pictures").join(format!("{name}.exr"))
}

/// Copies the pictures of one folder to another.
pub(crate) fn copy(from: &Path, to: &Path) -> Result<(), String> {
    let (from, to) = (from.join("pictures"), to.join("pictures"));
    let Ok(files) = std::fs::read_dir(&from) else { return Ok(()) };
    let told = |error: std::io::Error| format!("cannot copy `{}` to `{}`: {error}", from.display(), to.display());
    std::fs::create_dir_all(&to).map_err(told)?;
    for file in files {
        let file = file.map_err(told)?;
        std::fs::copy(file.path(), to.join(file.file_name())).map_err(told)?;
    }
    Ok(())
}

/// Makes the picture of a case and writes it to a file.
pub(crate) fn measure(stage: &mut Stage, subject: &Subject, case: &Case, folder: &Path) -> Result<Measured, Trouble> {
    let image = picture(stage, subject, case)?;
    let path = path(folder, case);
    let fail = |error: &dyn std::fmt::Display| Trouble::Fail(format!("cannot write `{}`: {error}", path.display()));
    std::fs::create_dir_all(folder.join("pictures")).map_err(|error| fail(&error))?;
    output::write(&path, &image, &output::Metadata::default()).map_err(|error| fail(&error))?;
    Ok((Outcome::Values(BTreeMap::new()), Some(image.sha256())))
}

fn picture(stage: &mut Stage, subject: &Subject, case: &Case) -> Result<Image, Trouble> {
    stage.look(case.size)?;
    stage.photons(case.map, case.photons, subject.on_cpu)?;
    let (device, photons) = (stage.device_of(subject.on_cpu), stage.uploaded());
    let (view, queries) = stage.view();
    let index = subject.technique.build(device, photons, case.radius())?;
    let estimates = caustic_rivals::irradiance(device, index.as_ref(), photons, case.radius(), queries, case.k)?;
    Ok(view.develop(stage.device, &estimates)?)
}

/// The picture of a case as PNG, if it was made.
pub(crate) fn png(results: &Results, case: &Case) -> Option<Vec<u8>> {
    let image = output::read(&path(results.folder, case)).ok()?;
    let bytes: Vec<u8> = image.rgb.as_flattened().iter().map(|&value| output::to_srgb8(value)).collect();
    let mut png = Cursor::new(Vec::new());
    let encoder = image::codecs::png::PngEncoder::new(&mut png);
    encoder.write_image(&bytes, image.width, image.height, image::ExtendedColorType::Rgb8).ok()?;
    Some(png.into_inner())
}

/// Number of pixels that look different from those of another subject's picture, by Yee's metric, if both were made.
pub(crate) fn perceptibly_different(results: &Results, case: &Case, other: &str) -> Option<f64> {
    let other = Case { subject: other.to_string(), ..case.clone() };
    let read = |case: &Case| metrics::Image::read(&path(results.folder, case)).ok();
    let metric = metrics::Metric::Yee(metrics::YeeOptions::default());
    Some(metrics::compare(&read(case)?, &read(&other)?, metric).ok()?.value)
}
