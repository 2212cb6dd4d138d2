//! Who computes what: a queue of units that workers take from, each as fast as it is.
//!
//! A fast worker takes more units than a slow one. When none is left, a worker that would otherwise wait takes one that another has had for
//! longer than it would take itself, and whoever is first counts ("backup tasks": Dean and Ghemawat, "MapReduce", 2004). All have the same
//! bits, so that it does not matter who that is. Units of a worker that is lost go back.

use crate::accumulate::Done;
use crate::work::{Split, WorkUnit};
use std::collections::BTreeSet;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// How often a worker that waits looks whether another one is late.
const LOOK: Duration = Duration::from_millis(20);

/// A unit that somebody computes.
struct Held {
    unit: WorkUnit,
    /// Who, and since when.
    holders: Vec<(usize, Instant)>,
}

/// What a worker has shown of its speed.
#[derive(Clone, Copy, Default)]
struct Speed {
    units: u32,
    took: Duration,
}

struct Inner {
    split: Split,
    /// What was there before.
    done: Done,
    /// Number of the next unit.
    next: u64,
    /// The one after the last, if it is known.
    end: Option<u64>,
    /// Units that were given back.
    returned: BTreeSet<WorkUnit>,
    held: Vec<Held>,
    speeds: Vec<Speed>,
    /// Whether nothing more is wanted.
    stopped: bool,
}

/// What there is for a worker to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Next {
    /// This.
    Unit(WorkUnit),
    /// Nothing yet, but somebody may be lost or late.
    Wait,
    /// Nothing any more.
    Nothing,
}

/// Units to be computed.
pub(crate) struct Queue {
    inner: Mutex<Inner>,
    changed: Condvar,
}

impl Queue {
    /// The units with these numbers but for those that are done.
    pub(crate) fn new(split: Split, (next, end): (u64, Option<u64>), done: Done, workers: usize) -> Self {
        let (returned, held) = (BTreeSet::new(), Vec::new());
        let speeds = vec![Speed::default(); workers];
        let inner = Inner { split, done, next, end, returned, held, speeds, stopped: false };
        Self { inner: Mutex::new(inner), changed: Condvar::new() }
    }

    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What `worker` may compute next; waits until that is known.
    pub(crate) fn take(&self, worker: usize) -> Option<WorkUnit> {
        let mut inner = self.lock();
        loop {
            match inner.take(worker) {
                Next::Unit(unit) => return Some(unit),
                Next::Nothing => return None,
                Next::Wait => {
                    let waited = self.changed.wait_timeout(inner, LOOK);
                    inner = waited.unwrap_or_else(PoisonError::into_inner).0;
                }
            }
        }
    }

    /// What `worker` may compute next, as far as that is known.
    pub(crate) fn try_take(&self, worker: usize) -> Next {
        self.lock().take(worker)
    }

    /// Says that `worker` has computed a unit. Returns whether it is the first to have done so.
    pub(crate) fn finish(&self, worker: usize, unit: &WorkUnit) -> bool {
        let mut inner = self.lock();
        let Some(at) = inner.held.iter().position(|held| held.unit == *unit) else { return false };
        let held = inner.held.remove(at);
        if let Some((_, since)) = held.holders.iter().find(|(holder, _)| *holder == worker) {
            let speed = &mut inner.speeds[worker];
            speed.units += 1;
            speed.took += since.elapsed();
        }
        self.changed.notify_all();
        true
    }

    /// Gives back what `worker` holds: it will not compute it.
    pub(crate) fn lose(&self, worker: usize) {
        let mut inner = self.lock();
        inner.held.iter_mut().for_each(|held| held.holders.retain(|&(holder, _)| holder != worker));
        let lost: Vec<_> = inner.held.iter().filter(|held| held.holders.is_empty()).map(|held| held.unit).collect();
        inner.held.retain(|held| !held.holders.is_empty());
        inner.returned.extend(lost);
        self.changed.notify_all();
    }

    /// Whether nobody waits for this unit any more.
    pub(crate) fn is_idle(&self, unit: &WorkUnit) -> bool {
        let inner = self.lock();
        inner.stopped || !inner.held.iter().any(|held| held.unit == *unit)
    }

    /// Hands out no new units; those that are held are finished.
    pub(crate) fn close(&self) {
        let mut inner = self.lock();
        inner.end = Some(inner.next);
        self.changed.notify_all();
    }

    /// Wants nothing any more.
    pub(crate) fn stop(&self) {
        self.lock().stopped = true;
        self.changed.notify_all();
    }
}

impl Inner {
    /// Passes over the units that were done before.
    fn pass_over(&mut self) {
        while self.end != Some(self.next) && self.done.has(&self.split.unit(self.next)) {
            self.next += 1;
        }
    }

    fn take(&mut self, worker: usize) -> Next {
        if self.stopped {
            return Next::Nothing;
        }
        self.pass_over();
        let new = self.returned.pop_first().or_else(|| {
            let unit = (self.end != Some(self.next)).then(|| self.split.unit(self.next))?;
            self.next += 1;
            Some(unit)
        });
        if let Some(unit) = new {
            self.held.push(Held { unit, holders: vec![(worker, Instant::now())] });
            return Next::Unit(unit);
        }
        let Speed { units, took } = self.speeds[worker];
        let late = |held: &&mut Held| matches!(held.holders[..], [(other, since)] if other != worker && units > 0 && since.elapsed() > took / units);
        if let Some(held) = self.held.iter_mut().find(late) {
            held.holders.push((worker, Instant::now()));
            return Next::Unit(held.unit);
        }
        if self.held.is_empty() { Next::Nothing } else { Next::Wait }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn queue(end: Option<u64>, workers: usize) -> Queue {
        Queue::new(Split { pixels: 10, tiles: 1 }, (0, end), Done::default(), workers)
    }

    fn pass(queue: &Queue, worker: usize) -> Option<u32> {
        match queue.try_take(worker) {
            Next::Unit(unit) => Some(unit.pass),
            _ => None,
        }
    }

    fn unit(pass: u32) -> WorkUnit {
        WorkUnit { pass, first_pixel: 0, pixels: 10 }
    }

    #[test]
    fn units_of_a_lost_worker_go_back() {
        let queue = queue(Some(3), 2);
        assert_eq!((pass(&queue, 0), pass(&queue, 1), pass(&queue, 1)), (Some(0), Some(1), Some(2)));
        queue.lose(1);
        assert!(queue.is_idle(&unit(1)) && !queue.is_idle(&unit(0)));
        assert!(!queue.finish(1, &unit(1)), "what a lost worker sends late does not count");
        assert_eq!((pass(&queue, 0), pass(&queue, 0)), (Some(1), Some(2)));
        for pass in 0..3 {
            assert!(queue.try_take(0) == Next::Wait && queue.finish(0, &unit(pass)));
        }
        assert_eq!(queue.try_take(0), Next::Nothing);
    }

    #[test]
    fn who_waits_takes_what_is_late_and_the_first_counts() {
        let queue = queue(Some(2), 3);
        assert_eq!((pass(&queue, 0), pass(&queue, 1)), (Some(0), Some(1)));
        assert!(queue.finish(0, &unit(0)));
        assert_eq!(queue.try_take(2), Next::Wait, "a worker without a speed takes nothing from others");
        std::thread::sleep(Duration::from_millis(5));
        assert_eq!(pass(&queue, 0), Some(1), "unit 1 takes longer than worker 0 would");
        assert_eq!(queue.try_take(0), Next::Wait, "it has it already");
        assert!(queue.finish(0, &unit(1)) && queue.is_idle(&unit(1)) && !queue.finish(1, &unit(1)));
        assert_eq!(queue.try_take(2), Next::Nothing);
    }

    #[test]
    fn a_queue_can_be_closed_and_stopped() {
        let queue = queue(None, 1);
        assert_eq!(pass(&queue, 0), Some(0));
        queue.close();
        assert_eq!(queue.try_take(0), Next::Wait);
        assert!(!queue.is_idle(&unit(0)));
        queue.stop();
        assert!(queue.try_take(0) == Next::Nothing && queue.is_idle(&unit(0)));
    }
}
