//! The place of a picture: whether it can be there, and putting it there whole.

use super::error::OutputError;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// Checks that a file can be put at `path`.
///
/// # Errors
/// If it cannot, with the remedy.
pub fn check(path: &Path) -> Result<(), OutputError> {
    let folder = folder(path);
    match fs::metadata(folder) {
        Ok(found) if found.is_dir() => {}
        Ok(_) => return Err(OutputError::NotAFolder { folder: folder.to_path_buf() }),
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            return Err(OutputError::NoFolder { folder: folder.to_path_buf() });
        }
        Err(error) => return Err(not_writable(folder, &error)),
    }
    match fs::metadata(path) {
        Ok(found) if found.is_file() => {}
        Ok(found) => {
            let what = if found.is_dir() { "a folder" } else { "a device or pipe" };
            return Err(OutputError::Taken { path: path.to_path_buf(), what });
        }
        Err(error) if error.kind() == io::ErrorKind::NotFound => {}
        Err(error) => return Err(OutputError::Write { path: path.to_path_buf(), reason: error.to_string() }),
    }
    Unfinished::create(folder).map(drop).map_err(|error| not_writable(folder, &error))
}

/// Puts a file of these bytes at `path`: written beside it, brought to the disk, then renamed.
///
/// # Errors
/// If it cannot be written.
pub fn replace(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    let write = || -> io::Result<()> {
        let mut unfinished = Unfinished::create(folder(path))?;
        unfinished.file.write_all(bytes)?;
        unfinished.file.sync_all()?;
        unfinished.rename(path)
    };
    write().map_err(|error| OutputError::Write { path: path.to_path_buf(), reason: error.to_string() })
}

fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

fn not_writable(folder: &Path, error: &io::Error) -> OutputError {
    OutputError::NotWritable { folder: folder.to_path_buf(), reason: error.to_string() }
}

/// A file on its way: removed when it is dropped unless it was renamed.
struct Unfinished {
    path: PathBuf,
    file: File,
    renamed: bool,
}

impl Unfinished {
    fn create(folder: &Path) -> io::Result<Self> {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        loop {
            let number = NUMBER.fetch_add(1, Ordering::Relaxed);
            let path = folder.join(format!(".caustic-{}-{number}.unfinished", std::process::id()));
            match OpenOptions::new().write(true).create_new(true).open(&path) {
                Ok(file) => return Ok(Self { path, file, renamed: false }),
                // Left behind by a process of this number that was killed.
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
            }
        }
    }

    fn rename(&mut self, to: &Path) -> io::Result<()> {
        fs::rename(&self.path, to)?;
        self.renamed = true;
        Ok(())
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        if !self.renamed {
            // Nothing more can be done if this fails too.
            let _ = fs::remove_file(&self.path);
        }
    }
}
