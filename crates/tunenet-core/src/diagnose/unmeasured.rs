//! Axes that nobody measured: what acts along them alone is neither free nor a candidate.

use super::columns::stack;
use super::derivatives::Which;
use super::joint::{Joint, Point, dot};
use super::sets::Set;
use super::study::{Model, Study};
use crate::Result;
use crate::observation::{Note, with_decimals};

/// A coefficient that moves the recordings by less than this share of what another of its effect does is not seen.
const UNSEEN_SHARE: f64 = 1e-3;
/// An own unknown whose whole range moves nothing by more than this (in units of the noise) is held at its guess ...
const SILENT: f64 = 0.01;
/// ... by a pull of this share of its range.
const HELD_SHARE: f64 = 1e-6;

/// Where across its bounds a parameter is tried.
const ACROSS: [f64; 4] = [0.0, 0.02, 0.5, 0.9];

impl Study<'_> {
    /// Says which parameters of `model` the recordings do not determine: those on which they do not depend at all, and those
    /// that they do not depend on near the value found, as friction once the ball grips.
    pub fn say_what_has_no_say(&self, model: &Model, notes: &mut Vec<Note>) {
        let silent = |g: &usize| !model.fit.covariance[(*g, *g)].is_finite();
        for g in (0..model.structure.globals.len()).filter(silent) {
            let parameter = &model.structure.globals[g].parameter;
            if model.structure.globals[g].effect.is_some() {
                continue;
            }
            let remedy = "bring a recording in which it matters";
            notes.push(if self.moves_something(model, g) {
                let (name, value) = (&parameter.name, with_decimals(model.fit.point.globals[g], 3));
                let text = format!("the recordings do not determine `{name}`: near {value} they do not depend on it");
                Note::new("parameter.not_identifiable", text, remedy)
            } else {
                Note::new(
                    "parameter.no_effect",
                    format!("`{}` changes nothing in these recordings", parameter.name),
                    remedy,
                )
            });
        }
    }

    /// Whether another value of free number `g` within its bounds would change anything that counts.
    fn moves_something(&self, model: &Model, g: usize) -> bool {
        let parameter = &model.structure.globals[g].parameter;
        ACROSS.iter().any(|share| {
            let mut point = model.fit.point.clone();
            point.globals[g] = parameter.min + share * parameter.span();
            // What cannot be simulated is no less than a change.
            self.joint(&model.structure).residuals(&point, 1.0).map_or(true, |moved| {
                let both = moved.iter().flatten().zip(model.fit.residuals.iter().flatten());
                both.map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt() > SILENT
            })
        })
    }

    /// Holds own unknowns along axes that were not measured, and frees no coefficient that acts along them alone. A start
    /// velocity across the picture would otherwise turn spin into any force within it.
    pub fn leave_out_unmeasured(&mut self, base: &Model, held_out: &mut [Set]) -> Result<()> {
        if self.sets.iter().chain(held_out.iter()).all(|set| set.unmeasured().is_empty()) {
            return Ok(());
        }
        let point = base.fit.point.clone();
        let structure = self.structure(&[])?;
        for (sets, own) in [(&mut self.sets[..], Some(&point.own)), (held_out, None)] {
            let own = own.cloned().unwrap_or_else(|| sets.iter().map(|s| s.prepared.own_values()).collect());
            let here = Point { globals: point.globals.clone(), own };
            let joint = Joint { structure: &structure, sets, rollouts: &self.rollouts };
            let residuals = joint.residuals(&here, 1.0)?;
            let columns = joint.columns(&here, &residuals, Which::ALL);
            for (set, one) in sets.iter_mut().zip(&columns) {
                set.hold_silent(&one.own);
            }
        }
        for entry in 0..self.catalogue.len() {
            if self.catalogue[entry].seen.len() > 1 {
                self.catalogue[entry].seen = self.seen(entry, base)?;
            }
        }
        Ok(())
    }

    /// Which coefficients of an effect the recordings depend on.
    fn seen(&self, entry: usize, base: &Model) -> Result<Vec<bool>> {
        let structure = self.structure(&[entry])?;
        let known = base.structure.globals.len();
        let globals = structure.carry(&base.structure, &base.fit.point.globals);
        let point = Point { globals, own: base.fit.point.own.clone() };
        let which = Which { first: known, own: false, ..Which::ALL };
        let columns = self.joint(&structure).columns(&point, &base.fit.residuals, which);
        let lengths: Vec<usize> = base.fit.residuals.iter().map(Vec::len).collect();
        let mut sizes = vec![0.0f64; self.catalogue[entry].seen.len()];
        for (place, global) in structure.globals.iter().enumerate().skip(known) {
            let column = stack(&columns, &lengths, place);
            if let Some((_, k)) = global.effect {
                sizes[k] = sizes[k].max(dot(&column, &column).sqrt());
            }
        }
        let largest = sizes.iter().copied().fold(0.0, f64::max);
        Ok(sizes.into_iter().map(|size| largest <= 0.0 || size > UNSEEN_SHARE * largest).collect())
    }
}

impl Set {
    /// Channels of which nothing counts.
    pub fn unmeasured(&self) -> Vec<usize> {
        let width = self.width();
        (0..width).filter(|c| !self.keep.iter().skip(*c).step_by(width).any(|keep| *keep)).collect()
    }

    /// Holds the own unknowns with these derivatives of the white residuals where they move nothing.
    fn hold_silent(&mut self, columns: &[Vec<f64>]) {
        if self.unmeasured().is_empty() {
            return;
        }
        for (i, column) in columns.iter().enumerate() {
            if dot(column, column).sqrt() * self.prepared.own[i].span() < SILENT {
                self.hold(i);
            }
        }
    }

    /// Holds own unknown `i` at its guess.
    pub fn hold(&mut self, i: usize) {
        self.pull[i] = HELD_SHARE * self.prepared.own[i].span();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::Observation;
    use crate::simulator::{Parameter, Prepared};

    fn seen_along_x_and_z() -> Set {
        let clock: Vec<f64> = (0..30).map(|k| f64::from(k) * 0.02).collect();
        let rows: Vec<[f64; 3]> = clock.iter().map(|t| [*t, 0.0, 1.0 - 4.905 * t * t]).collect();
        let mut prepared = Prepared::whole(Observation::positions(clock, &rows).unwrap(), 1);
        let own = |name: &str| Parameter::new(name, "m/s", 1.0, -4.0, 4.0).unwrap();
        prepared.own = vec![own("release.velocity_x"), own("release.velocity_y")];
        Set::new(0, 0, false, prepared)
    }

    #[test]
    fn an_axis_that_stands_still_is_not_measured() {
        assert_eq!(seen_along_x_and_z().unmeasured(), [1]);
    }

    /// What moves the recording stays as free as it was, what moves nothing is held at its guess.
    #[test]
    fn only_what_moves_nothing_is_held() {
        let mut set = seen_along_x_and_z();
        let before = set.pull.clone();
        set.hold_silent(&[vec![0.1; 90], vec![0.0; 90]]);
        assert_eq!(set.pull[0], before[0]);
        assert!(set.pull[1] < 1e-4 * before[1], "{:?}", set.pull);
    }
}
