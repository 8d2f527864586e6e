//! Networks trained for a scene, kept for the next run.

use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};
use tunenet_core::network::Model;
use tunenet_core::observation::Note;
use tunenet_formats::write_atomically;
use tunenet_formats::{model_from_bytes, model_to_bytes, read_bytes};
use tunenet_sim::NetworkStore;

use crate::files::names;
use crate::findings;

/// Names another folder; empty for none.
const FOLDER: &str = "TUNENET_CACHE";
/// Largest entry that is read, in bytes: thousands of times what a network of two branches has.
const LARGEST_ENTRY: u64 = 256 << 20;
/// Length of a digest in hexadecimal.
const DIGEST: usize = 64;

/// A folder of networks, or none. An entry is the digest of its key and its bytes, a line's end, and the bytes.
pub struct Cache {
    folder: Option<PathBuf>,
}

impl Cache {
    /// The user's: `$TUNENET_CACHE`, else `tunenet` in `$XDG_CACHE_HOME`, else in `~/.cache`.
    pub fn of_user() -> Self {
        let named = |name: &str| std::env::var_os(name);
        let absolute = |name: &str| named(name).map(PathBuf::from).filter(|path| path.is_absolute());
        let folder = match named(FOLDER) {
            Some(folder) => Some(PathBuf::from(folder)).filter(|folder| !folder.as_os_str().is_empty()),
            None => absolute("XDG_CACHE_HOME")
                .or_else(|| absolute("HOME").map(|home| home.join(".cache")))
                .map(|folder| folder.join("tunenet")),
        };
        Self { folder }
    }

    /// One that finds nothing and keeps nothing.
    pub fn none() -> Self {
        Self { folder: None }
    }

    fn path(&self, key: &str) -> Option<PathBuf> {
        let name = format!("{}.network", hex::encode(Sha256::digest(key)));
        self.folder.as_ref().map(|folder| folder.join(name))
    }
}

impl NetworkStore for Cache {
    /// The network of this key, where there is one; a note where there is something else in its place.
    fn find(&self, key: &str) -> (Option<Model>, Vec<Note>) {
        let Some(path) = self.path(key) else { return (None, Vec::new()) };
        if !path.exists() {
            return (None, Vec::new());
        }
        let bytes = match read_bytes(&path, LARGEST_ENTRY) {
            Ok(bytes) => bytes,
            Err(error) => return (None, vec![unusable(&path, &error.to_string())]),
        };
        let whole =
            bytes.split_at_checked(DIGEST + 1).filter(|(head, rest)| head[..DIGEST] == *digest(key, rest).as_bytes());
        let model = whole.and_then(|(_, rest)| model_from_bytes(&path, rest).ok());
        let notes = if model.is_none() {
            let text = format!("{} in the cache was damaged and has been made again", names::file_name(&path));
            vec![Note::new(findings::CACHE_REPLACED, text, "")]
        } else {
            Vec::new()
        };
        (model, notes)
    }

    /// Keeps a network; a note where that is not possible.
    fn keep(&self, key: &str, model: &Model) -> Option<Note> {
        let path = self.path(key)?;
        let written = model_to_bytes(model).and_then(|bytes| {
            let failed = |source| tunenet_formats::Error::io(&path, tunenet_formats::Action::Writing, source);
            std::fs::create_dir_all(path.parent().unwrap_or(Path::new("."))).map_err(failed)?;
            write_atomically(&path, |file| {
                writeln!(file, "{}", digest(key, &bytes))?;
                file.write_all(&bytes)
            })
        });
        written.err().map(|error| unusable(&path, &error.to_string()))
    }
}

fn unusable(path: &Path, why: &str) -> Note {
    let folder = path.parent().unwrap_or(path).display();
    let text = format!("the network for this scene is not kept: {why}");
    Note::new(
        findings::CACHE_UNUSABLE,
        text,
        format!("make {folder} writable, name another folder in {FOLDER}, or use --no-cache"),
    )
}

fn digest(key: &str, bytes: &[u8]) -> String {
    hex::encode(Sha256::new().chain_update(key).chain_update(bytes).finalize())
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_pipe_in_place_of_an_entry_is_not_waited_for() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache { folder: Some(folder.path().into()) };
        assert!(cache.find("a scene").1.is_empty());
        let path = cache.path("a scene").unwrap();
        assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
        let (model, notes) = cache.find("a scene");
        assert!(model.is_none() && notes[0].kind == findings::CACHE_UNUSABLE && notes[0].text.contains("a pipe"));
    }
}
