//! `tunenet track`.

use std::path::Path;

use anyhow::Result;
use serde::Serialize;
use serde_json::{Value, json};
use tunenet_core::observation::Note;
use tunenet_core::observation::State;
use tunenet_formats::write_atomically;
use tunenet_video_protocol::VideoFinding;
use tunenet_video_protocol::track::{Estimate, Facts, Samples, Untracked};

use super::video::{Asked, Unseen};
use crate::args::Track;
use crate::failure::{Exit, sentence};
use crate::files::destination::{self, Output, Product};
use crate::files::names;
use crate::view::answer::Printout;
use crate::view::html;
use crate::view::text::stage;

const SCHEMA: &str = "tunenet.track/1";
/// Pictures in a report.
const SHEET: usize = 12;

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
        names::require_ending(out, &["csv"])?;
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
        Err(error) => match error.downcast_ref::<Unseen>() {
            Some(unseen @ Unseen { untracked: Some(untracked), .. }) => return no(options, untracked, unseen),
            _ => return Err(error),
        },
    };
    let notes: Vec<Note> = found.facts.warnings.iter().map(VideoFinding::note).collect();
    let bounces_s = &found.facts.bounces_s;
    // A list without a bounce is no recording.
    let written = options.out.as_deref().filter(|_| !options.bounces || !bounces_s.is_empty());
    match written {
        Some(out) if options.bounces => write_bounces(out, bounces_s)?,
        Some(out) => write(out, &found.samples, options.pixels)?,
        None => {}
    }
    if let Some(path) = &options.report {
        html::track::write(path, &names::file_name(&options.video), &found, &notes)?;
    }
    let object = json(options, "tracked", &found.facts)?;
    printout(options, &found.facts, &notes).show(options.common.json, || object)?;
    for out in [written, options.report.as_deref(), options.overlay.as_deref()].into_iter().flatten() {
        stage("wrote", &names::file_name(out));
    }
    let Some(kept) = options.out.as_deref().filter(|_| written.is_none()) else { return Ok(Exit::Done) };
    stage("kept", &format!("{} is not written: no bounce is seen", kept.display()));
    Ok(Exit::Inconclusive)
}

/// The answer for scripts: what was found, behind what it was found in.
fn json(options: &Track, verdict: &str, facts: &impl Serialize) -> Result<Value> {
    let mut object = json!({ "schema": SCHEMA, "file": names::file_name(&options.video), "verdict": verdict });
    if let (Value::Object(object), Value::Object(facts)) = (&mut object, serde_json::to_value(facts)?) {
        object.extend(facts);
    }
    Ok(object)
}

fn no(options: &Track, untracked: &Untracked, error: &Unseen) -> Result<Exit> {
    let mut shown = Printout::default();
    let word = untracked.reason.word().replace('_', " ").to_uppercase();
    shown.verdict(&format!("{word}  {}", sentence(&anyhow::anyhow!("{error}"))));
    shown.line(&format!("  try: {}", error.note.remedy));
    let facts = json!({ "frames": untracked.frames, "seen": 0, "warnings": [untracked.finding] });
    let object = json(options, untracked.reason.word(), &facts)?;
    shown.show(options.common.json, || object)?;
    if let Some(path) = &options.report {
        html::track::unseen(path, &names::file_name(&options.video), untracked)?;
        stage("wrote", &names::file_name(path));
    }
    Ok(Exit::Inconclusive)
}

/// Writes the samples in metres, or in pixels where nothing says how large one is, or where that is wanted.
fn write(out: &Path, samples: &Samples, pixels: bool) -> Result<()> {
    let (names, places) = match samples.metres.as_ref().filter(|_| !pixels) {
        Some(metres) => (["x_m", "z_m"], [&metres.x_m, &metres.z_m]),
        None => (["u_px", "v_px"], [&samples.u_px, &samples.v_px]),
    };
    let columns = [&samples.t_s, places[0], places[1], &samples.radius_px, &samples.confidence];
    write_atomically(out, |file| {
        writeln!(file, "t_s,{},{},radius_px,confidence", names[0], names[1])?;
        for i in 0..samples.t_s.len() {
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

/// Nanometres and nanoseconds are beyond any video.
fn rounded(value: f64) -> f64 {
    (value * 1e9).round() / 1e9
}

/// The answer for readers.
fn printout(options: &Track, facts: &Facts, notes: &[Note]) -> Printout {
    let mut shown = Printout::default();
    let Facts { width_px, height_px, frames, fps, seen, whole, radius_px, .. } = facts;
    let name = names::file_name(&options.video);
    shown.row("film", &format!("{name}, {width_px} × {height_px} px, {frames} frames, {fps:.2} a second"));
    shown.row("ball", &format!("seen in {seen} frames, whole in {whole}, radius {radius_px:.1} px"));
    match &facts.scale {
        None => shown.row("scale", "none: the ball does not fly freely, and no length is given"),
        Some(scale) => shown.row("scale", &format!("{:.4} mm a pixel, by {}", 1e3 * scale.m_per_px, scale.words)),
    }
    let bounces: Vec<String> = facts.bounces_s.iter().map(|t| format!("{t:.3}")).collect();
    if !bounces.is_empty() {
        shown.row("bounces", &format!("{} s", bounces.join(", ")));
    }
    if let Some(Estimate { value, interval95: [low, high] }) = facts.restitution {
        shown.row("rebound", &format!("{value:.3} of the speed (95 %: {low:.3}–{high:.3}), before any simulation"));
    }
    for check in facts.preflight.iter().filter(|check| check.state == State::Failed) {
        shown.row("unusable", &check.text);
    }
    shown.warn_all(notes);
    shown
}
