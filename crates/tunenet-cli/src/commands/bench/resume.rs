//! What is finished, kept on disk, so that an interrupted run goes on where it stopped.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use tunenet_core::observation::recording::write_atomically;

/// A folder of finished pieces. A piece counts only for the run that it was made by: the program, the seed, and whatever
/// else decides what comes out.
pub struct Store {
    folder: PathBuf,
    run: Value,
}

impl Store {
    pub fn open(folder: &Path, run: Value) -> Result<Self> {
        let store = Self { folder: folder.into(), run };
        store.room("cells")?;
        Ok(store)
    }

    /// A folder of its own within, made where it is missing.
    pub fn room(&self, name: &str) -> Result<PathBuf> {
        let path = self.folder.join(name);
        std::fs::create_dir_all(&path).with_context(|| format!("creating {}", path.display()))?;
        Ok(path)
    }

    /// The piece `name`, from disk where this run has made it already. Either way it has passed through its file, so that
    /// a resumed run ends with the same digits.
    pub fn keep<T: Serialize + DeserializeOwned>(&self, name: &str, make: impl FnOnce() -> Result<T>) -> Result<T> {
        let path = self.folder.join("cells").join(format!("{name}.json"));
        if let Some(value) = self.kept(&path) {
            return Ok(value);
        }
        let text = format!("{:#}\n", json!({ "run": self.run, "value": make()? }));
        write_atomically(&path, |file| file.write_all(text.as_bytes()))?;
        self.kept(&path).with_context(|| format!("{} does not hold what was written to it", path.display()))
    }

    fn kept<T: DeserializeOwned>(&self, path: &Path) -> Option<T> {
        // Whatever cannot be read is made again.
        let text = std::fs::read_to_string(path).ok()?;
        let mut whole: Value = serde_json::from_str(&text).ok()?;
        (whole["run"] == self.run).then(|| serde_json::from_value(whole["value"].take()).ok())?
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_piece_is_made_once_for_a_run() {
        let folder = tempfile::tempdir().unwrap();
        let store = |seed: u64| Store::open(folder.path(), json!({ "seed": seed })).unwrap();
        assert_eq!(store(1).keep("a", || Ok(0.1 + 0.2)).unwrap(), 0.1 + 0.2);
        assert_eq!(store(1).keep::<f64>("a", || anyhow::bail!("made twice")).unwrap(), 0.1 + 0.2);
        assert_eq!(store(2).keep("a", || Ok(0.5)).unwrap(), 0.5);
    }
}
