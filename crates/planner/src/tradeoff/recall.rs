//! How many of the k nearest photons an estimate looks at, where it does not look at just these.

use caustic_device::Device;
use caustic_kernels::layout::Query;
use caustic_photon_map::{Gather, MapOptions, Nearest, PhotonMap};
use caustic_renderer::scene::Scene;
use caustic_renderer::{Integrator, PhotonFile, RenderError, Settings, View};

/// Most points of the picture that are looked at.
const POINTS: f64 = 1024.0;
/// How much farther than an estimate the k nearest are looked for.
const FARTHER: f32 = 4.0;

/// How an estimate differs from one of the k nearest photons, wherever they are.
pub struct Recall {
    /// Share of the k nearest that count: recall@k.
    pub recall: f64,
    /// Mean relative error of the distance of the last.
    pub radius_error: f64,
}

/// Recall of a render's first map, over points that its camera sees. There is none where estimates are not from k photons, where not all
/// are stored, or where there is no map.
///
/// # Errors
/// Those of renders.
pub fn recall(scene: &Scene, settings: &Settings, device: &Device) -> Result<Option<Recall>, RenderError> {
    if settings.integrator != Integrator::Photon || settings.thin > 1 {
        return Ok(None);
    }
    let traced = PhotonFile::trace(scene, settings, device, &mut |_| true)?;
    let Some(photons) = traced.photons.into_iter().find(|photons| !photons.is_empty()) else { return Ok(None) };
    let [width, height] = settings.size.map(f64::from);
    let scale = (POINTS / (width * height)).sqrt().min(1.0);
    let view = View::new(device, scene, [width, height].map(|side| ((side * scale) as u32).max(1)), 1, settings.seed)?;
    let mut queries: Vec<Query> = device.read(&view.queries, u64::from(view.count()))?;
    queries.retain(|query| query.active != 0);
    let map = |radius| {
        let options = MapOptions { radius, hash: settings.hash, table: settings.table, cell: None };
        PhotonMap::build(device, &photons, &options)
    };
    let (whole, own) = (map(FARTHER * settings.radius)?, map(settings.radius)?);
    let nearest = whole.k_nearest(device, &queries, settings.k, Gather::Auto)?;
    let exact = whole.reaches(device, &queries, settings.k, Nearest::Exact)?;
    let taken = own.reaches(device, &queries, settings.k, settings.nearest)?;
    let (mut recall, mut radius_error, mut points) = (0.0, 0.0, 0.0);
    for ((nearest, exact), taken) in nearest.iter().zip(&exact).zip(&taken).filter(|((found, _), _)| !found.is_empty())
    {
        let counted = nearest.iter().filter(|photon| photon.distance2 <= taken.radius2).count();
        recall += counted as f64 / nearest.len() as f64;
        radius_error += (f64::from(taken.radius2 / exact.radius2).sqrt() - 1.0).abs();
        points += 1.0;
    }
    Ok((points > 0.0).then(|| Recall { recall: recall / points, radius_error: radius_error / points }))
}
