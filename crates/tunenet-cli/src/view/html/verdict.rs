//! The answer at the head of a page: a shape, a word, a sentence.

use maud::{Markup, html};
use tunenet_core::findings as core_findings;
use tunenet_core::observation::Note;
use tunenet_core::tune::{Estimate, Outcome, Stop, Verdict};
use tunenet_sim::findings as sim_findings;

use crate::answers::tune::reason;
use crate::view::text::{in_words, rounded};

/// The verdict on recordings called `names`.
pub fn verdict(outcome: &Outcome, names: &str) -> Markup {
    let class = if outcome.verdict == Verdict::Tuned { "verdict tuned" } else { "verdict not" };
    html! {
        section class=(class) {
            (shape(shape_of(outcome.verdict), word(outcome)))
            div {
                p.word { (word(outcome)) }
                p { (sentence(outcome, names)) }
                @if let Some(note) = reason(outcome).or_else(|| open(outcome)) {
                    p { (prose(&note.text)) "." @if !note.remedy.is_empty() { " " span.try { (prose(&note.remedy)) "." } } }
                }
                @for estimate in outcome.parameters.iter().filter(|e| e.identified) {
                    p { (estimate.name) " " span.value { (value(estimate)) } " (95 %: " (interval(estimate)) "), was " (number(estimate.before)) }
                }
            }
        }
    }
}

/// With a capital at its beginning.
pub fn capital(text: &str) -> String {
    let mut characters = text.chars();
    characters.next().map_or_else(String::new, |first| first.to_uppercase().chain(characters).collect())
}

/// A sentence in which names stand between backticks.
pub fn prose(text: &str) -> Markup {
    // An even number of backticks leaves an odd number of pieces.
    let pieces: Vec<&str> = text.split('`').collect();
    html! {
        @if pieces.len().is_multiple_of(2) {
            (text)
        } @else {
            @for (i, piece) in pieces.iter().enumerate() {
                @if !i.is_multiple_of(2) { code { (piece) } } @else { (piece) }
            }
        }
    }
}

/// Why a parameter is not determined.
fn open(outcome: &Outcome) -> Option<&Note> {
    let opening = [
        sim_findings::FRICTION_NOT_OBSERVABLE,
        core_findings::RECORDINGS_SHORT,
        core_findings::PARAMETER_NOT_IDENTIFIABLE,
        core_findings::PARAMETER_NO_EFFECT,
    ];
    outcome.notes.iter().find(|n| outcome.verdict == Verdict::NotIdentifiable && opening.contains(&n.kind))
}

pub fn word(outcome: &Outcome) -> &'static str {
    match outcome.verdict {
        Verdict::Tuned => "Tuned",
        Verdict::Rejected => "Rejected",
        Verdict::PoorFit if outcome.stop == Stop::Limit => "Not finished",
        Verdict::PoorFit => "Poor fit",
        Verdict::NotIdentifiable => "Not identifiable",
    }
}

fn sentence(outcome: &Outcome, names: &str) -> String {
    let gap = |pick: fn(&tunenet_core::tune::Gap) -> f64| {
        outcome.gap.as_ref().map_or_else(String::new, |g| quantity(pick(g), &g.unit))
    };
    let (after, floor) = (gap(|g| g.after), gap(|g| g.noise_floor));
    match outcome.verdict {
        Verdict::Tuned => format!("The tuned simulation follows {names} to {after}; the noise floor is {floor}."),
        Verdict::PoorFit if outcome.stop == Stop::Limit => format!(
            "The limit on rollouts ended the fit to {names} before it had converged. The best values so far leave a gap of {after}; the \
             noise floor is {floor}."
        ),
        Verdict::PoorFit => format!(
            "The tuned simulation differs from {names} by {after}, but the noise floor is {floor}: an effect is missing from \
             the simulation, or the recording is of something else."
        ),
        Verdict::NotIdentifiable => {
            let open: Vec<&str> =
                outcome.parameters.iter().filter(|e| !e.identified).map(|e| e.name.as_str()).collect();
            format!("The data in {names} do not determine {}.", open.join(" and "))
        }
        Verdict::Rejected => format!("Nothing was tuned: {names} cannot be used."),
    }
}

/// A parameter's value with the digits that its interval allows, and its unit.
pub fn value(estimate: &Estimate) -> String {
    let unit = if estimate.unit == "1" { String::new() } else { format!("\u{a0}{}", estimate.unit) };
    format!("{}{unit}", signed(&rounded(estimate.value, half(estimate))))
}

/// Its interval, without unit.
pub fn interval(estimate: &Estimate) -> String {
    let (low, high) = estimate.interval95;
    let (low, high) = (rounded(low, half(estimate)), rounded(high, half(estimate)));
    let between = if low.starts_with('-') { " to " } else { "\u{2013}" };
    format!("{}{between}{}", signed(&low), signed(&high))
}

/// A length or time with its unit, kept on one line.
pub fn quantity(value: f64, unit: &str) -> String {
    signed(&in_words(value, unit)).replace(' ', "\u{a0}")
}

/// A number as it was given.
pub fn number(value: f64) -> String {
    // Digits as few as give the same number back.
    signed(&if value.abs() >= 1e10 { format!("{value:e}") } else { value.to_string() })
}

/// With a minus sign for a hyphen.
pub fn signed(number: &str) -> String {
    number.replace('-', "\u{2212}")
}

fn half(estimate: &Estimate) -> f64 {
    (estimate.interval95.1 - estimate.interval95.0) / 2.0
}

/// An outline and a mark in it, in a square of 52 units. Every verdict has a shape of its own, so that no colour is needed.
pub type Shape = (&'static str, &'static str);
/// A tick in a circle.
pub const TICK: Shape = ("M26 4a22 22 0 1 0 .01 0z", "M16 27l7 7l13 -15");
/// `+` in a circle.
pub const PLUS: Shape = (TICK.0, "M26 15v22M15 26h22");
/// `!` in a triangle.
pub const NOTICE: Shape = ("M26 5l22 40h-44z", "M26 20v12M26 38v.5");
/// `?` in a square on its tip.
pub const QUESTION: Shape =
    ("M26 3l23 23l-23 23l-23 -23z", "M20 21a6 6 0 1 1 8.500 5.500q-2.500 1.500 -2.500 4.500M26 37v.5");
/// A cross in an octagon.
pub const CROSS: Shape = ("M17 4h18l13 13v18l-13 13h-18l-13 -13v-18z", "M18 18l16 16M34 18l-16 16");

/// A shape that stands for `word`.
pub fn shape((outline, mark): Shape, word: &str) -> Markup {
    html! {
        svg viewBox="0 0 52 52" role="img" aria-label=(word) {
            path class="shape" d=(outline) {}
            path class="shape" d=(mark) {}
        }
    }
}

fn shape_of(verdict: Verdict) -> Shape {
    match verdict {
        Verdict::Tuned => TICK,
        Verdict::PoorFit => NOTICE,
        Verdict::NotIdentifiable => QUESTION,
        Verdict::Rejected => CROSS,
    }
}
