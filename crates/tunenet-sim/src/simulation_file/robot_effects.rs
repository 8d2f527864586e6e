//! The effects of a robot's file: numbers for each joint as lists in the order of the model.

use toml_edit::Item;
use tunenet_core::simulator::Coefficient;
use tunenet_formats::Result;

use super::SimulationFile;
use super::joint_numbers::{JointNumbersOf, refused};
use crate::robot::effects::RobotEffect;

/// An effect that a robot's file holds.
#[derive(Debug, Clone)]
pub struct PresentRobotEffect {
    /// Its entry of the catalogue.
    pub effect: RobotEffect,
    /// Its numbers, those of all joints of the first coefficient first; absent where the file leaves one out.
    pub values: Vec<f64>,
    /// Whether `tune` may change them.
    pub tune: bool,
}

impl SimulationFile {
    /// The effects of the catalogue that the file of a robot holds, in its order.
    ///
    /// # Errors
    /// [`Error::File`](tunenet_formats::Error::File) where a list has not one number for each joint.
    pub fn robot_effects(&self) -> Result<Vec<PresentRobotEffect>> {
        let joints = self.robot()?.joints.len();
        let Some(all) = self.item("effects").and_then(Item::as_table_like) else { return Ok(Vec::new()) };
        let mut found = Vec::new();
        for (name, item) in all.iter() {
            let (Some(table), Some(effect)) = (item.as_table_like(), RobotEffect::find(name)) else { continue };
            let (values, tune) = numbers_of(&effect, joints).read(self, table, "the order is that of the model")?;
            found.push(PresentRobotEffect { effect, values, tune });
        }
        Ok(found)
    }

    /// Writes an effect's numbers under `[effects.NAME]`, as [`robot_effects`](Self::robot_effects) gives them; everything else is
    /// kept as it stands.
    ///
    /// # Errors
    /// [`Setting`](tunenet_core::Error::Setting) where the effect is unknown or a number is outside its bounds; the
    /// file is as before then.
    pub fn add_robot_effect(&mut self, name: &str, values: &[f64]) -> Result<()> {
        let Some(effect) = RobotEffect::find(name) else {
            return Err(refused("an effect of a robot".into(), format!("`{name}`")));
        };
        // Bounds of hinges and of slides alike; whoever simulates the file knows which joints slide.
        let widened = |c: &Coefficient| {
            let (min, max) = effect.bounds_in_files(c);
            Coefficient { min, max, ..c.clone() }
        };
        let coefficients: Vec<Coefficient> = effect.coefficients.iter().map(widened).collect();
        JointNumbersOf { coefficients: &coefficients, ..numbers_of(&effect, 1) }.write(self, values)
    }

    /// Writes the value of a parameter of a robot, be it a number of an effect (`load_friction.mu.2`) or a parameter of the file.
    ///
    /// # Errors
    /// As [`add_robot_effect`](Self::add_robot_effect) and [`robot_effects`](Self::robot_effects).
    pub fn set_robot_value(&mut self, name: &str, value: f64) -> Result<()> {
        let parts: Vec<&str> = name.split('.').collect();
        if let (Some(_), Some((effect, key))) = (self.candidate(parts[0]), name.split_once('.')) {
            return self.add_effect(effect, &[(key, value)]);
        }
        let (Some(effect), Some(_)) = (RobotEffect::find(parts[0]), parts.get(1)) else {
            self.set_value(name, value);
            return Ok(());
        };
        let joints = self.robot()?.joints.len();
        let present = self.robot_effects()?.into_iter().find(|p| p.effect.name == effect.name);
        let values = numbers_of(&effect, joints).with(present.map(|p| p.values), &parts[1..], value);
        self.add_robot_effect(effect.name, &values)
    }
}

fn numbers_of(effect: &RobotEffect, joints: usize) -> JointNumbersOf<'_> {
    let RobotEffect { name, coefficients, per_joint, .. } = *effect;
    JointNumbersOf { name, coefficients, per_joint, count: effect.numbers(joints) }
}
