//! The page of `tunenet track`: what was seen of the ball, drawn into the film's own frames.

use std::path::Path;

use maud::{Markup, html};
use serde_json::Value;
use tunenet_core::Result;
use tunenet_core::observation::Note;

use super::axis::Axis;
use super::checks::warnings;
use super::page;
use super::panel::{ABOVE, BELOW, Panel, left_edge};
use super::svg::Svg;
use crate::commands::film::column;

/// Size of a curve, in the units of its drawing.
const SIZE: (f64, f64) = (720.0, 240.0);

/// Writes the page for the film `name`.
pub fn write(path: &Path, name: &str, found: &Value, notes: &[Note]) -> Result<()> {
    let body = html! {
        section.verdict.tuned {
            div {
                p.word { "TRACKED" }
                p { "The ball is seen in " (shown(&found["seen"])) " of " (shown(&found["frames"])) " frames, whole in "
                    (shown(&found["whole"])) "." }
            }
        }
        section {
            h2 { "The track in the film" }
            p.how { "The circle is where the ball was found, the line where it came from. A thin circle: the border cuts the "
                "ball, and the frame is left out." }
            div.grid { @for picture in found["pictures"].as_array().into_iter().flatten() { (frame(picture)) } }
        }
        section { h2 { "Over time" } (curves(found)) }
        section { h2 { "What to know" } (warnings(notes)) }
        section { h2 { "The film" } (facts(found)) }
    };
    page::write(path, &page::page("Track", name, &body))
}

/// Writes the page for the film `name`, in which no ball could be followed.
pub fn unseen(path: &Path, name: &str, found: &Value, reason: &Note) -> Result<()> {
    let word = found["verdict"].as_str().unwrap_or_default().replace('_', " ").to_uppercase();
    let body = html! {
        section.verdict.not {
            div { p.word { (word) } p { (reason.text) "." } }
        }
        section { h2 { "What to do" } p { (reason.remedy) "." } }
        section {
            h2 { "The film" }
            p.how { (shown(&found["frames"])) " frames decode. These are some of them, as they are." }
            div.grid { @for picture in found["pictures"].as_array().into_iter().flatten() { (frame(picture)) } }
        }
    };
    page::write(path, &page::page("Track", name, &body))
}

fn frame(picture: &Value) -> Markup {
    let caption =
        format!("frame {}, {:.3} s", picture["frame"].as_u64().unwrap_or(0), picture["time_s"].as_f64().unwrap_or(0.0));
    let source = format!("data:image/jpeg;base64,{}", picture["jpeg"].as_str().unwrap_or_default());
    html! {
        figure {
            img src=(source) alt=(caption) width=(shown(&picture["width"])) height=(shown(&picture["height"]))
                style="max-width:100%;height:auto";
            figcaption { (caption) }
        }
    }
}

/// Height, or rows of the picture where nothing says how large a pixel is, and the ball's radius.
fn curves(found: &Value) -> Markup {
    let times = column(found, "t_s").unwrap_or_default();
    let height = match (column(found, "z_m"), column(found, "v_px")) {
        (Some(z), _) => ("height of the centre in m", z),
        (None, Some(v)) => ("height of the centre in px", v.into_iter().map(|v| -v).collect()),
        _ => return html! {},
    };
    let radius = ("radius in px", column(found, "radius_px").unwrap_or_default());
    let bounces: Vec<f64> = found["bounces_s"].as_array().into_iter().flatten().filter_map(Value::as_f64).collect();
    html! {
        @for (name, values) in [height, radius] {
            figure { (curve(name, &times, &values, &bounces)) }
        }
        p.how { "Upright lines are bounces, where two flights cross. The radius tells of a ball that comes nearer, and of blur." }
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

fn facts(found: &Value) -> Markup {
    let number = |key: &str| found[key].as_f64().unwrap_or(0.0);
    let scale = match found["scale"]["m_per_px"].as_f64() {
        Some(metres) => {
            format!("{:.4} mm a pixel, by {}", 1e3 * metres, found["scale"]["words"].as_str().unwrap_or_default())
        }
        None => "none".into(),
    };
    let restitution = match found["restitution"]["value"].as_f64() {
        Some(value) => format!("{value:.3} of the speed, from the flights alone"),
        None => "not seen".into(),
    };
    let rows = [
        ("size", format!("{} × {} px", number("width_px"), number("height_px"))),
        ("rate", format!("{:.3} frames a second", number("fps"))),
        ("repeated frames", number("duplicates").to_string()),
        ("missing frames", number("dropped").to_string()),
        ("radius", format!("{:.1} px", number("radius_px"))),
        ("scale", scale),
        ("rebound", restitution),
    ];
    html! {
        table { tbody { @for (name, text) in rows { tr { th scope="row" { (name) } td { (text) } } } } }
    }
}

fn shown(value: &Value) -> String {
    value.to_string()
}
