//! The file behind a recording: opened only where it is one, and the same from the first byte to the last.

use std::fs::{File, Metadata};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use crate::{Action, Error, Result};

/// Largest text that is read, in bytes: half a minute of reading. As many numbers as are read at most
/// ([`MOST_NUMBERS`](crate::MOST_NUMBERS)) fit in with 20 signs each.
pub(crate) const LARGEST_TEXT: u64 = 1 << 30;

/// Opens a file for reading. A folder, a pipe and a device are refused before they are opened, since opening a pipe waits
/// for its writer; and what is read is read more than once.
///
/// # Errors
/// [`Error::Io`] where the system refuses, [`Error::File`] where there is no file of a known length.
pub fn open(path: impl AsRef<Path>) -> Result<File> {
    let path = path.as_ref();
    let failed = |e| Error::io(path, Action::Opening, e);
    refuse_other(path, &std::fs::metadata(path).map_err(failed)?)?;
    let file = File::open(path).map_err(failed)?;
    // Whoever swapped it in between gets the same answer.
    refuse_other(path, &file.metadata().map_err(failed)?)?;
    Ok(file)
}

/// All bytes of a file of at most `most` bytes.
///
/// # Errors
/// [`Error::Io`] where the system refuses, [`Error::File`] where there is no file of a known length, or a longer one.
pub fn read_bytes(path: impl AsRef<Path>, most: u64) -> Result<Vec<u8>> {
    use std::io::Read as _;
    let path = path.as_ref();
    let mut bytes = Vec::new();
    open(path)?.take(most + 1).read_to_end(&mut bytes).map_err(|e| Error::io(path, Action::Reading, e))?;
    if bytes.len() as u64 > most {
        let message = format!("expected a file of at most {most} bytes, found a larger one");
        return Err(Error::file(path, message, "is this the right file?"));
    }
    Ok(bytes)
}

fn refuse_other(path: &Path, about: &Metadata) -> Result<()> {
    if about.is_dir() {
        return Err(Error::file(path, "expected a file, found a folder", "name one file in it"));
    }
    if !about.is_file() {
        let hint = "write it to a file first, for example `cat > recording.csv`, and give that";
        return Err(Error::file(path, format!("expected a file, found {}", device(about)), hint));
    }
    Ok(())
}

#[cfg(unix)]
fn device(about: &Metadata) -> &'static str {
    use std::os::unix::fs::FileTypeExt;
    let kind = about.file_type();
    match (kind.is_fifo(), kind.is_socket()) {
        (true, _) => "a pipe",
        (_, true) => "a socket",
        _ => "a device",
    }
}

#[cfg(not(unix))]
fn device(_: &Metadata) -> &'static str {
    "a device"
}

/// Reads by `read`, and refuses a file of `paths` where it was written to meanwhile: half of one recording and half of another fit
/// together too often.
pub(crate) fn unchanged<T>(paths: &[PathBuf], read: impl FnOnce() -> Result<T>) -> Result<T> {
    let state = |path: &PathBuf| {
        if path.is_dir() {
            return Ok(None);
        }
        let about = open(path)?.metadata().map_err(|e| Error::io(path, Action::Opening, e))?;
        Ok(Some(Version::of(&about)))
    };
    let before = paths.iter().map(state).collect::<Result<Vec<Option<Version>>>>()?;
    let result = read();
    for (path, before) in paths.iter().zip(before) {
        if let Some(before) = before {
            // What the change broke is no news after the change itself.
            same(path, &before)?;
        }
    }
    result
}

/// Refuses a file that is not as it was.
fn same(path: &Path, before: &Version) -> Result<()> {
    match std::fs::metadata(path).map(|about| Version::of(&about)) {
        Ok(after) if after == *before => Ok(()),
        Ok(after) => {
            let (found, expected) = (after.bytes, before.bytes);
            let what = if found == expected {
                "its contents or its time of change are others".to_owned()
            } else {
                format!("expected {expected} bytes, found {found}")
            };
            let message = format!("the file changed while it was read: {what}");
            Err(Error::file(path, message, "wait until the recording has ended, or read a copy"))
        }
        Err(_) => {
            let message = "the file changed while it was read: it is no longer there";
            Err(Error::file(path, message, "read a copy that is not changed meanwhile"))
        }
    }
}

/// What distinguishes one state of a file from another.
#[derive(Debug, PartialEq, Eq)]
pub struct Version {
    bytes: u64,
    /// `None` where the system does not report it.
    modified: Option<SystemTime>,
    /// Its number on the disk: another file under the same name has another.
    number: u64,
}

/// A change is at least so old before a time of change distinguishes it from the next one: file systems count in steps of up to 2 s.
const SETTLED: std::time::Duration = std::time::Duration::from_secs(3);

impl Version {
    /// That of the file at `path`.
    ///
    /// # Errors
    /// [`Error::Io`] where the system refuses.
    pub fn at(path: &Path) -> Result<Self> {
        std::fs::metadata(path).map(|about| Self::of(&about)).map_err(|e| Error::io(path, Action::Opening, e))
    }

    /// Whether a later change would be another version.
    #[must_use]
    pub fn settled(&self) -> bool {
        self.modified.and_then(|at| at.elapsed().ok()).is_some_and(|age| age > SETTLED)
    }

    fn of(about: &Metadata) -> Self {
        #[cfg(unix)]
        let number = std::os::unix::fs::MetadataExt::ino(about);
        #[cfg(not(unix))]
        let number = 0;
        Self { bytes: about.len(), modified: about.modified().ok(), number }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{error_text, file};

    #[test]
    fn a_change_is_reported_instead_of_what_it_broke() {
        let (_folder, path) = file("a.csv", "t_s,z_m\n0,1\n");
        assert_eq!(unchanged(std::slice::from_ref(&path), || Ok(7)).unwrap(), 7);
        let grows = || {
            std::fs::write(&path, "t_s,z_m\n0,1\n1,2\n").unwrap();
            Err::<(), _>(tunenet_core::Error::Stopped.into())
        };
        let (message, hint) = error_text(&unchanged(std::slice::from_ref(&path), grows).unwrap_err());
        assert_eq!(message, "a.csv: the file changed while it was read: expected 12 bytes, found 16");
        assert_eq!(hint, "wait until the recording has ended, or read a copy");
    }

    #[test]
    fn another_file_of_the_same_size_is_a_change_too() {
        let (folder, path) = file("a.csv", "t_s,z_m\n0,1\n");
        let replaced = || {
            let other = folder.path().join("b.csv");
            std::fs::write(&other, "t_s,z_m\n0,2\n").unwrap();
            std::fs::rename(other, &path).unwrap();
            Ok(())
        };
        let (message, _) = error_text(&unchanged(std::slice::from_ref(&path), replaced).unwrap_err());
        assert!(message.starts_with("a.csv: the file changed while it was read: its contents"), "{message}");
        let removed = || {
            std::fs::remove_file(&path).unwrap();
            Ok(())
        };
        let (message, _) = error_text(&unchanged(std::slice::from_ref(&path), removed).unwrap_err());
        assert_eq!(message, "a.csv: the file changed while it was read: it is no longer there");
    }
}
