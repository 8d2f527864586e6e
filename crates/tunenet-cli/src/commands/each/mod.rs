//! Many recordings one by one: which are whose, on how many threads, each answer in a file of its own, and what is there
//! already is not done again.

mod kept;
mod names;
mod spread;
mod treat;
mod verdict;

use std::path::{Path, PathBuf};

use anyhow::Result;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use tunenet_core::{Error, Origin};

use crate::args::Apart;
use crate::exit_status::Exit;
use crate::files::destination::{self, Output, Product};
use crate::shard::{self, Job, Mark, Share, mark};
use crate::view::json::{print_json, warning};
use crate::view::text::{stage, warn};
pub use kept::{ALL, merged};
use kept::{together, write};
use spread::spread;

/// What is done with every recording.
pub struct Work<'a> {
    /// `tune` or `diagnose`.
    pub tool: &'static str,
    /// All recordings, of every shard.
    pub observation: &'a [PathBuf],
    /// The files of their own in which the inputs of each recording stand.
    pub inputs: Vec<Vec<PathBuf>>,
    pub apart: &'a Apart,
    pub jobs: Option<usize>,
    pub json: bool,
    /// Whether files that tunenet did not write may be replaced.
    pub overwrite: bool,
    /// Everything but the recordings that decides what comes out.
    pub run: Value,
}

/// The answer to one recording.
pub struct Answered<C> {
    /// As `--json` prints it, but for `file` and errors, which are added.
    pub object: Value,
    /// For users, in one line.
    pub line: String,
    /// What a report draws of it.
    pub case: Option<C>,
}

/// A recording with what came of it: an answer's case, or why there is none.
pub type Case<C> = (String, std::result::Result<C, String>);

impl Work<'_> {
    /// Treats each recording with `one`, which is given its path and what it is called for people. One that cannot be used does
    /// not keep the others from being treated.
    pub fn run<C: Send>(
        &self,
        one: &(dyn Fn(&Path, &str) -> Result<Answered<C>> + Sync),
    ) -> Result<(Exit, Vec<Case<C>>)> {
        let shard = self.apart.sharing.shard;
        if shard.is_some() && self.apart.out_dir.is_none() {
            let (expected, found) = ("--out-dir with it, the folder for the results of a shard".into(), "none".into());
            return Err(Error::Setting { origin: Origin::Flag, name: "--shard", expected, found }.into());
        }
        let folder = self.apart.out_dir.as_deref().map(|out| shard::folder(out, shard));
        if let (Some(folder), Some(_)) = (&folder, shard) {
            mark::clear_damage(folder)?.iter().for_each(|text| stage("again", text));
        }
        let shown = names::shown(self.observation);
        let names = if folder.is_some() { names::of(self.observation)? } else { Vec::new() };
        let mine: Vec<usize> =
            (0..self.observation.len()).filter(|i| shard.is_none_or(|shard| shard.takes(*i as u64))).collect();
        let place = |i: usize| folder.as_ref().map(|folder| folder.join(&names[i]));
        if let Some(folder) = &folder {
            let files = mine.iter().filter_map(|i| place(*i)).chain([folder.join(ALL)]);
            let answer =
                |path: PathBuf| Output { makes_folder: true, ..Output::new(&path, "--out-dir", Product::Answer) };
            let inputs: Vec<&Path> =
                self.observation.iter().chain(self.inputs.iter().flatten()).map(AsRef::as_ref).collect();
            destination::check(&files.map(answer).collect::<Vec<_>>(), &inputs, self.overwrite)?;
        }
        let treat = |i: usize| self.treat(i, &shown[i], place(i).as_deref(), one);
        let treated = spread(self.jobs, self.json, &mine, &treat)?;
        let (mut objects, mut cases) = (Vec::with_capacity(treated.len()), Vec::new());
        for (i, (object, case)) in mine.iter().zip(treated) {
            let name = shown[*i].clone();
            if let Some(text) = object["error"].as_str() {
                cases.push((name, Err(text.to_owned())));
            } else if let Some(case) = case {
                cases.push((name, Ok(case)));
            }
            objects.push(object);
        }
        let (exit, mut all) = together(self.tool, objects, shard);
        let share = Share { pieces: mine.len() as u64, all: self.observation.len() as u64 };
        if let Some(note) = shard.and_then(|shard| share.noted(shard)) {
            warn(&note);
            all["warnings"] = json!([warning(&note)]);
        }
        if self.json {
            print_json(&all)?;
        }
        if let Some(folder) = &folder {
            write(&folder.join(ALL), &all)?;
            if let Some(shard) = shard {
                let digest = hex::encode(Sha256::digest(self.run.to_string()));
                let job = Job::Each { tool: self.tool.into(), run: digest, recordings: names };
                Mark::write(folder, shard, job)?;
            }
            stage("wrote", &folder.display().to_string());
        }
        Ok((exit, cases))
    }
}
