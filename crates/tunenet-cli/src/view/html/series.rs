//! A recording with the simulation before and after, and what is left over below it on the same axis.

use maud::{Markup, html};
use tunenet_core::diagnose::Explained;
use tunenet_core::observation::{Kind, Observation};
use tunenet_core::tune::Comparison;

use super::axis::Axis;
use super::driving::{self, Driving, MOST_INPUTS, MOST_SAMPLES};
use super::label::Labels;
use super::panel::{ABOVE, BELOW, Panel, left_edge};
use super::points::{Points, thinned};
use super::svg::{Anchor, Svg};

/// Most dots of one drawing; beyond, an even choice is drawn.
const MOST_DOTS: usize = 2000;
/// Up to this many stand apart and are drawn larger.
const FEW_DOTS: usize = 60;
/// Noise stays within this many standard deviations in 95 of 100 samples.
const BAND: f64 = 2.0;

/// One channel of one recording, ready to be drawn.
pub struct Series {
    /// Above the drawing: `drop.csv, z`.
    pub title: String,
    x_name: String,
    y_name: String,
    y_unit: String,
    measured: Points,
    before: Points,
    after: Points,
    /// What is written on the line after.
    after_name: &'static str,
    residual: Points,
    events: Vec<f64>,
    /// What drove the recording, at most [`MOST_INPUTS`] of it.
    inputs: Vec<Driving>,
    /// How many inputs there are beyond these.
    undrawn: usize,
}

/// How large to draw.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Size {
    /// Over the whole page.
    Wide,
    /// Over half of it, or over a telephone.
    Narrow,
}

impl Size {
    pub fn width(self) -> f64 {
        if self == Self::Wide { 760.0 } else { 368.0 }
    }
}

impl Series {
    /// Every channel that moves, of a recording that was tuned to.
    pub fn of(name: &str, comparison: &Comparison) -> Vec<Self> {
        let seen = &comparison.seen;
        let moving = (0..seen.channels().len()).filter(|c| comparison.moves[*c]);
        moving
            .map(|channel| {
                let curve = |values: &[f64]| column(seen, &comparison.clock, values, channel);
                let clock = seen.clock().iter().copied();
                let width = seen.channels().len();
                let residual = comparison.residual.iter().copied().skip(channel).step_by(width);
                Self {
                    before: curve(&comparison.before),
                    after: curve(&comparison.after),
                    residual: clock.zip(residual).collect(),
                    events: comparison.events.clone(),
                    ..Self::measured(name, seen, channel)
                }
            })
            .collect()
    }

    /// Every channel of a recording that was not used.
    pub fn unused(name: &str, seen: &Observation) -> Vec<Self> {
        (0..seen.channels().len()).map(|channel| Self::measured(name, seen, channel)).collect()
    }

    /// One channel of a recording, explained; `before` only where it differs.
    pub fn explained(one: &Explained, channel: usize, before: Option<&[f64]>) -> Self {
        let (seen, width) = (&one.seen, one.noise.len());
        let simulated = |residual: &[f64]| {
            let counted = (channel..residual.len()).step_by(width).filter(|&i| one.kept[i]);
            let spots = counted.map(|i| (seen.clock()[i / width], seen.values()[i] - residual[i] * one.noise[channel]));
            intervals(seen.kind(), spots.collect())
        };
        Self {
            before: before.map_or_else(Vec::new, simulated),
            after: simulated(&one.after),
            after_name: if before.is_some() { "improved" } else { "tuned" },
            ..Self::measured(&one.name, seen, channel)
        }
    }

    fn measured(name: &str, seen: &Observation, channel: usize) -> Self {
        let about = &seen.channels()[channel];
        let (x_name, y_name) = if seen.kind() == Kind::EventTimes {
            ("bounce, counted from 0".into(), "interval before it".into())
        } else {
            ("time, s".into(), about.name.clone())
        };
        let mut inputs = Driving::of(seen);
        let undrawn = inputs.len().saturating_sub(MOST_INPUTS);
        inputs.truncate(MOST_INPUTS);
        let title = if seen.channels().len() > 1 { format!("{name}, {}", about.name) } else { name.to_string() };
        Self {
            title,
            x_name,
            y_name,
            y_unit: about.unit.clone(),
            measured: column(seen, seen.clock(), seen.values(), channel),
            before: Vec::new(),
            after: Vec::new(),
            after_name: "tuned",
            residual: Vec::new(),
            events: Vec::new(),
            inputs,
            undrawn,
        }
    }

    /// The greatest residual, in standard deviations.
    pub fn greatest(&self) -> f64 {
        self.residual.iter().map(|r| r.1.abs()).fold(0.0, f64::max)
    }

    /// Whether only a choice of the samples is drawn.
    fn is_thinned(&self) -> bool {
        self.measured.len().max(self.residual.len()) > MOST_DOTS
    }

    /// Few dots may be large.
    fn dot(&self, class: &str) -> String {
        if self.measured.len() > FEW_DOTS { class.into() } else { format!("{class} few") }
    }

    /// The drawing; residuals on a scale of ± `limit` standard deviations.
    pub fn draw(&self, size: Size, limit: f64) -> Markup {
        let width = size.width();
        let (tall, low) = if size == Size::Wide { (270.0, 110.0) } else { (200.0, 96.0) };
        let curves = || self.measured.iter().chain(&self.before).chain(&self.after);
        let y = Axis::around(curves().map(|p| p.1), (ABOVE + tall, ABOVE), 0.05);
        let ranges = [(y.low(), y.high()), (-limit, limit)].into_iter().chain(self.inputs.iter().map(Driving::range));
        let left = left_edge(&ranges.collect::<Vec<_>>());
        let x = Axis::around(curves().chain(&self.residual).map(|p| p.0), (left, width - 10.0), 0.0);
        let top = Panel { x: x.clone(), y };
        let (with_residual, driven) = (!self.residual.is_empty(), !self.inputs.is_empty());
        // Where the panels of the channel end, and those of the inputs begin.
        let end = ABOVE + tall + if with_residual { ABOVE + low + 6.0 } else { 0.0 };
        let mut svg = Svg::new(width, end + driving::height(&self.inputs) + BELOW);
        let y_name = top.y.title(&self.y_name, &self.y_unit);
        let named = |last: bool| last.then_some(self.x_name.as_str());
        top.frame(&mut svg, named(!with_residual && !driven), &y_name);
        let dots = top.spots(&thinned(&self.measured, MOST_DOTS));
        let curve = |points: &Points| top.spots(&thinned(points, if size == Size::Wide { 1200 } else { 600 }));
        let (before, after) = (curve(&self.before), curve(&self.after));
        svg.dots(&self.dot("dot"), &dots);
        svg.path("line before", &before, false);
        svg.path("line after", &after, false);
        let mut labels = Labels::new(&top, &dots, &[&before, &after]);
        if !after.is_empty() {
            labels.on(&mut svg, "before", "before", &before, &after);
            labels.on(&mut svg, "after", self.after_name, &after, &before);
        }
        labels.on(&mut svg, "", "\u{2022} measured", &dots, &before);
        if with_residual {
            let begin = 2.0 * ABOVE + tall + 6.0;
            let bottom = Panel { x: x.clone(), y: Axis::new((-limit, limit), (begin + low, begin)) };
            self.draw_residual(&mut svg, &top, &bottom, named(!driven));
        }
        driving::draw(&self.inputs, &mut svg, &x, end, &self.x_name);
        let class = if size == Size::Wide { "wide" } else { "narrow" };
        let below = match (with_residual, driven) {
            (false, false) => "",
            (true, false) => ", with residuals below",
            (false, true) => ", with inputs below",
            (true, true) => ", with residuals and inputs below",
        };
        let label = format!("{}: measured, simulated before and {}{below}", self.title, self.after_name);
        svg.finish(class, &label)
    }

    fn draw_residual(&self, svg: &mut Svg, top: &Panel, bottom: &Panel, x_name: Option<&str>) {
        let (left, right) = bottom.x.places();
        svg.area("band", (left, bottom.y.at(BAND)), (right, bottom.y.at(-BAND)));
        bottom.frame(svg, x_name, "residual / \u{3c3}");
        for edge in [-BAND, BAND] {
            bottom.level(svg, "limit", edge);
        }
        bottom.level(svg, "zero", 0.0);
        svg.text("name", (right, bottom.y.places().1 - 12.0), Anchor::End, "band: \u{b1}2 \u{3c3} of the noise");
        svg.dots(&self.dot("dot small"), &bottom.spots(&thinned(&self.residual, MOST_DOTS)));
        for event in &self.events {
            for panel in [top, bottom] {
                let (x, floor) = (panel.x.at(*event), panel.y.places().0);
                svg.line("event", (x, floor), (x, floor - 9.0));
            }
        }
    }
}

/// The drawings of all `series`: one large one, or many small ones with the same scale of residuals.
///
/// `own_start` says that each simulation has the start (and a ball the surface) that suits its parameters best.
pub fn drawings(series: &[Series], own_start: bool) -> Markup {
    let limit = series.iter().map(Series::greatest).fold(3.0, f64::max) * 1.1;
    let thinned = series.iter().any(Series::is_thinned);
    let events = series.iter().any(|s| !s.events.is_empty());
    let fitted = series.iter().any(|s| !s.residual.is_empty());
    let how = html! {
        p.how {
            @if fitted {
                "Dots are measured; the dashed line is the simulation with the old parameters, the solid line with the tuned ones. "
                "Below: measured \u{2212} tuned, in standard deviations of the noise. If the simulation is right, 95 of 100 dots lie \
                 in the band, without a pattern."
                @if own_start {
                    " The start of each recording, of a ball also the surface, is estimated for both, each with its own parameters, so the \
                     dashed line may start at another value than the solid one."
                }
                @if events { " Ticks on the lower edges mark bounces." }
            } @else {
                "The recording; nothing was simulated."
            }
            @if thinned { " Of long recordings an even choice of at most " (MOST_DOTS) " samples is drawn." }
            (about_inputs(series))
        }
    };
    html! {
        @if let [one] = series {
            figure.screen { (one.draw(Size::Wide, limit)) (one.draw(Size::Narrow, limit)) }
            (how)
        } @else {
            div.grid {
                @for one in series {
                    figure { figcaption.above { (one.title) } (one.draw(Size::Narrow, limit)) }
                }
                (how)
            }
        }
    }
}

/// What the panels of inputs below `series` show; nothing where there are none.
pub fn about_inputs(series: &[Series]) -> Markup {
    let inputs = || series.iter().flat_map(|one| &one.inputs);
    let undrawn = series.iter().map(|one| one.undrawn).max().unwrap_or(0);
    html! {
        @if inputs().next().is_some() {
            " The lowest panels show what drove the recording: in steps where a value holds until the next sample, otherwise as \
             straight lines."
            @if inputs().any(Driving::is_thinned) {
                " Of a long input an even choice of at most " (MOST_SAMPLES) " samples is drawn."
            }
            @if undrawn > 0 { " Of " (MOST_INPUTS + undrawn) " inputs the first " (MOST_INPUTS) " are drawn." }
        }
    }
}

/// One channel over the clock; of bounce times, the intervals between bounces that follow each other.
fn column(seen: &Observation, clock: &[f64], values: &[f64], channel: usize) -> Points {
    let all: Points =
        clock.iter().copied().zip(values.iter().copied().skip(channel).step_by(seen.channels().len())).collect();
    intervals(seen.kind(), all)
}

/// Of bounce times the intervals between bounces that follow each other; of anything else the values as they are.
pub fn intervals(kind: Kind, all: Points) -> Points {
    if kind != Kind::EventTimes {
        return all;
    }
    let next =
        |pair: &[(f64, f64)]| ((pair[1].0 - pair[0].0 - 1.0).abs() < 0.5).then(|| (pair[1].0, pair[1].1 - pair[0].1));
    all.windows(2).filter_map(next).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missed_bounce_leaves_its_intervals_out() {
        let clock = vec![0.0, 1.0, 3.0, 4.0];
        let seen =
            Observation::new(Kind::EventTimes, tunenet_ball::bounce_time_channels(), clock, vec![1.0, 1.5, 2.0, 2.25])
                .unwrap();
        assert_eq!(column(&seen, seen.clock(), seen.values(), 0), [(1.0, 0.5), (4.0, 0.25)]);
    }
}
