//! Small drawings: a ladder of gaps, bars with a limit, profiles, joint regions, autocorrelations.

use maud::Markup;
use tunenet_core::simulator::Parameter;
use tunenet_core::tune::{Contour, Profile};

use super::axis::Axis;
use super::panel::{ABOVE, BELOW, Panel, left_edge};
use super::series::Size;
use super::svg::{Anchor, Svg, bold_width, text_width};

const ROW: f64 = 30.0;
/// From this ratio between greatest and least on, a ladder goes by powers of ten.
const WIDE_RATIO: f64 = 12.0;
/// A misfit is drawn up to this many times the cut.
const HIGHEST: f64 = 2.6;

/// One rung of a ladder, or one bar.
pub struct Rung {
    pub name: String,
    pub class: &'static str,
    pub value: f64,
    pub shown: String,
}

/// Values of one unit as rungs, the last one also as a line that the others are held against.
pub fn ladder(rungs: &[Rung], label: &str) -> Markup {
    let width = Size::Narrow.width();
    let left = rungs.iter().map(|r| text_width(&r.name)).fold(0.0, f64::max) + 8.0;
    let room = rungs.iter().map(|r| bold_width(&r.shown)).fold(0.0, f64::max) + 14.0;
    let positive = |r: &&Rung| r.value > 0.0;
    let least = rungs.iter().filter(positive).map(|r| r.value).fold(f64::INFINITY, f64::min);
    let most = rungs.iter().map(|r| r.value).fold(0.0, f64::max);
    let logarithmic = most > WIDE_RATIO * least;
    let of = |value: f64| if logarithmic { value.max(least).log10() } else { value };
    let low = if logarithmic { of(least) - 0.15 } else { 0.0 };
    let x = Axis::new((low, of(most)), (left, width - room));
    let bottom = 14.0 + ROW * rungs.len() as f64;
    let mut svg = Svg::new(width, bottom + 26.0);
    for (i, rung) in rungs.iter().enumerate() {
        let y = 14.0 + ROW * (i as f64 + 0.5);
        svg.text("row", (0.0, y + 4.5), Anchor::Start, &rung.name);
        svg.line(&format!("rung {}", rung.class), (left, y), (x.at(of(rung.value)), y));
        svg.dots(&format!("knob {}", rung.class), &[(x.at(of(rung.value)), y)]);
        svg.text("value", (x.at(of(rung.value)) + 10.0, y + 4.5), Anchor::Start, &rung.shown);
    }
    if let Some(floor) = rungs.last() {
        let at = x.at(of(floor.value));
        svg.line("limit", (at, 8.0), (at, bottom));
    }
    svg.line("axis", (left, 8.0), (left, bottom));
    let scale = if logarithmic { "log scale" } else { "linear scale from 0" };
    svg.text("name", (left, bottom + 18.0), Anchor::Start, scale);
    svg.finish("small", label)
}

/// Bars from 0 with a limit that they should stay below (or reach).
pub fn bars(rungs: &[Rung], (limit, limit_name): (f64, &str), label: &str) -> Markup {
    let width = Size::Narrow.width();
    let left = (rungs.iter().map(|r| text_width(&r.name)).fold(0.0, f64::max) + 8.0).min(width / 2.0);
    let room = rungs.iter().map(|r| bold_width(&r.shown)).fold(0.0, f64::max) + 14.0;
    let most = rungs.iter().map(|r| r.value).fold(limit * 1.15, f64::max);
    let x = Axis::new((0.0, most), (left, width - room));
    let bottom = 14.0 + ROW * rungs.len() as f64;
    let mut svg = Svg::new(width, bottom + 26.0);
    for (i, rung) in rungs.iter().enumerate() {
        let y = 14.0 + ROW * (i as f64 + 0.5);
        svg.text("row", (0.0, y + 4.5), Anchor::Start, &rung.name);
        svg.area(&format!("bar {}", rung.class), (left, y - 8.0), (x.at(rung.value), y + 8.0));
        svg.text("value", (x.at(rung.value).max(x.at(limit)) + 8.0, y + 4.5), Anchor::Start, &rung.shown);
    }
    svg.line("axis", (left, 8.0), (left, bottom));
    svg.line("limit", (x.at(limit), 8.0), (x.at(limit), bottom));
    let end = x.at(limit) + text_width(limit_name) / 2.0 + 2.0;
    let (at, anchor) = if end > width { (width, Anchor::End) } else { (x.at(limit), Anchor::Middle) };
    svg.text("name", (at, bottom + 18.0), anchor, limit_name);
    svg.finish("small", label)
}

/// A panel of the small size: the frame from `left` on, `tall` high.
fn small(x: (f64, f64), y: (f64, f64), tall: f64) -> (Svg, Panel) {
    let width = Size::Narrow.width();
    let panel = Panel { x: Axis::new(x, (left_edge(&[y]), width - 14.0)), y: Axis::new(y, (ABOVE + tall, ABOVE)) };
    (Svg::new(width, ABOVE + tall + BELOW), panel)
}

/// The misfit over one parameter, with where 95 % is cut and the values before and after.
pub fn profile(profile: &Profile, parameter: &Parameter, value: f64) -> Markup {
    let cut = profile.cut95;
    let highest = profile.curve.iter().map(|p| p.1).fold(1.15 * cut, f64::max).min(HIGHEST * cut);
    let values = || profile.curve.iter().map(|p| p.0).chain([value]);
    let range = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
    let (mut svg, panel) = small(range, (0.0, highest), 180.0);
    let (low, high) = profile.inside(cut);
    let ((_, right), (bottom, top)) = (panel.x.places(), panel.y.places());
    svg.area("band", (panel.x.at(low), bottom), (panel.x.at(high), top));
    panel.frame(&mut svg, Some(&panel.x.title(&parameter.name, &parameter.unit)), "misfit");
    panel.level(&mut svg, "limit", cut);
    svg.text("label", (right - 3.0, panel.y.at(cut) - 6.0), Anchor::End, "95 %");
    svg.path("line after", &panel.spots(&below(&profile.curve, highest)), false);
    svg.line("line after", (panel.x.at(value), bottom), (panel.x.at(value), bottom - 12.0));
    svg.dots("knob after", &[(panel.x.at(value), bottom)]);
    let (low, high) = profile.inside(profile.cut50);
    svg.line("thick after", (panel.x.at(low), bottom), (panel.x.at(high), bottom));
    svg.finish("small", &format!("misfit over {} with its 95 % cut", parameter.name))
}

/// The part of a curve up to a height, ending on it.
fn below(curve: &[(f64, f64)], height: f64) -> Vec<(f64, f64)> {
    let mut kept = Vec::with_capacity(curve.len());
    let crossing = |a: &(f64, f64), b: &(f64, f64)| (a.0 + (height - a.1) / (b.1 - a.1) * (b.0 - a.0), height);
    for (i, point) in curve.iter().enumerate() {
        let before = i.checked_sub(1).map(|b| &curve[b]);
        match before {
            Some(before) if (before.1 > height) != (point.1 > height) => kept.push(crossing(before, point)),
            _ => {}
        }
        if point.1 <= height {
            kept.push(*point);
        }
    }
    kept
}

/// Which pairs of values fit together: the regions of two parameters at several levels.
pub fn regions(contours: &[&Contour], parameters: (&Parameter, &Parameter)) -> Markup {
    let edge = || contours.iter().flat_map(|c| &c.edge);
    let over = |of: fn(&(f64, f64)) -> f64| {
        let (low, high) = edge().map(of).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        let room = 0.08 * (high - low);
        (low - room, high + room)
    };
    let (mut svg, panel) = small(over(|p| p.0), over(|p| p.1), 240.0);
    let titles =
        (panel.x.title(&parameters.0.name, &parameters.0.unit), panel.y.title(&parameters.1.name, &parameters.1.unit));
    panel.frame(&mut svg, Some(&titles.0), &titles.1);
    for contour in contours {
        let spots = panel.spots(&contour.edge);
        let class = if contour.level > 0.9 { "line after" } else { "thick after" };
        svg.path(class, &spots, true);
        // One label at the top, the other at the foot: where a bound cuts both regions, their tops are one.
        let height = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
        let place = if contour.level > 0.9 { spots.iter().min_by(height) } else { spots.iter().max_by(height) };
        let (x, y) = place.copied().unwrap_or_default();
        let y = if contour.level > 0.9 { y + 18.0 } else { y - 8.0 };
        svg.text("label after", (x, y), Anchor::Middle, &format!("{} %", 100.0 * contour.level));
    }
    if let Some(contour) = contours.first() {
        svg.dots("knob after", &[panel.spot(contour.best)]);
    }
    let label = format!("joint regions of {} and {}", parameters.0.name, parameters.1.name);
    svg.finish("small", &label)
}

/// Autocorrelation of residuals over lags from 1, with the envelope that white noise keeps.
pub fn autocorrelation(values: &[f64], envelope: f64) -> Markup {
    let lowest = values.iter().copied().fold(-1.3 * envelope, f64::min);
    let highest = values.iter().skip(1).copied().fold(1.3 * envelope, f64::max);
    let lags = values.len() as f64 - 1.0;
    let room = 0.06 * (highest - lowest);
    let (mut svg, panel) = small((0.3, lags + 0.7), (lowest - room, highest + room), 180.0);
    let (left, right) = panel.x.places();
    svg.area("band", (left, panel.y.at(envelope)), (right, panel.y.at(-envelope)));
    panel.frame(&mut svg, Some("lag, samples"), "autocorrelation of the residual");
    for edge in [-envelope, envelope] {
        panel.level(&mut svg, "limit", edge);
    }
    panel.level(&mut svg, "zero", 0.0);
    for (lag, value) in values.iter().enumerate().skip(1) {
        let place = panel.spot((lag as f64, *value));
        svg.line("stem", (place.0, panel.y.at(0.0)), place);
        svg.dots("dot end", &[place]);
    }
    svg.finish("small", "autocorrelation of the residual with its 95 % envelope")
}

#[cfg(test)]
mod tests {
    use super::below;

    #[test]
    fn a_curve_is_cut_where_it_leaves() {
        let curve = [(0.0, 4.0), (1.0, 0.0), (2.0, 1.0), (3.0, 3.0)];
        assert_eq!(below(&curve, 2.0), [(0.5, 2.0), (1.0, 0.0), (2.0, 1.0), (2.5, 2.0)]);
    }
}
