//! Frisch–Waugh–Lovell projection (Frisch and Waugh 1933; Lovell 1963): columns of effects, less what nuisance parameters and
//! shared parameters of a model explain of them.

use super::jacobian::Columns;
use crate::statistics::dot;

/// A direction whose projection keeps less than this share of its square is taken for dependent.
const DEPENDENT: f64 = 1e-9;

/// Takes out of a stacked column whatever nuisance parameters and shared parameters of the model explain.
pub(crate) struct Projector {
    /// Orthonormal, one group for each recording; the stretch of the stack that it covers.
    nuisances: Vec<(std::ops::Range<usize>, Vec<Vec<f64>>)>,
    /// Orthonormal, stacked over all recordings.
    shared: Vec<Vec<f64>>,
}

impl Projector {
    /// From the derivatives of a model with this many `shared` parameters, over recordings of these lengths (values).
    pub fn new(columns: &[Columns], lengths: &[usize], shared: usize) -> Self {
        let mut nuisances = Vec::with_capacity(columns.len());
        let mut begin = 0;
        for (one, &length) in columns.iter().zip(lengths) {
            nuisances.push((begin..begin + length, orthonormal(one.nuisances.clone())));
            begin += length;
        }
        let mut projector = Self { nuisances, shared: Vec::new() };
        let stacked = (0..shared).map(|index| stack(columns, lengths, index));
        let reduced = stacked.map(|mut column| {
            projector.project_nuisances(&mut column);
            column
        });
        projector.shared = orthonormal(reduced.collect());
        projector
    }

    fn project_nuisances(&self, column: &mut [f64]) {
        for (range, basis) in &self.nuisances {
            take_out(&mut column[range.clone()], basis);
        }
    }

    /// The values of the recording `index` in a stacked column.
    pub fn range(&self, index: usize) -> std::ops::Range<usize> {
        self.nuisances[index].0.clone()
    }

    /// A column of the recording `index` without what the nuisance parameters of that recording explain.
    pub fn without_nuisances(&self, index: usize, column: &[f64]) -> Vec<f64> {
        let mut column = column.to_vec();
        take_out(&mut column, &self.nuisances[index].1);
        column
    }

    /// The products of a column of the recording `index` with the orthonormal directions of the shared parameters, one for each.
    pub fn along_shared(&self, index: usize, column: &[f64]) -> Vec<f64> {
        self.shared.iter().map(|direction| dot(&direction[self.range(index)], column)).collect()
    }

    /// In place.
    pub fn project(&self, column: &mut [f64]) {
        self.project_nuisances(column);
        take_out(column, &self.shared);
    }
}

/// The column of the shared parameter `index` over all recordings; 0 for a recording that does not depend on it.
pub(crate) fn stack(columns: &[Columns], lengths: &[usize], index: usize) -> Vec<f64> {
    let mut stacked = Vec::with_capacity(lengths.iter().sum());
    for (one, &length) in columns.iter().zip(lengths) {
        match one.indices.iter().position(|&i| i == index) {
            Some(i) => stacked.extend_from_slice(&one.shared[i]),
            None => stacked.resize(stacked.len() + length, 0.0),
        }
    }
    stacked
}

/// Twice, since once leaves rounding of the size of what was taken out.
fn take_out(column: &mut [f64], basis: &[Vec<f64>]) {
    for _ in 0..2 {
        for direction in basis {
            let part = dot(direction, column);
            column.iter_mut().zip(direction).for_each(|(c, d)| *c -= part * d);
        }
    }
}

/// An orthonormal basis of the columns' span; dependent ones are left out.
pub(crate) fn orthonormal(columns: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let mut basis: Vec<Vec<f64>> = Vec::with_capacity(columns.len());
    for mut column in columns {
        let before = dot(&column, &column);
        take_out(&mut column, &basis);
        let after = dot(&column, &column);
        if after > DEPENDENT * before && after.is_finite() {
            let scale = after.sqrt().recip();
            for c in &mut column {
                *c *= scale;
            }
            basis.push(column);
        }
    }
    basis
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_model_can_do_is_gone() {
        // Two recordings of three values; each has its own level, both share a slope.
        let level = vec![1.0; 3];
        let slope = vec![0.0, 1.0, 2.0];
        let one = Columns { indices: vec![0], shared: vec![slope.clone()], nuisances: vec![level.clone()] };
        let projector = Projector::new(&[one.clone(), one], &[3, 3], 1);
        let mut line = vec![5.0, 6.0, 7.0, -1.0, 0.0, 1.0];
        projector.project(&mut line);
        assert!(dot(&line, &line) < 1e-24, "{line:?}");
        let mut bend = vec![0.0, 1.0, 0.0, 0.0, 1.0, 0.0];
        projector.project(&mut bend);
        assert!((dot(&bend, &bend) - 2.0 * 2.0 / 3.0).abs() < 1e-12, "a bend less its mean has 2/3 each");
    }

    #[test]
    fn dependent_columns_add_no_direction() {
        assert_eq!(orthonormal(vec![vec![1.0, 1.0], vec![-2.0, -2.0], vec![0.0, 0.0]]).len(), 1);
    }
}
