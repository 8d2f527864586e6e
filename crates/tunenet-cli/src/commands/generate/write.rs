//! Writing a data set, or one shard of it.

use std::path::PathBuf;

use anyhow::Result;
use serde_json::json;
use tunenet_core::network::DatasetHeader;
use tunenet_core::observation::Note;
use tunenet_formats::Error;
use tunenet_formats::dataset::DatasetReader;

use crate::args::Gen;
use crate::exit_status::Exit;
use crate::files::names;
use crate::shard::{self, Share};
use crate::view;
use crate::view::answer::Printout;
use crate::view::json::warning;
use crate::view::text::{progress, stage};

/// Makes the pairs with `make`, where they are not there already, and says so, with what was noticed.
pub fn made(
    options: &Gen,
    (header, notes): (&DatasetHeader, &[Note]),
    make: impl FnOnce(&mut dyn FnMut(u64, u64) -> bool) -> tunenet_formats::Result<()>,
) -> Result<Exit> {
    if !there(options, header)? {
        let bar = progress(options.pairs, "rollouts");
        make(&mut |done, all| {
            bar.set_length(all);
            bar.set_position(done);
            true
        })?;
        bar.finish_and_clear();
    }
    render(options, header, notes)
}

/// Where the pairs are written: under `--out`, or where a shard of it belongs.
pub fn place(options: &Gen) -> PathBuf {
    options.sharing.shard.map_or_else(|| options.out.clone(), |shard| shard::file(&options.out, shard))
}

/// Whether the shard is complete already, as of a task that is submitted again. One that is not is made again, with a note.
///
/// # Errors
/// Where it is a shard of something else, which somebody may still want.
fn there(options: &Gen, header: &DatasetHeader) -> Result<bool> {
    let (Some(shard), out) = (options.sharing.shard, place(options)) else { return Ok(false) };
    if !out.exists() {
        return Ok(false);
    }
    let whole = DatasetReader::holds(&out, header, shard);
    if let Ok(other) = DatasetReader::open_shard(&out)
        && other.header() != header
        && !options.writing.overwrite
    {
        let described = |h: &DatasetHeader| format!("{} pairs of preset {}, seed {}", h.pairs, h.preset, h.seed);
        let message = format!("expected a shard of {}, found one of {}", described(header), described(other.header()));
        let hint = "give the command that made it, choose another --out, or replace it with --overwrite";
        return Err(Error::file(&out, message, hint).into());
    }
    let (what, why) =
        if whole { ("kept", "is complete already") } else { ("again", "was not this shard, or not whole") };
    stage(what, &format!("{} {why}", out.display()));
    Ok(whole)
}

fn render(options: &Gen, header: &DatasetHeader, notes: &[Note]) -> Result<Exit> {
    if let Some(shard) = options.sharing.shard {
        let block = shard.block(header.pairs);
        let what = format!("of {} pairs, preset {}, seed {}", header.pairs, header.preset, header.seed);
        let share = Share { pieces: block.end - block.start, all: header.pairs };
        view::shard::show(shard, &place(options), share, &what, options.common.json)?;
        return Ok(Exit::Done);
    }
    stage(
        "wrote",
        &format!("{}, {} pairs, preset {}, seed {}", options.out.display(), options.pairs, header.preset, header.seed),
    );
    let mut shown = Printout::default();
    shown.warn_all(notes);
    shown.show(options.common.json, || {
        let frames = (!header.clocks_in_pairs()).then_some(header.clock.len());
        json!({
            "schema": "tunenet.gen/1", "file": names::file_name(&options.out), "preset": header.preset,
            "pairs": options.pairs, "seed": header.seed, "frames": frames,
            "warnings": notes.iter().map(warning).collect::<Vec<_>>(),
        })
    })?;
    Ok(Exit::Done)
}
