//! The energy ledger: whether the power that the lights emit is found again.

use crate::RenderError;
use caustic_device::{Buffer, Device, Kernel, Plan};
use caustic_kernels::trace::{LEDGER_PATHS, LedgerBlock, LedgerPass, LedgerSum, Light, PhotonPass, Tally};
use serde::Serialize;

/// Standard errors by which a ledger may be off. Chance exceeds that once in 5·10⁸ times.
const STANDARD_ERRORS: f64 = 6.0;
/// What roundings may make of the sums, relative: hundreds of bounces at 2⁻²⁴ each.
const ROUNDING: f64 = 2e-5;
/// Fewest paths of which a mean is taken for normally distributed.
const FEWEST: u64 = 1000;

/// What became of the power that one light emitted for one map.
///
/// Of each path, what surfaces and media take is reckoned by expectation and what goes on by Russian roulette. The two agree on average only, within
/// the standard error, and do not if a weight or a chance is wrong.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LightLedger {
    /// Photons that it emitted and that had power.
    pub paths: u64,
    /// Emitted, W, for each of red, green and blue.
    pub emitted_w: [f64; 3],
    /// Taken by surfaces and media, W.
    pub absorbed_w: [f64; 3],
    /// Gone out of the scene, W.
    pub escaped_w: [f64; 3],
    /// Arrived on the diffuse surfaces where paths of the caustic map end, W.
    pub landed_w: [f64; 3],
    /// On paths that were given up, W.
    pub lost_w: [f64; 3],
    /// Mean of (emitted − absorbed − escaped − landed − lost) / emitted over paths.
    pub imbalance: f64,
    /// Standard error of the imbalance.
    pub standard_error: f64,
    /// Paths of which a number was not finite; they are in none of the sums.
    pub not_finite: u64,
}

impl LightLedger {
    /// Whether emitted = absorbed + escaped + landed + lost, as far as chance allows.
    #[must_use]
    pub fn closes(&self) -> bool {
        // Where roulette ends so few paths that none did, the scatter knows nothing of it: then the error is that of a count of whole paths.
        let of_few = (self.imbalance.abs() / self.paths.max(1) as f64).sqrt();
        let allowed = STANDARD_ERRORS * self.standard_error.max(of_few) + ROUNDING;
        self.not_finite == 0 && (self.paths < FEWEST || self.imbalance.abs() <= allowed)
    }
}

/// The sums of a light, before they are means.
#[derive(Clone, Debug, Default)]
struct Account {
    power: [[f64; 3]; 5],
    imbalance: f64,
    imbalance2: f64,
    paths: u64,
    not_finite: u64,
}

impl Account {
    fn add(&mut self, sum: &LedgerSum) {
        let Tally { emitted, absorbed, escaped, landed, lost } = sum.power;
        for (all, one) in self.power.iter_mut().zip([emitted, absorbed, escaped, landed, lost]) {
            for (all, one) in all.iter_mut().zip(one) {
                *all += f64::from(one);
            }
        }
        self.imbalance += f64::from(sum.imbalance);
        self.imbalance2 += f64::from(sum.imbalance2);
        self.paths += u64::from(sum.paths);
        self.not_finite += u64::from(sum.not_finite);
    }

    fn ledger(&self) -> LightLedger {
        let n = self.paths.max(1) as f64;
        let mean = self.imbalance / n;
        let [emitted_w, absorbed_w, escaped_w, landed_w, lost_w] = self.power;
        LightLedger {
            paths: self.paths,
            emitted_w,
            absorbed_w,
            escaped_w,
            landed_w,
            lost_w,
            imbalance: mean,
            standard_error: ((self.imbalance2 / n - mean * mean).max(0.0) / n).sqrt(),
            not_finite: self.not_finite,
        }
    }
}

/// Adds up the tallies of a pass, dispatch by dispatch.
pub(crate) struct Books {
    accounts: Vec<Account>,
    blocks: Vec<LedgerBlock>,
    /// The light of each block.
    owners: Vec<usize>,
    sums: Option<Buffer>,
}

impl Books {
    pub(crate) fn new(lights: usize) -> Self {
        Self { accounts: vec![Account::default(); lights], blocks: Vec::new(), owners: Vec::new(), sums: None }
    }

    /// Plans the sums of a dispatch whose paths have left `tallies`.
    pub(crate) fn plan(
        &mut self,
        device: &Device,
        plan: &mut Plan,
        pass: &PhotonPass,
        lights: &[Light],
        tallies: &Buffer,
    ) -> Result<(), RenderError> {
        self.blocks.clear();
        self.owners.clear();
        let end = pass.first + pass.paths;
        for (i, light) in lights.iter().enumerate() {
            let mut first = light.first_photon.max(pass.first);
            let last = (light.first_photon + light.photons).min(end);
            while first < last {
                let paths = LEDGER_PATHS.min(last - first);
                self.blocks.push(LedgerBlock { first: first - pass.first, paths });
                self.owners.push(i);
                first += paths;
            }
        }
        let blocks = self.blocks.len() as u32;
        let params = device.upload("ledger pass", &[LedgerPass { blocks }])?;
        let list = device.upload("ledger blocks", &self.blocks)?;
        let sums = device.scratch::<LedgerSum>("ledger sums", u64::from(blocks))?;
        plan.each(Kernel::SumLedger, blocks, &[&params, &list, tallies, &sums]);
        self.sums = Some(sums);
        Ok(())
    }

    /// Enters the sums of the dispatch that was planned and has been run.
    pub(crate) fn enter(&mut self, device: &Device) -> Result<(), RenderError> {
        if let Some(sums) = self.sums.take() {
            let sums: Vec<LedgerSum> = device.read(&sums, self.blocks.len() as u64)?;
            for (sum, &owner) in sums.iter().zip(&self.owners) {
                self.accounts[owner].add(sum);
            }
        }
        Ok(())
    }

    /// What became of each light's power.
    pub(crate) fn ledgers(&self) -> Vec<LightLedger> {
        self.accounts.iter().map(Account::ledger).collect()
    }
}

/// What is wrong with the ledgers of a map, in a sentence each.
pub(crate) fn problems(map: &str, ledgers: &[LightLedger]) -> Vec<String> {
    let mut problems = Vec::new();
    for (light, ledger) in ledgers.iter().enumerate().filter(|(_, ledger)| !ledger.closes()) {
        if ledger.not_finite > 0 {
            problems.push(format!(
                "ENERGY: {} photon paths of light {light} were not finite in the {map} map: its power or the scene is extreme",
                ledger.not_finite
            ));
        } else {
            problems.push(format!(
                "ENERGY: the {map} map's ledger of light {light} does not close: {:+.3} % of its power cannot be accounted for, with a standard error of {:.3} %; please report this as a bug, with the scene",
                ledger.imbalance * 100.0,
                ledger.standard_error * 100.0
            ));
        }
    }
    problems
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ledger_closes_within_its_error_and_not_beyond() {
        let good = LightLedger { paths: 1_000_000, imbalance: 5e-4, standard_error: 1e-4, ..LightLedger::default() };
        assert!(good.closes() && problems("global", std::slice::from_ref(&good)).is_empty());
        let bad = LightLedger { imbalance: -7e-4, ..good.clone() };
        assert!(!bad.closes() && problems("global", &[good.clone(), bad])[0].contains("light 1"));
        let few = LightLedger { paths: 999, imbalance: 1.0, ..good.clone() };
        assert!(few.closes(), "so few paths say nothing");
        // Two paths that should have ended and did not, or 37.
        let rare = |paths| LightLedger { paths: 5000, imbalance: paths / 5000.0, standard_error: 5e-5, ..good.clone() };
        assert!(rare(2.0).closes() && !rare(37.0).closes());
        assert!(!LightLedger { not_finite: 1, ..good }.closes());
    }

    #[test]
    fn an_account_has_the_mean_and_its_error() {
        let mut account = Account::default();
        let power = Tally { emitted: [1.0, 2.0, 3.0], lost: [0.5; 3], ..Tally::default() };
        account.add(&LedgerSum { power, imbalance: 1.0, imbalance2: 5.0, paths: 4, not_finite: 0 });
        account.add(&LedgerSum { power, imbalance: 1.0, imbalance2: 3.0, paths: 4, not_finite: 2 });
        let ledger = account.ledger();
        assert_eq!((ledger.emitted_w, ledger.lost_w), ([2.0, 4.0, 6.0], [1.0; 3]));
        // Mean square 1, mean ¼: variance 15/16, of a mean of eight.
        assert_eq!((ledger.imbalance, ledger.standard_error), (0.25, (15.0f64 / 16.0 / 8.0).sqrt()));
        assert_eq!((ledger.paths, ledger.not_finite), (8, 2));
    }

    /// A ledger that cannot fail says nothing: a wall whose photons survive always, and yet carry on as if only four of five did, takes
    /// light away.
    #[test]
    fn a_wrong_roulette_shows() {
        let device = Device::cpu();
        let mut scene = crate::scene::Scene::load("cornell").unwrap().compile();
        let kind = crate::photons::PassKind::global(20_000, crate::Show::Beauty, false);
        let ledger = |scene: &crate::scene::CompiledScene| {
            let buffers = crate::SceneBuffers::new(&device, scene).unwrap();
            let (_, report) = crate::trace::trace(&device, scene, &buffers, 0, &kind, &mut |_| true).unwrap();
            report.ledger
        };
        assert_eq!(problems("global", &ledger(&scene)), [""; 0]);
        for material in &mut scene.materials {
            material.survival = 1.25;
        }
        assert_eq!(problems("global", &ledger(&scene)).len(), 1);
    }
}
