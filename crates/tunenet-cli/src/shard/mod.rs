//! One share of a work: where it is written, and what says that it is finished.
//!
//! Every shard writes to a place of its own, whose name follows from `--out` and the shard: the same command line serves all
//! tasks of an array, and no two of them ever touch one file.

pub mod differing;
pub mod mark;

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use tunenet_core::network::Shard;
use tunenet_core::observation::Note;
use tunenet_formats::Error;

pub use self::mark::{Job, Mark};

use crate::findings;

/// Where pieces lie in the folder of a bench.
pub const CELLS: &str = "cells";

/// Refuses a folder that somebody keeps other things in: what a bench writes could have the names of these.
///
/// # Errors
/// [`Error::File`] where `folder` holds something, and no bench has begun there.
pub fn require_own(folder: &Path) -> anyhow::Result<()> {
    let holds_something = std::fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some());
    if holds_something && !folder.join(CELLS).is_dir() {
        let message = "expected a new or empty folder, or one of a bench, found other files in it";
        return Err(Error::file(folder, message, "choose another folder with --out").into());
    }
    Ok(())
}

/// Where a shard of the file `out` is written: `pairs.mcap` becomes `pairs.shard-02-of-16.mcap`.
pub fn file(out: &Path, shard: Shard) -> PathBuf {
    let mut name = out.file_stem().map(OsString::from).unwrap_or_default();
    name.push(suffix(shard));
    if let Some(ending) = out.extension() {
        name.push(".");
        name.push(ending);
    }
    out.with_file_name(name)
}

/// Where a shard of the folder `out` is written: `results` becomes `results.shard-02-of-16`.
pub fn folder(out: &Path, shard: Option<Shard>) -> PathBuf {
    let Some(shard) = shard else { return out.into() };
    // Without the slash that may stand at its end.
    let mut name: OsString = out.components().collect::<PathBuf>().into();
    name.push(suffix(shard));
    name.into()
}

fn suffix(shard: Shard) -> String {
    let width = (shard.count() - 1).to_string().len();
    format!(".shard-{:0width$}-of-{}", shard.index(), shard.count())
}

/// What a shard did of all that there is to do.
#[derive(Debug, Clone, Copy)]
pub struct Share {
    /// Pieces of this shard.
    pub pieces: u64,
    /// Pieces of all shards together.
    pub all: u64,
}

impl Share {
    /// Says so where there are more shards than pieces: the last of them can have nothing to do.
    pub fn noted(self, shard: Shard) -> Option<Note> {
        (u64::from(shard.count()) > self.all).then(|| {
            let (count, all) = (shard.count(), self.all);
            let text = format!("{count} shards of {all} pieces: from {all}/{count} on none has any");
            Note::new(findings::SHARDS_MANY, text, format!("take at most {} shards", all.max(1)))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shard_has_a_place_of_its_own() {
        let shard = |index, count| Shard::new(index, count).unwrap();
        assert_eq!(file(Path::new("a/pairs.mcap"), shard(2, 16)), Path::new("a/pairs.shard-02-of-16.mcap"));
        assert_eq!(file(Path::new("p.q.mcap"), shard(0, 1)), Path::new("p.q.shard-0-of-1.mcap"));
        assert_eq!(folder(Path::new("a/out/"), Some(shard(9, 10))), Path::new("a/out.shard-9-of-10"));
        assert_eq!(folder(Path::new("a/out"), None), Path::new("a/out"));
    }
}
