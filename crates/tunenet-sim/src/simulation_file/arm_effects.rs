//! The effects of an arm's file: numbers for each joint as lists in the order of the URDF.

use std::borrow::Cow;
use std::sync::LazyLock;

use toml_edit::Item;
use tunenet_formats::Result;

use super::SimulationFile;
use super::joint_numbers::{JointNumbersOf, refused};
use super::schema::{Key, Shape};
use crate::arm::effects::{ALL, ArmEffect};

/// The keys below `[effects]` of an arm: one for each coefficient of the catalogue, and whether `tune` may change it.
pub static ARM_EFFECT_KEYS: LazyLock<Vec<Key>> = LazyLock::new(|| {
    let keys = ALL.iter().flat_map(|effect| {
        let one = |c: &tunenet_core::simulator::Coefficient| Key {
            path: Cow::Owned(format!("effects.{}.{}", effect.name, c.key)),
            shape: if effect.per_joint { Shape::List(c.min, c.max) } else { Shape::Number(c.min, c.max) },
            required: false,
            meaning: Cow::Borrowed(effect.sentence),
        };
        let tune = Key {
            path: Cow::Owned(format!("effects.{}.tune", effect.name)),
            shape: Shape::Flag,
            required: false,
            meaning: Cow::Borrowed("whether `tune` may change these numbers (default: false)"),
        };
        effect.coefficients.iter().map(one).chain([tune]).collect::<Vec<_>>()
    });
    keys.collect()
});

/// An effect that an arm's file holds.
#[derive(Debug, Clone)]
pub struct PresentArmEffect {
    /// Its entry of the catalogue.
    pub effect: ArmEffect,
    /// Its numbers, those of all joints of the first coefficient first; absent where the file leaves one out.
    pub values: Vec<f64>,
    /// Whether `tune` may change them.
    pub tune: bool,
}

impl SimulationFile {
    /// The effects that the file of an arm with so many joints holds, in its order.
    ///
    /// # Errors
    /// [`Error::File`](tunenet_formats::Error::File) where a list has not one number for each joint.
    pub fn arm_effects(&self, joints: usize) -> Result<Vec<PresentArmEffect>> {
        let Some(all) = self.item("effects").and_then(Item::as_table_like) else { return Ok(Vec::new()) };
        let mut found = Vec::new();
        for (name, item) in all.iter() {
            let (Some(table), Some(effect)) = (item.as_table_like(), ArmEffect::find(name)) else { continue };
            let order = "the order is that of the URDF's joints";
            let (values, tune) = numbers_of(&effect, joints).read(self, table, order)?;
            found.push(PresentArmEffect { effect, values, tune });
        }
        Ok(found)
    }

    /// Writes an effect's numbers under `[effects.NAME]`, as [`arm_effects`](Self::arm_effects) gives them; everything else is
    /// kept as it stands.
    ///
    /// # Errors
    /// [`Setting`](tunenet_core::Error::Setting) where the effect is unknown or a number is outside its bounds; the
    /// file is as before then.
    pub fn add_arm_effect(&mut self, name: &str, values: &[f64]) -> Result<()> {
        let Some(effect) = ArmEffect::find(name) else {
            return Err(refused("an effect of an arm".into(), format!("`{name}`")));
        };
        numbers_of(&effect, 1).write(self, values)
    }

    /// Writes the value of a parameter of a replayed arm, be it a number of an effect (`viscous_friction.nms_rad.2`) or a
    /// parameter of the file.
    ///
    /// # Errors
    /// As [`add_arm_effect`](Self::add_arm_effect); [`Error::File`](tunenet_formats::Error::File) as [`arm_effects`](Self::arm_effects).
    pub fn set_arm_value(&mut self, name: &str, value: f64, joints: usize) -> Result<()> {
        let parts: Vec<&str> = name.split('.').collect();
        if let (Some(_), Some((effect, key))) = (self.candidate(parts[0]), name.split_once('.')) {
            return self.add_effect(effect, &[(key, value)]);
        }
        let (Some(effect), Some(_)) = (ArmEffect::find(parts[0]), parts.get(1)) else {
            self.set_value(name, value);
            return Ok(());
        };
        let present = self.arm_effects(joints)?.into_iter().find(|p| p.effect.name == effect.name);
        let values = numbers_of(&effect, joints).with(present.map(|p| p.values), &parts[1..], value);
        self.add_arm_effect(effect.name, &values)
    }
}

fn numbers_of(effect: &ArmEffect, joints: usize) -> JointNumbersOf<'_> {
    let ArmEffect { name, coefficients, per_joint, .. } = *effect;
    JointNumbersOf { name, coefficients, per_joint, count: effect.numbers(joints) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn numbers_of_joints_are_written_and_read_again() {
        let text = "kind = \"arm\"\narm.urdf = \"a.urdf\"\narm.payload_link = \"b\"\nmotion.kind = \"replay\"\n";
        let mut file = SimulationFile::parse(Path::new("arm.toml"), text).unwrap();
        file.add_arm_effect("viscous_friction", &[0.5, 1.5]).unwrap();
        file.set_arm_value("coulomb_friction.nm.2", 3.0, 2).unwrap();
        file.set_arm_value("time_delay.delay_s", 0.01, 2).unwrap();
        let again = SimulationFile::parse(Path::new("arm.toml"), &file.text()).unwrap();
        let found = again.arm_effects(2).unwrap();
        let values: Vec<_> = found.iter().map(|p| (p.effect.name, p.values.clone())).collect();
        assert!(values.contains(&("viscous_friction", vec![0.5, 1.5])), "{values:?}");
        assert!(values.contains(&("coulomb_friction", vec![0.0, 3.0])) && values.contains(&("time_delay", vec![0.01])));
        let message = again.arm_effects(3).unwrap_err().to_string();
        assert!(message.contains("expected 3 numbers, one for each joint, found 2"), "{message}");
        assert!(file.add_arm_effect("viscous_friction", &[-1.0, 0.0]).is_err());
    }
}
