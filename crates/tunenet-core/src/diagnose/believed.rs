//! Whether the coefficients of a fit can be believed.

use super::study::{Model, Study};

impl Study<'_> {
    /// Why a coefficient of `model` cannot be believed: outside what is physical, or pushed against a bound.
    pub fn unbelievable(&self, model: &Model) -> Option<String> {
        let spread = (model.deviance(model.scale()) / self.count() as f64).sqrt();
        for (position, &entry) in model.structure.effects.iter().enumerate() {
            for object in 0..self.subjects.len() {
                let effect = &self.catalogue[entry].of[object];
                let places = model.structure.of_effect(position);
                let globals = &model.structure.globals;
                let mine: Vec<usize> =
                    places.into_iter().filter(|&g| globals[g].object.is_none_or(|o| o == object)).collect();
                for g in mine {
                    let (value, p) = (model.fit.point.globals[g], &globals[g].parameter);
                    let k = globals[g].effect.map_or(0, |e| e.1);
                    let coefficient = &effect.coefficients[k];
                    let slack = 2.0 * spread * model.fit.covariance[(g, g)].max(0.0).sqrt();
                    let (low, high) = effect.plausible[k];
                    if value < low - slack || value > high + slack {
                        return Some(format!(
                            "`{}` would be {value:.3e} {}, outside {low} to {high}",
                            p.name, coefficient.unit
                        ));
                    }
                    if value != coefficient.absent && (value <= p.min || value >= p.max) {
                        return Some(format!("`{}` runs into its bound {value}", p.name));
                    }
                }
            }
        }
        None
    }
}
