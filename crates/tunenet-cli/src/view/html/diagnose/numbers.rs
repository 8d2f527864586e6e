//! The numbers of the answer: coefficients, tuned parameters, tests of what is left.

use maud::{Markup, html};
use tunenet_core::diagnose::{NamedEffect, Test, Value};
use tunenet_core::observation::with_decimals;

use crate::answers::diagnose::Answer;
use crate::view::html::axis::Axis;
use crate::view::html::svg::Svg;
use crate::view::html::verdict::{number, signed};
use crate::view::text::rounded;

fn unit(unit: &str) -> String {
    if unit == "1" { String::new() } else { format!("\u{a0}{unit}") }
}

fn value_and_interval(value: &Value) -> (String, String) {
    let (low, high) = value.interval95;
    let half = (high - low) / 2.0;
    let of = |v: f64| signed(&rounded(v, half));
    (of(value.value), format!("{} to {}", of(low), of(high)))
}

/// A bound in three digits.
fn short(bound: f64) -> String {
    if bound == 0.0 {
        return "0".into();
    }
    let text = rounded(bound, 0.05 * bound.abs());
    signed(if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text })
}

/// One row for each coefficient of each object.
struct Row<'a> {
    named: &'a NamedEffect,
    key: String,
    unit: &'a str,
    value: &'a Value,
    plausible: (f64, f64),
    /// Whether the recordings show it.
    shown: bool,
}

fn rows<'a>(answer: &'a Answer<'a>) -> Vec<Row<'a>> {
    let effects = answer.diagnosis.effects().iter();
    let fitted = effects.flat_map(|named| {
        let each = named.coefficients.iter().zip(answer.keys_of(named)).enumerate();
        each.map(move |(i, (fitted, key))| (named, fitted, key, i))
    });
    fitted
        .flat_map(|(named, fitted, key, i)| {
            fitted.values.iter().map(move |value| Row {
                named,
                key: key.clone(),
                unit: &fitted.unit,
                value,
                plausible: answer.plausible(named, i, value),
                shown: named.shows(&fitted.key, value),
            })
        })
        .collect()
}

/// Most lines of the answer in short.
const FEW: usize = 6;

/// Coefficients and tuned parameters, each with its interval, where these are few.
pub fn in_short(answer: &Answer) -> Vec<String> {
    let objects = &answer.loaded.objects;
    let line = |name: &str, object: Option<&str>, value: &Value, of: &str| {
        let (best, interval) = value_and_interval(value);
        let object = object.map(|o| format!(" of {o}")).unwrap_or_default();
        format!("{name}{object} {best}{} (95 %: {interval})", unit(of))
    };
    let coefficients = rows(answer).into_iter().filter(|row| row.shown).map(|row| {
        let object = answer.object(row.value).filter(|_| objects.len() > 1);
        line(&format!("{} {}", row.named.effect.name, row.key), object, row.value, row.unit)
    });
    let tuned = answer.parameters();
    let parameters = tuned.iter().map(|tuned| {
        let value = Value { object: None, value: tuned.value, interval95: tuned.interval95 };
        let object = objects.get(tuned.object).filter(|_| objects.len() > 1).map(|o| o.name.as_str());
        line(&tuned.name, object, &value, &tuned.unit)
    });
    let lines: Vec<String> = coefficients.chain(parameters).collect();
    if lines.len() > FEW { Vec::new() } else { lines }
}

/// The heads of a table's columns; the object is reported where there are several.
fn heads(answer: &Answer, first: &str, others: &[&str]) -> Markup {
    html! {
        thead { tr {
            th { (first) }
            @if answer.loaded.objects.len() > 1 { th { "object" } }
            @for other in others { th { (other) } }
        } }
    }
}

/// The cell of a row's object, where there are several; `None` is what all share.
fn of_object(answer: &Answer, object: Option<usize>) -> Markup {
    let name = object.and_then(|object| answer.loaded.objects.get(object)).map_or("all", |o| o.name.as_str());
    html! { @if answer.loaded.objects.len() > 1 { td.object data-name="object" { (name) } } }
}

pub fn coefficients(answer: &Answer) -> Markup {
    html! {
        table {
            (heads(answer, "effect", &["value", "95 % interval", "physical bounds", "equivalent"]))
            tbody {
                @for row in rows(answer) {
                    @let (value, interval) = value_and_interval(row.value);
                    tr {
                        th scope="row" { code { (row.named.effect.name) } br; code.key { (row.key) } }
                        (of_object(answer, row.value.object))
                        td data-name="value" { span.value { (value) (unit(row.unit)) } }
                        td data-name="95 % interval" { (interval) }
                        td data-name="physical bounds" { (short(row.plausible.0)) " to " (short(row.plausible.1)) (unit(row.unit)) }
                        td data-name="equivalent" {
                            @if let Some(drag) = answer.drag_coefficient(row.named, row.value) {
                                @let (value, interval) = value_and_interval(&drag);
                                "drag coefficient " span.value { (value) } " (95 %: " (interval) ")"
                            }
                        }
                    }
                }
            }
        }
        @for named in answer.diagnosis.effects() {
            @let evidence = &named.evidence;
            p.how {
                code { (named.effect.name) } ": the criterion falls by " (format!("{:.0}", evidence.bic_gain)) " by having it"
                @if let Some(next) = &evidence.runner_up {
                    "; with " code { (next) } " in its place it stands " (format!("{:.0}", evidence.runner_up_bic_gap)) " higher"
                }
                ". " (chance(evidence.p_value))
            }
        }
    }
}

fn chance(probability: f64) -> String {
    if probability < 1e-12 {
        return "Not explained by chance.".into();
    }
    format!("Probability by chance: {}.", signed(&format!("{probability:.1e}")))
}

pub fn parameters(answer: &Answer) -> Markup {
    // With a law these are what was tuned together with it.
    let all = answer.parameters();
    let own: Vec<_> = all.iter().filter(|p| !p.name.contains('.')).collect();
    let without = if answer.found().is_some() { "tuned without the law" } else { "tuned without effects" };
    html! {
        @if !own.is_empty() {
            table {
                (heads(answer, "parameter", &["given", without, "now", "95 % interval"]))
                tbody {
                    @for p in own {
                        @let of = |v: f64| value_and_interval(&Value { object: None, value: v, interval95: p.interval95 });
                        tr {
                            th scope="row" { (p.name) }
                            (of_object(answer, Some(p.object)))
                            td data-name="given" { (number(p.given)) }
                            td data-name=(without) { (of(p.before).0) }
                            td data-name="now" { span.value { (of(p.value).0) (unit(&p.unit)) } }
                            td.number data-name="95 % interval" { (of(p.value).1) }
                        }
                    }
                }
            }
        }
    }
}

/// Every test with its threshold.
pub fn adequacy(tests: &[Test]) -> Markup {
    html! {
        table {
            thead { tr { th { "test" } th { "value" } th { "passes up to" } th { "against the threshold" } th { "" } } }
            tbody {
                @for test in tests {
                    tr {
                        th scope="row" { (test.name) }
                        td data-name="value" { (with_decimals(test.value, 2)) }
                        td data-name="passes up to" { (format!("{:.2}", test.threshold)) }
                        td.track { (bar(test)) }
                        td.state { @if test.passed { "\u{2713} passed" } @else { "\u{2717} failed" } }
                    }
                }
            }
        }
    }
}

fn bar(test: &Test) -> Markup {
    let (width, height) = (150.0, 26.0);
    let most = 1.15 * test.value.max(test.threshold).max(f64::MIN_POSITIVE);
    let x = Axis::new((0.0, most), (4.0, width - 4.0));
    let mut svg = Svg::new(width, height);
    let class = if test.passed { "bar after" } else { "bar before" };
    svg.area(class, (x.at(0.0), 7.0), (x.at(test.value.max(0.0)), 19.0));
    svg.line("axis", (x.at(0.0), 3.0), (x.at(0.0), 23.0));
    svg.line("limit", (x.at(test.threshold), 2.0), (x.at(test.threshold), 24.0));
    svg.finish("bounds", &format!("{} against its threshold", test.name))
}
