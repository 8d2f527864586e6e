//! `tunenet bench grow`: what more pairs cost in seconds, memory and bytes, and what a cluster would need for many more.
//!
//! ```text
//! gen, gen --shard …, merge, train (processes of this program, weighed from outside) → results → write
//! ```

mod results;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use tunenet_core::Origin;
use tunenet_formats::{Action, Error};

use self::results::{Cluster, GrowResults, SizeCost, Spent};
use super::process;
use crate::args::BenchGrow;
use crate::output::{file_of, write_all};
use tunenet_cli::exit_status::Exit;
use tunenet_cli::files::hash;
use tunenet_cli::shard;
use tunenet_cli::view::answer;
use tunenet_cli::view::json::print_json;
use tunenet_cli::view::text::{progress, stage};

/// What pairs are drawn from: drops of the paper, whose files are small.
const PRESET: &str = "easy";
/// Shares that each set is cut into besides.
const SHARDS: u32 = 4;

pub fn run(options: &BenchGrow) -> Result<Exit> {
    if let Some(shard) = options.sharing.shard {
        let expected = "none: `bench grow` times one machine, and has nothing to cut".into();
        return Err(tunenet_core::Error::Setting {
            origin: Origin::Flag,
            name: "--shard",
            expected,
            found: format!("`{shard}`"),
        }
        .into());
    }
    std::fs::create_dir_all(&options.out).with_context(|| format!("creating {}", options.out.display()))?;
    let mut sizes = options.pairs.clone();
    sizes.sort_unstable();
    sizes.dedup();
    let bar = progress(sizes.len() as u64 * (3 + u64::from(SHARDS)), "grow");
    let mut rows = Vec::with_capacity(sizes.len());
    for pairs in sizes {
        rows.push(measured(options, pairs, &mut || bar.inc(1))?);
    }
    bar.finish_and_clear();
    let cluster = match (options.want, rows.last()) {
        (Some(want), Some(row)) => {
            Some(Cluster::extrapolated(want, options.nodes, options.cores, options.threads, row))
        }
        _ => None,
    };
    let results = GrowResults {
        schema: "tunenet.bench.grow/1",
        command: command(options),
        version: env!("CARGO_PKG_VERSION"),
        preset: PRESET,
        seed: options.common.seed,
        threads: options.threads,
        shards: SHARDS,
        rows,
        cluster,
        warnings: [],
    };
    let text = results.markdown();
    let object = serde_json::to_value(&results)?;
    write_all(&options.out, [("grow.md", text.clone()), ("grow.json", file_of(&object))])?;
    answer::text(options.common.json, &text)?;
    stage("wrote", &options.out.join("grow.md").display().to_string());
    if options.common.json {
        print_json(&object)?;
    }
    Ok(Exit::Done)
}

/// The command that measures this again.
fn command(options: &BenchGrow) -> String {
    let pairs: Vec<String> = options.pairs.iter().map(u64::to_string).collect();
    let want = options
        .want
        .map_or_else(String::new, |want| format!(" --want {want} --nodes {} --cores {}", options.nodes, options.cores));
    let (threads, seed) = (options.threads, options.common.seed);
    format!("tunenet bench grow --pairs {} --threads {threads} --seed {seed}{want}", pairs.join(" "))
}

/// One size: a whole set, the same from shards, and a network that learns from it. The files go away again.
fn measured(options: &BenchGrow, pairs: u64, step: &mut dyn FnMut()) -> Result<SizeCost> {
    let place = |name: &str| options.out.join(format!("{name}-{pairs}.mcap"));
    let (whole, merged, model) = (place("whole"), place("merged"), options.out.join("model.safetensors"));
    let parts: Vec<PathBuf> = (0..SHARDS)
        .map(|index| Ok(shard::file(&merged, tunenet_core::network::Shard::new(index, SHARDS)?)))
        .collect::<Result<_>>()?;
    let files = || [&whole, &merged, &model].into_iter().chain(&parts);
    // Files of an interrupted run would be resumed, so the cost would be too small.
    files().try_for_each(|file| clear(file))?;
    let (number, seed) = (pairs.to_string(), options.common.seed.to_string());
    let spent = |arguments: &[&str]| -> Result<Spent> { Ok(process::run_on(options.threads, arguments)?.into()) };
    let gen_to = ["gen", "ball", "--preset", PRESET, "--pairs", &number, "--seed", &seed, "--out"];
    let generate = spent(&[&gen_to[..], &[text(&whole)?]].concat())?;
    step();
    for index in 0..SHARDS {
        spent(&[&gen_to[..], &[text(&merged)?, "--shard", &format!("{index}/{SHARDS}")]].concat())?;
        step();
    }
    let shards: Vec<&str> = parts.iter().map(|part| text(part)).collect::<Result<_>>()?;
    let merge = spent(&[&["merge"][..], &shards, &["--out", text(&merged)?]].concat())?;
    step();
    ensure!(hash::sha256(&whole)? == hash::sha256(&merged)?, "{SHARDS} merged shards are not the whole file");
    // What is known to be equal need not lie there three times while the training takes room too.
    parts.iter().chain([&merged]).try_for_each(|file| clear(file))?;
    let bytes = std::fs::metadata(&whole).with_context(|| format!("reading {}", whole.display()))?.len();
    // Its number of steps is the same for any number of pairs: what grows is the reading.
    let train = spent(&["train", "--data", text(&whole)?, "--preset", "default", "--out", text(&model)?])?;
    step();
    files().try_for_each(|file| clear(file))?;
    Ok(SizeCost { pairs, bytes, generate, merge, train })
}

fn text(path: &Path) -> Result<&str> {
    path.to_str().context("the folder's name is not Unicode")
}

/// Removes a file and what an interrupted run left of it.
fn clear(path: &Path) -> Result<()> {
    for ending in ["", ".partial", ".partial.copy", ".checkpoint"] {
        let mut name = path.as_os_str().to_owned();
        name.push(ending);
        match std::fs::remove_file(&name) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                return Err(Error::io(PathBuf::from(name), Action::Removing, error).into());
            }
            _ => {}
        }
    }
    Ok(())
}
