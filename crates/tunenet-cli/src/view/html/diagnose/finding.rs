//! The answer at the head of the page: a shape, a word, a sentence that a person can act on.

use maud::{Markup, html};
use tunenet_core::diagnose::{Change, Doubt, GapOf, Verdict};
use tunenet_core::simulator::Phase;
use tunenet_sim::phase;

use super::numbers::in_short;
use super::plain;
use crate::answers::diagnose::{Answer, NOT_IN_CATALOGUE, why_insufficient};
use crate::answers::law::AnswerVerdict;
use crate::view::html::verdict::{CROSS, NOTICE, PLUS, QUESTION, Shape, TICK, capital, prose, quantity, shape};

pub fn finding(answer: &Answer) -> Markup {
    let diagnosis = answer.diagnosis;
    let class =
        if matches!(diagnosis.verdict(), Verdict::None | Verdict::Named) { "verdict tuned" } else { "verdict not" };
    let next = diagnosis.next_experiment.as_ref();
    if let Some(headline) = crate::view::text::law::headline(answer) {
        let alone = answer.verdict() == AnswerVerdict::Law;
        return html! {
            section class=(if alone { "verdict tuned" } else { "verdict not" }) {
                (shape(if alone { PLUS } else { QUESTION }, if alone { "Law" } else { "One of several" }))
                div {
                    p.word { @if alone { "Law" } @else { "One of several" } }
                    p.act { (headline.sentence) "." }
                }
            }
        };
    }
    html! {
        section class=(class) {
            (shape(shape_of(diagnosis.verdict()), word(diagnosis.verdict())))
            div {
                p.word { (word(diagnosis.verdict())) }
                p.act { (sentence(answer)) }
                @if diagnosis.verdict() == Verdict::Named {
                    @for named in diagnosis.effects() { p { (capital(&named.effect.sentence)) "." } }
                }
                @if !diagnosis.effects().is_empty() {
                    @for line in in_short(answer) { p.value { (line) } }
                }
                @for (effect, objects) in answer.unneeded() {
                    p { "The recordings of " (joined(&objects.iter().map(ToString::to_string).collect::<Vec<_>>(), "and")) " do not need " (plain(effect)) "; their files leave it out." }
                }
                @if let Some(text) = &diagnosis.conclusion.description() { p { (capital(text)) "." } }
                @if let Some(gap) = gap(answer) { p { (gap) } }
                @if diagnosis.verdict() == Verdict::Insufficient {
                    @for note in answer.reasons() { p { (capital(&note.text)) "." @if !note.remedy.is_empty() { " " span.try { (prose(&note.remedy)) "." } } } }
                }
                @if let Some(next) = next { p { span.try { (next.text) "." } } }
            }
        }
    }
}

pub fn word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::None => "None",
        Verdict::Named => "Named",
        Verdict::OneOf => "One of several",
        Verdict::Unknown => "Unknown",
        Verdict::Insufficient => "Insufficient",
    }
}

fn shape_of(verdict: Verdict) -> Shape {
    match verdict {
        Verdict::None => TICK,
        Verdict::Named => PLUS,
        Verdict::OneOf => QUESTION,
        Verdict::Unknown => NOTICE,
        Verdict::Insufficient => CROSS,
    }
}

/// What is missing, and where.
pub fn sentence(answer: &Answer) -> String {
    let diagnosis = answer.diagnosis;
    match diagnosis.verdict() {
        Verdict::None => "Nothing is missing that these recordings could show.".into(),
        Verdict::Named => {
            let each: Vec<_> = diagnosis
                .effects()
                .iter()
                .map(|e| format!("{} {}", plain(&e.effect.name), phase::name(&e.effect.phase)))
                .collect();
            let verb = if each.len() == 1 { "is" } else { "are" };
            format!("{} {verb} missing.", capital(&joined(&each, "and")))
        }
        Verdict::OneOf => {
            let (open, firm) = answer.open_and_firm();
            let words = |names: &[&str]| names.iter().map(|name| plain(name)).collect::<Vec<_>>();
            let or_unknown = if answer.allows_unknown() { format!(", or {NOT_IN_CATALOGUE}") } else { String::new() };
            let open: Vec<String> = open.iter().map(|names| joined(&words(names), "or")).collect();
            let place = common_place(answer).map(|p| format!(" {}", phase::name(&p))).unwrap_or_default();
            let certain = if firm.is_empty() {
                String::new()
            } else {
                format!(", in addition to {}", joined(&words(&firm), "and"))
            };
            let why = diagnosis.conclusion.doubt().map_or("not distinguishable in these recordings".into(), |doubt| {
                let by = if matches!(doubt, Doubt::DiscrepancyRemains) { "" } else { " by far" };
                let each = if open.len() == 1 { "" } else { " of each" };
                format!("the first{each} fits best{by}, but {doubt}")
            });
            format!("{}{place}{or_unknown}{certain}: {why}.", capital(&open.join("; and ")))
        }
        Verdict::Unknown => {
            let place = diagnosis.conclusion.remains().map(|p| format!(" {}", phase::name(p))).unwrap_or_default();
            format!("Something is missing{place}; no known effect explains it.")
        }
        Verdict::Insufficient => format!("The data are insufficient for an answer: {}.", why_insufficient(diagnosis)),
    }
}

/// Where all effects that are left act, if they act at the same place.
fn common_place(answer: &Answer) -> Option<Phase> {
    let candidates = answer.candidates();
    let mut places = candidates.iter().map(|name| answer.entry(name).map(|effect| effect.phase));
    let first = places.next()??;
    places.all(|place| place.as_ref() == Some(&first)).then_some(first)
}

/// What the gap was and is.
fn gap(answer: &Answer) -> Option<String> {
    let gap = answer.diagnosis.gap.as_ref()?;
    let words = |value: f64| quantity(value, &gap.unit);
    let of = match gap.of {
        GapOf::Recordings => "",
        GapOf::Segments => " of the flights only, cut at the contacts,",
        GapOf::Events => " of the contacts only, with de-trended flights,",
    };
    if answer.diagnosis.effects().is_empty() {
        return Some(format!(
            "Tuned, the gap is {}; the noise floor is {}.",
            words(gap.before),
            words(gap.noise_floor)
        ));
    }
    let held_out = match gap.held_out {
        Some(Change { before, after }) => {
            format!(" On recordings that were not fitted: from {} to {}.", words(before), words(after))
        }
        None => String::new(),
    };
    let which = if answer.diagnosis.verdict() == Verdict::OneOf {
        let chosen: Vec<String> = answer.chosen().into_iter().map(plain).collect();
        format!("With {}, the best of them,", joined(&chosen, "and"))
    } else {
        "With it".into()
    };
    Some(format!(
        "{which} the gap{of} falls from {} to {}; the noise floor is {}.{held_out}",
        words(gap.before),
        words(gap.after),
        words(gap.noise_floor)
    ))
}

/// "a", "a and b", "a, b and c".
fn joined(items: &[String], last: &str) -> String {
    match items {
        [] => "something".into(),
        [one] => one.clone(),
        [first @ .., end] => format!("{} {last} {end}", first.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::joined;

    #[test]
    fn lists_read_as_people_write_them() {
        let items = ["wind", "Magnus", "tilt"].map(String::from);
        assert_eq!(joined(&items, "or"), "wind, Magnus or tilt");
        assert_eq!(joined(&items[..2], "and"), "wind and Magnus");
        assert_eq!(joined(&items[..1], "and"), "wind");
    }
}
