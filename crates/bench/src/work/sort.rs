//! Sorting keys, alone or with the indices they came from.

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
    sorted: Buffer,
    /// The index that each sorted key had before; none where keys are alone.
    order: Option<Buffer>,
}

impl<'a> Sort<'a> {
    pub(super) fn new(device: &'a Device, n: u32, bits: u32, pairs: bool) -> Result<Self, Trouble> {
        let keys = device.scratch::<u32>("sort: keys", n.into())?;
        let mut plan = Plan::new();
        plan.scope("sort");
        let (sorted, order) = if pairs {
            let sorted = RadixSort::plan(device, &mut plan, &keys, n, bits)?;
            (sorted.keys, Some(sorted.order))
        } else {
            (RadixSort::plan_keys(device, &mut plan, &keys, n, bits)?, None)
        };
        Ok(Self { device, bits, input: points::keys(n, bits), keys, plan, sorted, order })
    }

    fn read(&self, buffer: &Buffer) -> Result<Vec<u32>, Trouble> {
        Ok(self.device.read(buffer, self.input.len() as u64)?)
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
        let mut digest = Digest::default();
        digest.add(&self.read(&self.sorted)?);
        if let Some(order) = &self.order {
            digest.add(&self.read(order)?);
        }
        Ok(digest.hex())
    }

    /// All pairs: keys ascend, equal keys keep their order, each key is the one that its index had. Since indices then ascend
    /// where keys are equal, none comes twice. Keys alone are what another sort makes of them.
    fn check(&mut self) -> Result<(usize, usize), Trouble> {
        let keys = self.read(&self.sorted)?;
        let Some(order) = &self.order else {
            let mut expected = self.input.clone();
            expected.par_sort_unstable();
            return Ok((keys.len(), keys.iter().zip(&expected).filter(|(key, expected)| key != expected).count()));
        };
        let order = self.read(order)?;
        let wrong = (0..keys.len()).into_par_iter().filter(|&i| {
            let is_its_own = self.input.get(order[i] as usize) == Some(&keys[i]);
            !is_its_own || (i > 0 && (keys[i - 1], order[i - 1]) >= (keys[i], order[i]))
        });
        Ok((keys.len(), wrong.count()))
    }

    fn units(&self) -> Units {
        Units { count: self.input.len() as f64, name: if self.order.is_some() { "pairs" } else { "keys" }, parts: &[] }
    }

    fn bytes(&self) -> Option<u64> {
        let model = if self.order.is_some() { traffic::sort } else { traffic::sort_keys };
        Some(model(self.input.len() as u32, self.bits))
    }

    fn peers(&mut self, policy: Policy, goes_on: &mut dyn FnMut() -> bool) -> Result<Vec<Peer>, Trouble> {
        // They are made to sort pairs here.
        if !peers::ANY || self.order.is_none() {
            return Ok(Vec::new());
        }
        let sorted = self.read(&self.sorted)?;
        Ok(peers::sorts(self.device, &self.input, self.bits, &sorted, policy, goes_on))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::built_in;

    /// What is recorded for keys alone is the hash of what the standard library makes of them.
    #[test]
    fn the_recorded_hashes_of_sorted_keys_are_those_of_another_sort() {
        let case = &built_in(Some("sort-keys-32")).unwrap()[0];
        let device = Device::cpu();
        for (&n, expected) in case.expected.iter().filter(|(n, _)| **n <= 1_000_000) {
            let mut keys = points::keys(n, 32);
            keys.sort_unstable();
            let mut digest = Digest::default();
            digest.add(&keys);
            assert_eq!(digest.hex(), *expected, "N = {n}");
            let mut sort = Sort::new(&device, n, 32, false).unwrap();
            sort.run().unwrap();
            assert_eq!((sort.digest().unwrap(), sort.check().unwrap()), (expected.clone(), (n as usize, 0)));
            // A key that is not the right one is noticed.
            keys[n as usize / 2] ^= 1;
            device.write(&sort.sorted, &keys);
            assert_eq!(sort.check().unwrap(), (n as usize, 1));
        }
    }
}
