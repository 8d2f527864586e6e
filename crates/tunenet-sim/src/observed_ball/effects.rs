//! The physical effects of an observed ball: which it can take on, and where their numbers go.

use rapier3d::math::Vector;
use tunenet_ball::Arcs;
use tunenet_core::observation::{Kind, Note, Observation};
use tunenet_core::simulator::{Effect, Parameter, Phase, Preparation};
use tunenet_core::{Error, Origin, Result};
use tunenet_formats::kind_name;

use super::acting::Acting;
use super::{Nuisance, ObservedBall};
use crate::ball::Scene;
use crate::ball::effects::{ALL, SCATTER};
use crate::scene::BallParameters;
use crate::valid_range::Farthest;

/// What the spin of a throw does in the air.
const SPIN: &str = "magnus";
/// How far a bounce may turn the normal, rad, and at how many bounces of a record it may; later ones are next to rest.
const GREATEST_TILT_RAD: f64 = 0.5;
const MOST_TILTS: usize = 12;

impl ObservedBall {
    /// Those that are not there, and that this kind of observation can show.
    pub(super) fn absent_effects(&self) -> Vec<Effect> {
        let present = |name: &str| {
            self.fixed.iter().any(|(e, _)| e.name() == name)
                || self.free.iter().chain(&self.per_recording).any(|e| e.name() == name)
        };
        let all = self.known_effects().filter(|e| !present(e.name()) && self.can_take(e));
        all.map(|e| e.entry(&self.body)).collect()
    }

    /// The catalogue, then the formulas of the file.
    fn known_effects(&self) -> impl Iterator<Item = Acting> {
        ALL.into_iter()
            .map(Acting::BuiltIn)
            .chain(self.formulas.iter().map(|formula| Acting::Formula(Box::new(formula.clone()))))
    }

    /// The effect of this name.
    pub(crate) fn find_effect(&self, name: &str) -> Option<Acting> {
        self.known_effects().find(|effect| effect.name() == name)
    }

    /// The same ball with one more formula among the effects that it can take on.
    pub(crate) fn with_formula(mut self, formula: crate::formula_effect::FormulaEffect) -> Self {
        self.formulas.push(formula);
        self
    }

    /// The same ball with the coefficients of these effects as further parameters.
    pub(crate) fn freed(&self, names: &[&str]) -> Result<Self> {
        let mut ball = self.clone();
        for name in names {
            let new = |e: &Acting| self.can_take(e) && !ball.free.iter().any(|f| f.name() == e.name());
            let Some(effect) = self.find_effect(name).filter(new) else {
                let known = ball.absent_effects().iter().map(|e| e.name.as_ref()).collect::<Vec<_>>().join(", ");
                let expected = format!("an effect of a ball seen as {} ({known})", kind_name(self.kind));
                return Err(Error::Setting {
                    origin: Origin::Caller,
                    name: "effects",
                    expected,
                    found: format!("`{name}`"),
                });
            };
            let at = ball.fixed.iter().position(|(e, _)| e.name() == *name);
            let present = at.map(|i| ball.fixed.remove(i).1);
            let parameters = effect.entry(&self.body).parameters(present.as_deref())?;
            // A random effect is not rolled out; its size follows from the tilts that a recording brings.
            let tune = effect.name() != SCATTER;
            ball.parameters.extend(parameters.into_iter().map(|p| Parameter { tune, ..p }));
            ball.free.push(effect);
        }
        Ok(ball)
    }

    /// The same ball, thrown with an unknown spin of its own in every recording; `None` where that is known or does not show.
    pub(super) fn spinning(&self) -> Option<Self> {
        let unknown = self.absent_effects().iter().any(|e| e.name == SPIN) && self.release.spin_rad_s.is_none();
        let effect = self.find_effect(SPIN).filter(|_| unknown)?;
        Some(Self { per_recording: vec![effect], ..self.clone() })
    }

    /// The same ball, released with an unknown spin about the axes along the surface, to which contacts answer; `None` where
    /// spin is known or does not show.
    pub(super) fn let_go_spinning(&self) -> Option<Self> {
        let unknown =
            self.kind == Kind::Positions && self.release.spin_rad_s.is_none() && self.per_recording.is_empty();
        let spins = [0, 1].map(Nuisance::Spin);
        let all = self.nuisances.iter().copied().chain(spins).collect();
        unknown.then(|| Self { nuisances: all, ..self.clone() })
    }

    /// Puts the effects into the scene: the file's, those with these coefficients, and the tilts of single bounces,
    /// which follow a recording's other nuisance parameters.
    pub(super) fn apply_effects(&self, scene: &mut Scene, mut coefficients: &[f64], nuisances: &[f64]) {
        for (effect, values) in &self.fixed {
            effect.apply(scene, values);
        }
        for effect in &self.free {
            let (values, rest) = coefficients.split_at(effect.numbers());
            effect.apply(scene, values);
            coefficients = rest;
        }
        let mut nuisances = nuisances.get(self.nuisances.len()..).unwrap_or_default();
        for effect in &self.per_recording {
            let Some((values, rest)) = nuisances.split_at_checked(effect.numbers()) else { break };
            effect.apply(scene, values);
            nuisances = rest;
        }
        if !nuisances.is_empty() {
            scene.contact.tilts_rad = nuisances.chunks_exact(2).map(|tilt| [tilt[0], tilt[1]]).collect();
        }
    }

    /// What effects change of a recording made ready.
    pub(super) fn with_nuisances_of_effects(&self, preparation: Preparation) -> Result<Preparation> {
        let Preparation::Usable(mut prepared) = preparation else { return Ok(preparation) };
        prepared.notes.extend(self.notes_of_formulas());
        // A record without a bounce is silent about contacts only.
        let phases = self.free.iter().flat_map(|e| vec![e.phase(); e.numbers()]);
        for (silent, phase) in prepared.silent[BallParameters::COUNT..].iter_mut().zip(phases) {
            if *phase == Phase::Segment {
                *silent = None;
            }
        }
        for effect in &self.per_recording {
            let entry = effect.entry(&self.body);
            for (parameter, (low, high)) in entry.parameters(None)?.into_iter().zip(&entry.plausible) {
                prepared.nuisances.push(Parameter::new(parameter.name, parameter.unit, parameter.value, *low, *high)?);
            }
        }
        if self.scatters() {
            prepared.nuisances.extend(self.tilts(&prepared.seen)?);
        }
        Ok(Preparation::Usable(prepared))
    }

    /// What a user should know of the formulas that act.
    fn notes_of_formulas(&self) -> impl Iterator<Item = Note> {
        self.fixed.iter().map(|(effect, _)| effect).chain(&self.free).flat_map(Acting::notes)
    }

    /// What a user should know of the formulas of the file in a rollout of positions (m), row-major, at these instants (s).
    #[must_use]
    pub fn formula_notes(&self, clock: &[f64], positions: &[f64]) -> Vec<Note> {
        let mut notes: Vec<Note> = self.notes_of_formulas().collect();
        let place = |i: usize| Vector::new(positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]);
        for (effect, values) in &self.fixed {
            let Some(force) = effect.force(values) else { continue };
            let left = Farthest::of((1..clock.len()).map(|i| {
                let v = (place(i) - place(i - 1)) / (clock[i] - clock[i - 1]);
                force.outside(clock[i], place(i), v)
            }));
            notes.extend(left.map(|left| left.note(effect.name())));
        }
        notes
    }

    /// Whether this kind of observation can show an effect.
    fn can_take(&self, effect: &Acting) -> bool {
        // With a tuned coefficient of friction its addition is redundant.
        let twin = effect.name() == "bounce_friction"
            && self.parameters.iter().any(|p| p.name == BallParameters::FRICTION && p.tune);
        !twin && (effect.shows_in_bounce_times() || self.kind == Kind::Positions)
    }

    /// Whether a recording's nuisance parameters include the tilt of the normal at each bounce.
    fn scatters(&self) -> bool {
        let fixed = self.fixed.iter().any(|(e, values)| e.name() == SCATTER && values[0] > 0.0);
        self.kind == Kind::Positions && (fixed || self.free.iter().any(|e| e.name() == SCATTER))
    }

    /// The tilts of the normal as nuisance parameters: about x and y, for each bounce of the record.
    fn tilts(&self, seen: &Observation) -> Result<Vec<Parameter>> {
        let bounces = Arcs::cut(seen, self.scene.gravity_m_s2).map_or(0, |arcs| arcs.contacts.len());
        let name = |bounce: usize, axis: &str| format!("bounce.{}.tilt_about_{axis}", bounce + 1);
        let each = (0..bounces.min(MOST_TILTS)).flat_map(|bounce| [name(bounce, "x"), name(bounce, "y")]);
        each.map(|name| Parameter::new(name, "rad", 0.0, -GREATEST_TILT_RAD, GREATEST_TILT_RAD)).collect()
    }
}
