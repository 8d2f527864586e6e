//! What a driven joint may have beyond its simulation.
//!
//! One file each, which holds the entry of the catalogue and what its numbers change; [`all`] is the list, together with
//! effects that [arms](crate::arm::effects) have as well. To add one, write its file and its line: the simulation file, rollouts and
//! diagnosis follow from the list. Numbers of joints stand in the order of the model.

mod backlash;
mod command_delay;
mod command_lag;
mod command_offset;
mod dead_band;
mod directional_friction;
mod duty_limit;
mod extra_load;
mod firmware_damping;
mod firmware_gain;
mod joint_elasticity;
mod load_friction;
mod load_offset;
mod position_latch;
mod quadratic_friction;
mod release_braking;
mod release_delay;
mod slide;
mod speed_limit;
mod stribeck_friction;
mod time_delay;
mod voltage_sag;

use tunenet_core::simulator::{Coefficient, Effect, Phase, Side, Twin};

pub(crate) use self::slide::{in_units_of_joints, unit_of_slide};
use super::imperfect::{DriveEffects, Imperfect};
use super::numbers::Number;
use crate::arm::effects::{self as arm, Imperfections};

/// An effect of a robot: its entry in the catalogue, and how it acts.
#[derive(Debug, Clone)]
pub struct RobotEffect {
    /// Its name in simulation files.
    pub name: &'static str,
    /// Where it acts.
    pub phase: Phase,
    /// Whether every joint has numbers of its own.
    pub per_joint: bool,
    /// Its numbers, each as of one joint.
    pub coefficients: &'static [Coefficient],
    /// The physical bounds of each of them.
    pub plausible: &'static [(f64, f64)],
    /// What it is, in one plain sentence.
    pub sentence: &'static str,
    /// Effects that some recordings cannot distinguish from it.
    pub mistaken_for: &'static [&'static str],
    /// The key of a joint that it states anew.
    pub restates: Option<&'static str>,
    /// The numbers of every joint that together do the same.
    repeated_by: &'static [Number],
    /// Effects that no recording distinguishes from it.
    pub twins: &'static [RobotTwin],
    act: Act,
}

/// An effect that looks like another one in every recording of joints that start at rest.
#[derive(Debug, Clone)]
pub struct RobotTwin {
    name: &'static str,
    side: Side,
    /// A number of every joint that has to be tuned: where it is known, recordings do distinguish both.
    tuned: Option<Number>,
    separated_by: &'static str,
}

/// What the numbers of an effect change, those of all joints of the first coefficient first.
#[derive(Debug, Clone, Copy)]
enum Act {
    /// The robot as a whole.
    Robot(fn(&mut Imperfect, &[f64])),
    /// The drive of each joint, by its own number.
    Drives(fn(&mut DriveEffects, &[f64])),
    /// The arm, as arms have it.
    Arm(fn(&mut Imperfections, &[f64])),
}

/// The effects of arms that joints from commands have too, by name, with the numbers of every joint that together do the same. The
/// sentence and the rest of the entry are the arm's own.
const OF_ARMS: [(&str, &[Number]); 7] = [
    ("viscous_friction", &[Number::Viscous]),
    ("coulomb_friction", &[Number::Coulomb]),
    ("armature", &[Number::Armature]),
    ("joint_offset", &[Number::Zero]),
    ("joint_spring", &[]),
    ("payload_com_offset", &[]),
    ("base_tilt", &[]),
];

/// What looks like an effect in one setup, and what does: a tilt scales the weight of a joint by its cosine, as a wrong mass does, and the
/// mean over the phases of a latch is a short lag. A motor of half the strength moves as one of a joint twice as heavy.
const FEIGNED_BY: [(&str, &str); 4] = [
    ("base_tilt", WRONG_MASSES),
    ("payload_com_offset", WRONG_MASSES),
    ("extra_load", OTHER_STRENGTH),
    ("position_latch", OTHER_TIMING),
];
const WRONG_MASSES: &str = "a wrong mass or centre of mass of a link or load";
const OTHER_STRENGTH: &str = "another mass or inertia of a link, or a motor of another strength";
const OTHER_TIMING: &str = "a filter or an interpolation of commands or readings";

const OWN: [&RobotEffect; 21] = [
    &stribeck_friction::EFFECT,
    &joint_elasticity::EFFECT,
    &speed_limit::EFFECT,
    &command_delay::EFFECT,
    &command_lag::EFFECT,
    &command_offset::EFFECT,
    &release_delay::EFFECT,
    &load_friction::EFFECT,
    &directional_friction::EFFECT,
    &quadratic_friction::EFFECT,
    &dead_band::EFFECT,
    &backlash::EFFECT,
    &duty_limit::EFFECT,
    &firmware_gain::EFFECT,
    &firmware_damping::EFFECT,
    &voltage_sag::EFFECT,
    &release_braking::EFFECT,
    &load_offset::EFFECT,
    &extra_load::EFFECT,
    &position_latch::EFFECT,
    &time_delay::EFFECT,
];

/// The catalogue.
#[must_use]
pub fn all() -> Vec<RobotEffect> {
    let known = |effect: arm::ArmEffect| {
        let (_, repeated_by) = OF_ARMS.iter().find(|(name, _)| *name == effect.name)?;
        Some(of_arm(effect, repeated_by))
    };
    let of_arms = arm::ALL.into_iter().filter_map(known);
    of_arms.chain(OWN.into_iter().cloned()).collect()
}

fn of_arm(effect: arm::ArmEffect, repeated_by: &'static [Number]) -> RobotEffect {
    RobotEffect {
        name: effect.name,
        phase: effect.phase.clone(),
        per_joint: effect.per_joint,
        coefficients: effect.coefficients,
        plausible: effect.plausible,
        sentence: effect.sentence,
        mistaken_for: effect.mistaken_for,
        restates: None,
        repeated_by,
        twins: &[],
        act: Act::Arm(effect.apply),
    }
}

impl RobotEffect {
    /// The effect of this name.
    #[must_use]
    pub fn find(name: &str) -> Option<Self> {
        all().into_iter().find(|effect| effect.name == name)
    }

    /// How many numbers each of its coefficients has on a robot of so many joints.
    #[must_use]
    pub fn numbers(&self, joints: usize) -> usize {
        if self.per_joint { joints } else { 1 }
    }

    /// The bounds of one of its coefficients in a file, which does not say which joints slide.
    #[must_use]
    pub(crate) fn bounds_in_files(&self, c: &Coefficient) -> (f64, f64) {
        if self.per_joint { slide::bounds_of_any_joint(c) } else { (c.min, c.max) }
    }

    /// Its entry for a robot with these joints: each coefficient stands there once for every joint, under the same key and numbered
    /// by the joint. `tuned` is whether a number is tuned in every joint.
    #[must_use]
    pub(crate) fn entry(&self, joints: &[&str], tuned: impl Fn(Number) -> bool) -> Effect {
        let each = self.numbers(joints.len());
        let of_joints = |c: &Coefficient| -> Vec<Coefficient> {
            if self.per_joint {
                (1..=joints.len()).map(|joint| c.clone().numbered(joint)).collect()
            } else {
                vec![c.clone()]
            }
        };
        let coefficients = self.coefficients.iter().flat_map(of_joints).collect();
        let known =
            |name: &&&str| OF_ARMS.iter().any(|(arm, _)| arm == *name) || OWN.iter().any(|own| own.name == **name);
        let twins = self.twins.iter().filter(|twin| twin.tuned.is_none_or(&tuned));
        let repeating =
            |joint: &&str| self.repeated_by.iter().map(|number| number.parameter_of(joint).into()).collect();
        let twin =
            |one: &RobotTwin| Twin { name: one.name.into(), side: one.side, separated_by: one.separated_by.into() };
        Effect {
            exact_twins: twins.map(twin).collect(),
            restates: self.restates.map_or_else(Vec::new, |key| {
                joints.iter().map(|joint| format!("joints.{joint}.{key}").into()).collect()
            }),
            repeated_by: if self.repeated_by.is_empty() { Vec::new() } else { joints.iter().map(repeating).collect() },
            plausible: self.plausible.iter().flat_map(|p| std::iter::repeat_n(*p, each)).collect(),
            mistaken_for: self.mistaken_for.iter().filter(known).map(|name| (*name).into()).collect(),
            feigned_by: FEIGNED_BY.iter().find(|(name, _)| *name == self.name).map(|(_, by)| (*by).into()),
            ..Effect::new(self.name, self.phase.clone(), self.sentence, coefficients)
        }
    }

    /// Adds it to what a robot has, the numbers of all joints of the first coefficient first.
    pub(crate) fn apply(&self, robot: &mut Imperfect, values: &[f64]) {
        match self.act {
            Act::Robot(act) => act(robot, values),
            Act::Arm(act) => act(&mut robot.arm, values),
            Act::Drives(act) => {
                for (j, drive) in robot.drives.iter_mut().enumerate() {
                    let own: [f64; 1] = [values[j]];
                    act(drive, &own);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_every_absent_number_changes_nothing() {
        let all = all();
        assert_eq!(all.len(), OF_ARMS.len() + OWN.len());
        for (i, effect) in all.iter().enumerate() {
            assert!(all[..i].iter().all(|other| other.name != effect.name), "{}", effect.name);
            let entry = effect.entry(&["a", "b"], |_| true);
            let absent: Vec<f64> = entry.coefficients.iter().map(|c| c.absent).collect();
            let mut robot = Imperfect::none(2);
            effect.apply(&mut robot, &absent);
            // The width of Stribeck's friction shapes it alone.
            robot.arm.stribeck_rad_s = vec![1.0; 2];
            assert_eq!(robot, Imperfect::none(2), "{}", effect.name);
        }
    }

    #[test]
    fn a_wrong_mass_looks_like_a_tilt_and_a_filter_like_a_latch() {
        let feigned = |name: &str| RobotEffect::find(name).unwrap().entry(&["a"], |_| true).feigned_by;
        assert_eq!(feigned("base_tilt").as_deref(), Some(WRONG_MASSES));
        assert_eq!(feigned("position_latch").as_deref(), Some(OTHER_TIMING));
        assert_eq!(feigned("dead_band"), None);
    }

    /// Twins are twins of each other, but for a gain below the stated one; where the stall torque is known there are none of the duty.
    #[test]
    fn twins_name_each_other() {
        let twins = |name: &str, tuned: bool| RobotEffect::find(name).unwrap().entry(&["a"], |_| tuned).exact_twins;
        for (one, other) in [("command_delay", "time_delay"), ("firmware_gain", "duty_limit")] {
            for (name, twin) in [(one, other), (other, one)] {
                assert_eq!(twins(name, true).iter().map(|t| t.name.as_ref()).collect::<Vec<_>>(), [twin]);
            }
        }
        assert!(twins("firmware_gain", true)[0].side == Side::Above && twins("duty_limit", true)[0].side == Side::Any);
        assert!(twins("firmware_gain", false).is_empty() && twins("duty_limit", false).is_empty());
        assert_eq!(twins("time_delay", false).len(), 1);
        // A centre of mass may be anywhere, a load only farther out: what names the former is no twin of the latter.
        assert_eq!(twins("load_offset", true)[0].name, "payload_com_offset");
        assert!(twins("payload_com_offset", true).is_empty());
        let gain = RobotEffect::find("firmware_gain").unwrap().entry(&["a", "b"], |_| true);
        assert_eq!(gain.restates, ["joints.a.gain_1_rad", "joints.b.gain_1_rad"]);
        let friction = RobotEffect::find("coulomb_friction").unwrap().entry(&["a", "b"], |_| true);
        assert_eq!(friction.repeated_by, [["a__coulomb"], ["b__coulomb"]]);
        let braking = RobotEffect::find("release_braking").unwrap().entry(&["a"], |_| true);
        assert_eq!(braking.repeated_by, [["a__viscous", "a__back_emf"]]);
    }

    #[test]
    fn every_joint_has_its_own_number() {
        let mut robot = Imperfect::none(2);
        RobotEffect::find("speed_limit").unwrap().apply(&mut robot, &[0.2, 0.4]);
        assert_eq!((robot.drives[0].inverse_speed_s_rad, robot.drives[1].inverse_speed_s_rad), (0.2, 0.4));
    }
}
