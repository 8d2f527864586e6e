//! Physical effects of a ball: what its world may hold beyond gravity, restitution and friction.
//!
//! One file each, which holds the entry of the catalogue and how the coefficients enter the [`Scene`]; [`ALL`] is the
//! list. To add one, write its file and its line: the simulation file, tuning and diagnosis follow from the list.

mod bounce_friction;
mod bounce_scatter;
mod contact_time;
mod effective_gravity;
mod linear_drag;
mod magnus;
mod quadratic_drag;
mod rolling_resistance;
mod speed_dependent_restitution;
mod surface_tilt;
mod tangential_restitution;
mod wind;

use tunenet_core::simulator::{Coefficient, Effect, Phase, Text};

use super::Scene;

/// Density of air at 20 °C and sea level, kg/m³.
pub const AIR_KG_M3: f64 = 1.2;

/// The effect that is there wherever there is air.
pub const DRAG: &str = quadratic_drag::EFFECT.name;
/// The effect that is a per-contact random effect.
pub const SCATTER: &str = bounce_scatter::EFFECT.name;
/// Drag coefficients of smooth and of felted balls at the speeds of a hand's throw (Achenbach 1972; Mehta 2008).
const USUAL_DRAG_COEFFICIENT: (f64, f64) = (0.35, 0.65);
/// From foam and hollow balls (a table-tennis ball: 80) to solid rubber.
const DENSITY_KG_M3: (f64, f64) = (50.0, 1200.0);

/// The settings that make bounds narrower than those of any ball.
const MASS_AND_SIZE: [&str; 2] = ["ball.mass_kg", "ball.radius_m"];

/// What is known of a ball before anything is tuned: it decides what is plausible.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body {
    /// Its radius, m.
    pub radius_m: f64,
    /// Its mass, kg, where it is known.
    pub mass_kg: Option<f64>,
    /// Gravity where it falls, m/s².
    pub gravity_m_s2: f64,
    /// Whether it moves in air.
    pub in_air: bool,
}

impl Body {
    /// The mass of the air that it displaces over its own mass, where it moves in air and its mass is known.
    #[must_use]
    pub fn buoyancy(&self) -> Option<f64> {
        let volume = 4.0 / 3.0 * std::f64::consts::PI * self.radius_m.powi(3);
        self.mass_kg.filter(|_| self.in_air).map(|mass| AIR_KG_M3 * volume / mass)
    }

    /// The quadratic drag (1/m) of a drag coefficient of 1: c = ρ A / (2 m), where it moves in air and its mass is known.
    #[must_use]
    pub fn drag_1_m(&self) -> Option<f64> {
        self.mass_kg.filter(|_| self.in_air).map(|mass| 0.5 * AIR_KG_M3 * self.area_m2() / mass)
    }

    /// Between which quadratic drags (1/m) the air brakes a usual ball of this size; absent where there is no air. Where its
    /// mass is not known, between those of solid rubber and of a hollow or foamed ball.
    #[must_use]
    pub fn usual_drag_1_m(&self) -> Option<(f64, f64)> {
        let (low, high) = USUAL_DRAG_COEFFICIENT;
        let volume = 4.0 / 3.0 * std::f64::consts::PI * self.radius_m.powi(3);
        let (heaviest, lightest) =
            self.mass_kg.map_or((DENSITY_KG_M3.1 * volume, DENSITY_KG_M3.0 * volume), |m| (m, m));
        let unit = 0.5 * AIR_KG_M3 * self.area_m2();
        self.in_air.then_some((low * unit / heaviest, high * unit / lightest))
    }

    fn area_m2(&self) -> f64 {
        std::f64::consts::PI * self.radius_m * self.radius_m
    }
}

/// A physical effect: its entry in the catalogue, and how it acts.
#[derive(Debug, Clone, Copy)]
pub struct BallEffect {
    /// Its name in simulation files.
    pub name: &'static str,
    /// Where it acts.
    pub phase: &'static Phase,
    /// Its numbers.
    pub coefficients: &'static [Coefficient],
    /// The physical bounds of each coefficient for this ball.
    pub plausible: fn(&Body) -> Vec<(f64, f64)>,
    /// What it is, in one plain sentence.
    pub sentence: &'static str,
    /// Effects that some recordings cannot distinguish from it.
    pub mistaken_for: &'static [&'static str],
    /// Largest share of the forecast error that may remain where few recordings show it; see [`Effect::forecast_share`].
    pub forecast_share: f64,
    /// Why it is not to be expected of this ball where something else explains its recordings as well.
    pub implausible: fn(&Body) -> Option<&'static str>,
    /// Whether the bounce times of a vertical drop show it.
    pub shows_in_bounce_times: bool,
    /// Adds it to a scene.
    pub apply: fn(&mut Scene, &[f64]),
}

/// The catalogue.
pub const ALL: [BallEffect; 12] = [
    quadratic_drag::EFFECT,
    linear_drag::EFFECT,
    wind::EFFECT,
    magnus::EFFECT,
    effective_gravity::EFFECT,
    speed_dependent_restitution::EFFECT,
    surface_tilt::EFFECT,
    bounce_friction::EFFECT,
    tangential_restitution::EFFECT,
    contact_time::EFFECT,
    rolling_resistance::EFFECT,
    bounce_scatter::EFFECT,
];

impl BallEffect {
    /// The effect of this name.
    #[must_use]
    pub fn find(name: &str) -> Option<Self> {
        ALL.into_iter().find(|e| e.name == name)
    }

    /// Its entry for this ball.
    #[must_use]
    pub fn entry(&self, body: &Body) -> Effect {
        let of_unknown_mass = (self.plausible)(&Body { mass_kg: None, ..*body });
        Effect {
            plausible: (self.plausible)(body),
            plausible_rests_on: if (self.plausible)(body) == of_unknown_mass {
                Vec::new()
            } else {
                MASS_AND_SIZE.map(Text::from).to_vec()
            },
            always: self.name == DRAG && body.in_air,
            random: self.name == bounce_scatter::EFFECT.name,
            mistaken_for: self.mistaken_for.iter().map(|name| (*name).into()).collect(),
            implausible: (self.implausible)(body).map(Text::from),
            forecast_share: self.forecast_share,
            ..Effect::new(self.name, self.phase.clone(), self.sentence, self.coefficients.to_vec())
        }
    }
}
