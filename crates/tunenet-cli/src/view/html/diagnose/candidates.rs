//! The candidates: how much each explains, which cannot be distinguished, how they do on held-out recordings, and why others
//! are excluded.

use maud::{Markup, html};
use tunenet_core::diagnose::{Candidate, Diagnosis, Verdict};
use tunenet_core::observation::with_decimals;
use tunenet_sim::phase;

use crate::answers::diagnose::Answer;
use crate::view::html::axis::Axis;
use crate::view::html::series::Size;
use crate::view::html::svg::{Anchor, Svg, bold_width, text_width};
use crate::view::html::verdict::capital;

/// Bars that are drawn; the table has all.
const MOST: usize = 8;
const ROW: f64 = 42.0;

fn gain(candidate: &Candidate) -> String {
    let about = if candidate.fitted { "" } else { "\u{2248}\u{a0}" };
    // Whole numbers have no minus before 0.
    format!("{about}{:.0}", candidate.bic_gain.round() + 0.0).replace('-', "\u{2212}")
}

/// Those that could be the answer, best first.
pub fn left(diagnosis: &Diagnosis) -> impl Iterator<Item = &Candidate> {
    diagnosis.candidates.iter().filter(|c| c.excluded.is_none())
}

/// Names that these recordings do not distinguish from the best.
pub fn confusable(diagnosis: &Diagnosis) -> Vec<&str> {
    match diagnosis.verdict() {
        Verdict::OneOf => diagnosis.names(),
        _ => Vec::new(),
    }
}

/// Bars of the gain, with the line that an explanation has to reach to be left.
pub fn gains(diagnosis: &Diagnosis) -> Markup {
    let is_shown = |(i, c): &(usize, &Candidate)| *i < MOST || diagnosis.names().contains(&c.name.as_ref());
    let shown: Vec<&Candidate> = left(diagnosis).enumerate().filter(is_shown).map(|(_, c)| c).collect();
    let width = Size::Narrow.width();
    let best = shown.iter().map(|c| c.bic_gain).fold(0.0, f64::max);
    let needed = (best - diagnosis.margin).max(diagnosis.least_gain);
    let right = width - 30.0;
    let x = Axis::new((0.0, 1.05 * best.max(needed)), (1.0, right));
    let bottom = 8.0 + ROW * shown.len() as f64;
    let mut svg = Svg::new(width, bottom + 26.0);
    let twins = confusable(diagnosis);
    let mut bracketed = Vec::new();
    for (i, one) in shown.iter().enumerate() {
        let y = 8.0 + ROW * i as f64;
        let class = if one.bic_gain >= needed { "after" } else { "rest" };
        svg.text("row", (0.0, y + 13.0), Anchor::Start, &one.name);
        svg.text("value", (right - 2.0, y + 13.0), Anchor::End, &gain(one));
        svg.area(&format!("bar {class}"), (x.at(0.0), y + 19.0), (x.at(one.bic_gain.max(0.0)), y + 33.0));
        if twins.contains(&one.name.as_ref()) {
            bracketed.push(y + 20.0);
        }
    }
    svg.line("axis", (x.at(0.0), 8.0), (x.at(0.0), bottom));
    for i in 0..shown.len() {
        let y = 8.0 + ROW * i as f64;
        svg.line("limit", (x.at(needed), y + 16.0), (x.at(needed), y + 36.0));
    }
    let text = format!("dotted: needed, {needed:.0}");
    let middle = x.at(needed);
    let half = text_width(&text) / 2.0;
    let at = middle.clamp(half, width - half);
    svg.text("name", (at, bottom + 18.0), Anchor::Middle, &text);
    if let ([first, .., last], true) = (&bracketed[..], bracketed.len() > 1) {
        let edge = width - 8.0;
        svg.path("bracket", &[(edge - 8.0, *first), (edge, *first), (edge, *last), (edge - 8.0, *last)], false);
        for y in &bracketed {
            svg.line("bracket", (edge - 8.0, *y), (edge, *y));
        }
    }
    debug_assert!(shown.iter().all(|c| text_width(&c.name) + bold_width(&gain(c)) < right), "names leave room");
    svg.finish("small", "gain of the information criterion by candidate, with the margin")
}

/// All candidates that are not excluded, with what they do on held-out recordings.
pub fn table(answer: &Answer) -> Markup {
    let diagnosis = answer.diagnosis;
    let control = diagnosis.gap.as_ref().and_then(|g| g.control.as_ref()).map(|c| c.0.as_ref());
    let ratio = |c: &Candidate| match (&diagnosis.gap, c.held_out_ratio) {
        (_, Some(ratio)) => Some(ratio),
        (Some(gap), None) if control == Some(c.name.as_ref()) => {
            gap.held_out.zip(gap.control.as_ref()).map(|(h, (_, after))| after / h.before.max(f64::MIN_POSITIVE))
        }
        _ => None,
    };
    let (kept, idle): (Vec<&Candidate>, Vec<&Candidate>) = left(diagnosis)
        .partition(|c| c.bic_gain > 0.0 || ratio(c).is_some() || diagnosis.names().contains(&c.name.as_ref()));
    html! {
        table {
            thead { tr { th { "effect" } th { "acts" } th { "gain" } th { "behind the best" } th { "held-out error" } th { "" } } }
            tbody {
                @for one in &kept {
                    tr {
                        th scope="row" { code { (one.name) } }
                        td data-name="acts" { @if let Some(effect) = answer.entry(&one.name) { (phase::name(&effect.phase)) } }
                        td.number data-name="gain" { (gain(one)) }
                        td.number data-name="behind the best" { (format!("{:.0}", one.delta)) }
                        td.number data-name="held-out error" { @if let Some(ratio) = ratio(one) { (format!("\u{d7}\u{a0}{}", with_decimals(ratio, 3))) } }
                        td.state { @if diagnosis.names().contains(&one.name.as_ref()) { (role(diagnosis.verdict())) } @else if control == Some(one.name.as_ref()) { "control" } }
                    }
                }
            }
        }
        p.how {
            "Gain: decrease of the Bayesian information criterion with only this effect added; \u{2248} marks values that were "
            "predicted, not fitted. "
            @if kept.iter().any(|c| ratio(c).is_some()) { "Held-out error: divided by that of the simulation tuned without it. " }
            @if let Some(name) = control {
                "The control is a wrong effect, " code { (name) } ": an improvement that it reaches as well is no evidence. "
            }
            @if !idle.is_empty() {
                "No improvement with: "
                @for (i, one) in idle.iter().enumerate() { @if i > 0 { ", " } code { (one.name) } }
                "."
            }
        }
    }
}

fn role(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Named => "named",
        Verdict::OneOf => "possible",
        _ => "nearest",
    }
}

/// Effects that cannot be the answer, and why.
pub fn excluded(diagnosis: &Diagnosis) -> Markup {
    let all: Vec<(&str, String)> =
        diagnosis.candidates.iter().filter_map(|c| Some((c.name.as_ref(), c.excluded.as_ref()?.to_string()))).collect();
    html! {
        @if !all.is_empty() {
            table {
                thead { tr { th { "effect" } th { "excluded, because" } } }
                tbody { @for (name, why) in &all { tr { th scope="row" { code { (name) } } td { (capital(why)) } } } }
            }
        }
    }
}
