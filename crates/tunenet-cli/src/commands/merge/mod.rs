//! `tunenet merge`: combines shards to what one run would have written.

mod folders;
mod foreign;

use std::path::{Path, PathBuf};

use anyhow::Result;
use serde_json::json;
use tunenet_core::network::Shard;
use tunenet_formats::Error;
use tunenet_formats::dataset::merge;

use super::globs;
use crate::args::Merge;
use crate::exit_status::Exit;
use crate::files::destination::{self, Output, Product};
use crate::files::names;
use crate::view::answer::Printout;
use crate::view::text::{progress, stage};

pub fn run(options: &Merge) -> Result<Exit> {
    let shards = globs::expanded(&options.shards, "SHARD")?;
    let (folders, files): (Vec<PathBuf>, Vec<PathBuf>) = shards.iter().cloned().partition(|path| path.is_dir());
    if let (Some(folder), Some(file)) = (folders.first(), files.first()) {
        let message =
            format!("expected shards of one kind, found a folder here and the file {}", names::file_name(file));
        return Err(Error::file(folder, message, "merge data sets and folders each on their own").into());
    }
    if folders.is_empty() { dataset(options, &files) } else { folders::run(options, &folders) }
}

/// Shards of a data set.
fn dataset(options: &Merge, shards: &[PathBuf]) -> Result<Exit> {
    names::require_ending(&options.out, "--out", &["mcap"])?;
    let inputs: Vec<&Path> = shards.iter().map(AsRef::as_ref).collect();
    let output = Output::new(&options.out, "--out", Product::Dataset);
    destination::check(&[output], &inputs, options.writing.overwrite)?;
    let bar = progress(0, "pairs");
    let header = merge(shards, &options.out, &mut |done, all| {
        bar.set_length(all);
        bar.set_position(done);
        true
    })?;
    bar.finish_and_clear();
    stage("merged", &format!("{} shards", shards.len()));
    stage(
        "wrote",
        &format!("{}, {} pairs, preset {}, seed {}", options.out.display(), header.pairs, header.preset, header.seed),
    );
    Printout::default().show(options.common.json, || {
        json!({
            "schema": "tunenet.merge/1", "file": names::file_name(&options.out), "shards": shards.len(),
            "preset": header.preset, "pairs": header.pairs, "seed": header.seed, "warnings": [],
        })
    })?;
    Ok(Exit::Done)
}

/// Every shard once, and none missing: `what` of each path is its shard.
fn complete(shards: &[(&Path, Shard)]) -> Result<()> {
    for (number, (path, shard)) in shards.iter().enumerate() {
        if let Some((other, _)) = shards[..number].iter().find(|(_, known)| known == shard) {
            let message = format!("expected every shard once, found {shard} here and in {}", names::file_name(other));
            return Err(Error::file(*path, message, "leave one of them out").into());
        }
    }
    let Some((first, shard)) = shards.first() else { return Ok(()) };
    let lacking: Vec<String> = (0..shard.count())
        .filter(|index| shards.iter().all(|(_, known)| known.index() != *index))
        .map(|index| format!("{index}/{}", shard.count()))
        .collect();
    if lacking.is_empty() {
        Ok(())
    } else {
        Err(tunenet_formats::dataset::missing(first, shard.count(), &lacking).into())
    }
}
