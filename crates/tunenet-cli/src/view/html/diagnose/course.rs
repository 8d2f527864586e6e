//! The force of a law along its variables, with its band, what the recordings ask for, and the other laws of the answer.

use maud::{Markup, html};
use tunenet_core::law::{Course, Member, Sample};
use tunenet_core::statistics::extent;

use crate::view::html::axis::Axis;
use crate::view::html::panel::{ABOVE, BELOW, Panel, left_edge};
use crate::view::html::svg::Svg;

const WIDTH: f64 = 480.0;
const HEIGHT: f64 = 270.0;
/// How far intervals may widen the scale beyond what the law covers, in units of that.
const ROOM: f64 = 0.8;

/// The charts of one of `members`; the first one has the legend.
pub fn courses(member: &Member, members: &[Member]) -> Markup {
    let others = |course: &Course| -> Vec<&Course> {
        let all = members.iter().filter(|other| !std::ptr::eq(*other, member)).flat_map(|other| &other.courses);
        all.filter(|other| compares(course, other)).collect()
    };
    let drawn: Vec<(&Course, Vec<&Course>)> = member.courses.iter().map(|course| (course, others(course))).collect();
    let undetermined = drawn.iter().any(|(course, _)| course.bins.is_empty());
    let is_first = members.first().is_some_and(|first| std::ptr::eq(first, member));
    html! {
        @if !drawn.is_empty() {
            div.grid {
                @for (course, others) in &drawn {
                    figure { figcaption.above { (caption(course)) } (drawing(course, others)) }
                }
                @if is_first {
                    p.how {
                        "The line is the law, its band the 95 % interval of all its numbers together. Each cross is the estimate of the "
                        "recordings themselves in a range of the variable: the law there, and what the recordings ask for beyond it on average. "
                        "Its width is the range, its height the 95 % interval of the noise; parameters and initial states are those of the fit. "
                        "The scale covers 98 % of what was visited."
                        @if drawn.iter().any(|(_, others)| !others.is_empty()) { " Dotted: the other laws of the answer, where they lie on this scale; each has fitted parameters of its own." }
                    }
                }
                @if undetermined { p.how { "Where there is no cross, the recordings do not determine the force in single ranges." } }
            }
        }
    }
}

/// Whether both are one component along one variable alone, so that they can be drawn on one scale.
fn compares(one: &Course, other: &Course) -> bool {
    one.held.is_none() && other.held.is_none() && (&one.component, &one.variable) == (&other.component, &other.variable)
}

fn caption(course: &Course) -> String {
    let held = course.held.as_ref().map_or_else(String::new, |(name, value)| format!(", at {name} = {value:.3}"));
    format!("Along {} over {}{held}", course.component, course.variable)
}

fn drawing(course: &Course, others: &[&Course]) -> Markup {
    let (first, last) = extent(course.curve.iter().map(|s| s.at));
    let (least, greatest) = extent(course.curve.iter().map(|s| s.value));
    let room = ROOM * (greatest - least).max(0.5 * greatest.abs().max(least.abs()));
    let within = |v: f64| v.clamp(least - room, greatest + room);
    // A law with other parameters of the simulator may have quite another force.
    let is_near = |other: &&&Course| other.curve.iter().all(|s| s.value == within(s.value));
    let others: Vec<&&Course> = others.iter().filter(is_near).collect();
    let rivals = others.iter().flat_map(|other| other.curve.iter().map(|s| s.value));
    let intervals = course.curve.iter().chain(course.bins.iter().map(|bin| &bin.estimate));
    let reached = intervals.flat_map(|s| [s.value, s.interval95.0, s.interval95.1]).chain(rivals).map(within);
    let y = Axis::around(reached, (HEIGHT - BELOW, ABOVE), 0.05);
    let left = left_edge(&[(y.low(), y.high())]);
    let panel = Panel { x: Axis::new((first, last), (left, WIDTH - 10.0)), y };
    let spot = |at: f64, value: f64| panel.spot((at.clamp(first, last), within(value)));
    let mut svg = Svg::new(WIDTH, HEIGHT);
    let bound = |get: &dyn Fn(&Sample) -> f64| course.curve.iter().map(|s| spot(s.at, get(s))).collect::<Vec<_>>();
    let (low, mut high) = (bound(&|s| s.interval95.0), bound(&|s| s.interval95.1));
    high.reverse();
    svg.path("band bare", &[low, high].concat(), true);
    let title = panel.x.title(&course.variable, &course.variable_unit);
    panel.frame(&mut svg, Some(&title), &panel.y.title("law", &course.unit));
    if panel.y.low() < 0.0 && panel.y.high() > 0.0 {
        panel.level(&mut svg, "zero", 0.0);
    }
    for other in others {
        let points: Vec<_> = other.curve.iter().map(|s| spot(s.at, s.value)).collect();
        svg.path("limit", &points, false);
    }
    svg.path("line after", &bound(&|s| s.value), false);
    for bin in &course.bins {
        let Sample { at, value, interval95 } = bin.estimate;
        svg.line("stem", spot(at, interval95.0), spot(at, interval95.1));
        svg.line("stem", spot(bin.range.0, value), spot(bin.range.1, value));
    }
    svg.finish("small", &format!("{}: the law, its band and the estimate of the recordings", caption(course)))
}
