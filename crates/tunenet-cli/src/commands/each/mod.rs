//! Many recordings one by one: which are whose, on how many threads, each answer in a file of its own, and what is there
//! already is not done again.

mod names;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::{Context, Result};
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use tunenet_core::network::Shard;
use tunenet_core::{Error, Origin};
use tunenet_formats::write_atomically;

use crate::args::{Apart, pool};
use crate::failure::{Exit, sentence};
use crate::files::destination::{self, Output, Product};
use crate::files::hash;
use crate::shard::{self, Job, Mark, Share, mark};
use crate::view::answer;
use crate::view::json::{print_json, warning};
use crate::view::text::{note, stage, warn};

/// All answers together, beside those to each recording.
pub const ALL: &str = "each.json";
/// The key of an answer's file that says what it was made by; the answer itself is everything else.
const RUN: &str = "run";

/// What is done with every recording.
pub struct Work<'a> {
    /// `tune` or `diagnose`.
    pub tool: &'static str,
    /// All recordings, of every shard.
    pub observation: &'a [PathBuf],
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
    /// For people, in one line.
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
            let (expected, found) =
                ("--out-dir beside it, where the answers of a shard are kept".into(), "none".into());
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
            let inputs: Vec<&Path> = self.observation.iter().map(AsRef::as_ref).collect();
            destination::check(&files.map(answer).collect::<Vec<_>>(), &inputs, self.overwrite)?;
        }
        let treat = |i: usize| self.treat(&self.observation[i], &shown[i], place(i).as_deref(), one);
        let treated = self.spread(&mine, &treat)?;
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

    /// All of `mine`, at most so many at a time as there are threads; told in their order.
    fn spread<T: Send>(&self, mine: &[usize], treat: &(dyn Fn(usize) -> Result<(T, String)> + Sync)) -> Result<Vec<T>> {
        let pool = pool(self.jobs)?;
        // Without `--jobs` one after the other, each on all threads: then memory does not grow with the cores.
        let workers = self.jobs.unwrap_or(1).min(mine.len()).max(1);
        let next = AtomicUsize::new(0);
        let done = Mutex::new(InOrder { results: BTreeMap::new(), count: 0, json: self.json, printed: Ok(()) });
        let work = || loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            let Some(i) = mine.get(number) else { return };
            let result = pool.install(|| treat(*i));
            if let Ok(mut done) = done.lock() {
                done.add(number, result);
            }
        };
        std::thread::scope(|scope| {
            (1..workers).for_each(|_| drop(scope.spawn(work)));
            work();
        });
        let done = done.into_inner().map_err(|_| anyhow::anyhow!("a recording's thread broke down"))?;
        done.printed?;
        done.results.into_values().map(|result| result.map(|(value, _)| value)).collect()
    }

    /// One recording's answer and its line: from its file where it is there, otherwise made, and written there.
    fn treat<C>(
        &self,
        path: &Path,
        name: &str,
        place: Option<&Path>,
        one: &dyn Fn(&Path, &str) -> Result<Answered<C>>,
    ) -> Result<((Value, Option<C>), String)> {
        // What cannot be read has no digest, and is refused by whoever reads it.
        let run = place.and_then(|_| hash::sha256(path).ok()).map(|hash| {
            let all = json!([env!("CARGO_PKG_VERSION"), self.tool, self.run, name, hash]);
            hex::encode(Sha256::digest(all.to_string()))
        });
        if let (Some(place), Some(run)) = (place, &run)
            && let Some(kept) = kept(place, run)
        {
            return Ok(((kept, None), format!("{name}: kept")));
        }
        let (object, line, case) = match one(path, name) {
            Ok(Answered { mut object, line, case }) => {
                object["file"] = Value::String(name.to_owned());
                (object, format!("{name}: {line}"), case)
            }
            Err(error) => {
                let text = sentence(&error);
                // Most errors begin with the path already.
                let place = if text.contains(name) { String::new() } else { format!("{name}: ") };
                let schema = format!("tunenet.{}/1", self.tool);
                (json!({ "schema": schema, "file": name, "error": text }), format!("{place}{text}"), None)
            }
        };
        if let Some(place) = place {
            let mut whole = object.clone();
            whole[RUN] = json!(run);
            write(place, &whole)?;
        }
        Ok(((object, case), line))
    }
}

/// Results as they come, their lines printed in order.
struct InOrder<T> {
    results: BTreeMap<usize, Result<(T, String)>>,
    count: usize,
    /// Whether standard output is for the one object.
    json: bool,
    printed: tunenet_core::Result<()>,
}

impl<T> InOrder<T> {
    fn add(&mut self, number: usize, result: Result<(T, String)>) {
        self.results.insert(number, result);
        while let Some(result) = self.results.get(&self.count) {
            if let Ok((_, line)) = result {
                if self.json {
                    note(line);
                } else if self.printed.is_ok() {
                    self.printed = answer::line(line);
                }
            }
            self.count += 1;
        }
    }
}

/// The answer that lies at `path`, where it was made by this very run and is no error.
fn kept(path: &Path, run: &str) -> Option<Value> {
    let text = std::fs::read_to_string(path).ok()?;
    let value: Value = serde_json::from_str(&text).ok()?;
    if value[RUN] != run || value.get("error").is_some() {
        return None;
    }
    Some(without_run(value))
}

fn without_run(mut value: Value) -> Value {
    if let Some(object) = value.as_object_mut() {
        object.shift_remove(RUN);
    }
    value
}

fn write(path: &Path, value: &Value) -> Result<()> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(|source| Error::io(folder, "creating", source))?;
    }
    let text = format!("{value:#}\n");
    Ok(write_atomically(path, |file| file.write_all(text.as_bytes()))?)
}

/// The one object of all answers, and how the command ends with them.
fn together(tool: &str, objects: Vec<Value>, shard: Option<Shard>) -> (Exit, Value) {
    let refused = objects.iter().filter(|object| object.get("error").is_some()).count();
    let certain = |object: &Value| matches!(object["verdict"].as_str(), Some("tuned" | "none" | "named"));
    let exit = if refused > 0 {
        Exit::Refused
    } else if objects.iter().all(certain) {
        Exit::Done
    } else {
        Exit::Inconclusive
    };
    stage("done", &format!("{} observations, {refused} refused", objects.len()));
    let mut all = json!({ "schema": format!("tunenet.{tool}.each/1") });
    if let Some(shard) = shard {
        all["shard"] = json!(shard.to_string());
    }
    all["observations"] = Value::Array(objects);
    (exit, all)
}

/// What one run would have answered, from the answers that shards have brought to `folder`.
pub fn merged(tool: &str, recordings: &[String], folder: &Path, as_json: bool) -> Result<Exit> {
    let mut objects = Vec::with_capacity(recordings.len());
    for name in recordings {
        let path = folder.join(name);
        let text = std::fs::read_to_string(&path).map_err(|source| Error::io(&path, "reading", source))?;
        let value = serde_json::from_str(&text).with_context(|| format!("{} is no answer", path.display()))?;
        objects.push(without_run(value));
    }
    let (exit, all) = together(tool, objects, None);
    write(&folder.join(ALL), &all)?;
    if as_json {
        print_json(&all)?;
    } else {
        answer::line(&format!("wrote    {}", folder.display()))?;
    }
    Ok(exit)
}
