//! The law that was found: its form, its numbers, its tests, its course along its variable, and what was refused.

use maud::{Markup, html};
use tunenet_core::law::{
    CHANCE, LEAST_PROBABILITY, LIKELY_FORCE_NATS, MOST_FORCE_NATS, MOST_HELD_OUT, MOST_HELD_OUT_FORCE_NATS, Member,
};

use super::course::courses;
use crate::answers::diagnose::Answer;
use crate::answers::law::{Law, alias, cautions, why_not, why_refused};
use crate::view::html::verdict::{capital, signed};
use crate::view::text::rounded;

/// The section, where a law was searched.
pub fn section(answer: &Answer) -> Markup {
    let Some(law) = answer.law else { return html! {} };
    html! {
        h2 { "Law of the missing force" }
        (content(answer, law))
    }
}

fn content(answer: &Answer, law: &Law) -> Markup {
    let found = match &law.found {
        Ok(found) => found,
        Err(why) => return html! { p { (capital(why)) "." } },
    };
    let decides = law.decides(answer.diagnosis.verdict()).is_some();
    html! {
        @if let Some(reason) = why_not(&found.answer) { p { (capital(&reason)) "." } }
        @if !decides && found.answer.reason.is_none() { p { "No smooth force is left that a law could explain." } }
        @for member in &found.answer.members {
            h3 { code { (member.text()) } @if let Some(alias) = alias(member) { " \u{b7} " (alias) } }
            (numbers(member))
            (courses(member, &found.answer.members))
            (tests(member))
            @for caution in cautions(member) { p { (capital(&caution)) "." } }
        }
        @if !found.answer.refused.is_empty() {
            h3 { "Refused" }
            ul.plain { @for refused in &found.answer.refused { li { code { (refused.text) } ": " (why_refused(refused)) } } }
        }
        p.how {
            (found.answer.rollouts) " rollouts of the search"
            @if let Some(sample) = found.sample() { " in " (sample) }
            "."
        }
    }
}

fn numbers(member: &Member) -> Markup {
    let all = || member.terms.iter().flat_map(|term| &term.numbers);
    html! {
        table {
            thead { tr { th { "number" } th { "value" } th { "95 % interval" } th { "unit" } } }
            tbody {
                @for n in all() {
                    @let half = (n.interval95.1 - n.interval95.0) / 2.0;
                    @let of = |v: f64| signed(&rounded(v, half));
                    tr {
                        th scope="row" { code { (n.key) } }
                        td.number data-name="value" { (of(n.value)) }
                        td.number data-name="95 % interval" { (of(n.interval95.0)) " to " (of(n.interval95.1)) }
                        td data-name="unit" { @if n.unit != "1" { (n.unit) } }
                    }
                }
            }
        }
        @if !member.valid.is_empty() {
            p { "Seen for " @for (i, (name, (low, high))) in member.valid.iter().enumerate() { @if i > 0 { ", " } code { (name) } (format!(" {low:.3} to {high:.3}")) } "." }
        }
    }
}

fn tests(member: &Member) -> Markup {
    let gates = &member.gates;
    html! {
        table {
            thead { tr { th { "test" } th { "value" } th { "passes" } } }
            tbody {
                tr { th scope="row" { "residual force" } td.number { (format!("{:.2} nats", gates.residual_force_nats)) } td { (format!("at most {MOST_FORCE_NATS}, alone {LIKELY_FORCE_NATS}")) } }
                @if let Some(p) = gates.heterogeneity_p {
                    tr { th scope="row" { "recordings agree" } td.number { (format!("p {p:.3}")) } td { (format!("at least {LEAST_PROBABILITY}, alone {CHANCE}")) } }
                }
                @if let Some(ratio) = gates.held_out_ratio {
                    @let base = gates.held_out_base.unwrap_or(f64::INFINITY);
                    tr { th scope="row" { "held out, over noise" } td.number { (format!("{ratio:.3}")) } td { (format!("at most {base:.3}, without the law")) } }
                }
                @if let (Some(left), Some(p), Some(_)) = (gates.held_out_left, gates.held_out_p, gates.held_out_nats) {
                    tr { th scope="row" { "held out, less what uncertain constants explain" } td.number { (format!("{left:.3}, p {p:.3}")) } td { "at most " (MOST_HELD_OUT) (format!(", or p at least {LEAST_PROBABILITY}, alone {CHANCE}")) } }
                }
                @if let Some(p) = gates.held_out_differ_p {
                    tr { th scope="row" { "held out, same constants" } td.number { (format!("p {p:.3}")) } td { (format!("at least {LEAST_PROBABILITY}, alone {CHANCE}")) } }
                }
                @if let Some(nats) = gates.held_out_force_nats {
                    tr { th scope="row" { "held out, residual force" } td.number { (format!("{nats:.2} nats")) } td { (format!("at most {MOST_HELD_OUT_FORCE_NATS}, alone {MOST_FORCE_NATS}")) } }
                }
                tr { th scope="row" { "gain of BIC" } td.number { (format!("{:.0}", member.bic_gain)) } td { "more than 6" } }
            }
        }
    }
}
