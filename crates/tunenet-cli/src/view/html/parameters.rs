//! The parameters: before, tuned, interval, bounds, and how well the data pin them down.

use maud::{Markup, html};
use tunenet_core::simulator::Parameter;
use tunenet_core::tune::{Estimate, Outcome, Status};

use super::axis::Axis;
use super::svg::Svg;
use super::verdict::{interval, number, quantity, value};

/// An interval wider than this share of the bounds, or than the value itself, leaves much open.
const WEAK_SHARE: f64 = 0.25;

/// A person's word for how well a parameter is known.
fn status(estimate: &Estimate, outcome: &Outcome) -> &'static str {
    let (low, high) = estimate.interval95;
    let (min, max) = estimate.bounds;
    if !estimate.identified {
        let without_effect = estimate.status == Status::NoEffect || !outcome.free.contains(&estimate.name);
        return if without_effect { "no effect" } else { "not determined" };
    }
    if estimate.value <= min || estimate.value >= max {
        "at bound"
    } else if high - low > (WEAK_SHARE * (max - min)).min(estimate.value.abs()) {
        "weak"
    } else {
        "determined"
    }
}

pub fn parameters(outcome: &Outcome) -> Markup {
    html! {
        table {
            thead { tr {
                th { "parameter" } th { "before" } th { "tuned" } th { "95 % interval" } th { "bounds" } th { "within bounds" }
                th { "status" }
            } }
            tbody {
                @for estimate in &outcome.parameters {
                    tr {
                        th scope="row" { (estimate.name) }
                        td data-name="before" { (number(estimate.before)) }
                        td data-name="tuned" {
                            @if estimate.identified { span.value { (value(estimate)) } } @else { "unknown" }
                        }
                        td data-name="95 % interval" { (interval(estimate)) }
                        td data-name="bounds" { (number(estimate.bounds.0)) " to " (number(estimate.bounds.1)) @if estimate.unit != "1" { " " (estimate.unit) } }
                        td.track data-name="within bounds" { (track(estimate)) }
                        td.state data-name="status" { (status(estimate, outcome)) }
                    }
                }
            }
        }
        p.how {
            "The bar spans the bounds: the dashed mark is the value before, the dot the tuned one, the thick line its 95 % interval. "
            "The interval holds if the simulation can reproduce the real system; it does not cover missing effects."
        }
    }
}

/// The bounds as a bar, with the interval and both values on it.
fn track(estimate: &Estimate) -> Markup {
    let (width, height, middle) = (150.0, 26.0, 13.0);
    let x = Axis::new(estimate.bounds, (8.0, width - 8.0));
    let mut svg = Svg::new(width, height);
    let (min, max) = (x.at(estimate.bounds.0), x.at(estimate.bounds.1));
    svg.line("axis", (min, middle), (max, middle));
    for end in [min, max] {
        svg.line("axis", (end, middle - 5.0), (end, middle + 5.0));
    }
    let (low, high) = (x.at(estimate.interval95.0), x.at(estimate.interval95.1));
    svg.line("thick after", (low, middle), (high, middle));
    let before = x.at(estimate.before.clamp(estimate.bounds.0, estimate.bounds.1));
    svg.line("mark line before", (before, middle - 9.0), (before, middle + 9.0));
    if estimate.identified {
        svg.dots("knob after", &[(x.at(estimate.value), middle)]);
    }
    svg.finish("bounds", &format!("{} within its bounds", estimate.name))
}

/// What every recording brought of its own and the fit estimated along with the parameters.
pub fn estimated(names: &[String], own: &[Vec<Parameter>]) -> Markup {
    html! {
        table {
            thead { tr { th { "recording" } th { "nuisance parameters" } } }
            tbody {
                @for (name, each) in names.iter().zip(own).filter(|(_, own)| !own.is_empty()) {
                    tr {
                        th.file scope="row" { (name) }
                        td {
                            @for (i, p) in each.iter().enumerate() {
                                @if i > 0 { ", " }
                                (p.name.replace('_', " ")) " " span.state { (quantity(p.value, &p.unit)) }
                            }
                        }
                    }
                }
            }
        }
    }
}
