//! Named buffers, and the ledger of what they take.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, RwLock};

/// Where a buffer's bytes are: on the CPU as words, on a GPU, or on both.
pub(crate) struct Storage {
    pub(crate) cpu: Option<RwLock<Vec<u32>>>,
    pub(crate) gpu: Option<wgpu::Buffer>,
}

const ELSEWHERE: &str = "a buffer belongs to the device that made it";

/// A named piece of a device's memory. Cloning it makes another handle; the memory goes with the last.
#[derive(Clone)]
pub struct Buffer(Arc<Inner>);

struct Inner {
    name: String,
    bytes: u64,
    storage: Storage,
    ledger: Arc<Ledger>,
}

impl Buffer {
    pub(crate) fn new(name: &str, bytes: u64, storage: Storage, ledger: &Arc<Ledger>) -> Self {
        ledger.take(name, bytes);
        Self(Arc::new(Inner { name: name.to_string(), bytes, storage, ledger: Arc::clone(ledger) }))
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.0.name
    }

    /// Its size, bytes.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.0.bytes
    }

    pub(crate) fn on_cpu(&self) -> &RwLock<Vec<u32>> {
        self.0.storage.cpu.as_ref().expect(ELSEWHERE)
    }

    pub(crate) fn on_gpu(&self) -> &wgpu::Buffer {
        self.0.storage.gpu.as_ref().expect(ELSEWHERE)
    }

    pub(crate) fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        self.ledger.give_back(&self.name, self.bytes);
    }
}

/// What the buffers of one name take.
#[derive(Clone, Debug, serde::Serialize)]
pub struct BufferBytes {
    /// The name.
    pub buffer: String,
    /// Bytes now.
    pub bytes: u64,
    /// Bytes at the most.
    pub peak_bytes: u64,
}

#[derive(Default)]
pub(crate) struct Ledger(Mutex<Entries>);

#[derive(Default)]
struct Entries {
    rows: Vec<BufferBytes>,
    index: HashMap<String, usize>,
    bytes: u64,
    peak: u64,
}

impl Ledger {
    fn entries(&self) -> std::sync::MutexGuard<'_, Entries> {
        self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    fn take(&self, name: &str, bytes: u64) {
        let mut entries = self.entries();
        let next = entries.rows.len();
        let row = *entries.index.entry(name.to_string()).or_insert(next);
        if row == next {
            entries.rows.push(BufferBytes { buffer: name.to_string(), bytes: 0, peak_bytes: 0 });
        }
        let row = &mut entries.rows[row];
        row.bytes += bytes;
        row.peak_bytes = row.peak_bytes.max(row.bytes);
        entries.bytes += bytes;
        entries.peak = entries.peak.max(entries.bytes);
    }

    fn give_back(&self, name: &str, bytes: u64) {
        let mut entries = self.entries();
        if let Some(&row) = entries.index.get(name) {
            entries.rows[row].bytes -= bytes;
            entries.bytes -= bytes;
        }
    }

    pub(crate) fn report(&self) -> Vec<BufferBytes> {
        self.entries().rows.clone()
    }

    pub(crate) fn reset_peak(&self) {
        let mut entries = self.entries();
        entries.peak = entries.bytes;
    }

    pub(crate) fn total(&self) -> (u64, u64) {
        let entries = self.entries();
        (entries.bytes, entries.peak)
    }
}
