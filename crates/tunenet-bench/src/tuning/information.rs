//! What a drop with unknown height, instant of release and floor allows: Fisher's information from the closed form alone.

use super::closed_form::Drop;

/// Steps of the central differences, as shares of each unknown's own size.
const STEP: f64 = 1e-6;

/// The Cramér–Rao standard deviation of the restitution under white noise of `noise_m` on the height, where the height of
/// fall, the instant of release and the floor's height are unknown too; infinite where the data do not determine it.
pub fn restitution_sd(drop: Drop, clock: &[f64], noise_m: f64) -> f64 {
    let time_s = (drop.fall_m / super::closed_form::GRAVITY_M_S2).sqrt();
    let heights = |e: f64, fall_m: f64, late_s: f64| {
        let clock: Vec<f64> = clock.iter().map(|t| t - late_s).collect();
        Drop { restitution: e, fall_m }.heights(&clock)
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
    // What the other three unknowns cannot imitate of the first column (Gram–Schmidt) is the information on it.
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut basis: Vec<Vec<f64>> = Vec::new();
    let mut left = Vec::new();
    for column in columns.iter().rev() {
        left.clone_from(column);
        // Twice, since once leaves rounding behind.
        for _ in 0..2 {
            for unit in &basis {
                let share = product(&left, unit);
                left.iter_mut().zip(unit).for_each(|(l, u)| *l -= share * u);
            }
        }
        let length = product(&left, &left).sqrt();
        if length > 0.0 {
            basis.push(left.iter().map(|l| l / length).collect());
        }
    }
    noise_m / product(&left, &left).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknowns_cost_information() {
        let clock: Vec<f64> = (0..200).map(|i| f64::from(i) / 60.0).collect();
        let drop = Drop { fall_m: 2.0, restitution: 0.6 };
        let known: f64 = drop.samples(clock.iter().copied()).map(|(_, slope)| slope * slope).sum();
        let sd = restitution_sd(drop, &clock, 0.01);
        assert!(sd > 0.01 / known.sqrt() && sd < 0.1, "{sd}");
        // Twice the noise, twice the spread; nothing seen of the rebound, nothing known.
        assert!((restitution_sd(drop, &clock, 0.02) / sd - 2.0).abs() < 1e-9);
        assert!(restitution_sd(drop, &clock[..30], 0.01) > 1e3);
    }
}
