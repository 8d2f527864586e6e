//! What is known of effects before anything is measured.

use super::decide::in_place_of;
use super::search::Found;
use super::study::Study;
use crate::observation::Note;

impl Study<'_> {
    /// Whether the effect has to be there in every object, so that recordings need only say how large it is.
    pub fn certain(&self, entry: usize) -> bool {
        self.catalogue[entry].of.iter().all(crate::simulator::Effect::certain)
    }

    /// Whether `other` explains what `entry` does, but is not to be expected of these objects as `entry` is.
    pub fn stands_back(&self, other: usize, entry: usize) -> bool {
        self.unlikely(other).is_some() && self.unlikely(entry).is_none()
    }

    fn unlikely(&self, entry: usize) -> Option<&'static str> {
        let of = &self.catalogue[entry].of;
        of.iter().all(|effect| effect.unlikely.is_some()).then_some(of[0].unlikely)?
    }

    /// Says which effects explain the recordings as well as those found within `margin`, and why they are not offered.
    pub fn say_what_stands_back(&self, found: &Found, margin: f64, notes: &mut Vec<Note>) {
        for place in &found.places {
            let offered = in_place_of(self, place, margin);
            let near = place.others.iter().filter(|(other, gap)| *gap < margin && !offered.contains(other));
            for (other, why) in near.filter_map(|(other, _)| Some((*other, self.unlikely(*other)?))) {
                let name = self.catalogue[other].name;
                let text = format!("`{name}` would explain these recordings about as well, but {why}");
                notes.push(Note::new(
                    "effect.unlikely",
                    text,
                    "set world.medium = \"other\" where it did not move in air",
                ));
            }
        }
    }
}
