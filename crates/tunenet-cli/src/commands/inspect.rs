//! `tunenet inspect`.

use anyhow::Result;
use serde_json::{Value, json};
use tunenet_core::Error;
use tunenet_core::network::{DatasetHeader, DatasetReader, Model};
use tunenet_core::observation::Kind;
use tunenet_core::observation::recording::{Contents, Log, Table, contents_with};
use tunenet_sim::SimulationFile;

use super::{load, print_json};
use crate::cli::Inspect;
use crate::failure::{Exit, sentence};
use crate::terminal::{stage, table, warn};

pub fn run(options: &Inspect) -> Result<Exit> {
    let path = &options.file;
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_lowercase();
    let (mut object, usable) = match extension.as_str() {
        "toml" => (simulation(&SimulationFile::read(path)?)?, true),
        "safetensors" => (model(&Model::load(path)?), true),
        _ => match contents_with(path, &load::reading(&options.reading))? {
            Contents::Table(found) => series(&found, options),
            // What `gen` writes is a log too, though none of measurements.
            Contents::Log(found) => match DatasetReader::open(path) {
                Ok(reader) => {
                    let header = reader.header().clone();
                    // Whether it is whole shows only at its end.
                    let broken = reader.into_iter().find_map(Result::err);
                    (dataset(&header, broken.as_ref()), broken.is_none())
                }
                Err(_) => log(&found),
            },
        },
    };
    object["schema"] = json!("tunenet.inspect/1");
    object["file"] = json!(load::name(path));
    object["usable"] = json!(usable);
    if options.common.json {
        print_json(&object);
    }
    Ok(if usable { Exit::Done } else { Exit::Inconclusive })
}

/// What an observation of this kind can be used for.
fn purpose(kind: Kind) -> &'static str {
    match kind {
        Kind::Positions => "tune a ball's restitution and friction",
        Kind::BounceTimes => "tune a ball's restitution",
        Kind::Pixels => "nothing yet: pixels need a camera",
        Kind::Joints => "nothing yet: joint series need an arm",
        _ => "a simulator of your own",
    }
}

fn series(found: &Table, options: &Inspect) -> (Value, bool) {
    // With `--columns` the file is what the mapping makes of it.
    let usable = if options.reading.columns.is_empty() {
        found.usable.clone()
    } else {
        load::recording(&options.file, &options.reading).map(|r| r.observation.kind()).map_err(|e| sentence(&e))
    };
    // A table whose columns say nothing has rows and no samples: what to type comes first.
    let samples = if found.samples == 0 { String::new() } else { format!(", {} samples", found.samples) };
    stage("table", &format!("{} rows{samples}", found.rows));
    let columns: Vec<Vec<String>> =
        found.columns.iter().map(|c| vec![c.name.clone(), c.read_as.clone().unwrap_or_else(|| "-".into())]).collect();
    anstream::eprintln!("{}", table(&columns));
    if let (Some((first, last)), Some(rate)) = (found.span_s, found.median_rate_hz) {
        let gap = found.largest_gap_s.unwrap_or(0.0);
        stage("clock", &format!("{first} s to {last} s, {rate:.1} Hz, largest gap {gap:.4} s"));
    }
    for line in &found.broken {
        stage("broken", &format!("line {}: {}", line.line, line.message));
    }
    if found.broken_count > found.broken.len() {
        stage("broken", &format!("{} more lines", found.broken_count - found.broken.len()));
    }
    found.notes.iter().for_each(warn);
    tell_usable(&usable);
    if usable.is_err() && !found.remedy.is_empty() {
        anstream::eprintln!("  try: {}", found.remedy.strip_prefix("try ").unwrap_or(&found.remedy));
    }
    let object = json!({
        "kind": usable.as_ref().map(|k| k.name()).ok(),
        "reason": usable.as_ref().err(),
        "remedy": usable.as_ref().err().map(|_| &found.remedy),
        "for": usable.as_ref().ok().map(|k| purpose(*k)),
        "rows": found.rows, "samples": found.samples,
        "columns": found.columns.iter().map(|c| json!({ "name": c.name, "read_as": c.read_as })).collect::<Vec<_>>(),
        "span_s": found.span_s.map(|(a, b)| [a, b]), "median_rate_hz": found.median_rate_hz, "largest_gap_s": found.largest_gap_s,
        "broken_lines": found.broken.iter().map(|b| json!({ "line": b.line, "message": b.message })).collect::<Vec<_>>(),
        "broken_count": found.broken_count,
        "warnings": found.notes.iter().map(super::tune::warning).collect::<Vec<_>>(),
    });
    (object, usable.is_ok())
}

fn tell_usable(usable: &Result<Kind, String>) {
    match usable {
        Ok(kind) => stage("usable", &format!("{}: {}", kind.name(), purpose(*kind))),
        Err(reason) => stage("unusable", reason),
    }
}

fn log(found: &Log) -> (Value, bool) {
    stage(
        "log",
        &format!("{} topics, profile `{}`, written by `{}`", found.topics.len(), found.profile, found.library),
    );
    let rows: Vec<Vec<String>> = found
        .topics
        .iter()
        .map(|t| {
            let usable = t.usable.as_ref().map_or_else(|reason| format!("- {reason}"), |kind| kind.name().to_string());
            vec![t.name.clone(), t.schema.clone(), t.encoding.clone(), t.messages.to_string(), usable]
        })
        .collect();
    anstream::eprintln!("{}", table(&rows));
    if let Some(reason) = &found.ended {
        stage("broken", reason);
    }
    let usable: Vec<&_> = found.topics.iter().filter(|t| t.usable.is_ok()).collect();
    match usable.as_slice() {
        [] => stage("unusable", "no topic carries positions, joints or bounces"),
        [one] => stage("usable", &one.name),
        several => stage("usable", &format!("{} topics, choose one with --topic", several.len())),
    }
    let object = json!({
        "kind": "log", "profile": found.profile, "library": found.library,
        "topics": found.topics.iter().map(|t| json!({
            "name": t.name, "schema": t.schema, "encoding": t.encoding, "messages": t.messages,
            "usable": t.usable.as_ref().ok().map(|k| k.name()), "reason": t.usable.as_ref().err(),
        })).collect::<Vec<_>>(),
        "ended": found.ended,
        "warnings": [],
    });
    (object, !usable.is_empty() && found.ended.is_none())
}

fn dataset(header: &DatasetHeader, broken: Option<&Error>) -> Value {
    stage("dataset", &format!("{} pairs, preset {}, seed {}", header.pairs, header.preset, header.seed));
    let rows: Vec<Vec<String>> = header
        .parameters
        .iter()
        .map(|p| {
            let learned = if p.tuned { "learned" } else { "fixed" };
            vec![p.name.clone(), format!("{} to {}", p.min, p.max), p.unit.clone(), learned.into()]
        })
        .collect();
    anstream::eprintln!("{}", table(&rows));
    match broken {
        None => stage("usable", "train a network"),
        Some(error) => stage("unusable", &error.to_string()),
    }
    json!({
        "kind": "dataset", "reason": broken.map(ToString::to_string), "preset": header.preset, "pairs": header.pairs, "seed": header.seed,
        "frames": header.clock.len(),
        "parameters": header.parameters.iter().map(|p| json!({
            "name": p.name, "min": p.min, "max": p.max, "unit": p.unit, "tune": p.tuned,
        })).collect::<Vec<_>>(),
        "warnings": [],
    })
}

fn simulation(file: &SimulationFile) -> Result<Value> {
    let parameters = file.parameters()?;
    let rows: Vec<Vec<String>> = parameters
        .iter()
        .map(|p| {
            let tuned = if p.tune { "tuned" } else { "fixed" };
            vec![p.name.clone(), p.value.to_string(), format!("{} to {}", p.min, p.max), p.unit.clone(), tuned.into()]
        })
        .collect();
    stage("ball", "a simulation file");
    anstream::eprintln!("{}", table(&rows));
    Ok(json!({
        "kind": "simulation",
        "parameters": parameters.iter().map(|p| json!({
            "name": p.name, "value": p.value, "min": p.min, "max": p.max, "unit": p.unit, "tune": p.tune,
        })).collect::<Vec<_>>(),
        "warnings": [],
    }))
}

fn model(model: &Model) -> Value {
    let parameters = model.parameters();
    stage("model", &format!("preset `{}`, seed {}", model.preset().name, model.seed()));
    let rows: Vec<Vec<String>> =
        parameters.iter().map(|p| vec![p.name.clone(), format!("{} to {}", p.min, p.max), p.unit.clone()]).collect();
    anstream::eprintln!("{}", table(&rows));
    json!({
        "kind": "model", "preset": model.preset().name, "seed": model.seed(),
        "parameters": parameters.iter().map(|p| json!({
            "name": p.name, "min": p.min, "max": p.max, "unit": p.unit,
        })).collect::<Vec<_>>(),
        "warnings": [],
    })
}
