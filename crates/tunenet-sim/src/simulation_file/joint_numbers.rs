//! Numbers of effects that have one for every joint: lists in the order of the model, as the files of arms and of robots hold them.

use toml_edit::{Array, Item, TableLike};
use tunenet_core::Origin;
use tunenet_core::simulator::Coefficient;
use tunenet_formats::{Error, Result};

use super::schema::{item_number, number};
use super::{SimulationFile, table};

/// An effect as far as its numbers stand in a file.
#[derive(Debug, Clone, Copy)]
pub(super) struct JointNumbersOf<'a> {
    pub name: &'a str,
    pub coefficients: &'a [Coefficient],
    /// Whether its numbers are lists.
    pub per_joint: bool,
    /// How many each coefficient has.
    pub count: usize,
}

impl JointNumbersOf<'_> {
    /// Its numbers in `[effects.NAME]`, those of all joints of the first coefficient first, absent where the file leaves one out; and
    /// whether `tune` may change them.
    ///
    /// # Errors
    /// [`Error::File`] where a list has not one number for each joint, with `order` as what to try.
    pub fn read(&self, file: &SimulationFile, own: &dyn TableLike, order: &str) -> Result<(Vec<f64>, bool)> {
        let mut values = Vec::new();
        for c in self.coefficients {
            let given = own.get(&c.key);
            let list = given.and_then(Item::as_array).map(|a| a.iter().filter_map(number).collect::<Vec<f64>>());
            // One number holds for every joint.
            let numbers = list.or_else(|| given.and_then(item_number).map(|v| vec![v; self.count]));
            let numbers = numbers.unwrap_or_else(|| vec![c.absent; self.count]);
            if numbers.len() != self.count {
                let (name, key, found) = (self.name, &c.key, numbers.len());
                let message = format!("`effects.{name}.{key}`: expected {}, found {found}", how_many(self.count));
                return Err(Error::file(file.path(), message, order));
            }
            values.extend(numbers);
        }
        Ok((values, own.get("tune").and_then(Item::as_bool).unwrap_or(false)))
    }

    /// Writes `values` to `[effects.NAME]`; everything else is kept as it stands.
    ///
    /// # Errors
    /// [`Setting`](tunenet_core::Error::Setting) where a number is outside its bounds; the file is as before then.
    pub fn write(&self, file: &mut SimulationFile, values: &[f64]) -> Result<()> {
        let count = (values.len() / self.coefficients.len().max(1)).max(1);
        let each = || self.coefficients.iter().zip(values.chunks(count));
        for (c, numbers) in each() {
            if let Some(value) = numbers.iter().find(|v| !(c.min..=c.max).contains(*v)) {
                let expected = format!("{} to {} for `{}.{}`", c.min, c.max, self.name, c.key);
                return Err(refused(expected, value.to_string()));
            }
        }
        let one = table(table(file.document.root_mut(), "effects", true), self.name, false);
        for (c, numbers) in each() {
            let decor = one.get(&c.key).and_then(Item::as_value).map(|v| v.decor().clone());
            one[c.key.as_ref()] = if self.per_joint {
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

    /// `present`, absent where there is none, with `value` at the number that `parts` of a parameter's name say: key, and joint from 1.
    pub fn with(&self, present: Option<Vec<f64>>, parts: &[&str], value: f64) -> Vec<f64> {
        let absent = || self.coefficients.iter().flat_map(|c| vec![c.absent; self.count]).collect();
        let mut values: Vec<f64> = present.unwrap_or_else(absent);
        let key = parts.first().copied().unwrap_or_default();
        let place = self.coefficients.iter().position(|c| c.key == key).unwrap_or(0);
        let joint = parts.get(1).and_then(|j| j.parse::<usize>().ok()).map_or(0, |j| j.saturating_sub(1));
        if let Some(at) = values.get_mut(place * self.count + joint) {
            *at = value;
        }
        values
    }
}

/// A refusal of what a caller asked for.
pub(super) fn refused(expected: String, found: String) -> Error {
    tunenet_core::Error::Setting { origin: Origin::Caller, name: "effects", expected, found }.into()
}

fn how_many(count: usize) -> String {
    if count == 1 { "one number".into() } else { format!("{count} numbers, one for each joint") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_placed_by_its_key_and_its_joint() {
        let coefficients = [
            Coefficient::new("nm", "N·m", 0.0, (0.0, 9.0), 0.1),
            Coefficient::new("rad_s", "rad/s", 0.1, (0.0, 9.0), 0.1),
        ];
        let effect =
            JointNumbersOf { name: "stribeck_friction", coefficients: &coefficients, per_joint: true, count: 2 };
        assert_eq!(effect.with(None, &["nm", "2"], 0.5), [0.0, 0.5, 0.1, 0.1]);
        assert_eq!(effect.with(Some(vec![1.0, 2.0, 3.0, 4.0]), &["rad_s", "1"], 0.5), [1.0, 2.0, 0.5, 4.0]);
        // A joint that is not there changes nothing.
        assert_eq!(effect.with(Some(vec![1.0, 2.0, 3.0, 4.0]), &["rad_s", "9"], 0.5), [1.0, 2.0, 3.0, 4.0]);
        assert_eq!((how_many(1), how_many(2)), ("one number".into(), "2 numbers, one for each joint".into()));
    }
}
