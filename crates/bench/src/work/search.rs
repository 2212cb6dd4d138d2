//! Building a photon map and searching it.

use super::map::{Prepared, check, digest};
use super::{Trouble, Units, Work, timed, traffic};
use crate::case::{Map, Output};
use crate::digest::Digest;
use crate::measure::Policy;
use crate::points::Points;
use crate::row::{Clock, Peer, Sample};
use crate::{exact, peers};
use caustic_device::{Buffer, Device, Plan, StageTime};
use caustic_kernels::gather::CUT_SHORT;
use caustic_kernels::layout::{Irradiance, Neighbour, Query};
use caustic_photon_map::{Gather, MapError};
use std::time::Instant;

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
    /// Neighbours, of which there is no plan yet: each run reads them back.
    Neighbours(Vec<Vec<Neighbour>>),
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
        let prepared = Prepared::new(device, &mut plan, &points, n, map)?;
        let queries = points.queries(queries);
        let count = queries.len() as u32;
        let result = match output {
            Output::Estimate => {
                let query_buffer = device.upload("queries", &queries)?;
                let out = device.buffer::<Irradiance>("irradiance", count.into())?;
                plan.scope("query");
                prepared.map.plan_irradiance(device, &mut plan, &query_buffer, count, map.k, gather, &out)?;
                Found::Estimates(out)
            }
            Output::Neighbours => Found::Neighbours(Vec::new()),
        };
        Ok(Self { device, plan, prepared, queries, k: map.k, gather, result })
    }

    fn output(&self) -> Output {
        match self.result {
            Found::Estimates(_) => Output::Estimate,
            Found::Neighbours(_) => Output::Neighbours,
        }
    }
}

impl Work for Search<'_> {
    fn run(&mut self) -> Result<Sample, Trouble> {
        let Self { device, plan, prepared, queries, k, gather, result } = self;
        let Found::Neighbours(found) = result else { return timed(device, plan) };
        // The last run's rows go before the clock starts.
        *found = Vec::new();
        let start = Instant::now();
        let mut sample = timed(device, plan)?;
        device.reset_stage_times();
        *found = prepared.map.k_nearest(device, queries, *k, *gather)?;
        sample.wall_ms = start.elapsed().as_secs_f64() * 1e3;
        let of_query = |stage: StageTime| StageTime { stage: format!("query/{}", stage.stage), ..stage };
        sample.stages.extend(device.stage_times().into_iter().map(of_query));
        Ok(sample)
    }

    fn digest(&mut self) -> Result<String, Trouble> {
        match &self.result {
            Found::Estimates(out) => {
                let estimates: Vec<Irradiance> = self.device.read(out, self.queries.len() as u64)?;
                let searches = estimates.iter().filter(|estimate| estimate.photons == CUT_SHORT).count();
                if searches > 0 {
                    return Err(MapError::CutShort { device: self.device.name(), searches }.into());
                }
                Ok(digest(&estimates))
            }
            Found::Neighbours(found) => {
                let mut digest = Digest::default();
                let counts: Vec<u32> = found.iter().map(|row| row.len() as u32).collect();
                digest.add(&counts);
                for row in found {
                    digest.add(row);
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
            Output::Estimate => size_of::<Irradiance>() as u64,
            Output::Neighbours => 8 * u64::from(self.k) + 4,
        };
        Some(traffic::build(n, table) + traffic::search(n, table, self.queries.len() as u32, result))
    }

    fn clock(&self, device: &Device) -> Clock {
        match self.result {
            Found::Estimates(_) if !device.is_gpu() => Clock::Wall,
            // The wall clock of neighbours has the read-back of all of them in it, and their way into one vector a query.
            Found::Estimates(_) | Found::Neighbours(_) => Clock::Stages,
        }
    }

    fn peers(&mut self, policy: Policy, goes_on: &mut dyn FnMut() -> bool) -> Result<Vec<Peer>, Trouble> {
        if !peers::ANY || self.device.is_gpu() {
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
