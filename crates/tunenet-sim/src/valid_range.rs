//! Where a rollout leaves the range in which the formula of an effect was seen to hold.

use tunenet_core::observation::Note;

use crate::findings;

/// A variable outside its range.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LeftRange {
    pub variable: String,
    pub value: f64,
    /// On the clock of the recording, s.
    pub time_s: f64,
    pub range: (f64, f64),
}

/// The variable that leaves its range farthest.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Farthest {
    pub left: LeftRange,
    /// The share of all instants at which a variable is outside its range.
    pub share: f64,
}

impl LeftRange {
    /// A variable with this value, where that is outside the range.
    pub fn of(variable: &str, value: f64, time_s: f64, range: (f64, f64)) -> Option<Self> {
        let left = || Self { variable: variable.into(), value, time_s, range };
        (!(range.0..=range.1).contains(&value)).then(left)
    }

    /// How far outside it is, over the width of the range.
    fn excess(&self) -> f64 {
        let (low, high) = self.range;
        (low - self.value).max(self.value - high) / (high - low)
    }

    /// The farthest of those of one instant.
    pub fn farthest(all: impl Iterator<Item = Self>) -> Option<Self> {
        all.max_by(|a, b| a.excess().total_cmp(&b.excess()))
    }
}

impl Farthest {
    /// Of all instants, with what is outside at each.
    pub fn of(instants: impl Iterator<Item = Option<LeftRange>>) -> Option<Self> {
        let mut count = 0.0;
        let mut left = Vec::new();
        for one in instants {
            count += 1.0;
            left.extend(one);
        }
        let share = left.len() as f64 / count;
        LeftRange::farthest(left.into_iter()).map(|left| Self { left, share })
    }

    /// What a user should know of it; `effect` is the name of the formula's effect.
    pub fn note(&self, effect: &str) -> Note {
        let LeftRange { variable, value, time_s, range: (low, high) } = &self.left;
        let percent = (100.0 * self.share).max(1.0);
        let text = format!(
            "`{variable}` reaches {value:.3} at {time_s:.3} s; the formula of `{effect}` was seen to hold from {low} to {high} \
             ({percent:.0} % of the instants are outside)"
        );
        Note::new(findings::EFFECT_OUTSIDE, text, findings::EFFECT_OUTSIDE.remedy())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A range of width 2: 0.1 below it is less than 3 above; of four instants two are outside.
    #[test]
    fn the_farthest_instant_is_named_with_the_share_of_all() {
        let at = |value, time_s| LeftRange::of("v_m_s", value, time_s, (1.0, 3.0));
        let found = Farthest::of([at(0.9, 0.0), at(2.0, 0.5), at(6.0, 1.0), at(3.0, 1.5)].into_iter());
        let found = found.expect("two are outside");
        assert_eq!((found.left.value, found.left.time_s, found.share), (6.0, 1.0, 0.5));
        assert!(found.note("law").text.contains("reaches 6.000 at 1.000 s"), "{:?}", found.note("law"));
        assert_eq!(Farthest::of([at(2.0, 0.0)].into_iter()), None);
    }
}
