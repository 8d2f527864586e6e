//! The scene of an arm.

use std::path::PathBuf;

use nalgebra::Vector3;
use serde::Deserialize;

use super::{Candidates, GRAVITY_M_S2, Record};
use crate::arm::Circle;

/// An arm that moves a payload.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct ArmScene {
    /// Gravity.
    #[serde(default)]
    pub world: ArmWorld,
    /// The arm itself.
    pub arm: ArmBody,
    /// What it does.
    pub motion: Motion,
    /// What is written of it.
    #[serde(default)]
    pub record: Record,
    /// Effects that it may lack, as formulas.
    #[serde(default)]
    pub candidates: Candidates,
}

/// Where an arm stands.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ArmWorld {
    /// Gravity, downwards, m/s².
    pub gravity_m_s2: f64,
}

impl Default for ArmWorld {
    fn default() -> Self {
        Self { gravity_m_s2: GRAVITY_M_S2 }
    }
}

/// The arm itself.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ArmBody {
    /// Its URDF, from the folder of the file.
    pub urdf: PathBuf,
    /// The link that holds the payload.
    pub payload_link: String,
    /// Edge of the payload, a homogeneous cube, m; a point at 0.
    #[serde(default)]
    pub payload_size_m: f64,
    /// Torque for each ampere, joint by joint, N·m/A, where currents were recorded.
    #[serde(default)]
    pub current_gain_nm_a: Option<Vec<f64>>,
}

/// What the arm does.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Motion {
    /// Whether it draws a circle or follows recorded joints.
    pub kind: MotionKind,
    /// Centre of the circle, m.
    pub centre_m: Option<[f64; 3]>,
    /// Its radius, m.
    pub radius_m: Option<f64>,
    /// How fast it is drawn, rad/s.
    pub rate_rad_s: Option<f64>,
    /// For how long, s.
    pub duration_s: Option<f64>,
    /// Of recorded joints: what is faster is smoothed away, Hz.
    pub cutoff_hz: Option<f64>,
}

/// Which motion an arm follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MotionKind {
    /// A circle of the tool.
    Circle,
    /// Recorded joints.
    Replay,
}

impl Motion {
    /// The circle, with what is left out at its default.
    #[must_use]
    pub fn circle(&self) -> Circle {
        let default = Circle::default();
        Circle {
            centre_m: self.centre_m.map_or(default.centre_m, Vector3::from),
            radius_m: self.radius_m.unwrap_or(default.radius_m),
            rate_rad_s: self.rate_rad_s.unwrap_or(default.rate_rad_s),
            duration_s: self.duration_s.unwrap_or(default.duration_s),
            tool: default.tool,
        }
    }
}
