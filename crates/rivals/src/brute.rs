//! Brute force (thesis, section 2.2), in chunks of queries.

use crate::{PhotonIndex, Photons};
use caustic_device::{Buffer, Device, Kernel, Plan};
use caustic_kernels::rivals::{BRUTE_TILE, BruteParams};
use caustic_photon_map::{MapError, Neighbours, RADII};

/// Bytes of a distance matrix in a CPU's memory: what a cache holds, since a sort comes back to its column. On a GPU the sort has a lane a
/// column, so that the more columns fit the better.
const CPU_MATRIX: u64 = 1 << 24;

/// How brute force sorts the distances of a query.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BruteSort {
    /// Insertion sort of the first k (Garcia et al.): the faster up to a hundred neighbours, they say.
    Insertion,
    /// Comb sort of all distances (Dobosiewicz 1980), with which they began.
    Comb,
}

/// Photons among which brute force searches: as they lie, nothing is built. Stages are named after the rows of the thesis's table 3, so that
/// [`Device::stage_times`] has its decomposition: `brute_distance`, `brute_insertion_sort` or `brute_comb_sort`, `brute_copy`.
pub struct BruteForce {
    photons: Buffer,
    count: u32,
    radius: f32,
    sort: BruteSort,
    matrix: Option<u64>,
}

impl BruteForce {
    /// Brute force with at most `matrix` bytes for the distances of a chunk of queries, but at least one query a chunk. If not
    /// given: what a GPU's largest buffer holds, 16 MiB on the CPU.
    ///
    /// # Errors
    /// [`MapError::Radius`].
    pub fn new(photons: &Photons, radius: f32, sort: BruteSort, matrix: Option<u64>) -> Result<Self, MapError> {
        if !RADII.contains(&radius) {
            return Err(MapError::Radius { radius });
        }
        Ok(Self { photons: photons.buffer.clone(), count: photons.count, radius, sort, matrix })
    }

    /// Queries whose distances a matrix has room for, and whose places 32 bits count.
    fn columns(&self, device: &Device) -> u32 {
        let bytes = self.matrix.unwrap_or(if device.is_gpu() { u64::MAX } else { CPU_MATRIX });
        let bytes = bytes.min(device.largest_buffer());
        let places = (bytes / 4).min(u64::from(u32::MAX - BRUTE_TILE));
        let columns = (places / u64::from(self.count.max(1))).max(1) as u32;
        // Rows of whole cache lines, where there is a choice.
        if columns > 32 { columns / 32 * 32 } else { columns }
    }
}

impl PhotonIndex for BruteForce {
    fn search(&self, device: &Device, queries: &Buffer, count: u32, k: u32) -> Result<Neighbours, MapError> {
        let found = Neighbours::new(device, count, k)?;
        let columns = self.columns(device).min(count.max(1));
        let (sort, rows) = match self.sort {
            BruteSort::Insertion => (Kernel::BruteInsertionSort, k.min(self.count)),
            BruteSort::Comb => (Kernel::BruteCombSort, self.count),
        };
        let matrix = |rows: u32| u64::from(columns) * u64::from(rows);
        let params = device.scratch::<BruteParams>("brute force: params", 1)?;
        let distances = device.scratch::<f32>("brute force: distances", matrix(self.count))?;
        let indices = device.scratch::<u32>("brute force: indices", matrix(rows))?;
        let sorted = device.scratch::<u32>("brute force: sorted", u64::from(columns))?;
        let mut first = 0;
        while first < count {
            let queries_here = columns.min(count - first);
            let chunk = BruteParams {
                first,
                queries: queries_here,
                columns,
                photons: self.count,
                k,
                radius2: self.radius * self.radius,
            };
            device.write(&params, &[chunk]);
            let mut plan = Plan::new();
            let tiles = queries_here.div_ceil(BRUTE_TILE) * self.count.div_ceil(BRUTE_TILE);
            plan.groups(Kernel::BruteDistance, tiles, &[&params, queries, &self.photons, &distances]);
            plan.each(sort, queries_here, &[&params, &distances, &indices, &sorted]);
            let copied = [&params, queries, &distances, &indices, &sorted, &found.neighbours, &found.counts];
            plan.each(Kernel::BruteCopy, queries_here * k, &copied);
            device.run(&plan)?;
            first += queries_here;
        }
        Ok(found)
    }

    fn bytes(&self) -> u64 {
        0
    }
}
