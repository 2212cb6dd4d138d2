//! How much memory a render takes, from what it is going to allocate.

use crate::chunk::Chunk;
use crate::chunked::at_once;
use crate::frame::{CPU_SAMPLES, GPU_SAMPLES};
use crate::lattice;
use crate::output::LayerKind;
use crate::scene::CompiledScene;
use crate::trace::DISPATCH;
use crate::{Integrator, Settings};
use caustic_device::Device;
use caustic_kernels::gather::{Compact, Reach};
use caustic_kernels::layout::{Arrival, Irradiance, Neighbour, Photon, Query, Site};
use caustic_kernels::sort::{DIGITS, SORT_BLOCK};
use caustic_kernels::trace::{
    BvhNode, Corners, LEDGER_PATHS, LayerPixel, LedgerBlock, LedgerSum, PART_DIRECT, Pixel, Primitive, Tally, Texel,
    Vertex,
};
use caustic_photon_map::{Filter, Gather, Nearest};

/// A map that a render is going to have.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ExpectedMap {
    /// Photons emitted.
    pub emitted: f64,
    /// Photons stored.
    pub stored: f64,
    /// Entries of its table.
    pub table: f64,
}

impl ExpectedMap {
    /// Bytes of the finished map.
    fn bytes(&self, compact: bool) -> f64 {
        self.stored * if compact { size::<Compact>() } else { size::<(Site, Arrival)>() } + 4.0 * self.table
    }

    /// Its part that is in memory at once. The table is as it is: that of a map of so many photons.
    fn of_chunk(self, settings: &Settings) -> Self {
        let (chunks, _) = settings.chunk.map_or((1, 0), |chunk| chunk.cut(self.emitted as u32));
        let share = 1.0 / f64::from(chunks.max(1));
        Self { emitted: share * self.emitted, stored: share * self.stored, ..self }
    }

    /// Most bytes while its photons are traced, stored and sorted.
    fn peak(&self, compact: bool) -> f64 {
        let chunk = self.emitted.min(f64::from(DISPATCH));
        // Counts; fates and segments with their sums; tallies and the ledger.
        let ledger = chunk / f64::from(LEDGER_PATHS) * size::<(LedgerBlock, LedgerSum)>();
        let trace = 4.0 * self.emitted + chunk * (16.0 + size::<Tally>()) + ledger;
        let store = 8.0 * self.emitted + self.stored * size::<Photon>();
        let histograms = 8.0 * f64::from(DIGITS) * self.stored / f64::from(SORT_BLOCK);
        let build = self.stored * (size::<Photon>() + 16.0) + histograms + self.bytes(compact);
        trace.max(store).max(build)
    }
}

/// Most bytes that the buffers of a render have at once: within a few percent of
/// [`RenderReport::peak_bytes`](crate::RenderReport::peak_bytes), if the maps are as expected.
#[must_use]
pub fn peak_bytes(scene: &CompiledScene, settings: &Settings, maps: [ExpectedMap; 2], device: &Device) -> u64 {
    let [width, height] = settings.size.map(f64::from);
    let pixels = width * height;
    let layers = settings.needs_layers();
    let film = pixels * (size::<Pixel>() + if layers { size::<LayerPixel>() } else { 0.0 });
    let most = f64::from(if device.is_gpu() { GPU_SAMPLES } else { CPU_SAMPLES });
    let paths = settings.integrator == Integrator::Path;
    let gathered = f64::from(if maps[0].stored > 0.0 { settings.final_gather } else { 0 });
    let rays = f64::from(settings.spp) * gathered.max(1.0);
    let tile_pixels = (most / rays).floor().clamp(1.0, pixels);
    let tile = tile_pixels * f64::from(settings.spp);
    let mut keys = 0.0;
    let mut each = size::<Vertex>() + if paths { 0.0 } else { size::<Query>() };
    each += if settings.parts() & PART_DIRECT != 0 { size::<Irradiance>() } else { 0.0 };
    let spacings = [settings.interpolate, 0];
    let of_maps = maps.iter().zip([gathered, 0.0].into_iter().zip(spacings));
    for (_, (gathered, spacing)) in of_maps.filter(|(map, _)| map.stored > 0.0) {
        // Queries are sorted, and those of a final gather are made first.
        let reached = settings.nearest == Nearest::Approximate && settings.estimate().k.is_some();
        let filtered =
            reached || settings.compact || settings.filter != Filter::Constant || settings.estimate().needs_sides();
        let search = 16.0 + if filtered { size::<Reach>() } else { 0.0 };
        each += size::<Irradiance>();
        each += if settings.layers.contains(&LayerKind::Radius) { 16.0 + size::<Reach>() } else { 0.0 };
        each += if settings.layers.contains(&LayerKind::Bias) { search + size::<Irradiance>() } else { 0.0 };
        let point = if gathered > 0.0 {
            gathered * (search + size::<(Query, Vertex)>() + size::<Irradiance>())
        } else {
            search
        };
        each += point;
        if spacing > 0 {
            let keys_of_tile = f64::from(lattice::keys(tile_pixels as u32, settings.size[0], spacing));
            keys = keys_of_tile * (point + size::<(Query, Vertex, Irradiance)>());
            each += size::<(Query, Irradiance)>();
        }
    }
    let records = scene.nodes.len() as f64 * size::<BvhNode>()
        + scene.primitives.len() as f64 * size::<Primitive>()
        + scene.corners.len() as f64 * size::<Corners>()
        + scene.texels.len() as f64 * size::<Texel>();
    if let Some(chunk) = settings.chunk {
        return (records + film + chunked(settings, chunk, maps, tile * each, device)) as u64;
    }
    let image = maps[0].bytes(settings.compact) + maps[1].bytes(settings.compact) + film + tile * each + keys;
    let photons = maps[0].peak(settings.compact).max(maps[0].bytes(settings.compact) + maps[1].peak(settings.compact));
    (records + image.max(photons)) as u64
}

/// Most bytes beside scene and film where photons come in chunks: a batch of samples with a chunk that is built or searched, or a tile that takes
/// `tile` bytes with what is known of the batch. What of it is on the host counts as well.
fn chunked(settings: &Settings, chunk: Chunk, maps: [ExpectedMap; 2], tile: f64, device: &Device) -> f64 {
    let [width, height] = settings.size.map(f64::from);
    let spp = f64::from(settings.spp);
    let samples = (width * height / f64::from(chunk.batches(settings))).ceil() * spp;
    let part = f64::from(at_once(settings)).min(samples);
    let nearest = settings.integrator != Integrator::Progressive;
    let neighbours = if nearest { part * f64::from(settings.k + 1) * size::<Neighbour>() } else { 0.0 };
    let counting = match settings.gather {
        Gather::Auto => device.is_gpu(),
        gather => gather == Gather::Histogram,
    };
    // Queries are sorted. Counting finds neighbours in no order and puts them in order beside that.
    let search = 20.0 * part + if counting { 2.0 * neighbours + 8.0 * part } else { neighbours };
    let walked = maps.iter().filter(|map| map.stored > 0.0).map(|map| {
        let map = map.of_chunk(settings);
        let powers = if nearest { map.stored * size::<[f32; 3]>() } else { 0.0 };
        // The host has powers and neighbours. That the device has its most at another time is not taken into account.
        powers + neighbours + map.peak(false).max(map.bytes(false) + search)
    });
    let known = samples * size::<(Irradiance, Irradiance)>();
    let batch = samples * Chunk::bytes_a_sample(settings) as f64;
    (batch + walked.fold(0.0, f64::max)).max(known + tile)
}

/// Bytes of a record.
fn size<T>() -> f64 {
    size_of::<T>() as f64
}
