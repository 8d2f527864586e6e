//! `tunenet-video track`: all that the parent needs of a film, as one JSON object.

use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::Result;
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};
use tunenet_core::Error;
use tunenet_core::observation::preflight::Expected;
use tunenet_core::observation::{Channel, Kind, Observation, bounces, resample};
use tunenet_track::colour::Window;
use tunenet_track::overlay::{Drawn, overlay, plain};
use tunenet_track::scale::{Known, Metric};
use tunenet_track::track::Settings;
use tunenet_track::{Answer, Source, Track, track};

/// Half a 95 % interval, in standard deviations.
const INTERVAL: f64 = 1.96;
/// Samples beyond this are no film's.
const MOST_RESAMPLED: f64 = 1e7;

#[derive(Debug, Args)]
pub struct Options {
    /// Film, or log (MCAP) with pictures
    file: PathBuf,
    /// Colour of the ball
    #[arg(long)]
    color: Option<String>,
    /// Topic of a log
    #[arg(long)]
    topic: Option<String>,
    /// The camera's true frames per second
    #[arg(long)]
    camera_rate: Option<f64>,
    /// Samples per second that are told
    #[arg(long)]
    rate: Option<f64>,
    /// Samples that are told with a rate, else most frames
    #[arg(long)]
    frames: Option<usize>,
    /// The ball's radius, m
    #[arg(long, conflicts_with = "length")]
    radius: Option<f64>,
    /// A length in the picture, m and px
    #[arg(long, num_args = 2)]
    length: Vec<f64>,
    /// Gravity, m/s²
    #[arg(long, default_value_t = 9.81)]
    gravity: f64,
    /// What the simulation says of the ball's radius, m
    #[arg(long)]
    expected_radius: Option<f64>,
    /// What the simulation says of the surface, m
    #[arg(long, allow_negative_numbers = true)]
    surface: Option<f64>,
    /// Pictures with the track drawn in, at most
    #[arg(long, default_value_t = 0)]
    sheet: usize,
    /// Write the film with the track drawn in here
    #[arg(long)]
    overlay: Option<PathBuf>,
}

/// What was found; an error of the file is an object as well, with `error`, so that the parent says it once.
pub fn run(options: &Options) -> Result<Value> {
    match found(options) {
        Ok(object) => Ok(object),
        Err(Error::File { message, hint, .. }) => Ok(json!({ "error": message, "hint": hint })),
        Err(Error::Setting { name, expected, found }) => {
            Ok(json!({ "setting": name, "expected": expected, "found": found }))
        }
        Err(other) => Err(other.into()),
    }
}

fn found(options: &Options) -> tunenet_core::Result<Value> {
    let source = Source::new(&options.file, options.topic.as_deref()).at_rate(options.camera_rate.or(options.rate));
    let colour = options.color.as_deref().map(Window::parse).transpose()?;
    let settings = Settings {
        colour,
        rate_hz: options.camera_rate,
        most_frames: options.frames.filter(|_| options.rate.is_none()),
    };
    let bar = progress();
    let answer = track(&source, &settings, &mut |done, promised| advance(&bar, "track", done, promised));
    let track = match answer? {
        Answer::Tracked(track) => track,
        Answer::Unseen { reason, frames, note } => {
            let pictures = if options.sheet > 0 { plain(&source, frames, options.sheet)? } else { Vec::new() };
            return Ok(json!({
                "verdict": reason.verdict(), "frames": frames, "seen": 0, "reason": note, "warnings": [note],
                "pictures": sheet(&pictures),
            }));
        }
    };
    let drawn = drawn(options, &source, &track, &bar)?;
    bar.finish_and_clear();
    told(options, &track, &drawn)
}

fn drawn(options: &Options, source: &Source, track: &Track, bar: &ProgressBar) -> tunenet_core::Result<Vec<Drawn>> {
    if options.sheet == 0 && options.overlay.is_none() {
        return Ok(Vec::new());
    }
    // A film that is half written is none: it gets its name when it is whole.
    let part = options.overlay.as_deref().map(part);
    let drawn = overlay(source, track, options.sheet, part.as_deref(), &mut |done, all| {
        advance(bar, "draw", done, all);
    });
    if let (Some(part), Some(whole)) = (&part, &options.overlay) {
        if drawn.is_ok() {
            std::fs::rename(part, whole).map_err(|e| Error::io(whole, "writing", e))?;
        } else {
            let _ = std::fs::remove_file(part);
        }
    }
    drawn.map_err(|e| match (e, &options.overlay) {
        (Error::File { path, message, hint }, Some(whole)) if part.as_ref() == Some(&path) => {
            Error::file(whole, message, hint)
        }
        (other, _) => other,
    })
}

/// A name beside `whole` with its ending, by which OpenCV knows the container.
fn part(whole: &Path) -> PathBuf {
    let name = whole.file_name().unwrap_or_default().to_string_lossy();
    whole.with_file_name(format!(".{}.{name}", std::process::id()))
}

fn told(options: &Options, track: &Track, drawn: &[Drawn]) -> tunenet_core::Result<Value> {
    let known = match (options.radius, options.length.as_slice()) {
        (Some(radius), _) => Known::Radius(radius),
        (None, [metres, pixels]) => Known::Length { metres: *metres, pixels: *pixels },
        _ => Known::Nothing,
    };
    let expected = Expected {
        gravity_m_s2: options.gravity,
        radius_m: options.radius.or(options.expected_radius),
        surface_height_m: options.surface,
        ..Expected::default()
    };
    let whole: Vec<_> = track.whole().collect();
    // Too few frames make no positions, which is said where positions are asked for.
    let metric = if whole.len() < 4 { None } else { Metric::of(track, known, &expected)? };
    let mut warnings = track.notes.clone();
    warnings.extend(metric.iter().flat_map(|m| m.notes.iter().cloned()));
    let has_arcs = metric.as_ref().is_some_and(|m| m.preflight.arcs.is_some());
    let column = |of: &dyn Fn(usize) -> f64| (0..whole.len()).map(of).collect::<Vec<f64>>();
    let mut samples = json!({
        "frame": whole.iter().map(|s| s.frame).collect::<Vec<_>>(),
        "t_s": column(&|i| whole[i].time_s),
        "u_px": column(&|i| whole[i].u_px),
        "v_px": column(&|i| whole[i].v_px),
        "radius_px": column(&|i| whole[i].radius_px),
        "confidence": column(&|i| whole[i].confidence),
    });
    let mut object = json!({
        "verdict": "tracked",
        "frames": track.frames,
        "seen": track.sightings.len(),
        "whole": whole.len(),
        "fps": track.rate_hz,
        "duplicates": track.repeated.len(),
        "dropped": track.dropped,
        "width_px": track.size_px.0,
        "height_px": track.size_px.1,
        "radius_px": track.radius_px(),
        "color": {
            "hue": track.colour.hue, "half_width": track.colour.half_width,
            "saturation": [track.colour.saturation.0, track.colour.saturation.1],
            "value": [track.colour.value.0, track.colour.value.1],
        },
        "scale": null,
        "bounces_s": [],
        "restitution": null,
        "preflight": [],
    });
    if let Some(metric) = &metric {
        let seen = &metric.observation;
        samples["x_m"] = json!(seen.column(0).collect::<Vec<f64>>());
        samples["z_m"] = json!(seen.column(2).collect::<Vec<f64>>());
        object["scale"] = json!({ "m_per_px": metric.metres_per_px, "by": metric.by, "words": metric.by.name() });
        // How much farther away a metre of height is, where the camera does not look from the side.
        object["scale"]["depth_1_m"] = json!(metric.camera.map_or(0.0, |camera| camera.depth(1.0) - 1.0));
        object["preflight"] = json!(metric.preflight.checks);
        if let Some(arcs) = &metric.preflight.arcs {
            object["bounces_s"] = json!(arcs.contacts.iter().map(|c| c.time_s).collect::<Vec<_>>());
            object["restitution"] = json!(arcs.restitution().map(|r| json!({
                "value": r.value, "interval95": [r.value - INTERVAL * r.sd, r.value + INTERVAL * r.sd],
            })));
        }
    }
    if !has_arcs {
        // Without a scale there are no flights in metres, but a kink of the track is a kink.
        let (clock, up) = (column(&|i| whole[i].time_s), column(&|i| -whole[i].v_px));
        object["bounces_s"] = json!(bounces(&clock, &up));
    }
    object["warnings"] = json!(warnings);
    if let Some(rate_hz) = options.rate {
        samples = resampled(&samples, released_s(metric.as_ref()), rate_hz, options.frames)?;
    }
    object["samples"] = samples;
    object["pictures"] = sheet(drawn);
    Ok(object)
}

fn sheet(drawn: &[Drawn]) -> Value {
    let one = |d: &Drawn| {
        json!({
            "frame": d.frame, "time_s": d.time_s, "width": d.size_px.0, "height": d.size_px.1,
            "jpeg": base64::encode(&d.jpeg),
        })
    };
    drawn.iter().map(one).collect()
}

/// When the ball is let go, s, where that is seen.
fn released_s(metric: Option<&Metric>) -> Option<f64> {
    let preflight = &metric?.preflight;
    let (kept, arcs) = (preflight.kept.as_ref()?, preflight.arcs.as_ref()?);
    kept.clock().get(arcs.usable.start).copied()
}

/// The samples on an even clock from `from_s` on, as far as they reach or `count` of them, the last one held.
fn resampled(samples: &Value, from_s: Option<f64>, rate_hz: f64, count: Option<usize>) -> tunenet_core::Result<Value> {
    let column =
        |name: &str| -> Vec<f64> { samples[name].as_array().into_iter().flatten().filter_map(Value::as_f64).collect() };
    let names: Vec<&str> =
        samples.as_object().into_iter().flatten().map(|(name, _)| name.as_str()).filter(|n| *n != "t_s").collect();
    let times = column("t_s");
    let columns: Vec<Vec<f64>> = names.iter().map(|name| column(name)).collect();
    let rows = (0..times.len()).flat_map(|i| columns.iter().map(move |c| c[i])).collect();
    let channels = names.iter().map(|name| Channel::new(*name, "1")).collect();
    let (first, last) = (times[0], times[times.len() - 1]);
    let from = from_s.unwrap_or(first);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a length of time, clamped")]
    let count = count.unwrap_or_else(|| ((last - from) * rate_hz + 1e-6).clamp(2.0, MOST_RESAMPLED) as usize + 1);
    let clock: Vec<f64> = (0..count).map(|k| from + k as f64 / rate_hz).collect();
    let even = resample(&Observation::new(Kind::Other, channels, times, rows)?, &clock)?;
    let mut out = json!({ "t_s": clock });
    for (i, name) in names.iter().enumerate() {
        out[*name] = even.column(i).collect::<Vec<f64>>().into();
    }
    Ok(out)
}

/// Invisible where standard error is no terminal.
fn progress() -> ProgressBar {
    let bar = ProgressBar::no_length();
    let style =
        ProgressStyle::with_template("{msg:<10} {wide_bar} {human_pos}/{human_len} frames, {per_sec}, {eta} left");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

fn advance(bar: &ProgressBar, what: &'static str, done: usize, promised: Option<usize>) {
    if bar.message() != what {
        bar.set_message(what);
    }
    if let Some(promised) = promised {
        bar.set_length(promised as u64);
    }
    bar.set_position(done as u64);
}
