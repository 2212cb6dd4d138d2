//! Building a photon map.

use super::{Trouble, Units, Work, timed, traffic};
use crate::case::{Map, Output};
use crate::digest::Digest;
use crate::exact;
use crate::points::Points;
use crate::row::Sample;
use caustic_device::{Device, Plan};
use caustic_kernels::layout::{Irradiance, Photon, Query};
use caustic_photon_map::{Gather, MapOptions, PhotonMap, bounds, plan_grid};

/// Queries whose estimates stand for a map: how a map lies in memory is its own affair, what it answers is not.
const PROBES: u32 = 1 << 16;
/// Photons of such an estimate.
const PROBE_K: u32 = 10;

/// A map whose construction is in a plan.
pub(super) struct Prepared {
    pub photons: Vec<Photon>,
    pub map: PhotonMap,
}

impl Prepared {
    /// Appends the construction of a map of `n` photons to a plan, as the part `build`. Cells are as wide as `cell`, if it says how
    /// wide.
    pub(super) fn new(
        device: &Device,
        plan: &mut Plan,
        points: &Points,
        n: u32,
        map: &Map,
        cell: Option<f32>,
    ) -> Result<Self, Trouble> {
        let photons = points.photons(n);
        let (low, high) = bounds("photons", photons.iter().map(|photon| photon.position))?;
        let options = MapOptions { radius: map.radius(n), hash: map.hash, table: None, cell };
        let stride = photons.len().div_ceil(4096).max(1);
        let sample: Vec<_> = photons.iter().step_by(stride).map(|photon| photon.position).collect();
        let grid = plan_grid(low, high, n.into(), &sample, &options)?;
        let unsorted = device.upload("photons", &photons)?;
        plan.scope("build");
        let map = PhotonMap::plan(device, plan, &unsorted, grid)?;
        Ok(Self { photons, map })
    }
}

/// Hashes what a query gives.
pub(super) fn digest(estimates: &[Irradiance]) -> String {
    let mut digest = Digest::default();
    digest.add(estimates);
    digest.hex()
}

/// How many of the first queries were checked against brute force, and how many of their neighbours or estimates differ.
pub(super) fn check(
    device: &Device,
    prepared: &Prepared,
    queries: &[Query],
    k: u32,
    gather: Gather,
    output: Output,
) -> Result<(usize, usize), Trouble> {
    let Prepared { photons, map } = prepared;
    let queries = &queries[..exact::checked(queries.len(), photons.len())];
    let radius2 = map.grid().radius2;
    let expected = exact::nearest(photons, queries, k as usize, radius2);
    if output == Output::Density {
        let all = exact::nearest(photons, queries, photons.len(), radius2);
        let estimates = map.density(device, queries)?;
        let differ = estimates.iter().zip(&all);
        let differ = differ.filter(|(e, all)| !exact::is_estimate(e, photons, all, photons.len(), radius2));
        return Ok((queries.len(), differ.count()));
    }
    let neighbours = map.k_nearest(device, queries, k, gather)?;
    let estimates = match output {
        Output::Estimate => map.irradiance(device, queries, k, gather)?,
        Output::Neighbours | Output::Density => Vec::new(),
    };
    let differ = (0..queries.len()).filter(|&i| {
        let right = neighbours[i] == expected[i][..expected[i].len().min(k as usize)];
        let estimate = estimates.get(i);
        !right || !estimate.is_none_or(|e| exact::is_estimate(e, photons, &expected[i], k as usize, radius2))
    });
    Ok((queries.len(), differ.count()))
}

pub(super) struct Build<'a> {
    device: &'a Device,
    plan: Plan,
    prepared: Prepared,
    probes: Vec<Query>,
}

impl<'a> Build<'a> {
    pub(super) fn new(device: &'a Device, n: u32, map: &Map) -> Result<Self, Trouble> {
        let points = Points::new(map.distribution, n, map.k);
        let mut plan = Plan::new();
        let prepared = Prepared::new(device, &mut plan, &points, n, map, None)?;
        Ok(Self { device, plan, prepared, probes: points.queries(n.min(PROBES)) })
    }
}

impl Work for Build<'_> {
    fn run(&mut self) -> Result<Sample, Trouble> {
        timed(self.device, &self.plan)
    }

    fn digest(&mut self) -> Result<String, Trouble> {
        Ok(digest(&self.prepared.map.irradiance(self.device, &self.probes, PROBE_K, Gather::Auto)?))
    }

    fn check(&mut self) -> Result<(usize, usize), Trouble> {
        check(self.device, &self.prepared, &self.probes, PROBE_K, Gather::Auto, Output::Estimate)
    }

    fn units(&self) -> Units {
        Units { count: self.prepared.photons.len() as f64, name: "photons", parts: &[] }
    }

    fn bytes(&self) -> Option<u64> {
        Some(traffic::build(self.prepared.photons.len() as u32, self.prepared.map.grid().table))
    }
}
