//! The scene of a ball.

use serde::Deserialize;

use super::{Candidates, GRAVITY_M_S2, Record};
use crate::ball;
use crate::ball::effects::Body;

/// A ball above a surface.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(default)]
pub struct BallScene {
    /// Gravity and medium.
    pub world: BallWorld,
    /// The ball itself.
    pub ball: BallBody,
    /// What it bounces off.
    pub surface: Surface,
    /// How it starts.
    pub release: Release,
    /// What is written of it.
    pub record: Record,
    /// Effects that it may lack, as formulas.
    pub candidates: Candidates,
}

/// Gravity and medium.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BallWorld {
    /// Gravity, downwards, m/s².
    pub gravity_m_s2: f64,
    /// What the ball moves in.
    pub medium: Medium,
}

impl Default for BallWorld {
    fn default() -> Self {
        Self { gravity_m_s2: GRAVITY_M_S2, medium: Medium::Air }
    }
}

/// What a ball moves in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Medium {
    /// Air, whose drag on a ball is known within limits.
    Air,
    /// Something else.
    Other,
}

/// The ball itself.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BallBody {
    /// Radius, m.
    pub radius_m: f64,
    /// Mass, kg, where it is known.
    #[serde(default)]
    pub mass_kg: Option<f64>,
}

impl Default for BallBody {
    fn default() -> Self {
        Self { radius_m: ball::Scene::default().radius_m, mass_kg: None }
    }
}

/// The surface.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Surface {
    /// Its height, m; estimated from the data where it is `None`.
    pub height_m: Option<f64>,
    /// Its tilt about x, rad.
    pub tilt_about_x_rad: f64,
    /// Its tilt about y, rad.
    pub tilt_about_y_rad: f64,
}

/// How a ball starts, recording by recording: what is `None` is estimated from the data.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Release {
    /// Height of fall, from the ball's lowest point to the surface, m.
    pub height_m: Option<f64>,
    /// Start of the centre, m.
    pub position_m: Option<[f64; 3]>,
    /// Start velocity, m/s.
    pub velocity_m_s: Option<[f64; 3]>,
    /// Spin, rad/s.
    pub spin_rad_s: Option<[f64; 3]>,
    /// When it is released, s.
    pub time_s: Option<f64>,
}

/// The parameters of a ball, in the order in which its simulator takes them; coefficients of effects follow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BallParameters {
    /// Normal speed after a bounce over that before.
    pub restitution: f64,
    /// Coulomb's coefficient between ball and surface.
    pub friction: f64,
}

impl BallParameters {
    /// `restitution`, as files name it.
    pub const RESTITUTION: &str = "restitution";
    /// `friction`, as files name it.
    pub const FRICTION: &str = "friction";
    /// How many they are.
    pub const COUNT: usize = 2;

    /// The parameters among a simulator's values, and the coefficients behind them.
    pub(crate) fn split(values: &[f64]) -> (Self, &[f64]) {
        let (own, coefficients) = values.split_at(Self::COUNT);
        (Self { restitution: own[0], friction: own[1] }, coefficients)
    }
}

impl BallScene {
    /// What is known of the ball before anything is tuned.
    #[must_use]
    pub fn body(&self) -> Body {
        Body {
            radius_m: self.ball.radius_m,
            mass_kg: self.ball.mass_kg,
            gravity_m_s2: self.world.gravity_m_s2,
            in_air: self.world.medium == Medium::Air,
        }
    }

    /// The scene that is simulated, without effects; restitution and friction come from the parameters.
    #[must_use]
    pub fn simulated(&self) -> ball::Scene {
        let default = ball::Scene::default();
        ball::Scene {
            gravity_m_s2: self.world.gravity_m_s2,
            radius_m: self.ball.radius_m,
            mass_kg: self.ball.mass_kg.unwrap_or(default.mass_kg),
            surface_height_m: self.surface.height_m.unwrap_or(0.0),
            surface_tilt_about_x_rad: self.surface.tilt_about_x_rad,
            surface_tilt_about_y_rad: self.surface.tilt_about_y_rad,
            friction: 0.0,
            restitution: 0.0,
            ..default
        }
    }
}
