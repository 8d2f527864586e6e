//! What is finished, kept on disk, so that an interrupted run resumes.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use anyhow::{Context, Result};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use tunenet_core::network::Shard;
use tunenet_formats::{Error, write_atomically};

use crate::args::Measured;
use tunenet_cli::Sharing;
use tunenet_cli::exit_status::Exit;
use tunenet_cli::files::destination;
use tunenet_cli::files::hash;
use tunenet_cli::shard::differing::{differing, sides};
use tunenet_cli::shard::{self, CELLS, Job, Mark, Share, mark};
use tunenet_cli::view;
use tunenet_cli::view::text::stage;

/// Draws that one piece holds: some seconds of work, which is what an interrupted run loses at most on each thread.
pub const DRAWS_PER_PIECE: u32 = 50;
/// What every run is identified by in addition to its options: the digest of the program.
const PROGRAM: &str = "program";

/// Refuses the folder of a shard that is finished for another run: what it holds would be made again, piece by piece. That
/// another build of the program finished it is only reported, since its pieces are made again anyway.
fn finished_alike(folder: &Path, run: &Value) -> Result<()> {
    if Mark::read(folder).is_err() {
        return Ok(());
    }
    let cells = folder.join(CELLS);
    let Ok(entries) = std::fs::read_dir(&cells) else { return Ok(()) };
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    let made = |path: &PathBuf| -> Option<Value> {
        let whole: Value = serde_json::from_str(&std::fs::read_to_string(path).ok()?).ok()?;
        whole.get("run").cloned()
    };
    let Some(made) = paths.iter().filter_map(made).find(|made| made != run) else { return Ok(()) };
    let (program, others): (Vec<_>, Vec<_>) = differing(run, &made).into_iter().partition(|one| one.option == PROGRAM);
    if others.is_empty() {
        debug_assert!(!program.is_empty());
        stage("again", &format!("{}, which another build of tunenet had finished", folder.display()));
        return Ok(());
    }
    let (expected, found) = sides(&others);
    let message = format!("expected a new folder, or a shard with {expected}, found a finished one with {found}");
    Err(Error::file(folder, message, "choose another folder with --out, or remove this one").into())
}

/// This program, as a digest of its bytes: the version number does not distinguish a rebuilt program from the one that made a piece.
///
/// # Errors
/// Where it cannot be read.
pub fn program() -> Result<String> {
    hash::sha256(&std::env::current_exe().context("this program's own path")?)
}

/// A folder of finished pieces. A piece counts only for the run that it was made by: the program, the seed, and what
/// else decides what comes out.
///
/// Of a run in shards, [`piece`](Self::piece) makes every n-th alone, in a folder of the shard's own.
pub struct Store {
    folder: PathBuf,
    run: Value,
    shard: Option<Shard>,
    /// How many pieces were asked for, and how many of them are this shard's.
    pieces: AtomicU64,
    mine: AtomicU64,
}

impl Store {
    pub fn open(folder: &Path, run: Value, sharing: &Sharing) -> Result<Self> {
        let folder = shard::folder(folder, sharing.shard);
        destination::leads_somewhere(&folder, &folder, true)?;
        shard::require_own(&folder)?;
        if sharing.shard.is_some() {
            finished_alike(&folder, &run)?;
            mark::clear_damage(&folder)?.iter().for_each(|text| stage("again", text));
        }
        let (pieces, mine) = (AtomicU64::new(0), AtomicU64::new(0));
        let store = Self { folder, run, shard: sharing.shard, pieces, mine };
        store.room(CELLS)?;
        Ok(store)
    }

    /// Whether this is one share of a run.
    pub fn sharded(&self) -> bool {
        self.shard.is_some()
    }

    /// Whether the next piece is this shard's. Asked once for each piece, in the same order in every run; without shards
    /// every piece is.
    pub fn turn(&self) -> bool {
        let number = self.pieces.fetch_add(1, Ordering::Relaxed);
        let mine = self.shard.is_none_or(|shard| shard.takes(number));
        self.mine.fetch_add(u64::from(mine), Ordering::Relaxed);
        mine
    }

    /// As [`keep`](Self::keep), for a piece that can be made apart from all others; `None` where it is another shard's.
    pub fn piece<T: Serialize + DeserializeOwned>(
        &self,
        name: &str,
        make: impl FnOnce() -> Result<T>,
    ) -> Result<Option<T>> {
        if self.turn() { self.keep(name, make).map(Some) } else { Ok(None) }
    }

    /// Of a run in shards: marks this one as finished and says so. `None` where the whole answer is to follow.
    pub fn finished(&self, bench: Measured, as_json: bool) -> Result<Option<Exit>> {
        let Some(shard) = self.shard else { return Ok(None) };
        Mark::write(&self.folder, shard, Job::Bench(serde_json::to_value(bench)?))?;
        let all = self.pieces.load(Ordering::Relaxed);
        let share = Share { pieces: self.mine.load(Ordering::Relaxed), all };
        view::shard::show(shard, &self.folder, share, &format!("of {all} pieces"), as_json)?;
        Ok(Some(Exit::Done))
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
        let path = self.folder.join(CELLS).join(format!("{name}.json"));
        if let Some(value) = self.kept(&path) {
            return Ok(value);
        }
        let text = format!("{:#}\n", json!({ "run": self.run, "value": make()? }));
        write_atomically(&path, |file| file.write_all(text.as_bytes()))?;
        self.kept(&path).with_context(|| format!("{} does not hold what was written to it", path.display()))
    }

    fn kept<T: DeserializeOwned>(&self, path: &Path) -> Option<T> {
        // What cannot be read is made again.
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
        let store = |seed: u64| Store::open(folder.path(), json!({ "seed": seed }), &Sharing::default()).unwrap();
        assert_eq!(store(1).keep("a", || Ok(0.1 + 0.2)).unwrap(), 0.1 + 0.2);
        assert_eq!(store(1).keep::<f64>("a", || anyhow::bail!("made twice")).unwrap(), 0.1 + 0.2);
        assert_eq!(store(2).keep("a", || Ok(0.5)).unwrap(), 0.5);
    }

    #[test]
    fn a_folder_of_others_is_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let open = || Store::open(folder.path(), json!({}), &Sharing::default());
        std::fs::write(folder.path().join("figure2.md"), "mine").unwrap();
        let refused = open().err().unwrap().to_string();
        assert!(refused.contains("expected a new or empty folder, or one of a bench"), "{refused}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        std::fs::remove_file(folder.path().join("figure2.md")).unwrap();
        open().unwrap();
        open().unwrap();
    }

    #[test]
    fn shards_share_the_pieces_out() {
        let folder = tempfile::tempdir().unwrap();
        let made: Vec<Vec<u64>> = (0..3)
            .map(|index| {
                let shard = Some(Shard::new(index, 3).unwrap());
                let store = Store::open(&folder.path().join("out"), json!({}), &Sharing { shard }).unwrap();
                (0..8).filter_map(|i| store.piece(&format!("p{i}"), || Ok(i)).unwrap()).collect()
            })
            .collect();
        assert_eq!(made, [vec![0, 3, 6], vec![1, 4, 7], vec![2, 5]]);
        assert!(folder.path().join("out.shard-2-of-3/cells/p5.json").is_file());
        assert!(!folder.path().join("out").exists());
    }
}
