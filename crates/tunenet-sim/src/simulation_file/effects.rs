//! The effects of a simulation file: `[effects.NAME]`, read and written.

use indexmap::IndexMap;
use toml_edit::{Array, Item};
use tunenet_core::Origin;
use tunenet_core::observation::Kind;
use tunenet_core::simulator::{Coefficient, measurement_effects};
use tunenet_formats::Result;

use super::schema::{Shape, item_number, number};
use super::{PresentRobotEffect, SimulationFile, table};
use crate::ball::effects::BallEffect;
use crate::scene::Candidate;

/// An effect that a file holds.
#[derive(Debug, Clone, PartialEq)]
pub struct PresentEffect {
    /// Its name.
    pub name: String,
    /// Its coefficients in the order of the catalogue; the absent value where the file leaves one out.
    pub values: Vec<f64>,
    /// Whether `tune` may change them.
    pub tune: bool,
}

/// The coefficients of an effect of either catalogue.
fn coefficients(name: &str) -> Option<Vec<Coefficient>> {
    let measured = || measurement_effects(Kind::Positions).into_iter().find(|e| e.name == name);
    BallEffect::find(name).map(|e| e.coefficients.to_vec()).or_else(|| measured().map(|e| e.coefficients))
}

/// The numbers of a coefficient, one or one for every direction; those that mean "absent" where the file leaves them out.
fn numbers(declared: &Candidate, key: &str, item: Option<&Item>) -> Vec<f64> {
    let absent = || declared.coefficients.get(key).map_or(0.0, |c| declared.absent(c));
    let list = item.and_then(Item::as_array).map(|all| all.iter().filter_map(number).collect::<Vec<f64>>());
    let count = declared.numbers_of(key);
    let given = list.or_else(|| item.and_then(item_number).map(|one| vec![one]));
    given.filter(|all| all.len() == count).unwrap_or_else(|| vec![absent(); count])
}

impl SimulationFile {
    /// The effects that the file holds, in its order.
    #[must_use]
    pub fn effects(&self) -> Vec<PresentEffect> {
        // Those of a robot's catalogue have a number for each joint.
        let of_joints = self.robot_effects().unwrap_or_default();
        let Some(all) = self.item("effects").and_then(Item::as_table_like) else { return Vec::new() };
        let each = all.iter().filter_map(|(name, item)| {
            let table = item.as_table_like()?;
            if let Some(PresentRobotEffect { values, tune, .. }) = of_joints.iter().find(|p| p.effect.name == name) {
                return Some(PresentEffect { name: name.into(), values: values.clone(), tune: *tune });
            }
            let value = |key: &str, absent: f64| table.get(key).and_then(item_number).unwrap_or(absent);
            let values = match self.candidate(name) {
                Some(declared) => {
                    let keys = declared.coefficients.keys();
                    keys.flat_map(|key| numbers(declared, key, table.get(key))).collect()
                }
                None => coefficients(name)?.iter().map(|c| value(&c.key, c.absent)).collect(),
            };
            let tune = table.get("tune").and_then(Item::as_bool).unwrap_or(false);
            Some(PresentEffect { name: name.into(), values, tune })
        });
        each.filter(|e| !e.values.is_empty()).collect()
    }

    /// What a coefficient may be: of a declared candidate as declared, of another effect as the catalogue has it.
    fn coefficient_shape(&self, effect: &str, key: &str) -> Option<Shape> {
        if let Some(declared) = self.candidate(effect) {
            let (key, number) = numbered(key);
            let c = declared.coefficients.get(key).filter(|_| number.is_none_or(|n| n < declared.numbers_of(key)))?;
            return Some(Shape::Number(c.min, c.max));
        }
        let path = format!("effects.{effect}.{key}");
        self.domain().keys().find(|known| known.path == path).map(|known| known.shape)
    }

    /// The names of effects, and whether `tune` may change their coefficients.
    fn tunings(&self) -> impl Iterator<Item = (&str, bool)> {
        let all = self.item("effects").and_then(Item::as_table_like);
        let tuned = |item: &Item| item.as_table_like().and_then(|table| table.get("tune")?.as_bool()) == Some(true);
        all.into_iter().flat_map(|all| all.iter()).map(move |(name, item)| (name, tuned(item)))
    }

    /// Whether `tune` may change the coefficients of an effect.
    #[must_use]
    pub fn tunes_an_effect(&self) -> bool {
        self.tunings().any(|(_, tuned)| tuned)
    }

    /// The names of effects whose coefficients `tune` leaves as they are.
    #[must_use]
    pub fn held_effects(&self) -> Vec<&str> {
        self.tunings().filter(|(_, tuned)| !tuned).map(|(name, _)| name).collect()
    }

    /// Writes an effect's coefficients under `[effects.NAME]`, as [`add_effect`](Self::add_effect) does, but all of them in the order
    /// of the catalogue: of one with a number for every direction, one after the other.
    ///
    /// # Errors
    /// As [`add_effect`](Self::add_effect).
    pub fn add_declared(&mut self, name: &str, values: &[f64]) -> Result<()> {
        let Some(declared) = self.candidate(name) else { return Ok(()) };
        let mut keys = Vec::new();
        for key in declared.coefficients.keys() {
            match declared.numbers_of(key) {
                1 => keys.push(key.clone()),
                several => keys.extend((1..=several).map(|number| format!("{key}.{number}"))),
            }
        }
        let pairs: Vec<(&str, f64)> = keys.iter().map(String::as_str).zip(values.iter().copied()).collect();
        self.add_effect(name, &pairs)
    }

    /// Writes an effect's coefficients under `[effects.NAME]`, `KEY.NUMBER` being one of several under a key; what
    /// stands there already takes the new values, and everything else is kept as it stands.
    ///
    /// ```
    /// use std::path::Path;
    /// use tunenet_sim::SimulationFile;
    /// let mut file = SimulationFile::parse(Path::new("ball.toml"), "kind = \"ball\"\nball.radius_m = 0.02\n")?;
    /// file.add_effect("quadratic_drag", &[("c_1_m", 0.13)])?;
    /// assert!(file.text().ends_with("\n[effects.quadratic_drag]\nc_1_m = 0.13\n"));
    /// assert_eq!(file.effects()[0].values, [0.13]);
    /// # Ok::<(), tunenet_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Setting`](tunenet_core::Error::Setting) where the effect or a coefficient is unknown, or a value outside its
    /// bounds; the file is as before then.
    pub fn add_effect(&mut self, name: &str, values: &[(&str, f64)]) -> Result<()> {
        for (key, value) in values {
            let path = format!("effects.{name}.{key}");
            let refuse = |expected: String, found: String| {
                Err(tunenet_core::Error::Setting { origin: Origin::Caller, name: "effects", expected, found }.into())
            };
            let Some(shape) = self.coefficient_shape(name, key) else {
                return refuse(format!("one of {}", self.domain().siblings(&path).join(", ")), format!("`{path}`"));
            };
            if !shape.accepts(&(*value).into()) {
                return refuse(format!("{} for `{path}`", shape.expected()), value.to_string());
            }
        }
        let written = self.written(name, values);
        let one = table(table(self.document.root_mut(), "effects", true), name, false);
        for (key, item) in written {
            let decor = one.get(&key).and_then(Item::as_value).map(|v| v.decor().clone());
            one[&key] = item;
            if let (Some(decor), Some(new)) = (decor, one[&key].as_value_mut()) {
                *new.decor_mut() = decor;
            }
        }
        Ok(())
    }

    /// What stands under each key with these values.
    fn written(&self, name: &str, values: &[(&str, f64)]) -> IndexMap<String, Item> {
        let mut several: IndexMap<String, Vec<f64>> = IndexMap::new();
        for (path, value) in values {
            let (key, number) = numbered(path);
            let declared = self.candidate(name).filter(|_| number.is_some());
            let now = || {
                let item = self.item(&format!("effects.{name}.{key}"));
                declared.map_or_else(|| vec![*value], |declared| numbers(declared, key, item))
            };
            let all = several.entry(key.to_owned()).or_insert_with(now);
            if let Some(place) = all.get_mut(number.unwrap_or(0)) {
                *place = *value;
            }
        }
        let item = |all: Vec<f64>| match all.as_slice() {
            [one] => toml_edit::value(*one),
            _ => toml_edit::value(all.into_iter().collect::<Array>()),
        };
        several.into_iter().map(|(key, all)| (key, item(all))).collect()
    }
}

/// A key, and which of several under it is meant, from 0: `a.2` is the second of `a`.
fn numbered(key: &str) -> (&str, Option<usize>) {
    let Some((key, number)) = key.split_once('.') else { return (key, None) };
    (key, number.parse().ok().and_then(|number: usize| number.checked_sub(1)))
}
