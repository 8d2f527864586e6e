//! SHA-256 of files, and what is identified by it.

use std::io::Read;
use std::path::{Path, PathBuf};

use anyhow::Result;
use sha2::{Digest, Sha256};
use toml_edit::{Array, InlineTable};
use tunenet_formats::{Action, Error, files_of, open};

use super::names::{file_name, pictures};

/// The SHA-256 of a file's bytes, in hexadecimal; of a folder of frames or of a recording in several files, that of all their bytes.
pub fn sha256(path: &Path) -> Result<String> {
    let mut hasher = Sha256::new();
    if path.is_file() {
        digest(path, &mut hasher)?;
        return Ok(hex::encode(hasher.finalize()));
    }
    let folder = path.is_dir();
    let failed = |source| Error::io(path, Action::Reading, source);
    let pictures = if folder { pictures(path).map_err(failed)? } else { Vec::new() };
    for file in if pictures.is_empty() { files_of(path)? } else { pictures } {
        digest(&file, &mut hasher)?;
    }
    if !folder {
        // Several episodes stand in the same files.
        hasher.update(file_name(path));
    }
    Ok(hex::encode(hasher.finalize()))
}

/// A file's name and hash, as `[provenance]` names what was read.
pub fn fingerprint(path: &Path) -> Result<InlineTable> {
    let mut one = InlineTable::new();
    one.insert("file", file_name(path).into());
    one.insert("sha256", sha256(path)?.into());
    Ok(one)
}

/// The same of several files.
pub fn fingerprints(paths: &[PathBuf]) -> Result<Array> {
    paths.iter().map(|path| fingerprint(path)).collect()
}

fn digest(path: &Path, hasher: &mut Sha256) -> Result<()> {
    let failed = |source| Error::io(path, Action::Reading, source);
    let mut file = open(path)?;
    let mut buffer = vec![0; 1 << 16];
    loop {
        let count = file.read(&mut buffer).map_err(failed)?;
        if count == 0 {
            break;
        }
        hasher.update(&buffer[..count]);
    }
    Ok(())
}

/// Refuses a recording that is given twice, whatever it is called: the same evidence counted twice looks like twice as much.
/// Only files of one length are read, so that a single large one costs nothing.
pub fn refuse_copies<'a>(recordings: impl Iterator<Item = &'a Path>) -> Result<()> {
    let mut seen: Vec<(&Path, u64)> = Vec::new();
    for path in recordings {
        // What cannot be read is refused by whoever reads it.
        let length = std::fs::metadata(path).map_or(0, |about| about.len());
        for (other, _) in seen.iter().filter(|(_, known)| *known == length && length > 0) {
            if sha256(path)? == sha256(other)? {
                let message = format!("expected another recording, found the same as in {}", other.display());
                return Err(Error::file(path, message, "give every recording once").into());
            }
        }
        seen.push((path, length));
    }
    Ok(())
}
