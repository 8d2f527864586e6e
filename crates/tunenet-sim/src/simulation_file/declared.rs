//! What a file declares itself: inputs, starts and candidates, in its order.

use super::SimulationFile;
use crate::scene::{Candidate, Input, Scene, Start};

impl SimulationFile {
    /// What drives the thing, by name.
    #[must_use]
    pub fn inputs(&self) -> impl ExactSizeIterator<Item = (&str, &Input)> {
        let Scene::Process(scene) = self.scene() else {
            return indexmap::map::Iter::default().map(named as Named<Input>);
        };
        scene.inputs.iter().map(named as Named<Input>)
    }

    /// Where its states start, by name.
    #[must_use]
    pub fn starts(&self) -> impl ExactSizeIterator<Item = (&str, &Start)> {
        let Scene::Process(scene) = self.scene() else {
            return indexmap::map::Iter::default().map(named as Named<Start>);
        };
        scene.start.iter().map(named as Named<Start>)
    }

    /// The effects that it may lack, by name.
    #[must_use]
    pub fn candidates(&self) -> impl ExactSizeIterator<Item = (&str, &Candidate)> {
        let Scene::Process(scene) = self.scene() else {
            return indexmap::map::Iter::default().map(named as Named<Candidate>);
        };
        scene.candidates.iter().map(named as Named<Candidate>)
    }

    /// The candidate of this name.
    #[must_use]
    pub fn candidate(&self, name: &str) -> Option<&Candidate> {
        if let Scene::Process(scene) = self.scene() { scene.candidates.get(name) } else { None }
    }
}

type Named<T> = for<'a> fn((&'a String, &'a T)) -> (&'a str, &'a T);

fn named<'a, T>((name, one): (&'a String, &'a T)) -> (&'a str, &'a T) {
    (name, one)
}
