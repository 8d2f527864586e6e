//! Prais–Winsten prewhitening of AR(1) residuals (Prais and Winsten 1954), which keeps the first value of a series; across gaps, too.

use crate::statistics::median;

/// What marks a value without a predecessor.
const NONE: usize = usize::MAX;

/// Turns plain residuals (in the channels' units) into white ones in units of the noise.
///
/// With lag-one correlation ρ at the usual spacing, and two kept samples `s` spacings apart, a = ρ^s:
/// `z_i = (r_i − a r_prev) / √(1 − a²)`, exact for first-order autoregressive noise, gaps included. What is set aside
/// becomes 0.
#[derive(Clone)]
pub(in crate::diagnose) struct Filter {
    previous: Vec<usize>,
    own: Vec<f64>,
    carry: Vec<f64>,
}

impl Filter {
    pub fn new(clock: &[f64], noise: &[f64], keep: &[bool], rho: f64) -> Self {
        let width = noise.len();
        let usual = median(clock.windows(2).map(|w| w[1] - w[0])).unwrap_or(0.0);
        let mut filter =
            Self { previous: vec![NONE; keep.len()], own: vec![0.0; keep.len()], carry: vec![0.0; keep.len()] };
        for (channel, sd) in noise.iter().enumerate() {
            let mut before = NONE;
            for i in (channel..keep.len()).step_by(width).filter(|&i| keep[i]) {
                let weight = sd.recip();
                filter.own[i] = weight;
                if before != NONE && rho != 0.0 {
                    let spacings = (clock[i / width] - clock[before / width]) / usual;
                    let a = rho.abs().powf(spacings) * if rho < 0.0 { -1.0 } else { 1.0 };
                    let white = (1.0 - a * a).sqrt().recip();
                    filter.previous[i] = before;
                    filter.own[i] = weight * white;
                    filter.carry[i] = weight * white * a;
                }
                before = i;
            }
        }
        filter
    }

    /// In place; `values` may be the beginning of a recording only.
    pub fn apply(&self, values: &mut [f64]) {
        for i in (0..values.len()).rev() {
            let before = if self.previous[i] == NONE { 0.0 } else { self.carry[i] * values[self.previous[i]] };
            values[i] = self.own[i] * values[i] - before;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_autoregression_becomes_white_across_a_gap() {
        // r_{k+1} = .5 r_k + √.75 w_k: the filter returns the w that went in; a gap of two spacings carries .25.
        let draws = [0.3, -1.0, 0.7, 0.2];
        let clock = [0.0, 1.0, 2.0, 4.0, 5.0];
        let mut values = vec![0.8];
        for (k, draw) in draws.iter().enumerate() {
            let a = 0.5f64.powf(clock[k + 1] - clock[k]);
            values.push(a * values[k] + (1.0 - a * a).sqrt() * draw);
        }
        Filter::new(&clock, &[1.0], &[true; 5], 0.5).apply(&mut values);
        assert_eq!(values[0], 0.8);
        assert!(values[1..].iter().zip(draws).all(|(z, w)| (z - w).abs() < 1e-14), "{values:?}");
    }

    #[test]
    fn what_is_set_aside_becomes_nothing() {
        let mut values = vec![4.0, 1e6, 4.0];
        Filter::new(&[0.0, 1.0, 2.0], &[2.0], &[true, false, true], 0.0).apply(&mut values);
        assert_eq!(values, [2.0, 0.0, 2.0]);
    }
}
