//! Folders of shards: what a bench or `--each` has kept, brought into one folder, and the ordinary answer printed from it.

use std::path::{Path, PathBuf};

use anyhow::Result;
use tunenet_formats::{Action, Error};

use super::complete;
use super::foreign::foreign;
use crate::args::Merge;
use crate::commands::{bench, each};
use crate::exit_status::Exit;
use crate::files::destination::{self, Output, Product};
use crate::files::{hash, names};
use crate::shard::{self, Job, Mark};
use crate::view::text::stage;

/// Where all shards make the same files, these have to be equal byte for byte: every trial rests on them.
const LEARNED: [&str; 2] = ["safetensors", "mcap"];

pub fn run(options: &Merge, folders: &[PathBuf]) -> Result<Exit> {
    let mut marks: Vec<(&Path, Mark)> = Vec::with_capacity(folders.len());
    for folder in folders {
        marks.push((folder, Mark::read(folder)?));
    }
    let Some((first, like)) = marks.first() else { return Ok(Exit::Done) };
    if like.program != like.job.program()? {
        let message = "expected a shard by this very program, found one by another build of the same version";
        return Err(Error::file(*first, message, "merge with the program that wrote the shards").into());
    }
    for (folder, mark) in &marks[1..] {
        if let Some((expected, found)) = foreign(like, mark) {
            let message =
                format!("expected a shard of {expected} as {}, found one of {found}", names::file_name(first));
            return Err(Error::file(*folder, message, "merge only shards of one command").into());
        }
    }
    complete(&marks.iter().map(|(folder, mark)| (*folder, mark.shard)).collect::<Vec<_>>())?;
    for (folder, mark) in &marks {
        mark.check(folder)?;
    }
    if !options.writing.overwrite {
        if matches!(like.job, Job::Bench(_)) {
            shard::require_own(&options.out)?;
        }
        let all = Path::new(each::ALL);
        let brought = marks.iter().flat_map(|(_, mark)| mark.files.iter());
        let answers =
            matches!(like.job, Job::Each { .. }).then(|| Output::new(&options.out.join(all), "--out", Product::Answer));
        for (path, hash) in brought.filter(|(path, _)| Path::new(path) != all) {
            let to = options.out.join(path);
            // A merge that is repeated brings the same again.
            if destination::holds_something(&to) && hash::sha256(&to).ok().as_ref() != Some(hash) {
                return Err(destination::taken(&Output::new(&to, "--out", Product::Unmarked)).into());
            }
        }
        if let Some(output) = answers {
            destination::check(&[Output { makes_folder: true, ..output }], &[], false)?;
        }
    }
    let job = like.job.clone();
    marks.sort_by_key(|(_, mark)| mark.shard);
    for (folder, mark) in &marks {
        gather(folder, mark, &marks, &options.out)?;
    }
    stage("merged", &format!("{} shards", marks.len()));
    match job {
        Job::Bench(measured) => bench::merged(&measured, &options.out, options.common.json),
        Job::Each { tool, recordings, .. } => each::merged(&tool, &recordings, &options.out, options.common.json),
    }
}

/// Copies what a shard has kept into `out`. What an earlier shard brought already stays.
fn gather(folder: &Path, mark: &Mark, all: &[(&Path, Mark)], out: &Path) -> Result<()> {
    for (path, hash) in &mark.files {
        let brought = all
            .iter()
            .take_while(|(_, other)| other.shard != mark.shard)
            .find_map(|(from, other)| other.files.get(path).map(|known| (*from, known)));
        if let Some((from, known)) = brought {
            let ending = Path::new(path).extension().and_then(|e| e.to_str()).unwrap_or_default();
            if known != hash && LEARNED.contains(&ending) {
                let message = format!("expected the same as in {}, found something else", names::file_name(from));
                let hint = "run all shards on one kind of processor: only there the same seed gives the same bytes";
                return Err(Error::file(folder.join(path), message, hint).into());
            }
            continue;
        }
        let to = out.join(path);
        if let Some(within) = to.parent() {
            std::fs::create_dir_all(within).map_err(|source| Error::io(within, Action::Creating, source))?;
        }
        let bytes = folder.join(path);
        let mut from = std::fs::File::open(&bytes).map_err(|source| Error::io(&bytes, Action::Reading, source))?;
        tunenet_formats::write_atomically(&to, |file| std::io::copy(&mut from, file).map(|_| ()))?;
    }
    Ok(())
}
