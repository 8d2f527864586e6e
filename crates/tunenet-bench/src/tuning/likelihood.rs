//! How well anything could do: the maximum of the likelihood on the same data, and the Cramér–Rao bound.

use super::closed_form::ClosedFormDrop;

/// Restitutions tried before the best local minima are descended: in 6.7 s a ball's heights at two neighbours differ by less
/// than a tenth of an arc.
const GRID: u32 = 800;
/// Local minima descended.
const MINIMA: usize = 3;
/// Golden sections of a local minimum: 0.618⁶⁰ of 2/800 is 7e-16.
const SECTIONS: usize = 60;

/// The restitution in `[0, 1]` under which white noise makes these heights likeliest: least squares over all of them.
pub fn fit(fall_m: f64, clock: &[f64], heights_m: &[f64]) -> f64 {
    let misfit = |restitution: f64| -> f64 {
        let drop = ClosedFormDrop { fall_m, restitution };
        drop.samples(clock.iter().copied()).zip(heights_m).map(|((z, _), seen)| (seen - z).powi(2)).sum()
    };
    let at = |i: u32| f64::from(i) / f64::from(GRID);
    let costs: Vec<f64> = (0..=GRID).map(|i| misfit(at(i))).collect();
    let mut order: Vec<u32> = (0..=GRID).collect();
    order.sort_by(|&a, &b| costs[a as usize].total_cmp(&costs[b as usize]));
    let mut best = (f64::INFINITY, 0.0);
    let mut descended: Vec<u32> = Vec::new();
    for i in order {
        if descended.iter().any(|d| d.abs_diff(i) <= 1) {
            continue;
        }
        let found = descend(&misfit, at(i.saturating_sub(1)), at((i + 1).min(GRID)));
        if found.0 < best.0 {
            best = found;
        }
        descended.push(i);
        if descended.len() == MINIMA {
            break;
        }
    }
    best.1
}

/// The least value between `low` and `high`, and where, by golden sections.
fn descend(cost: &dyn Fn(f64) -> f64, mut low: f64, mut high: f64) -> (f64, f64) {
    let golden = (5f64.sqrt() - 1.0) / 2.0;
    let (mut a, mut b) = (high - golden * (high - low), low + golden * (high - low));
    let (mut at_a, mut at_b) = (cost(a), cost(b));
    for _ in 0..SECTIONS {
        if at_a <= at_b {
            (high, b, at_b) = (b, a, at_a);
            a = high - golden * (high - low);
            at_a = cost(a);
        } else {
            (low, a, at_a) = (a, b, at_b);
            b = low + golden * (high - low);
            at_b = cost(b);
        }
    }
    [(at_a, a), (at_b, b), (cost(low), low), (cost(high), high)]
        .into_iter()
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .unwrap_or((at_a, a))
}

/// The mean absolute error that no unbiased estimate can beat on average under normal noise: `√(2/π)` times the
/// Cramér–Rao standard deviation `σ / ‖∂z/∂e‖`. Infinite where the data say nothing.
pub fn bound(fall_m: f64, restitution: f64, clock: &[f64], noise_m: f64) -> f64 {
    let slopes = ClosedFormDrop { fall_m, restitution }.samples(clock.iter().copied());
    let information: f64 = slopes.map(|(_, slope)| slope * slope).sum();
    (2.0 / std::f64::consts::PI).sqrt() * noise_m / information.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_noise_the_restitution_comes_back() {
        let clock: Vec<f64> = (0..400).map(|i| f64::from(i) / 60.0).collect();
        for restitution in [0.03, 0.314_159, 0.77, 0.999, 1.0] {
            let seen = ClosedFormDrop { fall_m: 4.1, restitution }.heights(&clock);
            assert!((fit(4.1, &clock, &seen) - restitution).abs() < 1e-9);
        }
    }
}
