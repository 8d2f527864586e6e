//! SHA-256 of files, and what is identified by it.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use anyhow::Result;
use sha2::{Digest, Sha256};
use toml_edit::{Array, InlineTable};
use tunenet_formats::{Action, Error, Version, files_of, open, shown_path};

use super::names::{file_name, pictures};

/// The SHA-256 of a file's bytes, in hexadecimal; of a folder of frames or of a recording in several files, that of all their bytes;
/// of an episode, that of the hashes of its files and of its name.
pub fn sha256(path: &Path) -> Result<String> {
    let mut hasher = Sha256::new();
    if path.is_file() || path.is_dir() {
        for file in files(path)? {
            digest(&file, &mut hasher)?;
        }
    } else {
        for file in files(path)? {
            hasher.update(shared(&file)?);
        }
        // Several episodes stand in the same files.
        hasher.update(file_name(path));
    }
    Ok(hex::encode(hasher.finalize()))
}

/// The files of a recording.
fn files(path: &Path) -> Result<Vec<PathBuf>> {
    if path.is_file() {
        return Ok(vec![path.to_owned()]);
    }
    let failed = |source| Error::io(path, Action::Reading, source);
    let pictures = if path.is_dir() { pictures(path).map_err(failed)? } else { Vec::new() };
    Ok(if pictures.is_empty() { files_of(path)? } else { pictures })
}

/// The files of episodes that were hashed, each as it was then: one of a data set holds thousands of them.
static HASHED: Mutex<BTreeMap<PathBuf, (Version, [u8; 32])>> = Mutex::new(BTreeMap::new());

/// The digest of a file that other episodes may stand in as well: hashed once, as long as it does not change.
fn shared(path: &Path) -> Result<[u8; 32]> {
    let version = Version::at(path)?;
    let mut all = HASHED.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, digest)) = all.get(path).filter(|(known, _)| *known == version) {
        return Ok(*digest);
    }
    let mut hasher = Sha256::new();
    digest(path, &mut hasher)?;
    let digest = hasher.finalize().into();
    // A change that follows at the same time of change would not show.
    if version.settled() {
        all.insert(path.to_owned(), (version, digest));
    }
    Ok(digest)
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

/// Recordings that may be copies of one another, with their hashes as far as these were needed.
type Alike<'a> = Vec<(&'a Path, Option<String>)>;

/// Refuses a recording that is given twice, whatever it is called: the same evidence counted twice looks like twice as much.
/// Only recordings of one length are read, so that a single large one costs nothing.
pub fn refuse_copies<'a>(recordings: impl Iterator<Item = &'a Path>) -> Result<()> {
    // Of one length and, of a data set, of one episode.
    let mut seen: BTreeMap<(u64, String), Alike<'a>> = BTreeMap::new();
    for path in recordings {
        // What cannot be read is refused by whoever reads it.
        let Some(length) = length(path).filter(|length| *length > 0) else { continue };
        let episode = if path.exists() { String::new() } else { file_name(path) };
        let alike = seen.entry((length, episode)).or_default();
        let hash = if alike.is_empty() { None } else { Some(sha256(path)?) };
        for (other, known) in alike.iter_mut() {
            if known.is_none() {
                *known = Some(sha256(other)?);
            }
            if *known == hash {
                let message = format!("expected another recording, found the same as in {}", shown_path(other));
                return Err(Error::file(path, message, "give every recording once").into());
            }
        }
        alike.push((path, hash));
    }
    Ok(())
}

/// The bytes of all files of a recording.
fn length(path: &Path) -> Option<u64> {
    let one = |path: PathBuf| std::fs::metadata(path).ok().map(|about| about.len());
    files(path).ok()?.into_iter().map(one).sum()
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, SystemTime};

    use super::*;

    /// A data set of LeRobot whose episodes stand in one file, of which nothing is read here.
    fn data_set(folder: &Path, data: &str) {
        std::fs::create_dir_all(folder.join("meta")).unwrap();
        std::fs::create_dir_all(folder.join("data/chunk-000")).unwrap();
        let info = r#"{"codebase_version": "v2.1", "fps": 30, "features": {}}"#;
        std::fs::write(folder.join("meta/info.json"), info).unwrap();
        for episode in 0..2 {
            std::fs::write(folder.join(format!("data/chunk-000/episode_00000{episode}.parquet")), data).unwrap();
        }
    }

    fn refused(paths: &[PathBuf]) -> Option<String> {
        refuse_copies(paths.iter().map(PathBuf::as_path)).err().map(|error| error.to_string())
    }

    #[test]
    fn episodes_and_folders_are_compared_by_their_files() {
        let folder = tempfile::tempdir().unwrap();
        let set = |name: &str| folder.path().join(name);
        data_set(&set("a"), "x");
        data_set(&set("copy"), "x");
        data_set(&set("other"), "y");
        let episode = |name: &str, number: u32| set(name).join(format!("episode_{number}"));
        assert_eq!(refused(&[episode("a", 0), episode("a", 1), episode("other", 0)]), None);
        assert!(refused(&[episode("a", 0), episode("a", 1), episode("a", 0)]).is_some());
        assert!(refused(&[episode("a", 0), episode("copy", 0)]).unwrap().contains("found the same as in"));
        // Folders have equal sizes by themselves.
        for (bag, data) in [("b", "one"), ("c", "two"), ("d", "one")] {
            std::fs::create_dir(set(bag)).unwrap();
            std::fs::write(set(bag).join("b_0.mcap"), data).unwrap();
        }
        assert_eq!(refused(&[set("b"), set("c")]), None);
        assert!(refused(&[set("b"), set("c"), set("d")]).unwrap().contains("/b"));
    }

    #[test]
    fn a_file_that_episodes_share_is_hashed_again_only_where_it_changed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let put = |text: &str, seconds: u64| {
            std::fs::write(&path, text).unwrap();
            let file = std::fs::File::options().write(true).open(&path).unwrap();
            file.set_modified(SystemTime::now() - Duration::from_secs(seconds)).unwrap();
        };
        put("one", 60);
        let first = shared(&path).unwrap();
        assert_eq!(hex::encode(first), sha256(&path).unwrap());
        assert!(HASHED.lock().unwrap().contains_key(&path));
        put("two", 50);
        assert_ne!(shared(&path).unwrap(), first);
    }
}
