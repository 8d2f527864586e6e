//! Scales: from a value to a place, with ticks at round numbers.

/// Decimals beyond which ticks are written as differences from a middle value.
const MOST_DECIMALS: i32 = 6;
/// What rounding may take from a step, as a share of it: differences of nearly equal doubles keep few digits.
const SLACK: f64 = 1e-6;
/// How many more parts an axis is cut into where it has a single tick.
const MORE_TICKS: u32 = 6;

/// One scale of a panel.
#[derive(Debug, Clone)]
pub struct Axis {
    low: f64,
    high: f64,
    from: f64,
    to: f64,
    /// Subtracted from what the ticks say, where their digits would be many.
    offset: f64,
}

impl Axis {
    /// From `low` to `high` (widened where they coincide) over the places `from` to `to`.
    pub fn new((low, high): (f64, f64), (from, to): (f64, f64)) -> Self {
        // Below, doubles no longer distinguish ticks.
        let least = 1e-14 * low.abs().max(high.abs()).max(1e-9);
        let (low, high) = if high - low > least { (low, high) } else { (low - least.max(0.5), high + least.max(0.5)) };
        let mut axis = Self { low, high, from, to, offset: 0.0 };
        if decimals(axis.step(4)) > MOST_DECIMALS && low.abs().max(high.abs()) > 100.0 * (high - low) {
            // Powers above 1 are exact, so that the offset is the double nearest to few digits.
            let fine = 10f64.powf(-(high - low).log10().ceil());
            axis.offset = (f64::midpoint(low, high) * fine).round() / fine;
        }
        axis
    }

    /// Around all of `values`, with a little room at both ends.
    pub fn around(values: impl Iterator<Item = f64>, places: (f64, f64), room: f64) -> Self {
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        let margin = room * (high - low);
        Self::new(if low <= high { (low - margin, high + margin) } else { (0.0, 1.0) }, places)
    }

    /// The place of a value.
    pub fn at(&self, value: f64) -> f64 {
        self.from + (value - self.low) / (self.high - self.low) * (self.to - self.from)
    }

    pub fn places(&self) -> (f64, f64) {
        (self.from, self.to)
    }

    pub fn low(&self) -> f64 {
        self.low
    }

    pub fn high(&self) -> f64 {
        self.high
    }

    fn step(&self, most: u32) -> f64 {
        let raw = (self.high - self.low) / f64::from(most.max(1));
        let power = 10f64.powf(raw.log10().floor());
        [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|s| *s >= raw * (1.0 - SLACK)).unwrap_or(raw)
    }

    /// At most `most` + 1 round values with their place and text, a few more where these were fewer than two: one number is no scale.
    pub fn ticks(&self, most: u32) -> Vec<(f64, String)> {
        let found = self.ticks_of(most);
        if found.len() > 1 {
            found
        } else {
            (most + 1..most + MORE_TICKS).map(|more| self.ticks_of(more)).find(|all| all.len() > 1).unwrap_or(found)
        }
    }

    fn ticks_of(&self, most: u32) -> Vec<(f64, String)> {
        let step = self.step(most);
        let places = usize::try_from(decimals(step).clamp(0, 9)).unwrap_or(0);
        let (low, high) = (self.low - self.offset, self.high - self.offset);
        let first = (low / step - SLACK).ceil();
        let size = low.abs().max(high.abs());
        let text = |value: f64| {
            let value = if value.abs() < SLACK * step { 0.0 } else { value };
            let plain = if value == 0.0 && decimals(step) > MOST_DECIMALS {
                "0".into()
            } else if value != 0.0 && (decimals(step) > MOST_DECIMALS || size >= 1e6) {
                format!("{value:.1e}").replace(".0e", "e")
            } else {
                format!("{value:.places$}")
            };
            let sign = if self.offset != 0.0 && value > 0.0 { "+" } else { "" };
            format!("{sign}{}", plain.replace('-', "\u{2212}"))
        };
        (0..=most)
            .map(|i| (first + f64::from(i)) * step)
            .take_while(|v| *v <= high + SLACK * step)
            .map(|v| (self.at(v + self.offset), text(v)))
            .collect()
    }

    /// What stands at the axis: `time, s`, or `restitution − 0.7` where ticks are differences.
    pub fn title(&self, name: &str, unit: &str) -> String {
        let name = if self.offset == 0.0 { name.to_string() } else { format!("{name} \u{2212} {}", self.offset) };
        if unit == "1" || unit.is_empty() { name } else { format!("{name}, {unit}") }
    }
}

/// How many decimals show multiples of `step` apart.
fn decimals(step: f64) -> i32 {
    #[expect(clippy::cast_possible_truncation, reason = "an exponent")]
    let exponent = (step.log10() + 1e-9).floor() as i32;
    -exponent
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(low: f64, high: f64) -> Vec<String> {
        Axis::new((low, high), (0.0, 100.0)).ticks(5).into_iter().map(|t| t.1).collect()
    }

    #[test]
    fn ticks_are_round_and_within() {
        assert_eq!(texts(0.0, 3.0), ["0", "1", "2", "3"]);
        assert_eq!(texts(-0.13, 0.42), ["0.0", "0.2", "0.4"]);
        assert_eq!(texts(0.829_6, 0.830_3), ["0.8296", "0.8298", "0.8300", "0.8302"]);
        assert_eq!(texts(0.0, 4e7), ["0", "1e7", "2e7", "3e7", "4e7"]);
    }

    #[test]
    fn many_digits_become_differences() {
        let axis = Axis::new((0.7 - 2e-9, 0.7 + 2e-9), (0.0, 100.0));
        assert_eq!(axis.title("restitution", "1"), "restitution \u{2212} 0.7");
        assert_eq!(
            axis.ticks(2).into_iter().map(|t| t.1).collect::<Vec<_>>(),
            ["\u{2212}2e\u{2212}9", "0", "+2e\u{2212}9"]
        );
    }

    #[test]
    fn places_are_linear_and_a_single_value_has_one_too() {
        let axis = Axis::new((2.0, 4.0), (10.0, 20.0));
        assert_eq!((axis.at(2.0), axis.at(3.0), axis.at(4.0)), (10.0, 15.0, 20.0));
        assert!(Axis::new((5.0, 5.0), (0.0, 1.0)).at(5.0).is_finite());
        assert!(Axis::around(std::iter::empty(), (0.0, 1.0), 0.1).at(0.5).is_finite());
    }
}
