//! Weighted least squares over some places, within their bounds.

use nalgebra::{DMatrix, DVector};

use super::logs::{Logs, Place, Point};
use crate::Result;
use crate::statistics::dot;

/// Most steps of a fit.
const STEPS: usize = 12;
/// A fit ends where a step gains less than this share.
const ENOUGH: f64 = 1e-7;
/// A step whose gain is as predicted to this share of what is left was along a straight line.
const STRAIGHT: f64 = 1e-4;
/// Pivots below this share of their diagonal are lost in rounding: the column says nothing new.
const LOST: f64 = 1e-9;
/// Rounds in which places that run into their bounds are held there.
const HOLDS: usize = 6;

/// A point and what it leaves.
#[derive(Clone)]
pub(super) struct Fitted {
    pub point: Point,
    /// What was free.
    pub active: Vec<Place>,
    /// Weighed residuals, and the sum of their squares.
    pub residuals: Vec<f64>,
    pub square: f64,
}

/// Products of columns and residuals: enough for every linear fit over some of the columns.
pub(super) struct Normal {
    pub places: Vec<Place>,
    pub products: DMatrix<f64>,
    pub right: DVector<f64>,
    pub square: f64,
}

impl Normal {
    pub fn new(places: &[Place], columns: &[Vec<f64>], residuals: &[f64]) -> Self {
        let n = columns.len();
        let mut products = DMatrix::zeros(n, n);
        for i in 0..n {
            for j in 0..=i {
                let product = dot(&columns[i], &columns[j]);
                (products[(i, j)], products[(j, i)]) = (product, product);
            }
        }
        let right = DVector::from_fn(n, |i, _| dot(&columns[i], residuals));
        Self { places: places.to_vec(), products, right, square: dot(residuals, residuals) }
    }

    /// The best step over the columns at `at`, and by how much it shrinks the squares; columns that say nothing new stay.
    pub fn solve(&self, at: &[usize]) -> (Vec<f64>, f64) {
        let mut kept: Vec<usize> = Vec::new();
        let mut factor: Vec<Vec<f64>> = Vec::new();
        // Cholesky row by row; what has no pivot is left out.
        for (position, &i) in at.iter().enumerate() {
            let mut row = Vec::with_capacity(kept.len() + 1);
            for (k, &other) in kept.iter().enumerate() {
                let before = dot(&row, &factor[k]);
                row.push((self.products[(i, at[other])] - before) / factor[k][k]);
            }
            let pivot = self.products[(i, i)] - row.iter().map(|v| v * v).sum::<f64>();
            if pivot > LOST * self.products[(i, i)] {
                row.push(pivot.sqrt());
                factor.push(row);
                kept.push(position);
            }
        }
        let mut half = Vec::with_capacity(kept.len());
        for (k, &position) in kept.iter().enumerate() {
            let before: f64 = half.iter().zip(&factor[k]).map(|(a, b): (&f64, &f64)| a * b).sum();
            half.push((self.right[at[position]] - before) / factor[k][k]);
        }
        let gain = half.iter().map(|v| v * v).sum();
        let mut steps = vec![0.0; at.len()];
        for k in (0..kept.len()).rev() {
            let after: f64 = (k + 1..kept.len()).map(|m| factor[m][k] * steps[kept[m]]).sum();
            steps[kept[k]] = (half[k] - after) / factor[k][k];
        }
        (steps, gain)
    }

    /// Where these places stand among the columns.
    pub fn at(&self, places: &[Place]) -> Vec<usize> {
        places.iter().filter_map(|p| self.places.iter().position(|q| q == p)).collect()
    }

    /// The inverse of the products of these columns; zeros where a column says nothing new.
    pub fn inverse(&self, at: &[usize]) -> DMatrix<f64> {
        let n = at.len();
        let scale: Vec<f64> = at.iter().map(|&i| self.products[(i, i)].sqrt().max(f64::MIN_POSITIVE).recip()).collect();
        let scaled = DMatrix::from_fn(n, n, |i, j| self.products[(at[i], at[j])] * scale[i] * scale[j]);
        let inverse = scaled.pseudo_inverse(LOST).unwrap_or_else(|_| DMatrix::zeros(n, n));
        DMatrix::from_fn(n, n, |i, j| inverse[(i, j)] * scale[i] * scale[j])
    }
}

impl Logs<'_> {
    /// The simulation as it is given, its own parameters tuned.
    pub fn tuned(&self) -> Result<Fitted> {
        self.fit_from(&self.given_point(), &self.tunable(), None)
    }

    pub fn evaluate(&self, point: Point, active: &[Place]) -> Result<Fitted> {
        let residuals = self.residuals(&point)?;
        let square = dot(&residuals, &residuals);
        Ok(Fitted { point, active: active.to_vec(), residuals, square })
    }

    /// Fits `active` from `point`. `known` are derivatives at that point, if any.
    pub fn fit_from(&self, point: &Point, active: &[Place], known: Option<&Normal>) -> Result<Fitted> {
        let mut best = self.evaluate(point.clone(), active)?;
        if active.is_empty() {
            return Ok(best);
        }
        let mut fresh;
        let mut normal = known.filter(|n| n.at(active).len() == active.len());
        for _ in 0..STEPS {
            let derivatives = if let Some(known) = normal.take() {
                known
            } else {
                fresh = Normal::new(active, &self.columns(&best.point, active)?, &best.residuals);
                &fresh
            };
            let (step, predicted) = self.bounded(derivatives, &best.point, active);
            let mut share = 1.0;
            let mut next = None;
            while share > 0.02 {
                let moved = self.moved(&best.point, active, &step, share);
                // What cannot be simulated is a step too long.
                if let Ok(there) = self.evaluate(moved, active)
                    && there.square <= best.square
                {
                    next = Some(there);
                    break;
                }
                share *= 0.4;
            }
            let Some(there) = next else { break };
            let gained = best.square - there.square;
            let straight = share == 1.0 && (gained - predicted).abs() < STRAIGHT * there.square;
            best = there;
            if straight || gained <= ENOUGH * best.square {
                break;
            }
        }
        Ok(best)
    }

    /// The best step within the bounds: what runs into one is held there, and the others are asked again.
    fn bounded(&self, normal: &Normal, point: &Point, active: &[Place]) -> (Vec<f64>, f64) {
        let mut held: Vec<Option<f64>> = vec![None; active.len()];
        let columns = normal.at(active);
        let mut steps = vec![0.0; active.len()];
        let mut gain = 0.0;
        for _ in 0..HOLDS {
            let free: Vec<usize> = (0..active.len()).filter(|&i| held[i].is_none()).collect();
            // Held places have moved already: the right side without their share.
            let mut shifted = Normal {
                places: normal.places.clone(),
                products: normal.products.clone(),
                right: normal.right.clone(),
                square: normal.square,
            };
            let mut fixed_gain = 0.0;
            for (i, step) in held.iter().enumerate().filter_map(|(i, h)| Some((i, (*h)?))) {
                fixed_gain +=
                    2.0 * step * shifted.right[columns[i]] - step * step * normal.products[(columns[i], columns[i])];
                let column = normal.products.column(columns[i]) * step;
                shifted.right -= column;
            }
            let at: Vec<usize> = free.iter().map(|&i| columns[i]).collect();
            let (found, more) = shifted.solve(&at);
            gain = fixed_gain + more;
            for (k, &i) in free.iter().enumerate() {
                steps[i] = found[k];
            }
            for (i, step) in held.iter().enumerate().filter_map(|(i, h)| Some((i, (*h)?))) {
                steps[i] = step;
            }
            let mut ran = false;
            for &i in &free {
                let (object, k) = active[i];
                let p = self.parameter(active[i]);
                let wanted = point[object][k] + steps[i];
                if wanted < p.min || wanted > p.max {
                    held[i] = Some(wanted.clamp(p.min, p.max) - point[object][k]);
                    ran = true;
                }
            }
            if !ran {
                break;
            }
        }
        (steps, gain)
    }

    fn moved(&self, point: &Point, active: &[Place], step: &[f64], share: f64) -> Point {
        let mut moved = point.clone();
        for (&(object, i), step) in active.iter().zip(step) {
            let p = self.parameter((object, i));
            moved[object][i] = (moved[object][i] + share * step).clamp(p.min, p.max);
        }
        moved
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_that_repeats_another_says_nothing_new() {
        let (a, b) = (vec![1.0, 1.0, 1.0, 1.0], vec![0.0, 1.0, 2.0, 3.0]);
        let seen = vec![1.0, 3.0, 5.0, 7.0];
        let normal = Normal::new(&[(0, 0), (0, 1), (0, 2)], &[a.clone(), b, a], &seen);
        let (step, gain) = normal.solve(&[0, 1, 2]);
        assert!((step[0] - 1.0).abs() < 1e-12 && (step[1] - 2.0).abs() < 1e-12 && step[2] == 0.0);
        assert!((gain - dot(&seen, &seen)).abs() < 1e-9);
    }
}
