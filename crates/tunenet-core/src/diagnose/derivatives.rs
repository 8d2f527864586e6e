//! Derivatives of the residuals, by finite differences of rollouts.

use rayon::prelude::*;

use super::joint::{Joint, Point};
use crate::simulator::Parameter;

/// Forward-difference step of a parameter or nuisance parameter, as a share of its bounds.
const DIFFERENCE_STEP: f64 = 1e-6;
/// ... and of a coefficient, as a share of a small visible one.
const COEFFICIENT_STEP: f64 = 1e-3;

/// Derivatives of one recording's white residuals.
#[derive(Clone)]
pub(super) struct Columns {
    /// Which free numbers of the structure.
    pub places: Vec<usize>,
    /// A column for each of them.
    pub shared: Vec<Vec<f64>>,
    /// A column for each nuisance parameter.
    pub nuisances: Vec<Vec<f64>>,
}

/// Which derivatives.
#[derive(Clone, Copy)]
pub(super) struct Which {
    /// Over this share of each recording.
    pub horizon: f64,
    /// By free numbers from this one on ...
    pub first: usize,
    /// ... and by the nuisance parameters.
    pub nuisances: bool,
    /// By steps of a visible size.
    pub visibly: bool,
}

impl Which {
    pub const ALL: Self = Self { horizon: 1.0, first: 0, nuisances: true, visibly: false };
}

impl Joint<'_> {
    /// Derivatives of the white residuals at `point`, where they are `residuals`, by free numbers from `first` on.
    ///
    /// With `visibly`, coefficients are moved as far as can be seen: some (the time a shutter is open) have no slope at all
    /// where they are absent.
    pub fn columns(&self, point: &Point, residuals: &[Vec<f64>], what: Which) -> Vec<Columns> {
        let all: Vec<usize> = (0..self.sets.len()).collect();
        self.columns_of(&all, point, residuals, what)
    }

    /// The same of the recordings `sets`, whose residuals are `residuals`.
    pub fn columns_of(&self, sets: &[usize], point: &Point, residuals: &[Vec<f64>], what: Which) -> Vec<Columns> {
        let Which { horizon, first, nuisances, visibly } = what;
        let places: Vec<Vec<usize>> = sets
            .iter()
            .map(|&d| self.structure.places(self.sets[d].object).into_iter().filter(|&p| p >= first).collect())
            .collect();
        let nuisance_count = |k: usize| if nuisances { point.nuisances[sets[k]].len() } else { 0 };
        let tasks: Vec<(usize, usize)> =
            (0..sets.len()).flat_map(|k| (0..places[k].len() + nuisance_count(k)).map(move |c| (k, c))).collect();
        let column = |&(k, c): &(usize, usize)| -> Vec<f64> {
            let d = sets[k];
            let samples = self.samples(d, horizon);
            let rolled = |direction: f64| {
                let (mut globals, mut nuisances) = (point.globals.clone(), point.nuisances[d].clone());
                let step = if let Some(&place) = places[k].get(c) {
                    self.nudge_global(&mut globals, place, direction, visibly)
                } else {
                    let i = c - places[k].len();
                    let unknown = &self.sets[d].prepared.nuisances[i];
                    nudge(&mut nuisances[i], unknown, direction * DIFFERENCE_STEP * unknown.span())
                };
                self.white(d, &globals, &nuisances, samples).map(|r| (r, step))
            };
            // On the edge of what can be simulated only one side exists, or none; then nothing is known of this direction.
            let Ok((mut moved, step)) = rolled(1.0).or_else(|_| rolled(-1.0)) else {
                return vec![0.0; residuals[k].len()];
            };
            moved.iter_mut().zip(&residuals[k]).for_each(|(m, r)| *m = (*m - r) / step);
            moved
        };
        let mut columns = tasks.par_iter().map(column).collect::<Vec<_>>().into_iter();
        let gather = |(k, places): (usize, Vec<usize>)| Columns {
            shared: columns.by_ref().take(places.len()).collect(),
            nuisances: columns.by_ref().take(nuisance_count(k)).collect(),
            places,
        };
        places.into_iter().enumerate().map(gather).collect()
    }

    fn nudge_global(&self, globals: &mut [f64], place: usize, direction: f64, visibly: bool) -> f64 {
        let global = &self.structure.globals[place];
        let step = match global.absent {
            Some((_, typical)) if visibly => typical,
            Some((_, typical)) => COEFFICIENT_STEP * typical,
            None => DIFFERENCE_STEP * global.parameter.span(),
        };
        nudge(&mut globals[place], &global.parameter, direction * step)
    }
}

/// Moves `value` by `step`, inward where it would leave the bounds; returns the step taken.
fn nudge(value: &mut f64, parameter: &Parameter, step: f64) -> f64 {
    let before = *value;
    *value += if (parameter.min..=parameter.max).contains(&(before + step)) { step } else { -step };
    *value - before
}
