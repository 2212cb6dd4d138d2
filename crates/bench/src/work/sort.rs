//! Sorting pairs of key and index.

use super::{Trouble, Units, Work, timed, traffic};
use crate::digest::Digest;
use crate::measure::Policy;
use crate::peers;
use crate::points;
use crate::row::{Peer, Sample};
use caustic_device::{Buffer, Device, Plan};
use caustic_photon_map::RadixSort;
use rayon::prelude::*;

pub(super) struct Sort<'a> {
    device: &'a Device,
    bits: u32,
    input: Vec<u32>,
    keys: Buffer,
    plan: Plan,
    sorted: RadixSort,
}

impl<'a> Sort<'a> {
    pub(super) fn new(device: &'a Device, n: u32, bits: u32) -> Result<Self, Trouble> {
        let keys = device.buffer::<u32>("sort: keys", n.into())?;
        let mut plan = Plan::new();
        plan.scope("sort");
        let sorted = RadixSort::plan(device, &mut plan, &keys, n, bits)?;
        Ok(Self { device, bits, input: points::keys(n, bits), keys, plan, sorted })
    }

    fn read(&self) -> Result<[Vec<u32>; 2], Trouble> {
        let count = self.input.len() as u64;
        Ok([self.device.read(&self.sorted.keys, count)?, self.device.read(&self.sorted.order, count)?])
    }
}

impl Work for Sort<'_> {
    fn run(&mut self) -> Result<Sample, Trouble> {
        // A sort overwrites its keys. An upload waits in a queue until the next submission: the empty plan is one.
        self.device.write(&self.keys, &self.input);
        self.device.run(&Plan::new())?;
        timed(self.device, &self.plan)
    }

    fn digest(&mut self) -> Result<String, Trouble> {
        let [keys, order] = self.read()?;
        let mut digest = Digest::default();
        digest.add(&keys);
        digest.add(&order);
        Ok(digest.hex())
    }

    /// All pairs: keys ascend, equal keys keep their order, each key is the one that its index had. Since indices then ascend
    /// where keys are equal, none comes twice.
    fn check(&mut self) -> Result<(usize, usize), Trouble> {
        let [keys, order] = self.read()?;
        let wrong = (0..keys.len()).into_par_iter().filter(|&i| {
            let is_its_own = self.input.get(order[i] as usize) == Some(&keys[i]);
            !is_its_own || (i > 0 && (keys[i - 1], order[i - 1]) >= (keys[i], order[i]))
        });
        Ok((keys.len(), wrong.count()))
    }

    fn units(&self) -> Units {
        Units { count: self.input.len() as f64, name: "pairs", parts: &[] }
    }

    fn bytes(&self) -> Option<u64> {
        Some(traffic::sort(self.input.len() as u32, self.bits))
    }

    fn peers(&mut self, policy: Policy, goes_on: &mut dyn FnMut() -> bool) -> Result<Vec<Peer>, Trouble> {
        if !peers::ANY {
            return Ok(Vec::new());
        }
        let [sorted, _] = self.read()?;
        Ok(peers::sorts(self.device, &self.input, self.bits, &sorted, policy, goes_on))
    }
}
