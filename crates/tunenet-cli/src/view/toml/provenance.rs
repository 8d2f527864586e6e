//! The table `[provenance]` of a simulation file that tunenet wrote: what it was made from, and how well it fits.

use anyhow::Result;
use serde::Serialize;
use toml_edit::{Array, InlineTable, Value};

/// Its entries, in the order in which they are written.
pub struct Provenance(Vec<(&'static str, Value)>);

impl Provenance {
    /// Of a `command`'s answer with this verdict.
    ///
    /// # Errors
    /// Never where a verdict is written as a word.
    pub fn new(command: &'static str, seed: u64, verdict: impl Serialize) -> Result<Self> {
        let verdict = serde_json::to_value(verdict)?;
        Ok(Self(vec![
            ("tool", concat!("tunenet ", env!("CARGO_PKG_VERSION")).into()),
            ("command", command.into()),
            ("seed", i64::try_from(seed).unwrap_or(i64::MAX).into()),
            ("verdict", verdict.as_str().unwrap_or_default().into()),
        ]))
    }

    /// The same with one more entry.
    #[must_use]
    pub fn with(mut self, key: &'static str, value: impl Into<Value>) -> Self {
        self.0.push((key, value.into()));
        self
    }

    /// The same with an array, unless it is empty.
    #[must_use]
    pub fn with_any(self, key: &'static str, values: Array) -> Self {
        if values.is_empty() { self } else { self.with(key, values) }
    }

    /// The same with the 95 % interval of each parameter.
    #[must_use]
    pub fn with_intervals(self, intervals: impl IntoIterator<Item = (String, (f64, f64))>) -> Self {
        let one = |(name, (low, high)): (String, _)| (name.replace('.', "_"), Array::from_iter([low, high]));
        self.with("interval95", intervals.into_iter().map(one).collect::<InlineTable>())
    }

    /// The same with the gap before and after, and what noise alone leaves, in this unit.
    #[must_use]
    pub fn with_gap(self, unit: &str, [before, after, noise_floor]: [f64; 3]) -> Self {
        self.with("gap_unit", unit)
            .with("gap_before", before)
            .with("gap_after", after)
            .with("gap_noise_floor", noise_floor)
    }

    /// The entries.
    pub fn entries(&self) -> &[(&'static str, Value)] {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_stand_in_the_order_in_which_they_are_given() {
        let made = Provenance::new("tune", 7, "tuned").unwrap();
        let made = made.with_any("open_drag", Array::new()).with_intervals([("world.gravity".into(), (9.8, 9.9))]);
        let made = made.with_gap("m", [0.3, 0.02, 0.01]);
        let keys: Vec<&str> = made.entries().iter().map(|(key, _)| *key).collect();
        let gap = ["gap_unit", "gap_before", "gap_after", "gap_noise_floor"];
        assert_eq!(keys, [&["tool", "command", "seed", "verdict", "interval95"][..], &gap].concat());
        assert_eq!(made.entries()[4].1.to_string(), "{ world_gravity = [9.8, 9.9] }");
        assert_eq!(made.entries()[2].1.as_integer(), Some(7));
    }
}
