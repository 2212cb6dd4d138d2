//! Building a photon map and searching it.

use super::map::{Prepared, check, digest};
use super::{Trouble, Units, Work, timed, traffic};
use crate::case::{Map, Output};
use crate::digest::Digest;
use crate::measure::Policy;
use crate::points::Points;
use crate::row::{Peer, Sample};
use crate::{exact, peers};
use caustic_device::{Buffer, Device, Plan};
use caustic_kernels::gather::CUT_SHORT;
use caustic_kernels::layout::{Irradiance, Neighbour, Query};
use caustic_photon_map::{Gather, MapError, Neighbours};

pub(super) struct Search<'a> {
    device: &'a Device,
    plan: Plan,
    prepared: Prepared,
    queries: Vec<Query>,
    k: u32,
    gather: Gather,
    result: Found,
}

/// Where a run leaves what it found.
enum Found {
    /// Estimates, in a buffer of the plan.
    Estimates(Buffer),
    /// Estimates from all photons within the radius.
    Densities(Buffer),
    /// Neighbours, likewise.
    Neighbours(Neighbours),
}

impl<'a> Search<'a> {
    pub(super) fn new(
        device: &'a Device,
        n: u32,
        map: &Map,
        queries: u32,
        output: Output,
        gather: Gather,
    ) -> Result<Self, Trouble> {
        let points = Points::new(map.distribution, n, map.k);
        let mut plan = Plan::new();
        // A search of fixed extent wants cells of a fixed part of it; one that ends early wants few photons a cell.
        let cell = (output == Output::Density).then(|| 0.5 * map.radius(n));
        let prepared = Prepared::new(device, &mut plan, &points, n, map, cell)?;
        let queries = points.queries(queries);
        let count = queries.len() as u32;
        let query_buffer = device.upload("queries", &queries)?;
        plan.scope("query");
        let searched = &prepared.map;
        let result = match output {
            Output::Estimate => {
                let out = device.scratch::<Irradiance>("irradiance", count.into())?;
                searched.plan_irradiance(device, &mut plan, &query_buffer, count, map.k, gather, &out)?;
                Found::Estimates(out)
            }
            Output::Density => {
                let out = device.scratch::<Irradiance>("irradiance", count.into())?;
                searched.plan_density(device, &mut plan, &query_buffer, count, &out)?;
                Found::Densities(out)
            }
            Output::Neighbours => {
                Found::Neighbours(searched.plan_neighbours(device, &mut plan, &query_buffer, count, map.k, gather)?)
            }
        };
        Ok(Self { device, plan, prepared, queries, k: map.k, gather, result })
    }

    /// Refuses searches that the device ended early.
    fn whole(&self, counts: impl Iterator<Item = u32>) -> Result<(), Trouble> {
        match counts.filter(|&count| count == CUT_SHORT).count() {
            0 => Ok(()),
            searches => Err(MapError::CutShort { device: self.device.name(), searches }.into()),
        }
    }

    fn output(&self) -> Output {
        match self.result {
            Found::Estimates(_) => Output::Estimate,
            Found::Densities(_) => Output::Density,
            Found::Neighbours(_) => Output::Neighbours,
        }
    }
}

impl Work for Search<'_> {
    fn run(&mut self) -> Result<Sample, Trouble> {
        timed(self.device, &self.plan)
    }

    fn digest(&mut self) -> Result<String, Trouble> {
        match &self.result {
            Found::Estimates(out) | Found::Densities(out) => {
                let estimates: Vec<Irradiance> = self.device.read(out, self.queries.len() as u64)?;
                self.whole(estimates.iter().map(|estimate| estimate.photons))?;
                Ok(digest(&estimates))
            }
            Found::Neighbours(found) => {
                let count = self.queries.len() as u64;
                let counts: Vec<u32> = self.device.read(&found.counts, count)?;
                self.whole(counts.iter().copied())?;
                let neighbours: Vec<Neighbour> = self.device.read(&found.neighbours, count * u64::from(self.k))?;
                let mut digest = Digest::default();
                digest.add(&counts);
                for (row, &count) in neighbours.chunks(self.k as usize).zip(&counts) {
                    digest.add(&row[..count as usize]);
                }
                Ok(digest.hex())
            }
        }
    }

    fn check(&mut self) -> Result<(usize, usize), Trouble> {
        check(self.device, &self.prepared, &self.queries, self.k, self.gather, self.output())
    }

    fn units(&self) -> Units {
        Units { count: self.queries.len() as f64, name: "queries", parts: &["query"] }
    }

    fn bytes(&self) -> Option<u64> {
        let n = self.prepared.photons.len() as u32;
        let table = self.prepared.map.grid().table;
        let result = match self.output() {
            Output::Estimate | Output::Density => size_of::<Irradiance>() as u64,
            Output::Neighbours => 8 * u64::from(self.k) + 4,
        };
        Some(traffic::build(n, table) + traffic::search(n, table, self.queries.len() as u32, result))
    }

    fn peers(&mut self, policy: Policy, goes_on: &mut dyn FnMut() -> bool) -> Result<Vec<Peer>, Trouble> {
        if !peers::ANY || self.device.is_gpu() || self.output() == Output::Density {
            return Ok(Vec::new());
        }
        let Prepared { photons, map } = &self.prepared;
        let radius2 = map.grid().radius2;
        let compared = &self.queries[..exact::checked(self.queries.len(), photons.len())];
        let expected = exact::nearest(photons, compared, self.k as usize, radius2);
        let kth: Vec<peers::Kth> = expected
            .iter()
            .map(|row| {
                let row = &row[..row.len().min(self.k as usize)];
                peers::Kth { found: row.len(), distance2: row.last().map_or(0.0, |last| last.distance2) }
            })
            .collect();
        let positions: Vec<[f32; 3]> = photons.iter().map(|photon| photon.position).collect();
        let queries: Vec<[f32; 3]> = self.queries.iter().map(|query| query.position).collect();
        Ok(peers::searches(&positions, &queries, self.k, radius2, &kth, policy, goes_on))
    }
}
