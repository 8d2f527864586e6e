//! `tunenet inspect`.

mod joints;
mod motion;
mod settings;
mod video;

use std::path::Path;

use anyhow::Result;
use serde_json::{Value, json};
use tunenet_ball::preflight::{ApparentGravity, Expected};
use tunenet_core::Error;
use tunenet_core::network::{DatasetHeader, Model, Shard};
use tunenet_core::observation::{Channel, Kind};
use tunenet_formats::dataset::DatasetReader;
use tunenet_formats::{Contents, Log, ReadOptions, Recording, Table, contents_with};
use tunenet_formats::{kind_name, load_model};
use tunenet_sim::simulation_file::Domain;
use tunenet_sim::{SimulationFile, process};

use super::load;
use super::video::is_video;
use crate::args::Inspect;
use crate::failure::{Exit, sentence};
use crate::files::{hash, names};
use crate::view::answer::Printout;
use motion::Motion;

pub fn run(options: &Inspect) -> Result<Exit> {
    if let [path] = options.files.as_slice() {
        let mut shown = Printout::default();
        let found = look(path, options, &mut shown)?;
        shown.show(options.common.json, || found.object)?;
        return Ok(if found.usable { Exit::Done } else { Exit::Inconclusive });
    }
    hash::refuse_copies(options.files.iter().map(AsRef::as_ref))?;
    several(options)
}

/// What was found in one file.
struct Found {
    object: Value,
    usable: bool,
    motion: Option<Motion>,
}

fn look(path: &Path, options: &Inspect, shown: &mut Printout) -> Result<Found> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_lowercase();
    let plain = |object: Value, usable: bool| Found { object, usable, motion: None };
    let mut found = match extension.as_str() {
        "toml" => plain(settings::look(path, shown)?, true),
        "safetensors" => plain(model(&load_model(path)?, shown), true),
        _ if is_video(path) => {
            let (object, usable) = video::look(path, options.reading.camera_rate, shown)?;
            plain(object, usable)
        }
        _ => match contents_with(path, &reading(options)?)? {
            Contents::Table(found) => series(&found, path, options, shown),
            // What `gen` writes is a log too, though none of measurements.
            Contents::Log(found) => match DatasetReader::open(path).or_else(|_| DatasetReader::open_shard(path)) {
                Ok(reader) => {
                    let (header, shard) = (reader.header().clone(), reader.shard());
                    // Whether it is whole shows only at its end.
                    let broken = reader.into_iter().find_map(Result::err);
                    plain(dataset(&header, shard, broken.as_ref(), shown), broken.is_none() && shard.is_none())
                }
                Err(_) => log(&found, path, options, shown),
            },
        },
    };
    found.object["schema"] = json!("tunenet.inspect/1");
    found.object["file"] = json!(names::file_name(path));
    found.object["usable"] = json!(found.usable);
    Ok(found)
}

/// How files are read; where a program simulates, by its channels.
fn reading(options: &Inspect) -> Result<ReadOptions> {
    let mut reading = load::reading(&options.reading);
    if let Some(sim) = &options.sim {
        let file = SimulationFile::read(sim)?;
        load::of_kind(&file, Domain::Process)?;
        reading.channels = process::channels(&file)?;
    }
    Ok(reading)
}

/// The recording in a file, as `tune` looks at it.
fn recording(path: &Path, options: &Inspect) -> Result<Recording> {
    match &options.sim {
        Some(sim) => load::of_channels(&SimulationFile::read(sim)?, path, &options.reading, load::MOST_SAMPLES),
        None => load::recording(path, &options.reading),
    }
}

/// Several files: each on its own, then what all of them say of gravity.
fn several(options: &Inspect) -> Result<Exit> {
    let (mut objects, mut gravities, mut worst, mut rate_hz) = (Vec::new(), Vec::new(), Exit::Done, 0.0);
    let head = ["file", "bounces", "gravity", "noticed"];
    let mut rows: Vec<Vec<String>> = vec![head.map(String::from).to_vec()];
    let mut shown = Printout::default();
    for path in &options.files {
        let name = names::file_name(path);
        shown.row("file", &name);
        match look(path, options, &mut shown) {
            Ok(found) => {
                if !found.usable && worst == Exit::Done {
                    worst = Exit::Inconclusive;
                }
                if let Some(motion) = &found.motion {
                    gravities.extend(motion.gravity());
                    rate_hz = motion.rate_hz();
                    rows.push([vec![name], motion.row()].concat());
                }
                objects.push(found.object);
            }
            Err(error) => {
                worst = Exit::Refused;
                let text = sentence(&error);
                shown.row("refused", &text);
                objects.push(json!({ "schema": "tunenet.inspect/1", "file": name, "usable": false, "error": text }));
            }
        }
        shown.line("");
    }
    shown.table(&rows);
    let pooled = ApparentGravity::pooled(&gravities);
    let mut causes = Vec::new();
    if let Some(gravity) = &pooled {
        let expected = Expected::default().gravity_m_s2;
        motion::render_gravity(
            gravity,
            &match gravities.len() {
                1 => " from 1 recording".into(),
                several => format!(" from {several} recordings together"),
            },
            &mut shown,
        );
        if gravity.differs(expected) {
            causes = gravity.causes(expected, rate_hz);
            for cause in &causes {
                shown.row("perhaps", cause);
            }
        }
    }
    shown.show(options.common.json, || {
        json!({
            "schema": "tunenet.inspect.files/1", "files": objects, "gravity": pooled.as_ref().map(motion::gravity_json),
            "causes": causes, "warnings": [],
        })
    })?;
    Ok(worst)
}

/// What an observation of this kind can be used for.
fn purpose(kind: Kind) -> &'static str {
    match kind {
        Kind::Positions => "tune a ball's restitution and friction",
        Kind::EventTimes => "tune a ball's restitution",
        Kind::Pixels => "tune a ball's restitution, the camera found from the fall",
        Kind::Joints => "tune an arm's payload",
        _ => "tune a simulator of your own",
    }
}

fn series(found: &Table, path: &Path, options: &Inspect, shown: &mut Printout) -> Found {
    // With `--columns` the file is what the mapping makes of it.
    let mapped = !options.reading.columns.is_empty();
    let readable = if mapped { Ok(()) } else { found.usable.clone().map(|_| ()) };
    let read = readable.and_then(|()| recording(path, options).map_err(|e| sentence(&e)));
    let usable = read.as_ref().map(|r| r.observation.kind()).map_err(Clone::clone);
    // What reading it as a recording says goes further than what the table alone shows.
    let notes = read.as_ref().map_or_else(|_| found.notes.clone(), |r| r.notes.clone());
    let read = read.ok();
    let motion = read.as_ref().and_then(|r| Motion::of(&r.observation));
    // A table whose columns say nothing has rows and no samples: what to type comes first.
    let samples = if found.samples == 0 { String::new() } else { format!(", {} samples", found.samples) };
    shown.row("table", &format!("{} rows{samples}", found.rows));
    let columns: Vec<Vec<String>> =
        found.columns.iter().map(|c| vec![c.name.clone(), c.read_as.clone().unwrap_or_else(|| "-".into())]).collect();
    shown.table(&columns);
    if let (Some((first, last)), Some(rate)) = (found.span_s, found.median_rate_hz) {
        let gap = found.largest_gap_s.unwrap_or(0.0);
        let [first, last] = [first, last].map(|t| (t * 1e6).round() / 1e6);
        shown.row("clock", &format!("{first} s to {last} s, {rate:.1} Hz, largest gap {gap:.4} s"));
    }
    for line in &found.broken {
        shown.row("broken", &format!("line {}: {}", line.line, line.message));
    }
    if found.broken_count > found.broken.len() {
        shown.row("broken", &format!("{} more lines", found.broken_count - found.broken.len()));
    }
    if let Some((first, last)) = whole_lines(found) {
        let header = if first > 1 && has_header(found) { "1p;" } else { "" };
        shown.row("whole", &format!("lines {first} to {last}: `sed -n '{header}{first},{last}p'` cuts them out"));
        shown.line("  try: where single cells are bad, empty them; a line with an empty cell is left out");
    }
    shown.warn_all(&notes);
    let units = read.as_ref().and_then(|r| joints::units(&r.observation, shown));
    let usable = judged(usable, motion.as_ref(), shown);
    let remedy = remedy(found, options);
    if usable.is_err() && !remedy.is_empty() {
        shown.line(&format!("  try: {}", remedy.strip_prefix("try ").unwrap_or(&remedy)));
    }
    let mut object = json!({
        "kind": usable.as_ref().map(|k| k.name()).ok(),
        "reason": usable.as_ref().err(),
        "remedy": usable.as_ref().err().map(|_| &remedy),
        "for": usable.as_ref().ok().map(|k| motion.as_ref().and_then(Motion::purpose).unwrap_or_else(|| purpose(*k))),
        "rows": found.rows, "samples": found.samples,
        "columns": found.columns.iter().map(|c| json!({ "name": c.name, "read_as": c.read_as })).collect::<Vec<_>>(),
        "span_s": found.span_s.map(|(a, b)| [a, b]), "median_rate_hz": found.median_rate_hz, "largest_gap_s": found.largest_gap_s,
        "broken_lines": found.broken.iter().map(|b| json!({ "line": b.line, "message": b.message })).collect::<Vec<_>>(),
        "broken_count": found.broken_count,
        "warnings": notes.iter().map(crate::view::json::warning).collect::<Vec<_>>(),
    });
    if let Some(motion) = &motion {
        motion.add_to(&mut object);
    }
    if let Some(units) = &units {
        joints::add_to(units, &mut object);
    }
    Found { object, usable: usable.is_ok(), motion }
}

/// What to type; where columns could be the channels of a program, that as well.
fn remedy(found: &Table, options: &Inspect) -> String {
    let timed = found.columns.iter().any(|c| c.read_as.as_deref() == Some("t_s"));
    let named = found.columns.iter().filter(|c| c.read_as.is_none() && Channel::from_header(&c.name).is_some());
    let channels: Vec<String> = named.map(|c| format!("`{}`", c.name)).collect();
    if options.sim.is_some() || !timed || channels.is_empty() {
        return found.remedy.clone();
    }
    let program =
        format!("where a program of yours simulates {}, give its simulation file with `--sim`", channels.join(", "));
    if found.remedy.is_empty() { program } else { format!("{}; {program}", found.remedy) }
}

/// Tells what its motion shows, and the verdict.
fn judged(usable: Result<Kind, String>, motion: Option<&Motion>, shown: &mut Printout) -> Result<Kind, String> {
    if let Some(motion) = motion {
        motion.render(shown);
    }
    let usable = usable.and_then(|kind| match motion.and_then(Motion::rejected) {
        Some(reason) => Err(reason.to_owned()),
        None => Ok(kind),
    });
    match &usable {
        Ok(kind) => {
            let good = motion.and_then(Motion::purpose).unwrap_or_else(|| purpose(*kind));
            shown.row("usable", &format!("{}: {good}", kind_name(*kind)));
        }
        Err(reason) => shown.row("unusable", reason),
    }
    usable
}

fn topics(count: usize) -> String {
    if count == 1 { "1 topic".into() } else { format!("{count} topics") }
}

fn has_header(found: &Table) -> bool {
    found.columns.iter().any(|c| !c.name.is_empty())
}

/// The longest stretch of lines without a broken one, where some are broken and all are listed.
fn whole_lines(found: &Table) -> Option<(usize, usize)> {
    if found.broken.is_empty() || found.broken_count > found.broken.len() {
        return None;
    }
    let header = usize::from(has_header(found));
    let ends = found.broken.iter().map(|b| b.line).chain([header + found.rows + 1]);
    let mut start = header + 1;
    let mut best = None;
    for end in ends {
        if end > start && best.is_none_or(|(first, last)| end - start > last + 1 - first) {
            best = Some((start, end - 1));
        }
        start = end + 1;
    }
    best
}

fn log(found: &Log, path: &Path, options: &Inspect, shown: &mut Printout) -> Found {
    shown.row(
        "log",
        &format!("{}, profile `{}`, written by `{}`", topics(found.topics.len()), found.profile, found.library),
    );
    let rows: Vec<Vec<String>> = found
        .topics
        .iter()
        .map(|t| {
            let usable =
                t.usable.as_ref().map_or_else(|reason| format!("- {reason}"), |kind| kind_name(*kind).to_string());
            vec![t.name.clone(), t.schema.clone(), t.encoding.clone(), t.messages.to_string(), usable]
        })
        .collect();
    shown.table(&rows);
    let usable: Vec<&_> = found.topics.iter().filter(|t| t.usable.is_ok()).collect();
    let chosen = usable.len() == 1 || options.reading.topic.is_some();
    let read = (chosen && found.ended.is_none()).then(|| recording(path, options).ok()).flatten();
    let notes = read.as_ref().map_or_else(Vec::new, |r| r.notes.clone());
    shown.warn_all(&notes);
    let units = read.as_ref().and_then(|r| joints::units(&r.observation, shown));
    let motion = read.and_then(|r| Motion::of(&r.observation));
    let rejected = motion.as_ref().and_then(Motion::rejected);
    if let Some(motion) = &motion {
        motion.render(shown);
    }
    match (usable.as_slice(), &found.ended) {
        (_, Some(reason)) => {
            let seconds = found.span_s.map_or_else(String::new, |s| format!(" and span {s:.2} s"));
            shown.row("unusable", &format!("{reason}{seconds}; the rest is missing, so `tune` refuses the file"));
            shown.line(&format!("  try: `mcap recover {} -o recovered.mcap`, which keeps them", path.display()));
        }
        ([], _) => shown.row("unusable", "no topic carries positions, joints or bounces"),
        _ if rejected.is_some() => shown.row("unusable", rejected.unwrap_or_default()),
        ([one], _) => shown.row("usable", &one.name),
        (several, _) => shown.row("usable", &format!("{} topics, choose one with --topic", several.len())),
    }
    let mut object = json!({
        "kind": "log", "profile": found.profile, "library": found.library,
        "topics": found.topics.iter().map(|t| json!({
            "name": t.name, "schema": t.schema, "encoding": t.encoding, "messages": t.messages,
            "usable": t.usable.as_ref().ok().map(|k| k.name()), "reason": t.usable.as_ref().err(),
        })).collect::<Vec<_>>(),
        "ended": found.ended,
        "warnings": notes.iter().map(crate::view::json::warning).collect::<Vec<_>>(),
    });
    let good = !usable.is_empty() && found.ended.is_none() && rejected.is_none();
    if let Some(motion) = &motion {
        motion.add_to(&mut object);
    }
    if let Some(units) = &units {
        joints::add_to(units, &mut object);
    }
    Found { object, usable: good, motion }
}

fn dataset(header: &DatasetHeader, shard: Option<Shard>, broken: Option<&Error>, shown: &mut Printout) -> Value {
    let of = shard.map_or_else(String::new, |shard| {
        let block = shard.block(header.pairs);
        format!("shard {shard}, {} of ", block.end - block.start)
    });
    shown.row("dataset", &format!("{of}{} pairs, preset {}, seed {}", header.pairs, header.preset, header.seed));
    let rows: Vec<Vec<String>> = header
        .parameters
        .iter()
        .map(|p| {
            let learned = if p.tuned { "learned" } else { "fixed" };
            vec![p.name.clone(), format!("{} to {}", p.min, p.max), p.unit.clone(), learned.into()]
        })
        .collect();
    shown.table(&rows);
    match (broken, shard) {
        (None, None) => shown.row("usable", "train a network"),
        (None, Some(_)) => shown.row("unusable", "a shard alone: `tunenet merge` puts shards together"),
        (Some(error), _) => shown.row("unusable", &error.to_string()),
    }
    json!({
        "kind": if shard.is_some() { "shard" } else { "dataset" }, "shard": shard.map(|shard| shard.to_string()),
        "reason": broken.map(ToString::to_string), "preset": header.preset, "pairs": header.pairs, "seed": header.seed,
        "frames": header.clock.len(),
        "parameters": header.parameters.iter().map(|p| json!({
            "name": p.name, "min": p.min, "max": p.max, "unit": p.unit, "tune": p.tuned,
        })).collect::<Vec<_>>(),
        "warnings": [],
    })
}

fn model(model: &Model, shown: &mut Printout) -> Value {
    let parameters = model.parameters();
    shown.row("model", &format!("preset `{}`, seed {}", model.preset().name, model.seed()));
    let rows: Vec<Vec<String>> =
        parameters.iter().map(|p| vec![p.name.clone(), format!("{} to {}", p.min, p.max), p.unit.clone()]).collect();
    shown.table(&rows);
    json!({
        "kind": "model", "preset": model.preset().name, "seed": model.seed(),
        "parameters": parameters.iter().map(|p| json!({
            "name": p.name, "min": p.min, "max": p.max, "unit": p.unit,
        })).collect::<Vec<_>>(),
        "warnings": [],
    })
}
