//! Repetition: how often a case runs, and what the times come to.

use serde::{Deserialize, Serialize};
use std::time::{Duration, Instant};

/// How often to run.
#[derive(Clone, Copy, Debug)]
pub struct Policy {
    /// Runs that are measured if they are fast enough.
    pub repeat: usize,
    /// Runs before them, which warm caches and pipelines up …
    pub warm_up: usize,
    /// … and more until this time has passed: the clock of a card that was idle rises in tenths of a second.
    pub warm_for: Duration,
    /// Time after which `least` runs are enough.
    pub budget: Duration,
    /// Runs at least …
    pub least: usize,
}

/// … unless they take this many budgets, when one is enough.
const PATIENCE: u32 = 6;

/// Median and spread of some times.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// The one in the middle, ms.
    pub median: f64,
    /// A quarter is below, ms.
    pub low: f64,
    /// A quarter is above, ms.
    pub high: f64,
    /// The least, ms.
    pub least: f64,
    /// The most, ms.
    pub most: f64,
}

impl Spread {
    /// Of some times, in any order; zero of none.
    #[must_use]
    pub fn of(times: &[f64]) -> Self {
        let mut sorted = times.to_vec();
        sorted.sort_by(f64::total_cmp);
        let Some(last) = sorted.len().checked_sub(1) else { return Self::default() };
        let at = |quarters: usize| {
            // Between two neighbours where no time is just there.
            let place = (last * quarters) as f64 / 4.0;
            let (below, above) = (sorted[place.floor() as usize], sorted[place.ceil() as usize]);
            below + (above - below) * place.fract()
        };
        Self { median: at(2), low: at(1), high: at(3), least: sorted[0], most: sorted[last] }
    }
}

/// Runs `run`, which returns what it measured, as often as the policy says; `goes_on` is asked between runs. What is returned is
/// empty only if it was told to stop before the first run ended.
pub fn repeat<T, E>(
    policy: Policy,
    goes_on: &mut dyn FnMut() -> bool,
    mut run: impl FnMut() -> Result<T, E>,
) -> Result<Vec<T>, E> {
    let start = Instant::now();
    let mut warmed = 0;
    while warmed < policy.warm_up || start.elapsed() < policy.warm_for {
        if !goes_on() {
            return Ok(Vec::new());
        }
        run()?;
        warmed += 1;
        // Warming up a run of a minute is a waste.
        if start.elapsed() > policy.budget {
            break;
        }
    }
    let start = Instant::now();
    let mut results = Vec::new();
    while results.len() < policy.repeat.max(1) && goes_on() {
        results.push(run()?);
        let took = start.elapsed();
        let enough = results.len() >= policy.least && took > policy.budget;
        if enough || took > policy.budget * PATIENCE {
            break;
        }
    }
    Ok(results)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_and_quarters() {
        let spread = Spread::of(&[5.0, 1.0, 3.0, 2.0, 4.0]);
        assert_eq!(spread, Spread { median: 3.0, low: 2.0, high: 4.0, least: 1.0, most: 5.0 });
        assert_eq!(Spread::of(&[1.0, 2.0]).median, 1.5);
        assert_eq!(Spread::of(&[7.0]).high, 7.0);
        assert_eq!(Spread::of(&[]), Spread::default());
    }

    fn runs(policy: Policy, stop_after: usize, each: Duration) -> (usize, usize) {
        let (mut asked, mut ran) = (0, 0);
        let mut goes_on = || {
            asked += 1;
            asked <= stop_after
        };
        let result = repeat(policy, &mut goes_on, || {
            ran += 1;
            std::thread::sleep(each);
            Ok::<_, ()>(())
        });
        (ran, result.unwrap().len())
    }

    #[test]
    fn runs_are_as_many_as_asked_fewer_when_long_and_none_after_an_interrupt() {
        let policy =
            Policy { repeat: 9, warm_up: 2, warm_for: Duration::ZERO, budget: Duration::from_secs(100), least: 3 };
        assert_eq!(runs(policy, 99, Duration::ZERO), (11, 9));
        assert_eq!(runs(policy, 0, Duration::ZERO), (0, 0));
        assert_eq!(runs(policy, 4, Duration::ZERO), (4, 2));
        let hurried = Policy { budget: Duration::from_micros(100), ..policy };
        assert_eq!(runs(hurried, 99, Duration::from_millis(2)), (2, 1));
        // Runs that are short go on until the clock is up.
        let cold = Policy { warm_for: Duration::from_millis(50), ..policy };
        let (ran, measured) = runs(cold, 99, Duration::from_millis(1));
        assert!(measured == 9 && ran > 11, "{ran}");
        let enough = Policy { budget: Duration::ZERO, ..policy };
        assert_eq!(runs(enough, 99, Duration::from_millis(1)).1, 1);
    }
}
