//! `tunenet track`.

use std::path::Path;

use anyhow::Result;
use serde_json::{Value, json};
use tunenet_core::observation::Note;
use tunenet_core::observation::recording::write_atomically;

use super::destination::{self, Output, Product};
use super::film::{self, Asked, Unseen};
use super::{load, print_json};
use crate::cli::Track;
use crate::failure::{Exit, sentence};
use crate::report;
use crate::terminal::{stage, warn};

const SCHEMA: &str = "tunenet.track/1";
/// Pictures in a report.
const SHEET: usize = 12;
/// Found on the way, and of no use in the answer itself: what a CSV or a report holds.
const INNER: [&str; 3] = ["samples", "pictures", "reason"];

pub fn run(options: &Track) -> Result<Exit> {
    let outputs = [
        (&options.out, "--out", Product::Unmarked),
        (&options.report, "--report", Product::Page),
        (&options.overlay, "--overlay", Product::Unmarked),
    ];
    let outputs =
        outputs.into_iter().filter_map(|(path, flag, product)| Some(Output::new(path.as_ref()?, flag, product)));
    destination::check(&outputs.collect::<Vec<_>>(), &[&options.video], options.writing.overwrite)?;
    if let Some(out) = &options.out {
        load::ending(out, &["csv"])?;
    }
    let asked = Asked::default()
        .with("--color", options.color.as_ref())
        .with("--topic", options.topic.as_ref())
        .with("--camera-rate", options.camera_rate.map(|r| r.to_string()))
        .with("--rate", options.rate.map(|r| r.to_string()))
        .with("--frames", options.frames.map(|n| n.to_string()))
        .with("--radius", options.radius.map(|r| r.to_string()))
        .with("--overlay", options.overlay.as_ref())
        .with("--sheet", options.report.as_ref().map(|_| SHEET.to_string()))
        .length(options.length);
    let found = match asked.track(&options.video) {
        Ok(found) => found,
        Err(error) => match error.downcast::<Unseen>() {
            Ok(unseen) => return no(options, &unseen),
            Err(other) => return Err(other),
        },
    };
    let notes: Vec<Note> = found["warnings"].as_array().into_iter().flatten().map(film::note).collect();
    let bounces_s: Vec<f64> = found["bounces_s"].as_array().into_iter().flatten().filter_map(Value::as_f64).collect();
    // A list without a bounce is no recording.
    let written = options.out.as_deref().filter(|_| !options.bounces || !bounces_s.is_empty());
    match written {
        Some(out) if options.bounces => write_bounces(out, &bounces_s)?,
        Some(out) => write(out, &found, options.pixels)?,
        None => {}
    }
    if let Some(path) = &options.report {
        report::track::write(path, &load::name(&options.video), &found, &notes)?;
    }
    tell(options, &found, &notes);
    for out in [written, options.report.as_deref(), options.overlay.as_deref()].into_iter().flatten() {
        stage("wrote", &load::name(out));
    }
    if options.common.json {
        print_json(&object(options, &found))?;
    }
    let Some(kept) = options.out.as_deref().filter(|_| written.is_none()) else { return Ok(Exit::Done) };
    stage("kept", &format!("{} is not written: no bounce is seen", kept.display()));
    Ok(Exit::Inconclusive)
}

/// The answer for scripts.
fn object(options: &Track, found: &Value) -> Value {
    let mut object = json!({ "schema": SCHEMA, "file": load::name(&options.video) });
    for (key, value) in found.as_object().into_iter().flatten().filter(|(key, _)| !INNER.contains(&key.as_str())) {
        object[key] = value.clone();
    }
    object
}

fn no(options: &Track, unseen: &Unseen) -> Result<Exit> {
    let (bold, reset) = (anstyle::Style::new().bold(), anstyle::Reset);
    let word = unseen.object["verdict"].as_str().unwrap_or_default().replace('_', " ").to_uppercase();
    anstream::eprintln!("{bold}{word}  {}{reset}", sentence(&anyhow::anyhow!("{unseen}")));
    anstream::eprintln!("  try: {}", unseen.note.remedy);
    if options.common.json {
        print_json(&object(options, &unseen.object))?;
    }
    if let Some(path) = &options.report {
        report::track::unseen(path, &load::name(&options.video), &unseen.object, &unseen.note)?;
        stage("wrote", &load::name(path));
    }
    Ok(Exit::Inconclusive)
}

/// Writes the samples in metres, or in pixels where nothing says how large one is, or where that is wanted.
fn write(out: &Path, found: &Value, pixels: bool) -> Result<()> {
    let metres = !pixels && found["samples"].get("x_m").is_some();
    let place = if metres { ["x_m", "z_m"] } else { ["u_px", "v_px"] };
    let names = ["t_s", place[0], place[1], "radius_px", "confidence"];
    let columns: Vec<Vec<f64>> = names.iter().map(|name| film::column(found, name).unwrap_or_default()).collect();
    write_atomically(out, |file| {
        writeln!(file, "{}", names.join(","))?;
        for i in 0..columns[0].len() {
            let row: Vec<String> = columns.iter().map(|column| format!("{:?}", rounded(column[i]))).collect();
            writeln!(file, "{}", row.join(","))?;
        }
        Ok(())
    })?;
    Ok(())
}

fn write_bounces(out: &Path, bounces_s: &[f64]) -> Result<()> {
    write_atomically(out, |file| {
        writeln!(file, "bounce_time_s")?;
        bounces_s.iter().try_for_each(|time_s| writeln!(file, "{:?}", rounded(*time_s)))
    })?;
    Ok(())
}

/// Nanometres and nanoseconds are beyond any film.
fn rounded(value: f64) -> f64 {
    (value * 1e9).round() / 1e9
}

fn tell(options: &Track, found: &Value, notes: &[Note]) {
    let number = |key: &str| found[key].as_f64().unwrap_or(0.0);
    stage(
        "film",
        &format!(
            "{}, {} × {} px, {} frames, {:.2} a second",
            load::name(&options.video),
            number("width_px"),
            number("height_px"),
            number("frames"),
            number("fps")
        ),
    );
    stage(
        "ball",
        &format!(
            "seen in {} frames, whole in {}, radius {:.1} px",
            number("seen"),
            number("whole"),
            number("radius_px")
        ),
    );
    match &found["scale"] {
        Value::Null => stage("scale", "none: the ball does not fly freely, and no length is given"),
        scale => stage(
            "scale",
            &format!(
                "{:.4} mm a pixel, by {}",
                1e3 * scale["m_per_px"].as_f64().unwrap_or(0.0),
                scale["words"].as_str().unwrap_or_default()
            ),
        ),
    }
    let bounces: Vec<String> = found["bounces_s"]
        .as_array()
        .into_iter()
        .flatten()
        .filter_map(Value::as_f64)
        .map(|t| format!("{t:.3}"))
        .collect();
    if !bounces.is_empty() {
        stage("bounces", &format!("{} s", bounces.join(", ")));
    }
    if let Some(value) = found["restitution"]["value"].as_f64() {
        let bound = |i: usize| found["restitution"]["interval95"][i].as_f64().unwrap_or(value);
        stage(
            "rebound",
            &format!("{value:.3} of the speed (95 %: {:.3}–{:.3}), before any simulation", bound(0), bound(1)),
        );
    }
    for check in found["preflight"].as_array().into_iter().flatten() {
        if check["state"] == "failed" {
            stage("unusable", check["text"].as_str().unwrap_or_default());
        }
    }
    notes.iter().for_each(warn);
}
