//! What is left of the recordings over time: with the simulation, and in units of the noise, before and after.

use maud::{Markup, html};
use tunenet_core::diagnose::Explained;
use tunenet_core::observation::Kind;

use crate::view::html::axis::Axis;
use crate::view::html::panel::{ABOVE, BELOW, Panel, left_edge};
use crate::view::html::points::thinned;
use crate::view::html::series::{Series, Size, about_inputs};
use crate::view::html::svg::{Anchor, Svg};

/// Height of the strip of one channel.
const STRIP: f64 = 84.0;
/// Most recordings that are drawn.
const MOST: usize = 12;
const MOST_POINTS: usize = 600;
/// Noise stays within this many standard deviations in 95 of 100 samples.
const BAND: f64 = 2.0;
/// A misfit below so many standard deviations may be noise.
const NOISY: f64 = 1.5;

/// The recordings to draw: all, or those that disagree most before, in their order.
pub fn chosen(all: &[Explained]) -> Vec<&Explained> {
    let mut order: Vec<usize> = (0..all.len()).collect();
    order.sort_by(|&a, &b| misfit(&all[b], &all[b].before).total_cmp(&misfit(&all[a], &all[a].before)));
    order.truncate(MOST);
    order.sort_unstable();
    order.into_iter().map(|i| &all[i]).collect()
}

/// Root mean square of what counted of `residual`.
fn misfit(one: &Explained, residual: &[f64]) -> f64 {
    let (sum, count) = counted(one, residual).fold((0.0, 0.0), |(s, n), v| (s + v * v, n + 1.0));
    (sum / f64::max(count, 1.0)).sqrt()
}

fn counted<'a>(one: &'a Explained, residual: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
    residual.iter().zip(&one.kept).filter(|(_, kept)| **kept).map(|(v, _)| *v)
}

/// The channels that counted.
fn channels(one: &Explained) -> Vec<usize> {
    let width = one.noise.len();
    (0..width).filter(|&c| one.kept.iter().skip(c).step_by(width).any(|kept| *kept)).collect()
}

/// Its name, and which of its flights it is where they were cut apart.
pub fn label(one: &Explained) -> String {
    one.segment.map_or_else(|| one.name.clone(), |flight| format!("{}, flight {flight}", one.name))
}

fn title(one: &Explained) -> String {
    format!("{}{}", label(one), if one.held_out { ", held out" } else { "" })
}

/// The channels that are drawn: of an arm every joint's torque, else the one that disagrees most.
fn drawn(one: &Explained) -> Vec<usize> {
    if one.seen.kind() == Kind::Joints { channels(one) } else { vec![worst(one)] }
}

/// Each recording with the simulation, in the channel where they disagree most, or every joint of an arm; `both` where before differs from after
/// by what was `added`.
pub fn overlays(shown: &[&Explained], both: bool, added: &str) -> Markup {
    let of = |one: &Explained| {
        let before = both.then_some(&one.before[..]);
        drawn(one)
            .into_iter()
            .map(|channel| (Series::explained(one, channel, before), one.held_out))
            .collect::<Vec<_>>()
    };
    let (series, held_out): (Vec<Series>, Vec<bool>) = shown.iter().flat_map(|one| of(one)).unzip();
    html! {
        div.grid {
            @for (series, held_out) in series.iter().zip(held_out) {
                figure {
                    figcaption.above { (series.title) @if held_out { ", held out" } }
                    (series.draw(Size::Narrow, 1.0))
                }
            }
            p.how {
                "Dots are measured: the torque of every joint of an arm, otherwise the channel with the largest misfit, or with the largest motion if there is none. "
                @if both {
                    "The dashed line is the simulation without the " (added) ", parameters tuned; the solid line has the " (added) "."
                } @else {
                    "The line is the tuned simulation."
                }
                @if shown.iter().any(|one| !one.nuisances.is_empty()) { " The start of each recording is fitted." }
                (about_inputs(&series))
            }
        }
    }
}

/// The channel with the greatest misfit; where all are only noise, the one that moves farthest.
fn worst(one: &Explained) -> usize {
    let width = one.noise.len();
    let size = |c: usize| -> f64 {
        let square = |(i, r): (usize, &f64)| if one.kept[i] && i % width == c { r * r } else { 0.0 };
        (one.before.iter().enumerate().map(square).sum::<f64>() / one.seen.len().max(1) as f64).sqrt()
    };
    let travelled = |c: usize| {
        let (low, high) = one.seen.column(c).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        high - low
    };
    let most = |of: &dyn Fn(usize) -> f64| channels(one).into_iter().max_by(|&a, &b| of(a).total_cmp(&of(b)));
    let found = most(&|c| size(c) * one.noise[c]).filter(|&c| size(c) > NOISY);
    found.or_else(|| most(&travelled)).unwrap_or(0)
}

/// The residuals of each recording over time, all on the same scales.
pub fn residuals(shown: &[&Explained], all: usize, both: bool, dots: &str) -> Markup {
    let greatest = |one: &&Explained| {
        let before = counted(one, &one.before).filter(|_| both);
        before.chain(counted(one, &one.after)).map(f64::abs).fold(0.0, f64::max)
    };
    let limit = round(shown.iter().map(greatest).fold(3.0, f64::max));
    let span = shown.iter().map(|one| range(one).1 - range(one).0).fold(0.0, f64::max);
    html! {
        div.grid {
            @for one in shown {
                figure { figcaption.above { (title(one)) } (strips(one, limit, span, both)) }
            }
            p.how {
                "Measured \u{2212} simulated in standard deviations \u{3c3} of the noise, every recording on the same scales. "
                @if both { "Dashed: before. " }
                "Dots: " (dots) ". The band is \u{b1}2 \u{3c3}"
                @if shown.iter().any(|one| !one.events.is_empty()) { "; ticks on the lower edges mark contacts" }
                ". Only noise should be left: 95 of 100 dots in the band, without a pattern."
                @if all > shown.len() { " The " (shown.len()) " of " (all) " recordings that disagreed most are drawn." }
            }
        }
    }
}

/// The next round number, of which a few ticks are multiples.
fn round(value: f64) -> f64 {
    let power = 10f64.powf(value.log10().floor());
    [1.0, 1.5, 2.0, 3.0, 5.0, 7.0].map(|m| m * power).into_iter().find(|v| *v >= value).unwrap_or(10.0 * power)
}

fn range(one: &Explained) -> (f64, f64) {
    let clock = one.seen.clock();
    (clock.first().copied().unwrap_or(0.0), clock.last().copied().unwrap_or(1.0))
}

/// One strip for every channel, one below the other.
fn strips(one: &Explained, limit: f64, span: f64, both: bool) -> Markup {
    let (channels, width) = (channels(one), Size::Narrow.width());
    let begin = range(one).0;
    let left = left_edge(&[(-limit, limit)]);
    let x = Axis::new((begin, begin + span), (left, width - 10.0));
    let height = |i: usize| i as f64 * (STRIP + ABOVE + 6.0);
    let mut svg = Svg::new(width, height(channels.len()) + BELOW);
    let x_name = if one.seen.kind() == Kind::EventTimes { "bounce, counted from 0" } else { "time, s" };
    for (i, &channel) in channels.iter().enumerate() {
        let top = height(i) + ABOVE;
        let panel = Panel { x: x.clone(), y: Axis::new((-limit, limit), (top + STRIP, top)) };
        let (edge, right) = panel.x.places();
        svg.area("band", (edge, panel.y.at(BAND)), (right, panel.y.at(-BAND)));
        let name = format!("{}: residual / \u{3c3}", one.seen.channels()[channel].name);
        panel.frame(&mut svg, (i + 1 == channels.len()).then_some(x_name), &name);
        panel.level(&mut svg, "zero", 0.0);
        let points = |residual: &[f64]| {
            let counted = (channel..residual.len()).step_by(one.noise.len()).filter(|&k| one.kept[k]);
            let all: Vec<_> = counted.map(|k| (one.seen.clock()[k / one.noise.len()], residual[k])).collect();
            panel.spots(&thinned(&all, MOST_POINTS))
        };
        if both {
            svg.path("line thin before", &points(&one.before), false);
            if i == 0 {
                svg.text("name", (right, top - 12.0), Anchor::End, "dashed before, dots after");
            }
        }
        svg.dots("dot small", &points(&one.after));
        for contact in one.events.iter().filter(|t| (begin..=begin + span).contains(*t)) {
            let (at, floor) = (panel.x.at(*contact), panel.y.places().0);
            svg.line("event", (at, floor), (at, floor - 9.0));
        }
    }
    svg.finish("narrow", &format!("{}: residuals before and after over time", one.name))
}

/// A place of the motion, with the misfit there before and after.
pub struct Place {
    pub name: String,
    pub before: f64,
    pub after: f64,
}

/// Flights by the number of contacts before them; the last name is that of all later ones.
const FLIGHTS: [&str; 5] = ["before the 1st contact", "after the 1st", "after the 2nd", "after the 3rd", "later"];
/// Thirds of a recording's height.
const THIRDS: [&str; 3] = ["low third", "middle third", "high third"];

/// The misfit by axis, by flight between contacts and by height.
pub fn places(all: &[Explained]) -> Vec<(&'static str, Vec<Place>)> {
    let axes: Vec<String> =
        all.first().map_or_else(Vec::new, |one| one.seen.channels().iter().map(|c| c.name.clone()).collect());
    let axis = |one: &Explained, i: usize| Some(i % one.noise.len());
    let flight = |one: &Explained, i: usize| {
        let at = one.seen.clock()[i / one.noise.len()];
        let passed = one.events.iter().filter(|t| **t <= at).count();
        (!one.events.is_empty()).then(|| passed.min(FLIGHTS.len() - 1))
    };
    let third = |one: &Explained, i: usize| {
        let width = one.noise.len();
        let heights = || one.seen.column(width - 1);
        let (low, high) = heights().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        let share = (one.seen.row(i / width)[width - 1] - low) / (high - low).max(f64::MIN_POSITIVE);
        let third = if share < 1.0 / 3.0 { 0 } else { 1 + usize::from(share >= 2.0 / 3.0) };
        (one.seen.kind() == Kind::Positions).then_some(third)
    };
    let groups = [
        ("by axis", grouped(all, &axes, axis)),
        ("by flight", grouped(all, &FLIGHTS, flight)),
        ("by height of the recording", grouped(all, &THIRDS, third)),
    ];
    groups.into_iter().filter(|(_, places)| places.len() > 1).collect()
}

/// The misfit of all values that `of` puts into the group of each name; groups without values are left out.
fn grouped(all: &[Explained], names: &[impl ToString], of: impl Fn(&Explained, usize) -> Option<usize>) -> Vec<Place> {
    let mut sums = vec![(0.0, 0.0, 0.0); names.len()];
    for one in all {
        for i in (0..one.kept.len()).filter(|&i| one.kept[i]) {
            let Some(sum) = of(one, i).and_then(|group| sums.get_mut(group)) else { continue };
            sum.0 += one.before[i].powi(2);
            sum.1 += one.after[i].powi(2);
            sum.2 += 1.0;
        }
    }
    let mean = |sum: f64, count: f64| (sum / count).sqrt();
    let groups = names.iter().zip(sums).filter(|(_, (.., count))| *count > 0.0);
    groups.map(|(name, (b, a, n))| Place { name: name.to_string(), before: mean(b, n), after: mean(a, n) }).collect()
}
