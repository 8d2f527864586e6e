//! An arm as a simulator that core can tune: it follows a motion, and its joints' torques are observed.
//!
//! ```text
//! simulation file → URDF, motion → controller without the payload → Rapier's arm with it → commanded torques
//! ```

mod prepare;
mod rollout;

use std::path::{Path, PathBuf};

use toml_edit::Item;
use tunenet_core::observation::{Channel, Kind, Note, Observation};
use tunenet_core::simulator::{Parameter, Preparation, RolloutResult, Simulator};
use tunenet_formats::{Error, Result};

use crate::SimulationFile;
use crate::arm::{Model, Motion, model_file};
use crate::scene::{ArmBody, MotionKind};

pub use rollout::{STEP_HZ, STIFFNESS_1_S2};

/// An arm that draws a circle with a payload which its controller does not know of.
///
/// Parameters: the payload's mass (kg) and its centre of mass in the axes of its link (m, 3). Channels: the commanded torque
/// of every joint between base and payload, `tau1`… in N·m (N of a joint that slides), in the order of the URDF. The clock
/// counts from the start of the motion.
#[derive(Debug, Clone)]
pub struct ObservedArm {
    /// From the base to the payload's link, everything else held.
    model: Model,
    /// The payload's link among the model's frames.
    link: usize,
    payload_size_m: f64,
    gravity_m_s2: f64,
    motion: Motion,
    parameters: Vec<Parameter>,
    channels: Vec<Channel>,
}

impl ObservedArm {
    /// The arm that `file` describes.
    ///
    /// # Errors
    /// What reading the URDF refuses; [`Error::File`] where a link that moves has no inertia, the payload's link is none, the
    /// circle cannot be drawn, or the motion is none that can be simulated.
    pub fn new(file: &SimulationFile) -> Result<Self> {
        let scene = file.arm()?;
        if scene.motion.kind == MotionKind::Replay {
            let message = "`motion.kind`: expected \"circle\", found \"replay\", which this command cannot simulate";
            return Err(Error::file(file.path(), message, "set motion.kind to \"circle\""));
        }
        has_rigid_bodies_alone(file)?;
        let (model, link) = arm(file)?;
        let circle = scene.motion.circle();
        let motion =
            Motion::circle(&model, &model.frames[link], &circle).map_err(|e| in_file(file, Part::Motion, e))?;
        let unit = |kind| if kind == crate::arm::JointKind::Prismatic { "N" } else { "N·m" };
        let joint = |(i, joint): (usize, &crate::arm::Joint)| Channel::new(format!("tau{}", i + 1), unit(joint.kind));
        let channels = model.joints().into_iter().enumerate().map(joint).collect();
        Ok(Self {
            link,
            payload_size_m: scene.arm.payload_size_m,
            gravity_m_s2: scene.world.gravity_m_s2,
            motion,
            parameters: file.parameters()?.into_iter().filter(|p| p.name != "torque_gain").collect(),
            channels,
            model,
        })
    }

    /// The arm's bodies and joints, from the base to the payload.
    #[must_use]
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// What it follows.
    #[must_use]
    pub fn motion(&self) -> &Motion {
        &self.motion
    }

    /// What the URDF says and the simulation leaves out.
    #[must_use]
    pub fn notes(&self) -> &[Note] {
        &self.model.notes
    }

    /// The instants of the file's record, s.
    #[must_use]
    pub fn clock(&self, rate_hz: f64) -> Vec<f64> {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "bounded by the schema's ranges")]
        let count = (self.motion.duration_s() * rate_hz + 1e-9).floor() as usize;
        (0..=count).map(|i| i as f64 / rate_hz).collect()
    }
}

/// Refuses effects and candidates, which this arm does not simulate.
fn has_rigid_bodies_alone(file: &SimulationFile) -> Result<()> {
    for table in ["effects", "candidates"] {
        let Some((name, _)) = file.item(table).and_then(Item::as_table_like).and_then(|all| all.iter().next()) else {
            continue;
        };
        let message = format!("`{table}.{name}`: an arm with motion.kind = \"circle\" simulates no {table}");
        let hint = format!("set motion.kind to \"replay\", or remove [{table}.{name}]");
        return Err(Error::file(file.path(), message, hint));
    }
    Ok(())
}

/// The chain from the base to the payload's link, which every motion of the arm shares, and that link among its frames.
///
/// # Errors
/// What reading the URDF refuses; [`Error::File`] as [`ObservedArm::new`].
pub fn arm(file: &SimulationFile) -> Result<(Model, usize)> {
    let arm = &file.arm()?.arm;
    let name = arm.payload_link.as_str();
    let chain =
        model_file::read(&next_to_file(file, arm))?.chain_to(name).map_err(|e| in_file(file, Part::PayloadLink, e))?;
    let model = chain.weighed().map_err(|e| in_file(file, Part::Urdf, e))?;
    let link = model.frames.iter().position(|f| f.name == name).unwrap_or(0);
    Ok((model, link))
}

/// What of the file a setting comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    Motion,
    PayloadLink,
    /// The URDF that the file names.
    Urdf,
}

/// A setting that `part` of the file is to blame for.
fn in_file(file: &SimulationFile, part: Part, error: tunenet_core::Error) -> Error {
    let tunenet_core::Error::Setting { name, expected, found, .. } = error else { return error.into() };
    let hint = match part {
        Part::Motion => "change centre_m, radius_m or rate_rad_s under [motion]; the arm's base is the origin",
        Part::PayloadLink => "name the link that holds the payload; its frame is where the payload is",
        Part::Urdf => {
            let path = urdf_path(file).unwrap_or_else(|_| file.path().to_path_buf());
            return Error::file(path, format!("expected {expected}, found {found}"), "mend the URDF");
        }
    };
    Error::file(file.path(), format!("`{name}`: expected {expected}, found {found}"), hint)
}

/// Where the file's URDF lies: next to the file, unless its path is absolute.
///
/// # Errors
/// [`Error::File`] where the file describes no arm.
pub fn urdf_path(file: &SimulationFile) -> Result<PathBuf> {
    Ok(next_to_file(file, &file.arm()?.arm))
}

fn next_to_file(file: &SimulationFile, arm: &ArmBody) -> PathBuf {
    file.path().parent().unwrap_or(Path::new("")).join(&arm.urdf)
}

impl Simulator for ObservedArm {
    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn kind(&self) -> Kind {
        Kind::Joints
    }

    fn prepare(&self, seen: &Observation) -> tunenet_core::Result<Preparation> {
        self.prepared(seen)
    }

    fn rollout(&self, parameters: &[f64], _nuisances: &[f64], clock: &[f64], values: &mut [f64]) -> RolloutResult {
        Ok(self.roll(parameters, clock, values)?)
    }
}
