//! The effects of a simulation file: `[effects.NAME]`, read and written.

use toml_edit::Item;
use tunenet_core::Origin;
use tunenet_core::observation::Kind;
use tunenet_core::simulator::{Coefficient, measurement_effects};
use tunenet_formats::Result;

use super::schema::{Shape, item_number};
use super::{SimulationFile, table};
use crate::ball::effects::BallEffect;

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

impl SimulationFile {
    /// The effects that the file holds, in its order.
    #[must_use]
    pub fn effects(&self) -> Vec<PresentEffect> {
        let Some(all) = self.item("effects").and_then(Item::as_table_like) else { return Vec::new() };
        let each = all.iter().filter_map(|(name, item)| {
            let table = item.as_table_like()?;
            let value = |key: &str, absent: f64| table.get(key).and_then(item_number).unwrap_or(absent);
            let values = match self.candidate(name) {
                Some(declared) => declared.coefficients.iter().map(|(key, c)| value(key, c.absent)).collect(),
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
            return declared.coefficients.get(key).map(|c| Shape::Number(c.min, c.max));
        }
        let path = format!("effects.{effect}.{key}");
        self.domain().keys().find(|known| known.path == path).map(|known| known.shape)
    }

    /// Whether `tune` may change the coefficients of an effect.
    #[must_use]
    pub fn tunes_an_effect(&self) -> bool {
        let all = self.item("effects").and_then(Item::as_table_like);
        let tuned = |item: &Item| item.as_table_like().and_then(|table| table.get("tune")?.as_bool()) == Some(true);
        all.is_some_and(|all| all.iter().any(|(_, item)| tuned(item)))
    }

    /// Writes an effect's coefficients under `[effects.NAME]`; what stands there already takes the new values, and
    /// everything else is kept as it stands.
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
        let one = table(table(self.document.root_mut(), "effects", true), name, false);
        for (key, value) in values {
            let decor = one.get(key).and_then(Item::as_value).map(|v| v.decor().clone());
            one[key] = toml_edit::value(*value);
            if let (Some(decor), Some(new)) = (decor, one[key].as_value_mut()) {
                *new.decor_mut() = decor;
            }
        }
        Ok(())
    }
}
