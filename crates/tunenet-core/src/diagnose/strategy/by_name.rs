//! Selected effects by name: segments and events are explained separately, each with its own catalogue.

use crate::diagnose::hypothesis::catalogue::Entry;
use crate::diagnose::hypothesis::context::Context;
use crate::diagnose::hypothesis::forward_selection::SelectedEffect;
use crate::diagnose::hypothesis::plausibility::OutOfRange;
use crate::simulator::Text;

/// A [`SelectedEffect`] that holds in any catalogue.
pub(in crate::diagnose) struct ByName {
    name: Text,
    gain: f64,
    p_value: f64,
    others: Vec<(Text, f64)>,
    equals: Vec<Text>,
    excluded: Option<OutOfRange>,
}

impl ByName {
    pub fn of(context: &Context, selected: &SelectedEffect) -> Self {
        let name = |entry: usize| context.catalogue[entry].name.clone();
        Self {
            name: name(selected.entry),
            gain: selected.gain,
            p_value: selected.p_value,
            others: selected.others.iter().map(|&(entry, gap)| (name(entry), gap)).collect(),
            equals: selected.equals.iter().map(|&entry| name(entry)).collect(),
            excluded: selected.excluded.clone(),
        }
    }

    /// Without what lies farther behind.
    pub fn within(mut self, margin: f64) -> Self {
        let equals = &self.equals;
        self.others.retain(|(name, gap)| *gap < margin || equals.contains(name));
        self
    }

    /// In this catalogue; `None` where it does not hold the effect.
    pub fn in_catalogue(&self, catalogue: &[Entry]) -> Option<SelectedEffect> {
        let entry = |name: &str| catalogue.iter().position(|e| e.name == name);
        Some(SelectedEffect {
            entry: entry(&self.name)?,
            gain: self.gain,
            p_value: self.p_value,
            others: self.others.iter().filter_map(|(name, gap)| Some((entry(name)?, *gap))).collect(),
            equals: self.equals.iter().filter_map(|name| entry(name)).collect(),
            excluded: self.excluded.clone(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::tests::zoo::{entry, in_swings};

    #[test]
    fn an_effect_is_found_again_in_another_catalogue() {
        in_swings(&[], 1, 0, |context| {
            let (friction, rest) = (entry(context, "viscous_friction"), entry(context, "rest_angle"));
            let others = vec![(rest, 3.0), (entry(context, "time_scale"), 9.0)];
            let selected = SelectedEffect {
                entry: friction,
                gain: 20.0,
                p_value: 0.01,
                others,
                equals: Vec::new(),
                excluded: None,
            };
            let named = ByName::of(context, &selected).within(6.0);
            let turned: Vec<Entry> = context.catalogue.iter().rev().cloned().collect();
            let found = named.in_catalogue(&turned).unwrap();
            assert_eq!(turned[found.entry].name, "viscous_friction");
            assert_eq!(found.others.len(), 1);
            assert_eq!(turned[found.others[0].0].name, "rest_angle");
            assert!(named.in_catalogue(&turned[..1]).is_none());
        });
    }
}
