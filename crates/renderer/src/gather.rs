//! What the units of a render have come to, and whether there are enough of them.

use crate::accumulate::{Done, ProgressState};
use crate::report::{MapReport, Progress};
use crate::work::{Split, WorkUnit};
use crate::worker::Outcome;
use crate::{RenderError, Settings};
use std::collections::BTreeMap;
use std::time::Instant;

/// What is done after each unit.
pub(crate) type After<'a> = &'a mut dyn FnMut(&ProgressState) -> Result<(), RenderError>;

pub(crate) struct Gathering<'a> {
    settings: &'a Settings,
    clock: Instant,
    pub(crate) state: ProgressState,
    after: After<'a>,
    /// Where what ends a render is looked for after each pass: units that came before others that they follow.
    waiting: Option<InOrder>,
    /// Units that were wanted, if that is known, and that have come.
    units: (Option<u64>, u64),
    tiles: u32,
    noise: Option<f64>,
    /// The maps of the last pass so far.
    pub(crate) maps: Vec<MapReport>,
    pub(crate) last_pass: Option<u32>,
    pub(crate) notes: Vec<String>,
    pub(crate) problems: Vec<String>,
    pub(crate) stopped_by: Option<&'static str>,
}

/// Units that wait for those before them.
struct InOrder {
    split: Split,
    next: u64,
    done: Done,
    early: BTreeMap<WorkUnit, Outcome>,
}

impl InOrder {
    /// The next unit in order, if it is there.
    fn pop(&mut self) -> Option<Outcome> {
        while self.done.has(&self.split.unit(self.next)) {
            self.next += 1;
        }
        let outcome = self.early.remove(&self.split.unit(self.next))?;
        self.next += 1;
        Some(outcome)
    }
}

impl<'a> Gathering<'a> {
    /// Goes on from a state; `units` are to be added if that is known, cut as `split` says.
    pub(crate) fn new(
        settings: &'a Settings,
        split: Split,
        units: Option<u64>,
        state: ProgressState,
        after: After<'a>,
        clock: Instant,
    ) -> Self {
        let in_order = settings.stop.photons.is_some() || settings.stop.error.is_some();
        let waiting = in_order.then(|| InOrder { split, next: 0, done: state.done(), early: BTreeMap::new() });
        let mut gathering = Self {
            settings,
            clock,
            state,
            after,
            waiting,
            units: (units, 0),
            tiles: split.tiles,
            noise: None,
            maps: Vec::new(),
            last_pass: None,
            notes: Vec::new(),
            problems: Vec::new(),
            stopped_by: None,
        };
        gathering.look();
        gathering
    }

    /// Takes in what a unit came to.
    pub(crate) fn accept(&mut self, outcome: Outcome) -> Result<(), RenderError> {
        if !outcome.complete {
            return self.accept_partial(outcome);
        }
        match &mut self.waiting {
            None => self.add(outcome),
            Some(waiting) => {
                waiting.early.insert(outcome.piece.unit, outcome);
                while let Some(outcome) = self.waiting.as_mut().and_then(InOrder::pop) {
                    // Passes beyond the one that was enough would make another picture.
                    if self.stopped_by.is_none() {
                        self.add(outcome)?;
                    }
                }
                Ok(())
            }
        }
    }

    fn add(&mut self, outcome: Outcome) -> Result<(), RenderError> {
        let Outcome { piece, said, .. } = outcome;
        let unit = piece.unit;
        if self.last_pass.is_none_or(|last| last <= unit.pass) && !said.reports.is_empty() {
            self.maps = said.reports;
        }
        self.last_pass = self.last_pass.max(Some(unit.pass));
        if unit.first_pixel == 0 {
            self.problems.extend(said.problems);
            if unit.pass == 0 {
                self.notes.extend(said.notes);
            }
        }
        self.state.add(piece);
        self.units.1 += 1;
        (self.after)(&self.state)?;
        self.look();
        Ok(())
    }

    /// Keeps the rows of a first pass that was stopped: there is nothing else to show.
    fn accept_partial(&mut self, outcome: Outcome) -> Result<(), RenderError> {
        self.interrupt();
        if self.state.passes() == 0 && outcome.piece.unit.pass == 0 {
            self.maps = outcome.said.reports;
            self.notes.extend(outcome.said.notes);
            self.problems.extend(outcome.said.problems);
            self.state.add(outcome.piece);
        }
        Ok(())
    }

    /// Says that a worker is lost and that others do its work.
    pub(crate) fn lost(&mut self, error: &RenderError) {
        self.notes.push(format!("a device was given up, and the others did its work: {error}"));
    }

    /// The caller wants no more.
    pub(crate) fn interrupt(&mut self) {
        self.stopped_by = self.stopped_by.or(Some("interrupted"));
    }

    /// Looks whether there are enough passes.
    fn look(&mut self) {
        // Only who asks for an error waits for an estimate of it after each pass.
        self.noise = self.settings.stop.error.and_then(|_| self.state.noise());
        self.stopped_by = self.stopped_by.or_else(|| self.reached());
    }

    fn reached(&self) -> Option<&'static str> {
        let (stop, state) = (&self.settings.stop, &self.state);
        let passes = state.passes();
        if passes == 0 {
            None
        } else if self.settings.passes().is_some_and(|wanted| passes >= wanted) {
            Some("passes")
        } else if stop.photons.is_some_and(|photons| state.photons() >= photons) {
            Some("photons")
        } else if stop.seconds.is_some_and(|seconds| self.clock.elapsed().as_secs_f64() >= seconds) {
            Some("time")
        } else if stop.error.is_some_and(|error| self.noise.is_some_and(|noise| noise <= error)) {
            Some("error")
        } else {
            None
        }
    }

    /// Progress of all units: that of whatever is going to end them first. `begun` units are done in part.
    pub(crate) fn progress(&self, begun: f64) -> Progress {
        const TOTAL: u64 = 1 << 20;
        let done = self.units.1 as f64 + begun;
        let (stop, state) = (&self.settings.stop, &self.state);
        let passes = f64::from(state.passes());
        let parts = [
            self.units.0.map(|units| done / units as f64),
            stop.seconds.map(|seconds| self.clock.elapsed().as_secs_f64() / seconds),
            stop.photons.map(|photons| state.photons() as f64 / photons as f64),
            // Noise falls with the number of passes.
            stop.error.and_then(|error| Some(error / self.noise? * (passes + begun / f64::from(self.tiles)) / passes)),
        ];
        let part = parts.into_iter().flatten().fold(0.0, f64::max).min(1.0);
        Progress { phase: "passes", done: (part * TOTAL as f64) as u64, total: TOTAL }
    }
}
