//! The normal equations of the joint fit.

use nalgebra::{DMatrix, DVector};

use super::derivatives::Columns;
use super::joint::{Joint, Part, Point};
use crate::estimate::block_arrow::{Arrow, Block};
use crate::estimate::huber::huber_weight;
use crate::statistics::dot;

impl Joint<'_> {
    /// The normal equations of a part, its free numbers counted from 0.
    pub fn equations(
        &self,
        part: &Part,
        columns: &[Columns],
        residuals: &[Vec<f64>],
        point: &Point,
        scale: f64,
    ) -> Arrow {
        let mut arrow = Arrow::new(part.places.len(), columns.len());
        for ((&d, one), left) in part.sets.iter().zip(columns).zip(residuals) {
            let weights: Vec<f64> = left.iter().map(|r| huber_weight(*r, scale)).collect();
            let all: Vec<&Vec<f64>> = one.shared.iter().chain(&one.nuisances).collect();
            let (shared, nuisances) = (one.shared.len(), one.nuisances.len());
            let mut normal = DMatrix::zeros(all.len(), all.len());
            let mut right = DVector::zeros(all.len());
            let mut weighted = vec![0.0; weights.len()];
            for i in 0..all.len() {
                weighted.iter_mut().zip(all[i].iter().zip(&weights)).for_each(|(w, (a, b))| *w = a * b);
                for j in 0..=i {
                    let product = dot(&weighted, all[j]);
                    normal[(i, j)] = product;
                    normal[(j, i)] = product;
                }
                right[i] = -dot(&weighted, left);
            }
            let within = |place: &usize| part.places.iter().position(|p| p == place);
            let places: Vec<usize> = one.places.iter().filter_map(within).collect();
            for (i, &row) in places.iter().enumerate() {
                arrow.right[row] += right[i];
                for (j, &column) in places.iter().enumerate() {
                    arrow.shared[(row, column)] += normal[(i, j)];
                }
            }
            let mut nuisance_normal = normal.view((shared, shared), (nuisances, nuisances)).into_owned();
            let mut nuisance_right = right.rows(shared, nuisances).into_owned();
            let set = &self.sets[d];
            for (i, (p, pull)) in set.prepared.nuisances.iter().zip(&set.pull).enumerate() {
                nuisance_normal[(i, i)] += pull.powi(-2);
                nuisance_right[i] -= (point.nuisances[d][i] - p.value) / pull.powi(2);
            }
            let coupling = normal.view((0, shared), (shared, nuisances)).into_owned();
            arrow.blocks.push(Block { places, coupling, nuisances: nuisance_normal, nuisance_right });
        }
        // A coefficient on which the data are silent stays put.
        for (i, &place) in part.places.iter().enumerate() {
            let global = &self.structure.globals[place];
            if global.effect.is_some() {
                arrow.shared[(i, i)] += global.parameter.span().powi(-2);
            }
        }
        // A number on a bound that wants to leave it is held there.
        for (i, &place) in part.places.iter().enumerate() {
            let (p, value) = (&self.structure.globals[place].parameter, point.globals[place]);
            if arrow.right[i] < 0.0 && value <= p.min || arrow.right[i] > 0.0 && value >= p.max {
                arrow.hold(i);
            }
        }
        arrow
    }
}
