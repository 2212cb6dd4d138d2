//! Named buffers, and the ledger of what they take.

use crate::cpu::Words;
use crate::pool::{Pool, Storage};
use std::collections::HashMap;
use std::num::NonZeroU64;
use std::sync::{Arc, Mutex, RwLock};

const ELSEWHERE: &str = "a buffer belongs to the device that made it";

/// A named piece of a device's memory. Cloning it makes another handle; with the last the memory goes back to the device, which
/// keeps it for the next buffer.
#[derive(Clone)]
pub struct Buffer(Arc<Inner>);

struct Inner {
    name: String,
    bytes: u64,
    /// There until it is dropped.
    storage: Option<Storage>,
    accounts: Arc<Accounts>,
}

/// What outlives a device's buffers: who has memory, and what nobody has.
#[derive(Default)]
pub(crate) struct Accounts {
    pub(crate) ledger: Ledger,
    pub(crate) pool: Pool,
}

impl Buffer {
    pub(crate) fn new(name: &str, bytes: u64, storage: Storage, accounts: &Arc<Accounts>) -> Self {
        accounts.ledger.take(name, storage.bytes);
        accounts.pool.lend(storage.bytes);
        let storage = Some(storage);
        Self(Arc::new(Inner { name: name.to_string(), bytes, storage, accounts: Arc::clone(accounts) }))
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

    pub(crate) fn on_cpu(&self) -> &RwLock<Words> {
        self.0.storage.as_ref().and_then(|storage| storage.cpu.as_ref()).expect(ELSEWHERE)
    }

    pub(crate) fn on_gpu(&self) -> &wgpu::Buffer {
        self.0.storage.as_ref().and_then(|storage| storage.gpu.as_ref()).expect(ELSEWHERE)
    }

    /// What a kernel of a GPU sees: its own bytes, not all that its memory may have.
    pub(crate) fn binding(&self) -> wgpu::BufferBinding<'_> {
        wgpu::BufferBinding { buffer: self.on_gpu(), offset: 0, size: NonZeroU64::new(self.bytes()) }
    }

    pub(crate) fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        if let Some(storage) = self.storage.take() {
            self.accounts.ledger.give_back(&self.name, storage.bytes);
            self.accounts.pool.give_back(storage);
        }
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
