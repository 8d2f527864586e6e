//! What is compressed with zstd: a whole file of a bag, or each of its messages.

use std::fs::File;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

use tempfile::{NamedTempFile, TempPath};

use crate::format::ZSTD;
use crate::source::open;
use crate::{Action, Error, Result};

/// How much larger than its compressed copy a file may be, and what is read in any case, in bytes: as of chunks of an MCAP file.
const MOST_GROWTH: u64 = 64;
const SMALL: u64 = 256 << 20;

/// A file as it was before it was compressed: itself, or a copy that goes away with this value.
#[derive(Debug)]
pub(crate) struct Unpacked {
    path: PathBuf,
    copy: Option<TempPath>,
}

impl Unpacked {
    pub fn path(&self) -> &Path {
        self.copy.as_deref().unwrap_or(&self.path)
    }
}

/// The file at `path`, or what it holds where it is compressed with zstd, which goes into the system's folder for temporary files.
///
/// # Errors
/// [`Error::Io`] where the system refuses; [`Error::File`] where it is broken or implausibly large.
pub(crate) fn unpacked(path: &Path) -> Result<Unpacked> {
    let reading = |e| Error::io(path, Action::Reading, e);
    let mut file = open(path)?;
    let bytes = file.metadata().map_err(reading)?.len();
    let mut mark = [0; ZSTD.len()];
    let known = file.read(&mut mark).map_err(reading)?;
    if mark[..known] != *ZSTD {
        return Ok(Unpacked { path: path.to_owned(), copy: None });
    }
    let most = bytes.saturating_mul(MOST_GROWTH).max(SMALL);
    let copy = NamedTempFile::new().map_err(|e| Error::io(std::env::temp_dir(), Action::Creating, e))?;
    let copied = decompressed(open(path)?, copy.as_file(), most).map_err(|e| {
        let message = format!("the file cannot be unpacked with zstd: {e}");
        Error::file(path, message, "copy it again, or free space in the folder for temporary files")
    })?;
    if copied > most {
        let message = format!("it unpacks to more than {MOST_GROWTH} times its size and more than {SMALL} bytes");
        return Err(Error::file(path, message, "unpack it with `zstd -d` and give the file that it makes"));
    }
    Ok(Unpacked { path: path.to_owned(), copy: Some(copy.into_temp_path()) })
}

fn decompressed(from: File, mut to: &File, most: u64) -> std::io::Result<u64> {
    let mut reader = zstd::Decoder::new(from)?.take(most + 1);
    let copied = std::io::copy(&mut reader, &mut to)?;
    to.flush()?;
    Ok(copied)
}

/// A message, unpacked where it is compressed.
///
/// # Errors
/// What is wrong with it, to stand behind "the message".
pub(crate) fn message(data: &[u8], most: usize) -> std::result::Result<Vec<u8>, String> {
    if !data.starts_with(ZSTD) {
        return Ok(data.to_vec());
    }
    let most = most.min(data.len().saturating_mul(1 << 12)) as u64;
    let mut whole = Vec::new();
    let read = zstd::Decoder::with_buffer(data).and_then(|decoder| decoder.take(most + 1).read_to_end(&mut whole));
    match read {
        Err(error) => Err(format!("cannot be unpacked with zstd ({error})")),
        Ok(_) if whole.len() as u64 > most => Err("unpacks to implausibly many bytes".into()),
        Ok(_) => Ok(whole),
    }
}
