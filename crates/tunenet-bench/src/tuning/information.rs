//! What a drop with unknown height, instant of release and floor allows: Fisher's information from the closed form alone.

use nalgebra::{DMatrix, DVector};

use super::closed_form::ClosedFormDrop;

/// Steps of the central differences, as shares of each unknown's size.
const STEP: f64 = 1e-6;

/// The Cramér–Rao standard deviation of the restitution under white noise of `noise_m` on the height, where the height of
/// fall, the instant of release and the floor's height are unknown too; infinite where the data do not determine it.
pub fn restitution_sd(drop: ClosedFormDrop, clock: &[f64], noise_m: f64) -> f64 {
    let time_s = (drop.fall_m / crate::scene::GRAVITY_M_S2).sqrt();
    let heights = |e: f64, fall_m: f64, late_s: f64| {
        let clock: Vec<f64> = clock.iter().map(|t| t - late_s).collect();
        ClosedFormDrop { restitution: e, fall_m }.heights(&clock)
    };
    let slope = |high: Vec<f64>, low: Vec<f64>, width: f64| -> Vec<f64> {
        high.iter().zip(low).map(|(h, l)| (h - l) / width).collect()
    };
    let (e, h) = (drop.restitution, drop.fall_m);
    let at_h = |step: f64| heights(e, h * (1.0 + step), 0.0);
    let columns = [
        slope(heights(e + STEP, h, 0.0), heights(e - STEP, h, 0.0), 2.0 * STEP),
        slope(at_h(STEP), at_h(-STEP), 2.0 * STEP * h),
        slope(heights(e, h, STEP * time_s), heights(e, h, -STEP * time_s), 2.0 * STEP * time_s),
        vec![1.0; clock.len()],
    ];
    // Q R = columns, that of the restitution last: its share in R that the other three cannot imitate is the information on it.
    let columns = columns.into_iter().rev().map(DVector::from_vec).collect::<Vec<_>>();
    let imitated_by_none = DMatrix::from_columns(&columns).qr().unpack_r()[(3, 3)].abs();
    noise_m / imitated_by_none
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nuisance_parameters_cost_information() {
        let clock: Vec<f64> = (0..200).map(|i| f64::from(i) / 60.0).collect();
        let drop = ClosedFormDrop { fall_m: 2.0, restitution: 0.6 };
        let known: f64 = drop.samples(clock.iter().copied()).map(|(_, slope)| slope * slope).sum();
        let sd = restitution_sd(drop, &clock, 0.01);
        assert!(sd > 0.01 / known.sqrt() && sd < 0.1, "{sd}");
        // Twice the noise, twice the spread; nothing seen of the rebound, nothing known.
        assert!((restitution_sd(drop, &clock, 0.02) / sd - 2.0).abs() < 1e-9);
        assert!(restitution_sd(drop, &clock[..30], 0.01) > 1e3);
    }
}
