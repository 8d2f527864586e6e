//! Rollouts of a robot: from parameters, effects and what drove a recording to what is read of its joints.

use tunenet_core::Result;
use tunenet_core::simulator::{Model as Rollouts, Preparation, Prepared, RolloutResult, Run};

use super::acting::{pole, undefined};
use super::imperfect::Imperfect;
use super::layout::{Layout, Role, Wiring};
use super::numbers::JointNumbers;
use super::rig::Rig;
use super::trajectory::{Grid, Quantity, Readout, Trajectory};
use super::wiring::Wire;
use super::{chain, examine, one_joint, two_masses};

/// Most steps of one rollout.
const MOST_STEPS: f64 = 5e7;

/// A robot that simulates.
#[derive(Debug, Clone)]
pub struct RobotModel {
    rigs: Vec<Rig>,
    pub(super) layout: Layout,
}

impl RobotModel {
    pub(crate) fn new(rigs: Vec<Rig>, layout: Layout) -> Self {
        Self { rigs, layout }
    }

    fn imperfect(&self, joints: usize, coefficients: &[f64]) -> Imperfect {
        let mut imperfect = Imperfect::none(joints);
        let mut rest = coefficients;
        for effect in &self.layout.effects {
            let (own, others) = rest.split_at(effect.numbers(joints).min(rest.len()));
            effect.apply(&mut imperfect, own);
            rest = others;
        }
        imperfect
    }

    /// The steps of a rollout until the last of these instants.
    fn grid(&self, rig: &Rig, run: &Run) -> std::result::Result<Trajectory, String> {
        let start_s = run.recording.start_s;
        let last = run.times_s.last().copied().unwrap_or(start_s).max(start_s);
        let steps = ((last - start_s) / rig.step_s).ceil().max(1.0);
        if steps.is_nan() || steps > MOST_STEPS {
            return Err(format!("{:.0} s in steps of {} s are too many steps", last - start_s, rig.step_s));
        }
        let torques = self.layout.readings.iter().any(|reading| reading.quantity == Quantity::Torque);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "bounded above")]
        Ok(Trajectory::new(Grid { start_s, step_s: rig.step_s }, steps as usize, rig.joints.len(), torques))
    }
}

/// The joints of a setup with these parameters and effects.
pub(crate) fn driven_joints(
    joints: &[JointNumbers],
    roles: &[Role],
    parameters: &[f64],
    imperfect: &Imperfect,
) -> Vec<JointNumbers> {
    let mut joints = joints.to_vec();
    for (role, value) in roles.iter().zip(parameters) {
        *role.number.of(&mut joints[role.joint]) = *value;
    }
    let arm = &imperfect.arm;
    for (j, (joint, drive)) in joints.iter_mut().zip(&imperfect.drives).enumerate() {
        joint.viscous += arm.viscous_nms_rad[j];
        joint.coulomb += arm.coulomb_nm[j];
        joint.armature += arm.armature_kg_m2[j];
        joint.zero += arm.offset_rad[j];
        joint.spring += arm.spring_nm_rad[j];
        joint.compliance += arm.elasticity_rad_nm[j];
        joint.stribeck += arm.stribeck_nm[j];
        joint.stribeck_speed = arm.stribeck_rad_s[j];
        joint.gap += drive.gap_rad;
        joint.inverse_speed += drive.inverse_speed_s_rad;
        joint.command_delay_s += drive.command_delay_s;
        joint.command_lag_s += drive.command_lag_s;
        joint.command_offset += drive.command_offset_rad;
        joint.release_delay_s += drive.release_delay_s;
        joint.load_friction += drive.load_friction;
        joint.directional += drive.directional_nm;
        joint.quadratic += drive.quadratic_nms2_rad2;
        joint.dead_band += drive.dead_band_rad;
        joint.duty_max *= drive.duty_fraction;
        joint.kp *= drive.gain_factor;
        joint.kd = (joint.kd + drive.kd).max(0.0);
        joint.sag_ohm += drive.sag_ohm;
        joint.release_braking += drive.release_braking_nms_rad;
    }
    joints
}

impl Rollouts for RobotModel {
    fn has_own_measurement(&self) -> bool {
        true
    }

    fn checks_states(&self) -> bool {
        true
    }

    fn examine(&self, prepared: Box<Prepared>) -> Result<Preparation> {
        let setup = prepared.circumstances.as_ref().map_or(0, |known| known.setup);
        let (joints, step_s) = self.rigs.get(setup).map_or((&[][..], 0.0), |rig| (&rig.joints, rig.step_s));
        examine::examine(&self.layout, (joints, step_s), prepared)
    }

    fn simulate(&self, run: &Run, values: &mut [f64]) -> RolloutResult {
        let setup = run.recording.setup;
        let rig = self.rigs.get(setup).ok_or_else(|| format!("no robot for setup {setup}"))?;
        let imperfect = self.imperfect(rig.joints.len(), run.coefficients);
        let joints = driven_joints(&rig.joints, &self.layout.roles, run.parameters, &imperfect);
        let (mut q, mut w) = (vec![0.0; joints.len()], vec![0.0; joints.len()]);
        for (start, value) in self.layout.starts.iter().zip(run.start) {
            let list = if start.speed { &mut w } else { &mut q };
            list[start.joint] = *value;
        }
        let mut out = self.grid(rig, run)?;
        q.iter().zip(&w).enumerate().for_each(|(j, (q, w))| out.state(0, j, *q, *w));
        let (inputs, grid) = (&run.recording.inputs, out.grid);
        let wire = |(joint, wiring): (&JointNumbers, &Wiring)| {
            let of = |place: Option<usize>| place.and_then(|place| inputs.get(place));
            Wire::new(joint, of(wiring.command), of(wiring.enable), grid)
        };
        let wires = || -> Vec<Wire> { joints.iter().zip(&self.layout.wiring).map(wire).collect() };
        let mut read = wires();
        let formulas = imperfect.arm.formulas.as_slice();
        let elastic = joints.iter().any(|joint| joint.gap > 0.0 || joint.compliance > 0.0);
        let rolled: RolloutResult = match (joints.as_slice(), rig.load(&imperfect)) {
            ([joint], Some(load)) if elastic => {
                two_masses::roll((joint, &load, formulas), &mut read[0], (q[0], w[0]), &mut out).map_err(Into::into)
            }
            ([joint], Some(load)) => {
                if load.inertia + joint.armature <= 0.0 {
                    return Err("the joint has no inertia: its armature or its link needs some".into());
                }
                one_joint::roll((joint, &load, formulas), &mut read[0], (q[0], w[0]), &mut out).map_err(Into::into)
            }
            _ if elastic => return Err("backlash and elasticity are simulated at a single joint only".into()),
            _ => {
                let (world, gravity) = rig.world(&imperfect);
                chain::roll((&joints, &world, gravity, formulas), &mut read, (&q, &w), &mut out).map_err(Into::into)
            }
        };
        if let Err(why) = rolled {
            return Err(undefined(formulas, wires(), &out).map_or(why, Into::into));
        }
        if let Some(why) = pole(formulas, wires, &out) {
            return Err(why.into());
        }
        let readout = Readout { delay_s: imperfect.reading_delay_s, latch_s: imperfect.latch_s };
        let width = self.layout.readings.len();
        for (row, &time_s) in values.chunks_exact_mut(width).zip(run.times_s) {
            for (value, reading) in row.iter_mut().zip(&self.layout.readings) {
                *value = reading.factor * out.read(time_s, reading.joint, reading.quantity, readout);
            }
        }
        Ok(())
    }
}
