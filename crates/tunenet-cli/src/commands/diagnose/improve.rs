//! The improved simulation file: tuned parameters, the named effects, and on what evidence they stand there.

use std::path::{Path, PathBuf};

use anyhow::Result;
use toml_edit::{Array, InlineTable, Value as Toml};
use tunenet_core::Error;
use tunenet_core::diagnose::{Change, Fitted, Gap, NamedEffect, Value, Verdict};
use tunenet_core::observation::recording::write_atomically;
use tunenet_sim::SimulationFile;

use super::answer::Answer;
use super::manifest::Source;
use crate::cli::Diagnose;
use crate::commands::load;

/// What was written, and why nothing was where nothing was.
pub enum Written {
    NotAsked,
    Files(Vec<PathBuf>),
    Not(&'static str),
}

/// Refuses an output that cannot be written before anything is spent on it. For several objects it is a folder.
pub fn writable(options: &Diagnose, sources: &[Source]) -> Result<()> {
    let Some(out) = &options.out else { return Ok(()) };
    if !several(sources.iter().map(|s| s.object.as_str())) {
        let inputs = sources.iter().map(|s| s.path.as_path()).chain([options.simulation.sim.as_path()]);
        let inputs: Vec<&Path> = inputs.chain(options.manifest.as_deref()).collect();
        return load::writable(out, &inputs);
    }
    if out.is_file() {
        let message = "expected a folder, since every object gets a file of its own, found a file";
        return Err(Error::file(out, message, "name a folder with --out").into());
    }
    for source in sources {
        let plain = source.object.chars().all(|c| c.is_alphanumeric() || "-_. ".contains(c));
        if !plain || source.object.starts_with('.') {
            let message = format!("`{}` makes no file name for --out", source.object);
            let path = options.manifest.clone().unwrap_or_default();
            return Err(Error::file(path, message, "use letters, digits, -, _ and spaces in `object`").into());
        }
    }
    std::fs::create_dir_all(out).map_err(|e| Error::io(out, "creating", e))?;
    Ok(())
}

fn several<'a>(mut objects: impl Iterator<Item = &'a str>) -> bool {
    let first = objects.next();
    objects.any(|object| Some(object) != first)
}

/// Writes the files that were asked for, one for each object that has an answer.
pub fn write(options: &Diagnose, answer: &Answer) -> Result<Written> {
    let Some(out) = &options.out else { return Ok(Written::NotAsked) };
    let diagnosis = answer.diagnosis;
    let Some(gap) = &diagnosis.gap else { return Ok(Written::Not("nothing could be fitted")) };
    match diagnosis.verdict {
        Verdict::None | Verdict::Named | Verdict::OneOf => {}
        Verdict::Unknown => return Ok(Written::Not("no known effect explains the recordings")),
        Verdict::Insufficient => return Ok(Written::Not("the recordings do not suffice for an answer")),
    }
    let mut written = Vec::new();
    for (number, object) in answer.loaded.objects.iter().enumerate() {
        let mut file = object.file.clone();
        for tuned in diagnosis.parameters.iter().filter(|p| p.object == number) {
            // What is not a parameter of the file is a coefficient, written below.
            if !tuned.name.contains('.') {
                file.set_value(&tuned.name, tuned.value);
            }
        }
        for effect in &diagnosis.effects {
            let values: Vec<(&str, f64)> =
                effect.coefficients.iter().filter_map(|c| Some((c.key, of(c, number)?.value))).collect();
            file.add_effect(effect.effect.name, &values)?;
        }
        file.set_provenance(&provenance(options, answer, gap, number)?);
        let path =
            if answer.loaded.objects.len() == 1 { out.clone() } else { out.join(format!("{}.toml", object.name)) };
        put(&path, &file)?;
        written.push(path);
    }
    Ok(Written::Files(written))
}

fn put(path: &Path, file: &SimulationFile) -> Result<()> {
    Ok(write_atomically(path, |out| out.write_all(file.text().as_bytes()))?)
}

/// The value of an object, or the one that all share.
fn of(fitted: &Fitted, object: usize) -> Option<&Value> {
    fitted.values.iter().find(|v| v.object.is_none_or(|o| o == object))
}

fn provenance(options: &Diagnose, answer: &Answer, gap: &Gap, object: usize) -> Result<Vec<(&'static str, Toml)>> {
    let diagnosis = answer.diagnosis;
    let verdict = serde_json::to_value(diagnosis.verdict)?;
    let mut observations = Array::new();
    for recorded in answer.loaded.recorded.iter().filter(|r| r.object == object) {
        let mut one = InlineTable::new();
        one.insert("file", recorded.name.as_str().into());
        one.insert("sha256", recorded.hash.as_str().into());
        let held_out =
            diagnosis.uses.iter().find(|u| u.name == recorded.name).map_or(recorded.held_out, |u| u.held_out);
        one.insert("held_out", held_out.into());
        observations.push(one);
    }
    let intervals: InlineTable = diagnosis
        .parameters
        .iter()
        .filter(|p| p.object == object)
        .map(|p| (p.name.replace('.', "_"), Array::from_iter([p.interval95.0, p.interval95.1])))
        .collect();
    let effects: Array = diagnosis.effects.iter().map(|e| evidence(e, object)).collect();
    let mut entries: Vec<(&str, Toml)> = vec![
        ("tool", concat!("tunenet ", env!("CARGO_PKG_VERSION")).into()),
        ("command", "diagnose".into()),
        ("seed", i64::try_from(options.common.seed).unwrap_or(i64::MAX).into()),
        ("verdict", verdict.as_str().unwrap_or_default().into()),
        ("observations", observations.into()),
        ("interval95", intervals.into()),
        ("effects", effects.into()),
    ];
    if diagnosis.verdict == Verdict::OneOf {
        entries.push(("candidates", answer.candidates().iter().copied().collect::<Array>().into()));
    }
    entries.extend([
        ("gap_unit", Toml::from(gap.unit.as_str())),
        ("gap_before", gap.before.into()),
        ("gap_after", gap.after.into()),
        ("gap_noise_floor", gap.noise_floor.into()),
    ]);
    let pairs = [
        (["held_out_before", "held_out_after"], &gap.held_out),
        (["forecast_before", "forecast_after"], &gap.forecast),
    ];
    for ([before, after], change) in pairs {
        if let Some(Change { before: old, after: new }) = change {
            entries.extend([(before, Toml::from(*old)), (after, Toml::from(*new))]);
        }
    }
    Ok(entries)
}

/// What an effect stands there for.
fn evidence(named: &NamedEffect, object: usize) -> InlineTable {
    let mut one = InlineTable::new();
    one.insert("name", named.effect.name.into());
    one.insert("bic_gain", named.evidence.bic_gain.into());
    if let Some(other) = named.evidence.runner_up {
        one.insert("runner_up", other.into());
        one.insert("runner_up_bic_gap", named.evidence.runner_up_bic_gap.into());
    }
    for fitted in &named.coefficients {
        if let Some(value) = of(fitted, object) {
            let (low, high) = value.interval95;
            one.insert(format!("{}_interval95", fitted.key), Array::from_iter([low, high]).into());
        }
    }
    one
}
