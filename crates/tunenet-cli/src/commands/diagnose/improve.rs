//! The improved simulation file: tuned parameters, the named effects, and on what evidence they stand there.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::Result;
use toml_edit::{Array, DocumentMut, InlineTable, Value as Toml};
use tunenet_core::diagnose::{Change, Diagnosis, Fitted, Gap, GapOf, NamedEffect, Value, Verdict};
use tunenet_core::simulator::Simulator;
use tunenet_core::{Error, Origin};
use tunenet_formats::read_text;
use tunenet_formats::write_atomically;
use tunenet_sim::SimulationFile;
use tunenet_sim::arm::urdf::with_friction;
use tunenet_sim::observed_arm::urdf_path;
use tunenet_sim::replayed_arm::{ReplayedArm, replays};
use tunenet_sim::simulation_file::Domain;

use super::json::gap_of;
use super::manifest::Source;
use crate::answers::diagnose::{Answer, Edited, Object};
use crate::args::Diagnose;
use crate::files::destination::{self, Output, Product};
use crate::files::names;

const UNFITTED: &str = "nothing could be fitted";

/// What was written, and why nothing was where nothing was.
pub enum Written {
    NotAsked,
    Files(Vec<PathBuf>),
    Not(&'static str),
}

/// Refuses outputs that cannot be written, or would replace what is read, before anything is spent on them. For several
/// objects `--out` is a folder, which is made.
pub fn writable(options: &Diagnose, sources: &[Source]) -> Result<()> {
    let several = several(sources.iter().map(|s| s.object.as_str()));
    let mut outputs: Vec<Output> = Vec::new();
    match &options.out {
        Some(out) if several => outputs.extend(of_objects(options, out, sources)?),
        Some(out) => outputs.push(Output::new(out, "--out", Product::Simulation)),
        None => {}
    }
    outputs.extend(options.out_urdf.iter().map(|out| Output::new(out, "--out-urdf", Product::Unmarked)));
    outputs.extend(options.report.iter().map(|report| Output::new(report, "--report", Product::Page)));
    let inputs = sources.iter().map(|s| s.path.as_path()).chain([options.simulation.sim.as_path()]);
    let references = sources.iter().filter_map(|s| s.reference.as_deref());
    let urdf = options.simulation.urdf_set();
    let inputs: Vec<&Path> =
        inputs.chain(options.manifest.as_deref()).chain(references).chain(urdf.as_deref()).collect();
    destination::check(&outputs, &inputs, options.writing.overwrite)?;
    if let (Some(out), true) = (&options.out, several) {
        // The page may not be the folder itself either.
        if options.report.as_deref() == Some(out) {
            let (expected, found) = ("another file than `--out`".into(), names::file_name(out));
            return Err(Error::Setting { origin: Origin::Flag, name: "--report", expected, found }.into());
        }
        std::fs::create_dir_all(out).map_err(|e| Error::io(out, "creating", e))?;
    }
    Ok(())
}

/// A file for each object in the folder `out`.
fn of_objects(options: &Diagnose, out: &Path, sources: &[Source]) -> Result<Vec<Output>> {
    if out.is_file() {
        let message = "expected a folder, since every object gets a file of its own, found a file";
        return Err(Error::file(out, message, "name a folder with --out").into());
    }
    let objects: BTreeSet<&str> = sources.iter().map(|s| s.object.as_str()).collect();
    let one = |object: &str| {
        let plain = object.chars().all(|c| c.is_alphanumeric() || "-_. ".contains(c));
        if !plain || object.starts_with('.') {
            let message = format!("`{object}` makes no file name for --out");
            let path = options.manifest.clone().unwrap_or_default();
            return Err(Error::file(path, message, "use letters, digits, -, _ and spaces in `object`").into());
        }
        let path = out.join(format!("{object}.toml"));
        Ok(Output { makes_folder: true, ..Output::new(&path, "--out", Product::Simulation) })
    };
    objects.into_iter().map(one).collect()
}

fn several<'a>(mut objects: impl Iterator<Item = &'a str>) -> bool {
    let first = objects.next();
    objects.any(|object| Some(object) != first)
}

/// Writes the files that were asked for, one for each object that has an answer.
pub fn write(options: &Diagnose, answer: &Answer) -> Result<Written> {
    let Some(out) = &options.out else { return Ok(Written::NotAsked) };
    let diagnosis = answer.diagnosis;
    let gap = match (&diagnosis.gap, why_not(diagnosis)) {
        (_, Some(why)) => return Ok(Written::Not(why)),
        (None, None) => return Ok(Written::Not(UNFITTED)),
        (Some(gap), None) => gap,
    };
    let mut written = Vec::new();
    for (number, object) in answer.loaded.objects.iter().enumerate() {
        let mut file = improved(answer, number)?;
        let entries = provenance(options, answer, gap, number, &file)?;
        file.set_provenance(&entries);
        let path =
            if answer.loaded.objects.len() == 1 { out.clone() } else { out.join(format!("{}.toml", object.name)) };
        file.move_program(&path);
        put(&path, &file)?;
        written.push(path);
    }
    Ok(Written::Files(written))
}

/// Why there is no improved file.
fn why_not(diagnosis: &Diagnosis) -> Option<&'static str> {
    match diagnosis.verdict {
        Verdict::Unknown => Some("no known effect explains the recordings"),
        Verdict::Insufficient => Some("the recordings do not suffice for an answer"),
        Verdict::None | Verdict::Named | Verdict::OneOf => diagnosis.gap.is_none().then_some(UNFITTED),
    }
}

/// The file of an object with the tuned parameters and the named effects.
fn improved(answer: &Answer, number: usize) -> Result<SimulationFile> {
    let diagnosis = answer.diagnosis;
    let mut file = answer.loaded.objects[number].file.clone();
    if file.domain() == Domain::Arm {
        return improved_arm(answer, number, file);
    }
    for tuned in diagnosis.parameters.iter().filter(|p| p.object == number) {
        // A coefficient of an effect that the file has already bears both names.
        match tuned.name.split_once('.') {
            Some((effect, key)) => file.add_effect(effect, &[(key, tuned.value)])?,
            None => file.set_value(&tuned.name, tuned.value),
        }
    }
    for effect in &diagnosis.effects {
        let values: Vec<(&str, f64)> =
            effect.coefficients.iter().filter_map(|c| Some((c.key, of(c, number)?.value))).collect();
        file.add_effect(effect.effect.name, &values)?;
    }
    Ok(file)
}

/// The same of an arm, whose effects have numbers for each joint.
fn improved_arm(answer: &Answer, number: usize, mut file: SimulationFile) -> Result<SimulationFile> {
    let joints = answer.loaded.objects[number].simulator.channels().len();
    for tuned in answer.diagnosis.parameters.iter().filter(|p| p.object == number) {
        file.set_arm_value(&tuned.name, tuned.value, joints)?;
    }
    for effect in &answer.diagnosis.effects {
        let values: Vec<f64> = effect.coefficients.iter().filter_map(|c| Some(of(c, number)?.value)).collect();
        file.add_arm_effect(effect.effect.name, &values)?;
    }
    Ok(file)
}

/// Writes the URDF of the first object with the friction that was found in it; the path, where there was some.
pub fn write_urdf(options: &Diagnose, answer: &Answer) -> Result<Option<PathBuf>> {
    let Some(out) = &options.out_urdf else { return Ok(None) };
    let file = &answer.loaded.objects[0].file;
    if !replays(file) {
        let (expected, found) = ("an arm with `motion.kind = \"replay\"`".into(), "another simulation".into());
        return Err(Error::Setting { origin: Origin::Flag, name: "--out-urdf", expected, found }.into());
    }
    let found = answer.diagnosis.effects.iter().any(|e| e.effect.name.ends_with("_friction"));
    if why_not(answer.diagnosis).is_some() || !found {
        return Ok(None);
    }
    let arm = ReplayedArm::from_file(&improved(answer, 0)?)?;
    let values: Vec<f64> = arm.parameters().iter().map(|p| p.value).collect();
    let text = with_friction(&read_text(urdf_path(file)?)?, &arm.friction(&values))?;
    write_atomically(out, |out| out.write_all(text.as_bytes()))?;
    Ok(Some(out.clone()))
}

/// What the answer changes in the simulation file of every object, or why it changes nothing.
pub fn edits(options: &Diagnose, answer: &Answer) -> Result<std::result::Result<Vec<Edited>, &'static str>> {
    if let Some(why) = why_not(answer.diagnosis) {
        return Ok(Err(why));
    }
    let given = without_provenance(&SimulationFile::read(&options.simulation.sim)?.text())?;
    let one = |(number, object): (usize, &Object)| {
        let improved = without_provenance(&improved(answer, number)?.text())?;
        Ok(Edited { object: object.name.clone(), given: given.clone(), improved })
    };
    answer.loaded.objects.iter().enumerate().map(one).collect::<Result<_>>().map(Ok)
}

fn without_provenance(text: &str) -> Result<String> {
    let mut document: DocumentMut = text.parse()?;
    document.remove("provenance");
    Ok(document.to_string())
}

fn put(path: &Path, file: &SimulationFile) -> Result<()> {
    Ok(write_atomically(path, |out| out.write_all(file.text().as_bytes()))?)
}

/// The value of an object, or the one that all share.
fn of(fitted: &Fitted, object: usize) -> Option<&Value> {
    fitted.values.iter().find(|v| v.object.is_none_or(|o| o == object))
}

fn provenance(
    options: &Diagnose,
    answer: &Answer,
    gap: &Gap,
    object: usize,
    file: &SimulationFile,
) -> Result<Vec<(&'static str, Toml)>> {
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
        if let Some(reference) = &recorded.reference {
            one.insert("reference", reference.clone().into());
        }
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
        // Of what cannot be told apart only one is written, never all together.
        entries.push(("chosen", answer.chosen().into_iter().collect::<Array>().into()));
        // Numbers of flights alone are not those that a fit to whole recordings finds, where these are not explained.
        if gap.of == GapOf::Recordings {
            entries.push(("alternatives", super::alternatives::alternatives(answer, object).into()));
        }
    }
    if matches!(diagnosis.verdict, Verdict::None | Verdict::Named) {
        let open = super::alternatives::open(answer, object, file)?;
        entries.extend((!open.is_empty()).then(|| ("open_drag", open.into())));
    }
    entries.extend([
        ("gap_of", Toml::from(gap_of(gap))),
        ("gap_unit", gap.unit.as_str().into()),
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
        let same = named.coefficients.iter().filter(|other| other.key == fitted.key);
        let ranges: Vec<Array> = same
            .filter_map(|c| of(c, object))
            .map(|value| Array::from_iter([value.interval95.0, value.interval95.1]))
            .collect();
        let key = format!("{}_interval95", fitted.key);
        match <[Array; 1]>::try_from(ranges) {
            Ok([alone]) if !super::json::is_per_joint(named) => one.insert(key, alone.into()),
            Ok([alone]) => one.insert(key, [alone].into_iter().collect::<Array>().into()),
            Err(ranges) => one.insert(key, ranges.into_iter().collect::<Array>().into()),
        };
    }
    one
}
