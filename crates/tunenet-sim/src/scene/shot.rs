//! The scene of a bounce shot: plane, hoop, release and robot, as the task file describes them.

use std::path::PathBuf;

use serde::Deserialize;

/// A bounce shot. Every place is in metres from the ball's centre when it touches the plane, z up.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Task {
    /// What is to be done.
    pub kind: TaskKind,
    /// What the ball bounces off.
    #[serde(default)]
    pub plane: Plane,
    /// What the ball has to fall through.
    pub hoop: TaskHoop,
    /// From where the ball may be released.
    pub release: TaskRelease,
    /// What holds the ball; a hand that reaches everywhere where it is `None`.
    #[serde(default)]
    pub arm: Option<ArmTask>,
}

/// What a task file asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TaskKind {
    /// A ball that bounces off a plane through a hoop.
    Shot,
}

/// The plane; level by default.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Plane {
    /// Tilt about x, rad.
    pub tilt_about_x_rad: f64,
    /// Tilt about y, rad.
    pub tilt_about_y_rad: f64,
}

impl Plane {
    /// Tilt about x and y, rad.
    #[must_use]
    pub fn tilt_rad(&self) -> [f64; 2] {
        [self.tilt_about_x_rad, self.tilt_about_y_rad]
    }
}

/// The hoop; level where the file does not tilt it.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TaskHoop {
    /// Its centre, m.
    pub centre_m: [f64; 3],
    /// From its centre to the middle of its wire, m; above 0.
    pub radius_m: f64,
    /// Half the thickness of its wire, m; 0 by default.
    #[serde(default)]
    pub rim_radius_m: f64,
    /// Tilt about x, rad.
    #[serde(default)]
    pub tilt_about_x_rad: f64,
    /// Tilt about y, rad.
    #[serde(default)]
    pub tilt_about_y_rad: f64,
}

impl TaskHoop {
    /// Tilt about x and y, rad.
    #[must_use]
    pub fn tilt_rad(&self) -> [f64; 2] {
        [self.tilt_about_x_rad, self.tilt_about_y_rad]
    }
}

/// From where the ball may be released, and how exactly.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TaskRelease {
    /// Lowest and highest release of the ball's centre above the impact point, m.
    pub heights_m: (f64, f64),
    /// Standard deviation of the place of a release along each axis, m; 0 by default.
    #[serde(default)]
    pub position_sd_m: f64,
    /// Standard deviation of its velocity along each axis, m/s; 0 by default.
    #[serde(default)]
    pub velocity_sd_m_s: f64,
}

/// A robot that lets the ball go.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ArmTask {
    /// Its URDF; once a task file has been read, as seen from where the program runs.
    pub urdf: PathBuf,
    /// The link that holds the ball; the last one of the URDF where it is `None`.
    #[serde(default)]
    pub link: Option<String>,
    /// Where that link holds the ball's centre, in its own frame, m.
    #[serde(default)]
    pub grip_m: [f64; 3],
    /// Roll, pitch and yaw of that link at the release, rad; any where it is `None`.
    #[serde(default)]
    pub tool_rpy_rad: Option<[f64; 3]>,
    /// Where the base stands, m.
    #[serde(default)]
    pub base_position_m: [f64; 3],
    /// Roll, pitch and yaw of the base, rad.
    #[serde(default)]
    pub base_rpy_rad: [f64; 3],
}
