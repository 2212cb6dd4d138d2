//! What can go wrong on a device.

/// An error of a device, in one sentence with the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// No device answers to the choice.
    #[error("no GPU matches `{wanted}`: this machine has {available}; use --device cpu or one of these")]
    NoSuchDevice {
        /// What was asked for.
        wanted: String,
        /// What there is.
        available: String,
    },
    /// The device cannot run the exact kernels.
    #[error(
        "{device} cannot run these kernels ({reason}); use --device cpu, a GPU that `caustic info` calls exact, or --precision fast"
    )]
    NotExact {
        /// The device.
        device: String,
        /// What it lacks.
        reason: String,
    },
    /// A buffer is larger than the device allows.
    #[error(
        "buffer `{buffer}` needs {needed} bytes but {device} allows {available} bytes a buffer; lower {flag} or use --device cpu"
    )]
    BufferTooLarge {
        /// The buffer.
        buffer: String,
        /// The device.
        device: String,
        /// Bytes needed.
        needed: u64,
        /// Bytes that one buffer may have.
        available: u64,
        /// The flags that make it smaller.
        flag: &'static str,
    },
    /// The device has no room.
    #[error("buffer `{buffer}` needs {needed} bytes but {device} has {available}; lower {flag}")]
    OutOfMemory {
        /// The buffer.
        buffer: String,
        /// The device.
        device: String,
        /// Bytes needed.
        needed: u64,
        /// Bytes there are, as far as they are known.
        available: String,
        /// The flags that make it smaller.
        flag: &'static str,
    },
    /// The device went away or was reset.
    #[error("{device} was lost while it ran `{stage}` ({reason}); run again, with --device cpu if it happens again")]
    DeviceLost {
        /// The device.
        device: String,
        /// The plan's first and last stage, or what was being done.
        stage: String,
        /// The driver's words.
        reason: String,
    },
    /// The driver refused a stage.
    #[error("{device} refused stage `{stage}`: {reason}")]
    Stage {
        /// The device.
        device: String,
        /// The stage.
        stage: String,
        /// The driver's words.
        reason: String,
    },
}

/// The flags of the command line on which the size of a buffer depends.
pub(crate) fn flag_of(buffer: &str) -> &'static str {
    match buffer {
        b if b.contains("cell") => "the number of cells: use --hash teschner",
        b if b.contains("film") => "--size",
        b if b.contains("sample") => "--spp",
        b if b.contains("neighbour") => "--k or the number of queries",
        _ => "--photons or --caustic-photons",
    }
}
