//! `tunenet-video track`: all that the parent needs of a video.

use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::{Context, Result};
use base64::prelude::*;
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use tunenet_ball::preflight::Expected;
use tunenet_ball::{Arcs, bounces};
use tunenet_core::observation::{self, Channel, Kind, Observation, resample};
use tunenet_core::statistics::NORMAL_95;
use tunenet_formats::{Action, Error};
use tunenet_track::colour::Window;
use tunenet_track::overlay::{Drawn, overlay, plain};
use tunenet_track::scale::{Known, Metric};
use tunenet_track::track::Settings;
use tunenet_track::tracker::Sighting;
use tunenet_track::{Answer, Source, Track, track};
use tunenet_video_protocol::TrackAnswer;
use tunenet_video_protocol::track::{
    Check, Colour, Estimate, Facts, Flag, Metres, Picture, Samples, Scale, Tracked, Untracked,
};

/// Samples beyond this are no video's.
const MOST_RESAMPLED: f64 = 1e7;

#[derive(Debug, Args)]
pub struct Options {
    /// Video, or log (MCAP) with pictures
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
    /// Samples per second that are reported
    #[arg(long)]
    rate: Option<f64>,
    /// Samples that are reported with a rate, else most frames
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
    /// Write the video with the track drawn in here
    #[arg(long)]
    overlay: Option<PathBuf>,
}

/// What was found. What a person can mend is an answer as well, so that the parent says it once.
pub fn run(options: &Options) -> Result<TrackAnswer> {
    match found(options) {
        Err(Error::File { message, hint, .. }) => Ok(TrackAnswer::FileRefused { message, hint }),
        Err(Error::Core(tunenet_core::Error::Setting { name, expected, found, .. })) => {
            let flag = Flag::ALL.iter().copied().find(|flag| flag.word() == name);
            let flag = flag.with_context(|| format!("{name}: expected {expected}, found {found}"))?;
            Ok(TrackAnswer::FlagRefused { flag, expected, found })
        }
        other => Ok(other?),
    }
}

fn found(options: &Options) -> tunenet_formats::Result<TrackAnswer> {
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
        Answer::Untracked { reason, frames, finding } => {
            let pictures = if options.sheet > 0 { plain(&source, frames, options.sheet)? } else { Vec::new() };
            return Ok(TrackAnswer::Untracked(Untracked { reason, finding, frames, pictures: sheet(&pictures) }));
        }
    };
    let drawn = drawn(options, &source, &track, &bar)?;
    bar.finish_and_clear();
    Ok(TrackAnswer::Tracked(Box::new(answer_of(options, &track, &drawn)?)))
}

fn drawn(options: &Options, source: &Source, track: &Track, bar: &ProgressBar) -> tunenet_formats::Result<Vec<Drawn>> {
    if options.sheet == 0 && options.overlay.is_none() {
        return Ok(Vec::new());
    }
    // A video that is half written is none: it gets its name when it is whole.
    let part = options.overlay.as_deref().map(part);
    let drawn = overlay(source, track, options.sheet, part.as_deref(), &mut |done, all| {
        advance(bar, "draw", done, all);
    });
    if let (Some(part), Some(whole)) = (&part, &options.overlay) {
        if drawn.is_ok() {
            std::fs::rename(part, whole).map_err(|e| Error::io(whole, Action::Writing, e))?;
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

/// A name in the folder of `whole` with its ending, by which OpenCV knows the container.
fn part(whole: &Path) -> PathBuf {
    let name = whole.file_name().unwrap_or_default().to_string_lossy();
    whole.with_file_name(format!(".{}.{name}", std::process::id()))
}

fn answer_of(options: &Options, track: &Track, drawn: &[Drawn]) -> tunenet_core::Result<Tracked> {
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
    let column = |of: &dyn Fn(&Sighting) -> f64| whole.iter().map(|s| of(s)).collect::<Vec<f64>>();
    let mut samples = Samples {
        t_s: column(&|s| s.time_s),
        u_px: column(&|s| s.u_px),
        v_px: column(&|s| s.v_px),
        radius_px: column(&|s| s.radius_px),
        confidence: column(&|s| s.confidence),
        metres: metric.as_ref().map(|metric| Metres {
            x_m: metric.observation.column(0).collect(),
            z_m: metric.observation.column(2).collect(),
        }),
    };
    let facts = facts(track, metric.as_ref(), &samples);
    if let Some(rate_hz) = options.rate {
        samples = resampled(&samples, released_s(metric.as_ref()), rate_hz, options.frames)?;
    }
    Ok(Tracked { facts, samples, pictures: sheet(drawn) })
}

fn facts(track: &Track, metric: Option<&Metric>, samples: &Samples) -> Facts {
    let arcs = metric.and_then(|metric| metric.preflight.arcs.as_ref());
    let bounces_s = match arcs {
        Some(arcs) => arcs.contacts.iter().map(|contact| contact.time_s).collect(),
        // Without a scale there are no flights in metres, but a kink of the track is a kink.
        None => bounces(&samples.t_s, &samples.v_px.iter().map(|v| -v).collect::<Vec<f64>>()),
    };
    let restitution = arcs
        .and_then(Arcs::restitution)
        .map(|r| Estimate { value: r.value, interval95: [r.value - NORMAL_95 * r.sd, r.value + NORMAL_95 * r.sd] });
    let checks = metric.map_or(&[][..], |metric| &metric.preflight.checks);
    let colour = track.colour;
    Facts {
        frames: track.frames,
        seen: track.sightings.len(),
        whole: samples.t_s.len(),
        fps: track.rate_hz,
        duplicates: track.repeated.len(),
        dropped: track.dropped,
        width_px: track.size_px.0,
        height_px: track.size_px.1,
        radius_px: track.radius_px(),
        color: Colour {
            hue: colour.hue,
            half_width: colour.half_width,
            saturation: colour.saturation,
            value: colour.value,
        },
        scale: metric.map(|metric| Scale {
            m_per_px: metric.metres_per_px,
            by: metric.by,
            words: metric.by.name().to_owned(),
            depth_1_m: metric.camera.map_or(0.0, |camera| camera.depth(1.0) - 1.0),
        }),
        bounces_s,
        restitution,
        preflight: checks.iter().map(check).collect(),
        warnings: track.notes.iter().chain(metric.into_iter().flat_map(|metric| &metric.notes)).cloned().collect(),
    }
}

fn check(check: &observation::Check) -> Check {
    Check {
        code: check.kind.code().to_owned(),
        state: check.state,
        text: check.text.clone(),
        remedy: check.remedy.clone(),
    }
}

fn sheet(drawn: &[Drawn]) -> Vec<Picture> {
    let one = |d: &Drawn| Picture {
        frame: d.frame,
        time_s: d.time_s,
        width: d.size_px.0,
        height: d.size_px.1,
        jpeg: BASE64_STANDARD.encode(&d.jpeg),
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
fn resampled(
    samples: &Samples,
    from_s: Option<f64>,
    rate_hz: f64,
    count: Option<usize>,
) -> tunenet_core::Result<Samples> {
    let times = &samples.t_s;
    let (first, last) = (times[0], times[times.len() - 1]);
    let from = from_s.unwrap_or(first);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a length of time, clamped")]
    let count = count.unwrap_or_else(|| ((last - from) * rate_hz + 1e-6).clamp(2.0, MOST_RESAMPLED) as usize + 1);
    let clock: Vec<f64> = (0..count).map(|k| from + k as f64 / rate_hz).collect();
    let on_clock = |values: &[f64]| -> tunenet_core::Result<Vec<f64>> {
        let seen = Observation::new(Kind::Other, vec![Channel::new("value", "1")], times.clone(), values.to_vec())?;
        Ok(resample(&seen, &clock)?.values().to_vec())
    };
    let metres = |metres: &Metres| -> tunenet_core::Result<Metres> {
        Ok(Metres { x_m: on_clock(&metres.x_m)?, z_m: on_clock(&metres.z_m)? })
    };
    Ok(Samples {
        u_px: on_clock(&samples.u_px)?,
        v_px: on_clock(&samples.v_px)?,
        radius_px: on_clock(&samples.radius_px)?,
        confidence: on_clock(&samples.confidence)?,
        metres: samples.metres.as_ref().map(metres).transpose()?,
        t_s: clock,
    })
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
