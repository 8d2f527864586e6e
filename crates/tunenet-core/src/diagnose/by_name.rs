//! What an effect is worth, told by names: where flights and contacts are judged apart, each has a catalogue of its own.

use super::catalogue::Entry;
use super::search::Place;
use super::study::Study;

/// A [`Place`] that holds in any catalogue.
pub(super) struct ByName {
    name: &'static str,
    gain: f64,
    p_value: f64,
    others: Vec<(&'static str, f64)>,
    equals: Vec<&'static str>,
}

impl ByName {
    pub fn of(study: &Study, place: &Place) -> Self {
        let name = |entry: usize| study.catalogue[entry].name;
        Self {
            name: name(place.entry),
            gain: place.gain,
            p_value: place.p_value,
            others: place.others.iter().map(|&(entry, gap)| (name(entry), gap)).collect(),
            equals: place.equals.iter().map(|&entry| name(entry)).collect(),
        }
    }

    /// Without what lies farther behind.
    pub fn within(mut self, margin: f64) -> Self {
        let equals = &self.equals;
        self.others.retain(|(name, gap)| *gap < margin || equals.contains(name));
        self
    }

    /// In this catalogue; `None` where it does not hold the effect.
    pub fn place(&self, catalogue: &[Entry]) -> Option<Place> {
        let entry = |name: &str| catalogue.iter().position(|e| e.name == name);
        Some(Place {
            entry: entry(self.name)?,
            gain: self.gain,
            p_value: self.p_value,
            others: self.others.iter().filter_map(|&(name, gap)| Some((entry(name)?, gap))).collect(),
            equals: self.equals.iter().filter_map(|name| entry(name)).collect(),
        })
    }
}
