//! What a real arm's torques hold beyond those of rigid bodies.
//!
//! One file each, which holds the entry of the catalogue and how the coefficients enter the [`Imperfections`]; [`ALL`] is
//! the list. To add one, write its file and its line: the simulation file, replaying and diagnosis follow from the list.
//! Coefficients of a joint are one number for each joint, in the order of the URDF.

mod armature;
mod base_tilt;
mod coulomb_friction;
mod imperfections;
mod joint_elasticity;
mod joint_offset;
mod joint_spring;
mod payload_com_offset;
mod stribeck_friction;
mod time_delay;
mod torque_bias;
mod torque_gain;
mod viscous_friction;

pub use imperfections::Imperfections;

use tunenet_core::simulator::{Coefficient, Effect, Follows, Phase};

/// An effect of an arm: its entry in the catalogue, and how it acts.
#[derive(Debug, Clone, Copy)]
pub struct ArmEffect {
    /// Its name in simulation files.
    pub name: &'static str,
    /// Where it acts: in the arm, or in how torque and motion were measured.
    pub phase: &'static Phase,
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
    /// What its torque follows, and what it does where that varies.
    pub excited_by: (Follows, &'static str),
    /// Adds it to what an arm has, the numbers of all joints of the first coefficient first.
    pub apply: fn(&mut Imperfections, &[f64]),
}

/// The catalogue.
pub const ALL: [ArmEffect; 12] = [
    viscous_friction::EFFECT,
    coulomb_friction::EFFECT,
    stribeck_friction::EFFECT,
    armature::EFFECT,
    torque_bias::EFFECT,
    torque_gain::EFFECT,
    joint_offset::EFFECT,
    joint_spring::EFFECT,
    joint_elasticity::EFFECT,
    payload_com_offset::EFFECT,
    base_tilt::EFFECT,
    time_delay::EFFECT,
];

/// What wrong links look like in torques: each of these in one motion or another.
const FEIGNED_BY_LINKS: [&str; 4] =
    [armature::EFFECT.name, joint_offset::EFFECT.name, joint_spring::EFFECT.name, joint_elasticity::EFFECT.name];
const WRONG_LINKS: &str = "wrong masses, centres or inertias of links in the URDF";

impl ArmEffect {
    /// The effect of this name.
    #[must_use]
    pub fn find(name: &str) -> Option<Self> {
        ALL.into_iter().find(|e| e.name == name)
    }

    /// How many numbers each of its coefficients has on an arm of so many joints.
    #[must_use]
    pub fn numbers(&self, joints: usize) -> usize {
        if self.per_joint { joints } else { 1 }
    }

    /// Its entry for an arm of so many joints: each coefficient stands there once for every joint, under the same key and
    /// numbered by the joint.
    #[must_use]
    pub fn entry(&self, joints: usize) -> Effect {
        let each = self.numbers(joints);
        let of_joints = |c: &Coefficient| -> Vec<Coefficient> {
            if self.per_joint { (1..=joints).map(|joint| c.clone().numbered(joint)).collect() } else { vec![c.clone()] }
        };
        let coefficients = self.coefficients.iter().flat_map(of_joints).collect();
        Effect {
            plausible: self.plausible.iter().flat_map(|p| std::iter::repeat_n(*p, each)).collect(),
            mistaken_for: self.mistaken_for.iter().map(|name| (*name).into()).collect(),
            feigned_by: FEIGNED_BY_LINKS.contains(&self.name).then_some(WRONG_LINKS.into()),
            ..Effect::new(self.name, self.phase.clone(), self.sentence, coefficients)
        }
        .excited_by(self.excited_by.0, self.excited_by.1)
    }

    /// Whether these numbers mean that it is not there: its first coefficient is absent in every joint.
    #[must_use]
    pub fn is_absent(&self, values: &[f64]) -> bool {
        let first = if self.per_joint { values.len() / self.coefficients.len().max(1) } else { values.len() };
        values[..first].iter().enumerate().all(|(i, v)| {
            let coefficient = if self.per_joint { 0 } else { i };
            *v == self.coefficients[coefficient].absent
        })
    }
}

/// Adds number by number.
fn add(to: &mut [f64], values: &[f64]) {
    to.iter_mut().zip(values).for_each(|(to, value)| *to += value);
}
