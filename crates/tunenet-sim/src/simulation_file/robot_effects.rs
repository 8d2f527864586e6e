//! The effects of a robot's file: numbers for each joint as lists in the order of the model.

use toml_edit::{Array, Item};
use tunenet_core::Origin;
use tunenet_formats::{Error, Result};

use super::schema::{item_number, number};
use super::{SimulationFile, table};
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
    /// [`Error::File`] where a list has not one number for each joint.
    pub fn robot_effects(&self) -> Result<Vec<PresentRobotEffect>> {
        let joints = self.robot()?.joints.len();
        let Some(all) = self.item("effects").and_then(Item::as_table_like) else { return Ok(Vec::new()) };
        let mut found = Vec::new();
        for (name, item) in all.iter() {
            let (Some(table), Some(effect)) = (item.as_table_like(), RobotEffect::find(name)) else { continue };
            let count = effect.numbers(joints);
            let mut values = Vec::new();
            for c in effect.coefficients {
                let given = table.get(&c.key);
                let list = given.and_then(Item::as_array).map(|a| a.iter().filter_map(number).collect::<Vec<f64>>());
                let numbers = list.or_else(|| given.and_then(item_number).map(|v| vec![v]));
                let numbers = numbers.unwrap_or_else(|| vec![c.absent; count]);
                if numbers.len() != count {
                    let (key, found) = (&c.key, numbers.len());
                    let message = format!("`effects.{name}.{key}`: expected {}, found {found}", how_many(count));
                    return Err(Error::file(self.path(), message, "the order is that of [joints]"));
                }
                values.extend(numbers);
            }
            let tune = table.get("tune").and_then(Item::as_bool).unwrap_or(false);
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
        let refuse = |expected: String, found: String| {
            Err(tunenet_core::Error::Setting { origin: Origin::Caller, name: "effects", expected, found }.into())
        };
        let Some(effect) = RobotEffect::find(name) else {
            return refuse("an effect of a robot".into(), format!("`{name}`"));
        };
        let count = (values.len() / effect.coefficients.len().max(1)).max(1);
        for (c, numbers) in effect.coefficients.iter().zip(values.chunks(count)) {
            if let Some(value) = numbers.iter().find(|v| !(c.min..=c.max).contains(*v)) {
                return refuse(format!("{} to {} for `{name}.{}`", c.min, c.max, c.key), value.to_string());
            }
        }
        let one = table(table(self.document.root_mut(), "effects", true), name, false);
        for (c, numbers) in effect.coefficients.iter().zip(values.chunks(count)) {
            let decor = one.get(&c.key).and_then(Item::as_value).map(|v| v.decor().clone());
            one[c.key.as_ref()] = if effect.per_joint {
                toml_edit::value(numbers.iter().copied().collect::<Array>())
            } else {
                toml_edit::value(numbers[0])
            };
            if let (Some(decor), Some(new)) = (decor, one[c.key.as_ref()].as_value_mut()) {
                *new.decor_mut() = decor;
            }
        }
        Ok(())
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
        let (Some(effect), Some(key)) = (RobotEffect::find(parts[0]), parts.get(1)) else {
            self.set_value(name, value);
            return Ok(());
        };
        let count = effect.numbers(self.robot()?.joints.len());
        let absent = || effect.coefficients.iter().flat_map(|c| vec![c.absent; count]).collect();
        let present = self.robot_effects()?.into_iter().find(|p| p.effect.name == effect.name);
        let mut values: Vec<f64> = present.map_or_else(absent, |p| p.values);
        let place = effect.coefficients.iter().position(|c| c.key == *key).unwrap_or(0);
        let joint = parts.get(2).and_then(|j| j.parse::<usize>().ok()).map_or(0, |j| j.saturating_sub(1));
        if let Some(at) = values.get_mut(place * count + joint) {
            *at = value;
        }
        self.add_robot_effect(effect.name, &values)
    }
}

fn how_many(count: usize) -> String {
    if count == 1 { "one number".into() } else { format!("{count} numbers, one for each joint") }
}
