//! What drove a recording, below its channels on the same axis of time.

use tunenet_core::observation::{Hold, Input, Kind, Observation};

use super::axis::Axis;
use super::panel::{ABOVE, Panel};
use super::points::{Points, thinned};
use super::svg::Svg;

/// Most inputs below one channel.
pub const MOST_INPUTS: usize = 6;
/// Most samples of an input in one drawing; beyond, an even choice is drawn.
pub const MOST_SAMPLES: usize = 600;
/// Height of the panel of one input.
const TALL: f64 = 72.0;
/// Room between one panel and the name of the next.
const GAP: f64 = 6.0;

/// One input of a recording, ready to be drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Driving {
    name: String,
    unit: String,
    /// What it is between the points.
    hold: Hold,
    /// The samples within the recording, and its values at both ends.
    points: Points,
}

impl Driving {
    /// Every input of a recording of a program; an arm that replays its own motion has none that would say more.
    pub fn of(seen: &Observation) -> Vec<Self> {
        let known = seen.circumstances().filter(|_| seen.kind() == Kind::Other);
        let (first, last) = (seen.clock()[0], seen.clock()[seen.len() - 1]);
        let inputs = known.iter().flat_map(|known| &known.inputs);
        inputs.flat_map(|input| Self::channels(input, (first, last))).collect()
    }

    fn channels(input: &Input, (first, last): (f64, f64)) -> Vec<Self> {
        let series = input.series();
        let one = |(channel, about): (usize, &tunenet_core::observation::Channel)| {
            let samples = series.clock().iter().copied().zip(series.column(channel));
            let within = samples.filter(|(t, _)| first < *t && *t < last);
            let ends = [first, last].map(|t| (t, input.at(channel, t)));
            let points = std::iter::once(ends[0]).chain(within).chain([ends[1]]).collect();
            Self { name: about.name.clone(), unit: about.unit.clone(), hold: input.hold(), points }
        };
        series.channels().iter().enumerate().map(one).collect()
    }

    /// Whether only a choice of its samples is drawn.
    pub fn is_thinned(&self) -> bool {
        self.points.len() > MOST_SAMPLES
    }

    /// Between which values it stays.
    pub fn range(&self) -> (f64, f64) {
        let values = self.points.iter().map(|point| point.1);
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
    }

    /// The corners of its line: steps where a value holds until the next sample, otherwise the samples themselves.
    fn line(&self) -> Points {
        let chosen = thinned(&self.points, MOST_SAMPLES);
        match self.hold {
            Hold::Linear => chosen,
            Hold::Previous => stepped(&chosen),
        }
    }

    /// Its panel, which begins at `top`; the time is named there unless `x_name` is left out.
    fn draw(&self, svg: &mut Svg, x: &Axis, top: f64, x_name: Option<&str>) {
        let (low, high) = self.range();
        let y = Axis::around([low, high].into_iter(), (top + ABOVE + TALL, top + ABOVE), 0.08);
        let panel = Panel { x: x.clone(), y };
        panel.frame(svg, x_name, &panel.y.title(&self.name, &self.unit));
        svg.path("line thin", &panel.spots(&self.line()), false);
    }
}

/// How much higher a drawing is with these inputs in it.
pub fn height(inputs: &[Driving]) -> f64 {
    inputs.len() as f64 * (ABOVE + TALL + GAP)
}

/// Draws the panels of the inputs from `top` on, the first one uppermost.
pub fn draw(inputs: &[Driving], svg: &mut Svg, x: &Axis, top: f64, x_name: &str) {
    for (i, input) in inputs.iter().enumerate() {
        let begin = top + GAP + height(&inputs[..i]);
        input.draw(svg, x, begin, (i + 1 == inputs.len()).then_some(x_name));
    }
}

/// The corners of a line on which every value holds until the next point.
fn stepped(points: &[(f64, f64)]) -> Points {
    let corner = |pair: &[(f64, f64)]| [(pair[1].0, pair[0].1), pair[1]];
    points.first().copied().into_iter().chain(points.windows(2).flat_map(corner)).collect()
}

#[cfg(test)]
mod tests {
    use tunenet_core::observation::{Channel, Circumstances};

    use super::*;

    /// What drives a recording from 1 s to 4 s by samples from 0 s to 5 s.
    fn driving(hold: Hold) -> Driving {
        let clock = vec![0.0, 2.0, 3.0, 5.0];
        let input = Input::sampled(Channel::new("u", "V"), hold, clock, vec![1.0, 3.0, -2.0, 0.0]).unwrap();
        let seen = Observation::new(Kind::Other, vec![Channel::new("x", "m")], vec![1.0, 2.5, 4.0], vec![0.0; 3]);
        let seen = seen.unwrap().under(Circumstances::driven_by(vec![input]));
        Driving::of(&seen).remove(0)
    }

    #[test]
    fn a_held_input_is_drawn_in_steps_within_its_recording() {
        let corners = [(1.0, 1.0), (2.0, 1.0), (2.0, 3.0), (3.0, 3.0), (3.0, -2.0), (4.0, -2.0), (4.0, -2.0)];
        assert_eq!(driving(Hold::Previous).line(), corners);
        assert_eq!(stepped(&[]), []);
    }

    #[test]
    fn a_linear_input_is_drawn_straight_from_sample_to_sample() {
        let drawn = driving(Hold::Linear);
        assert_eq!(drawn.line(), [(1.0, 2.0), (2.0, 3.0), (3.0, -2.0), (4.0, -1.0)]);
        assert_eq!((drawn.range(), drawn.name.as_str(), drawn.unit.as_str()), ((-2.0, 3.0), "u", "V"));
    }

    #[test]
    fn a_long_input_is_drawn_by_an_even_choice_of_its_samples() {
        let points: Points = (0..100_000).map(|i| (f64::from(i), f64::from(i % 7))).collect();
        let long = Driving { points, ..driving(Hold::Previous) };
        assert!(long.is_thinned() && long.line().len() <= 2 * MOST_SAMPLES + 1);
        assert_eq!(long.line().last().map(|point| point.0), Some(99_999.0));
    }
}
