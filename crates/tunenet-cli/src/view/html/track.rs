//! The page of `tunenet track`: what was seen of the ball, drawn into the video's own frames.

use std::path::Path;

use maud::{Markup, html};
use tunenet_core::observation::Note;
use tunenet_formats::Result;
use tunenet_video_protocol::track::{Estimate, Facts, Picture, Samples, Tracked, Untracked};

use super::axis::Axis;
use super::checks::warnings;
use super::page;
use super::panel::{ABOVE, BELOW, Panel, left_edge};
use super::svg::Svg;
use super::verdict::{CROSS, TICK, shape};

/// Size of a curve, in the units of its drawing.
const SIZE: (f64, f64) = (720.0, 240.0);

/// Writes the page for the video `name`.
pub fn write(path: &Path, name: &str, found: &Tracked, notes: &[Note]) -> Result<()> {
    let facts = &found.facts;
    let body = html! {
        section.verdict.tuned {
            (shape(TICK, "Tracked"))
            div {
                p.word { "Tracked" }
                p { "The ball is seen in " (facts.seen) " of " (facts.frames) " frames, whole in " (facts.whole) "." }
                @if !facts.bounces_s.is_empty() { p { "Bounces at " (bounces(facts)) " s." } }
                @if let Some(Estimate { value, interval95: [low, high] }) = facts.rebound() {
                    p { "Rebound " span.value { (format!("{value:.3}")) } (format!(" of the speed (95 %: {low:.3}\u{2013}{high:.3}), from the flights only.")) }
                }
                @if let Some(scale) = &facts.scale { p { "Scale " (format!("{:.4} mm a pixel, by {}.", 1e3 * scale.m_per_px, scale.words)) } }
            }
        }
        section {
            h2 { "Track in the video" }
            p.how { "The circle is the position of the ball, the line its path. A thin circle: the border cuts the "
                "ball, and the frame is not used." }
            div.grid { @for picture in &found.pictures { (frame(picture)) } }
        }
        section { h2 { "Position over time" } (curves(&found.samples, &facts.bounces_s)) }
        section { h2 { "Warnings and notes" } (warnings(notes)) }
        section { h2 { "Video" } (table(facts)) }
    };
    page::write(path, &page::page("Track", name, &body))
}

/// Writes the page for the video `name`, in which no ball could be followed.
pub fn refused(path: &Path, name: &str, found: &Untracked) -> Result<()> {
    let word = found.reason.word().replace('_', " ").to_uppercase();
    let body = html! {
        section.verdict.not {
            (shape(CROSS, &word))
            div { p.word { (word) } p { (found.finding.text) "." } }
        }
        section { h2 { "Remedy" } p { (found.finding.remedy) "." } }
        section {
            h2 { "Video" }
            p.how { (found.frames) " frames decode. These are some of them, as they are." }
            div.grid { @for picture in &found.pictures { (frame(picture)) } }
        }
    };
    page::write(path, &page::page("Track", name, &body))
}

fn bounces(facts: &Facts) -> String {
    facts.bounces_s.iter().map(|t| format!("{t:.3}")).collect::<Vec<_>>().join(", ")
}

fn frame(picture: &Picture) -> Markup {
    let caption = format!("frame {}, {:.3} s", picture.frame, picture.time_s);
    let source = format!("data:image/jpeg;base64,{}", picture.jpeg);
    html! {
        figure {
            img src=(source) alt=(caption) width=(picture.width) height=(picture.height)
                style="max-width:100%;height:auto";
            figcaption { (caption) }
        }
    }
}

/// Height, or rows of the picture where nothing says how large a pixel is, and the ball's radius.
fn curves(samples: &Samples, bounces: &[f64]) -> Markup {
    let height = match &samples.metres {
        Some(metres) => ("height of the centre in m", metres.z_m.clone()),
        None => ("height of the centre in px", samples.v_px.iter().map(|v| -v).collect()),
    };
    let radius = ("radius in px", samples.radius_px.clone());
    html! {
        @for (name, values) in [height, radius] {
            figure { (curve(name, &samples.t_s, &values, bounces)) }
        }
        p.how { "Vertical lines are bounces, where two flights cross. A growing radius shows a ball that comes nearer, or blur." }
    }
}

fn curve(name: &str, times: &[f64], values: &[f64], bounces: &[f64]) -> Markup {
    let span = |all: &[f64]| {
        let (low, high) = all.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
        let room = (0.05 * (high - low)).max(1e-6 * high.abs()).max(1e-9);
        (low - room, high + room)
    };
    if times.is_empty() || values.len() != times.len() {
        return html! {};
    }
    let (across, up) = (span(times), span(values));
    let mut svg = Svg::new(SIZE.0, SIZE.1);
    let panel =
        Panel { x: Axis::new(across, (left_edge(&[up]), SIZE.0 - 8.0)), y: Axis::new(up, (SIZE.1 - BELOW, ABOVE)) };
    panel.frame(&mut svg, Some("time in s"), name);
    for bounce in bounces {
        let (bottom, top) = (panel.spot((*bounce, up.0)), panel.spot((*bounce, up.1)));
        svg.line("limit", bottom, top);
    }
    let points: Vec<(f64, f64)> = times.iter().copied().zip(values.iter().copied()).collect();
    svg.dots("dot small few", &panel.spots(&points));
    svg.finish("curve", &format!("{name} over {} samples", times.len()))
}

fn table(facts: &Facts) -> Markup {
    let scale = facts.scale.as_ref().map(|s| format!("{:.4} mm a pixel, by {}", 1e3 * s.m_per_px, s.words));
    let restitution = facts.rebound().map(|r| format!("{:.3} of the speed, from the flights only", r.value));
    let rows = [
        ("size", format!("{} × {} px", facts.width_px, facts.height_px)),
        ("rate", format!("{:.3} frames a second", facts.fps)),
        ("repeated frames", facts.duplicates.to_string()),
        ("missing frames", facts.dropped.to_string()),
        ("radius", format!("{:.1} px", facts.radius_px)),
        ("scale", scale.unwrap_or_else(|| "none".into())),
        ("rebound", restitution.unwrap_or_else(|| "not seen".into())),
    ];
    html! {
        table { tbody { @for (name, text) in rows { tr { th scope="row" { (name) } td { (text) } } } } }
    }
}
