//! `tunenet track`.

use anyhow::Result;
use serde_json::json;
use tunenet_core::observation::Note;
use tunenet_video_protocol::VideoFinding;
use tunenet_video_protocol::track::Untracked;

use super::video::{Asked, TrackFailure};
use crate::args::Track;
use crate::exit_status::Exit;
use crate::failure::sentence;
use crate::files::destination::{self, Output, Product};
use crate::files::{names, track_csv};
use crate::view::answer::Printout;
use crate::view::html;
use crate::view::json::track::object as track_json;
use crate::view::text::stage;
use crate::view::text::track::printout;
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
    options.out.iter().try_for_each(|out| names::require_ending(out, "--out", &["csv"]))?;
    options
        .overlay
        .iter()
        .try_for_each(|out| names::require_ending(out, "--overlay", &["mp4", "avi", "mov", "mkv"]))?;
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
        Err(error) => match error.downcast_ref::<TrackFailure>() {
            Some(failure @ TrackFailure { untracked: Some(untracked), .. }) => return no(options, untracked, failure),
            _ => return Err(error),
        },
    };
    let notes: Vec<Note> = found.facts.warnings.iter().map(VideoFinding::note).collect();
    let bounces_s = &found.facts.bounces_s;
    // A list without a bounce is no recording.
    let written = options.out.as_deref().filter(|_| !options.bounces || !bounces_s.is_empty());
    match written {
        Some(out) if options.bounces => track_csv::write_bounces(out, bounces_s)?,
        Some(out) => track_csv::write(out, &found.samples, options.pixels)?,
        None => {}
    }
    if let Some(path) = &options.report {
        html::track::write(path, &names::file_name(&options.video), &found, &notes)?;
    }
    let name = names::file_name(&options.video);
    let object = track_json(&name, "tracked", &found.facts)?;
    printout(&name, &found.facts, &notes).show(options.common.json, || object)?;
    for out in [written, options.report.as_deref(), options.overlay.as_deref()].into_iter().flatten() {
        stage("wrote", &names::file_name(out));
    }
    let Some(kept) = options.out.as_deref().filter(|_| written.is_none()) else { return Ok(Exit::Done) };
    stage("kept", &format!("{} is not written: no bounce is seen", kept.display()));
    Ok(Exit::Inconclusive)
}

fn no(options: &Track, untracked: &Untracked, error: &TrackFailure) -> Result<Exit> {
    let mut shown = Printout::default();
    let word = untracked.reason.word().replace('_', " ").to_uppercase();
    shown.verdict(&format!("{word}  {}", sentence(&anyhow::anyhow!("{error}"))));
    shown.line(&format!("  try: {}", error.note.remedy));
    let name = names::file_name(&options.video);
    let facts = json!({ "frames": untracked.frames, "seen": 0, "warnings": [untracked.finding] });
    let object = track_json(&name, untracked.reason.word(), &facts)?;
    shown.show(options.common.json, || object)?;
    if let Some(path) = &options.report {
        html::track::refused(path, &names::file_name(&options.video), untracked)?;
        stage("wrote", &names::file_name(path));
    }
    Ok(Exit::Inconclusive)
}
