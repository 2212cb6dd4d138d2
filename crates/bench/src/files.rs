//! Writing files whole.

use std::io;
use std::path::Path;

/// Puts a file of these bytes at `path`: written beside it, then renamed, so that nobody sees half of it.
pub(crate) fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let Some(name) = path.file_name() else {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "this is no name of a file"));
    };
    let unfinished = path.with_file_name(format!(".{}.{}.unfinished", name.to_string_lossy(), std::process::id()));
    let written = std::fs::write(&unfinished, bytes).and_then(|()| std::fs::rename(&unfinished, path));
    if written.is_err() {
        // Nothing more can be done if this fails too.
        let _ = std::fs::remove_file(&unfinished);
    }
    written
}
