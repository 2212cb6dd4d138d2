//! A photon pass: what it traces, and the map of it.

use crate::buffers::SceneBuffers;
use crate::photon_file::PhotonFile;
use crate::report::{MapReport, Progress};
use crate::scene::CompiledScene;
use crate::trace::trace;
use crate::{Feature, RenderError, Settings, Show, decide};
use caustic_device::{Buffer, Device, Plan};
use caustic_kernels::grid::Grid;
use caustic_kernels::layout::Photon;
use caustic_kernels::trace::{RAY_CAUSTIC, RAY_GLOBAL};
use caustic_photon_map::{MapOptions, PhotonMap, SeenCells, plan_grid};

/// Photons that are looked at to choose the width of cells.
const SAMPLE: u64 = 4096;

/// Which photons a pass traces and stores.
pub(crate) struct PassKind {
    /// Name of the map.
    pub(crate) map: &'static str,
    /// Name of the phase in progress reports.
    pub(crate) phase: &'static str,
    /// Flag that sets the number of photons.
    pub(crate) flag: &'static str,
    /// Photons emitted.
    pub(crate) emitted: u32,
    /// [`PhotonPass::rays`].
    pub(crate) rays: u32,
    /// [`PhotonPass::stored_from`].
    pub(crate) stored_from: u32,
    /// [`PhotonPass::thin`].
    pub(crate) thin: u32,
    /// Whether an empty map is an error: it was asked for by name.
    pub(crate) wanted: bool,
}

impl PassKind {
    /// The passes that a picture needs: of the global map and of the caustic one, if it is wanted and there can be one.
    pub(crate) fn of(settings: &Settings, scene: &CompiledScene) -> [Option<Self>; 2] {
        let Settings { photons, caustic_photons, show, final_gather, thin, .. } = *settings;
        let modelled = |feature| decide(scene, settings).iter().any(|one| one.feature == feature && one.modelled);
        [
            modelled(Feature::GlobalMap).then(|| Self::global(photons, show, final_gather > 0)),
            modelled(Feature::CausticMap).then(|| Self::caustic(caustic_photons, show)),
        ]
        .map(|kind| kind.map(|kind| Self { thin, ..kind }))
    }

    /// Direct light comes from shadow rays, so the global map of a picture holds only what was reflected before; shown by
    /// itself, it holds all, as it does for a final gather, whose rays see direct light as well.
    pub(crate) fn global(emitted: u32, show: Show, gathered: bool) -> Self {
        Self {
            map: "global",
            phase: "global photons",
            flag: "photons",
            emitted,
            rays: RAY_GLOBAL,
            stored_from: u32::from(show != Show::MapGlobal && !gathered),
            thin: 1,
            wanted: show != Show::Beauty,
        }
    }

    /// Light that comes to a diffuse surface through mirrors and glass alone.
    pub(crate) fn caustic(emitted: u32, show: Show) -> Self {
        Self {
            map: "caustic",
            phase: "caustic photons",
            flag: "caustic-photons",
            emitted,
            rays: RAY_CAUSTIC,
            stored_from: 0,
            thin: 1,
            wanted: show != Show::Beauty,
        }
    }
}

/// Traces the photons of a pass, or takes them from a file, and builds the map of those near cells that are `seen`, or of all. There is no map
/// if nothing was stored.
pub(crate) fn photon_map(
    device: &Device,
    scene: &CompiledScene,
    buffers: &SceneBuffers,
    settings: &Settings,
    kind: &PassKind,
    file: Option<&PhotonFile>,
    seen: Option<&SeenCells>,
    progress: &mut dyn FnMut(Progress) -> bool,
) -> Result<(Option<PhotonMap>, MapReport), RenderError> {
    let (photons, mut report) = match file {
        Some(file) => file.upload(device, kind)?,
        None => trace(device, scene, buffers, settings.seed, kind, progress)?,
    };
    let Some(mut unsorted) = photons else { return Ok((None, report)) };
    if let Some(seen) = seen {
        (unsorted, report.photons_kept) = seen.keep(device, &unsorted, report.photons_stored)?;
    }
    let grid = grid(device, scene, settings, &unsorted, report.photons_kept)?;
    let mut plan = Plan::new();
    plan.scope(kind.map);
    let plan_map = if settings.compact { PhotonMap::plan_compact } else { PhotonMap::plan };
    let map = plan_map(device, &mut plan, &unsorted, grid)?;
    if settings.estimate().needs_sides() {
        map.plan_sides(&mut plan, &buffers.primitives);
    }
    device.run(&plan)?;
    report.tell(&map);
    if settings.health {
        report.health = Some(map.health(device)?);
    }
    Ok((Some(map), report))
}

/// The grid of a map of the `stored` photons in a buffer.
pub(crate) fn grid(
    device: &Device,
    scene: &CompiledScene,
    settings: &Settings,
    photons: &Buffer,
    stored: u32,
) -> Result<Grid, RenderError> {
    let (low, high) = scene.diffuse_bounds;
    let positions = sample(device, photons, stored.into())?;
    let options = MapOptions { radius: settings.radius, hash: settings.hash, table: settings.table, cell: None };
    Ok(plan_grid(low, high, stored.into(), &positions, &options)?)
}

/// Positions of some of the `stored` photons of a pass, m. Paths are independent, so the first photons are as good a sample as any.
pub(crate) fn sample(device: &Device, photons: &Buffer, stored: u64) -> Result<Vec<[f32; 3]>, RenderError> {
    let first: Vec<Photon> = device.read(photons, stored.min(SAMPLE))?;
    Ok(first.iter().map(|photon| photon.position).collect())
}
