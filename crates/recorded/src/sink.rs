//! Where the accesses of the bodies that run on a thread are written down.

use std::cell::{Cell, RefCell};
use std::panic::Location;

/// In place of a lane: code between the phases of a workgroup, which every lane runs.
pub const ALL_LANES: u32 = u32::MAX;

/// One access of one lane to a buffer.
#[derive(Clone, Copy, Debug)]
pub struct Access {
    /// Where in the source it is.
    pub at: &'static Location<'static>,
    /// Address of the buffer, by which it is known.
    pub buffer: usize,
    /// The first byte of the record in the buffer.
    pub offset: u64,
    /// Bytes of the record.
    pub bytes: u32,
    /// The lane's index in its workgroup, or [`ALL_LANES`].
    pub lane: u32,
}

struct Sink {
    lane: Cell<u32>,
    accesses: RefCell<Vec<Access>>,
    local_loads: Cell<u64>,
    local_stores: Cell<u64>,
}

thread_local! {
    static SINK: Sink = const {
        Sink {
            lane: Cell::new(ALL_LANES),
            accesses: RefCell::new(Vec::new()),
            local_loads: Cell::new(0),
            local_stores: Cell::new(0),
        }
    };
}

/// Says whose accesses come next.
pub fn set_lane(lane: u32) {
    SINK.with(|sink| sink.lane.set(lane));
}

/// Writes down an access to record `i` of a buffer.
pub fn access(at: &'static Location<'static>, buffer: usize, i: usize, bytes: usize) {
    SINK.with(|sink| {
        let access = Access { at, buffer, offset: (i * bytes) as u64, bytes: bytes as u32, lane: sink.lane.get() };
        sink.accesses.borrow_mut().push(access);
    });
}

pub(crate) fn local_load() {
    SINK.with(|sink| sink.local_loads.set(sink.local_loads.get() + 1));
}

pub(crate) fn local_store() {
    SINK.with(|sink| sink.local_stores.set(sink.local_stores.get() + 1));
}

/// Moves this thread's accesses, in their order, to the end of `accesses`.
pub fn take_accesses(accesses: &mut Vec<Access>) {
    SINK.with(|sink| accesses.append(&mut sink.accesses.borrow_mut()));
}

/// This thread's loads from and stores to local memory since it was last asked.
#[must_use]
pub fn take_local() -> [u64; 2] {
    SINK.with(|sink| [sink.local_loads.take(), sink.local_stores.take()])
}
