//! What a file declares itself: inputs, starts and candidates, in its order.

use tunenet_formats::{Error, Result};

use super::SimulationFile;
use crate::formula_effect::joint::JointOf;
use crate::formula_effect::{FormulaEffect, Misfit};
use crate::scene::{Candidate, Candidates, Input, Scene, Start};

impl SimulationFile {
    /// What it predicts: names of channels with their units, in its order; none of a ball or an arm.
    #[must_use]
    pub fn headers(&self) -> Vec<String> {
        match self.scene() {
            Scene::Process(scene) => scene.process.channels.clone(),
            Scene::Equations(scene) => scene.headers(),
            Scene::Robot(scene) => scene.headers(),
            Scene::Ball(_) | Scene::Arm(_) => Vec::new(),
        }
    }

    /// What drives the thing, by name.
    #[must_use]
    pub fn inputs(&self) -> impl ExactSizeIterator<Item = (&str, &Input)> {
        let all = match self.scene() {
            Scene::Process(scene) => scene.inputs.iter(),
            Scene::Equations(scene) => scene.inputs.iter(),
            Scene::Robot(scene) => scene.inputs.iter(),
            Scene::Ball(_) | Scene::Arm(_) => indexmap::map::Iter::default(),
        };
        all.map(named as Named<Input>)
    }

    /// Where its states start, by name.
    #[must_use]
    pub fn starts(&self) -> impl ExactSizeIterator<Item = (&str, &Start)> {
        let all = match self.scene() {
            Scene::Process(scene) => scene.start.iter(),
            Scene::Equations(scene) => scene.start.iter(),
            Scene::Robot(scene) => scene.start.iter(),
            Scene::Ball(_) | Scene::Arm(_) => indexmap::map::Iter::default(),
        };
        all.map(named as Named<Start>)
    }

    /// The effects that it may lack, by name.
    #[must_use]
    pub fn candidates(&self) -> impl ExactSizeIterator<Item = (&str, &Candidate)> {
        self.all_candidates().iter().map(named as Named<Candidate>)
    }

    /// The candidate of this name.
    #[must_use]
    pub fn candidate(&self, name: &str) -> Option<&Candidate> {
        self.all_candidates().get(name)
    }

    /// The effects that a ball's file declares as formulas, in its order.
    ///
    /// # Errors
    /// [`Error::File`] where one of them does not fit.
    pub fn formulas(&self) -> Result<Vec<FormulaEffect>> {
        let mass_kg = self.ball()?.ball.mass_kg;
        let one = |(name, candidate)| {
            FormulaEffect::of_ball(name, candidate, mass_kg).map_err(|misfit| self.misfit(name, &misfit))
        };
        self.candidates().map(one).collect()
    }

    /// The effects that an arm's file declares as formulas, on an arm with these joints.
    ///
    /// # Errors
    /// As [`formulas`](Self::formulas).
    pub fn joint_formulas(&self, joints: &[String]) -> Result<Vec<FormulaEffect>> {
        let one = |(name, candidate)| {
            FormulaEffect::of_arm(name, candidate, Some(joints)).map_err(|misfit| self.misfit(name, &misfit))
        };
        self.candidates().map(one).collect()
    }

    /// The same of a robot with these joints, each of which turns or slides.
    pub(crate) fn robot_formulas(&self, joints: &[JointOf]) -> Result<Vec<FormulaEffect>> {
        let one = |(name, candidate)| {
            FormulaEffect::of_robot(name, candidate, Some(joints)).map_err(|misfit| self.misfit(name, &misfit))
        };
        self.candidates().map(one).collect()
    }

    fn misfit(&self, name: &str, misfit: &Misfit) -> Error {
        let Misfit { key, expected, found, .. } = misfit;
        let message = format!("`candidates.{name}.{key}`: expected {expected}, found {found}");
        Error::file(self.path(), message, "correct the candidate")
    }

    fn all_candidates(&self) -> &Candidates {
        match self.scene() {
            Scene::Ball(scene) => &scene.candidates,
            Scene::Arm(scene) => &scene.candidates,
            Scene::Process(scene) => &scene.candidates,
            Scene::Equations(scene) => &scene.candidates,
            Scene::Robot(scene) => &scene.candidates,
        }
    }
}

type Named<T> = for<'a> fn((&'a String, &'a T)) -> (&'a str, &'a T);

fn named<'a, T>((name, one): (&'a String, &'a T)) -> (&'a str, &'a T) {
    (name, one)
}
