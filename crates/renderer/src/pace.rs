//! How much work one submission is given.

use caustic_device::Device;
use std::time::{Duration, Instant};

/// Longest that a submission should take: far from the two seconds after which operating systems take a GPU for hung, and
/// short enough for progress.
const LIMIT: Duration = Duration::from_millis(250);

/// The size of the next piece of work, from what the last one took. A GPU that is a hundred times slower than another gets
/// pieces a hundred times smaller. The CPU has no watchdog: its pieces stay as they are.
pub(crate) struct Pace {
    size: u32,
    most: u32,
    fixed: bool,
}

impl Pace {
    /// Pieces of `first` on a GPU, then up to `most`; on a CPU of `on_cpu`.
    pub(crate) fn new(device: &Device, first: u32, most: u32, on_cpu: u32) -> Self {
        let fixed = !device.is_gpu();
        Self { size: if fixed { on_cpu } else { first }, most, fixed }
    }

    /// Size of the next piece.
    pub(crate) fn size(&self) -> u32 {
        self.size
    }

    /// Runs a piece of work and learns from the time it takes.
    pub(crate) fn run<T, E>(&mut self, work: impl FnOnce() -> Result<T, E>) -> Result<T, E> {
        let start = Instant::now();
        let result = work()?;
        self.learn(start.elapsed());
        Ok(result)
    }

    fn learn(&mut self, took: Duration) {
        if self.fixed {
            return;
        }
        if took > LIMIT {
            self.size = (self.size / 2).max(1 << 10);
        } else if took < LIMIT / 8 {
            self.size = self.size.saturating_mul(4).min(self.most);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_shrink_where_they_take_long_and_grow_where_they_do_not() {
        let mut pace = Pace { size: 1 << 18, most: 1 << 20, fixed: false };
        pace.learn(Duration::from_secs(3));
        assert_eq!(pace.size(), 1 << 17);
        for _ in 0..20 {
            pace.learn(Duration::from_secs(3));
        }
        assert_eq!(pace.size(), 1 << 10, "there is a least");
        pace.learn(Duration::from_millis(100));
        assert_eq!(pace.size(), 1 << 10, "in between it stays");
        for _ in 0..20 {
            pace.learn(Duration::from_millis(1));
        }
        assert_eq!(pace.size(), 1 << 20, "there is a most");
        let mut cpu = Pace::new(&Device::cpu(), 1, 2, 77);
        cpu.learn(Duration::from_secs(3));
        assert_eq!(cpu.size(), 77);
        assert!(pace.run(|| Err::<(), _>("an error")).is_err());
    }
}
