//! From a simulation file to a replayed arm.

use tunenet_core::observation::Note;
use tunenet_core::simulator::Simulator;
use tunenet_formats::{Error, Result};

use super::ReplayedArm;
use crate::SimulationFile;
use crate::observed_arm::arm;
use crate::scene::MotionKind;
use crate::simulation_file::PresentEffect;

/// Whether the arm of `file` follows recorded joints.
#[must_use]
pub fn replays(file: &SimulationFile) -> bool {
    file.arm().is_ok_and(|arm| arm.motion.kind == MotionKind::Replay)
}

impl ReplayedArm {
    /// The arm that `file` describes, its effects at the values that stand there.
    ///
    /// # Errors
    /// What reading the URDF refuses; [`Error::File`] and [`Setting`](tunenet_core::Error::Setting) where the file does
    /// not fit the arm.
    pub fn from_file(file: &SimulationFile) -> Result<Self> {
        let (model, link) = arm(file)?;
        let (payload, joints) = (model.frames[link].clone(), model.degrees());
        let scene = file.arm()?;
        let mut new = Self::new(model, payload, scene.world.gravity_m_s2, file.parameters()?)?;
        new.payload_size_m = scene.arm.payload_size_m;
        if let Some(hz) = scene.motion.cutoff_hz {
            new = new.with_cutoff(hz);
        }
        if let Some(gains) = scene.arm.current_gain_nm_a.clone() {
            new = new.with_current_gain(gains).map_err(|error| match error {
                tunenet_core::Error::Setting { name, expected, found, .. } => {
                    let message = format!("`{name}`: expected {expected}, found {found}");
                    Error::file(file.path(), message, "one number for each joint between base and payload")
                }
                other => other.into(),
            })?;
        }
        let formulas = file.joint_formulas(&new.joint_names())?;
        new = new.with_formulas(formulas);
        for present in file.arm_effects(joints)? {
            new = new.with_fixed(present.effect.name, &present.values)?;
        }
        for present in file.effects().into_iter().filter(|present| file.candidate(&present.name).is_some()) {
            new = new.with_fixed(&present.name, &present.values)?;
        }
        Ok(new)
    }

    /// What the URDF says and this arm leaves out.
    #[must_use]
    pub fn notes(&self) -> &[Note] {
        &self.arm.model.notes
    }

    /// What the URDF lacks of the joints that move, in their order.
    #[must_use]
    pub fn missing_limits(&self) -> Vec<Note> {
        self.arm.model.joints().iter().filter_map(|joint| joint.without_limits()).collect()
    }
}

/// The replayed arm of `file`, with the numbers of those effects free that the file asks to tune.
///
/// # Errors
/// As [`ReplayedArm::from_file`].
pub fn replayed(file: &SimulationFile) -> Result<Box<dyn Simulator>> {
    let arm = ReplayedArm::from_file(file)?;
    let present = file.arm_effects(arm.joint_names().len())?;
    let formulas: Vec<PresentEffect> =
        file.effects().into_iter().filter(|e| e.tune && file.candidate(&e.name).is_some()).collect();
    let built_in = present.iter().filter(|p| p.tune).map(|p| p.effect.name);
    let free: Vec<&str> = built_in.chain(formulas.iter().map(|e| e.name.as_str())).collect();
    Ok(if free.is_empty() { Box::new(arm) } else { arm.with_effects(&free)? })
}
