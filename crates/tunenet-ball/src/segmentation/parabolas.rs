//! Optimal partitioning (Jackson et al. 2005) of a record into the fewest parabolas that explain it, without assuming gravity.
//! Starts of pieces that cannot win any more are left out (PELT: Killick, Fearnhead & Eckley 2012).
//!
//! Dynamic programming over all cuts: the least sum of squared
//! residuals in units of the noise, plus a price for each piece. Flights come out as pieces of equal curvature, a ball that
//! is held or rests as pieces without any.

use std::ops::Range;

use super::span;
use tunenet_core::observation::noise_sd;

/// The price of a piece: its three numbers and its place, at half the logarithm of a long record each, and some for luck.
const PRICE: f64 = 30.0;
/// Parabolas are not asked to explain more than this share of the range of heights: air bends a flight a little.
const PRACTICAL_SHARE: f64 = 8e-3;
/// More samples than this are not cut: the time grows with their square.
pub(crate) const MOST_SAMPLES: usize = 1200;

/// The pieces, in order, without gaps. One piece for records that are too long.
pub(crate) fn parabolas(clock: &[f64], heights: &[f64]) -> Vec<Range<usize>> {
    let n = clock.len();
    if n > MOST_SAMPLES {
        return std::iter::once(0..n).collect();
    }
    let least = (PRACTICAL_SHARE * span(heights)).max(f64::MIN_POSITIVE);
    let price = PRICE * noise_sd(heights).hypot(least).powi(2);
    // `best[j]`: the least cost of the first j samples; `from[j]`: where their last piece begins.
    let mut best = vec![f64::INFINITY; n + 1];
    let mut from = vec![0; n + 1];
    best[0] = 0.0;
    for start in 0..n {
        if !best[start].is_finite() {
            continue;
        }
        let mut sums = Sums::default();
        for end in start + 1..=n {
            sums.add(clock[end - 1] - clock[start], heights[end - 1] - heights[start]);
            let cost = best[start] + price + sums.remaining();
            if cost < best[end] {
                (best[end], from[end]) = (cost, start);
            }
            // A longer piece costs at least as much as this one and the rest apart, which begins at less. PELT leaves a start out
            // at one price less; this margin keeps rounding out of the decision.
            if cost > best[end] + 2.0 * price {
                break;
            }
        }
    }
    let mut pieces = Vec::new();
    let mut end = n;
    while end > 0 {
        pieces.push(from[end]..end);
        end = from[end];
    }
    pieces.reverse();
    pieces
}

/// Power sums of a piece: of t to t⁴, and of z, t z, t² z, z².
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    count: f64,
    t: [f64; 4],
    z: [f64; 3],
    zz: f64,
}

impl Sums {
    fn add(&mut self, t: f64, z: f64) {
        let powers = [t, t * t, t * t * t, t * t * t * t];
        self.count += 1.0;
        self.t.iter_mut().zip(powers).for_each(|(sum, power)| *sum += power);
        self.z.iter_mut().zip([1.0, t, t * t]).for_each(|(sum, power)| *sum += power * z);
        self.zz += z * z;
    }

    /// The sum of squares that the best parabola leaves.
    fn remaining(&self) -> f64 {
        if self.count < 3.5 {
            return 0.0;
        }
        let (n, [t1, t2, t3, t4], [z0, z1, z2]) = (self.count, self.t, self.z);
        // Elimination, constant first: what is left of t, t² and z once their means are taken off.
        let (tt, ts, ss) = (t2 - t1 * t1 / n, t3 - t1 * t2 / n, t4 - t2 * t2 / n);
        let (tz, sz, zz) = (z1 - t1 * z0 / n, z2 - t2 * z0 / n, self.zz - z0 * z0 / n);
        let (ss, sz, zz) = (ss - ts * ts / tt, sz - ts * tz / tt, zz - tz * tz / tt);
        (zz - if ss > 0.0 { sz * sz / ss } else { 0.0 }).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hop_is_cut_where_it_lands() {
        let clock: Vec<f64> = (0..60).map(|i| f64::from(i) / 60.0).collect();
        // Two hops that land at 0.5 s, and the same in millimetres.
        let heights: Vec<f64> = clock
            .iter()
            .map(|t| {
                let s = t % 0.5;
                4.905 * s * (0.5 - s)
            })
            .collect();
        for unit in [1.0, 1000.0] {
            let heights: Vec<f64> = heights.iter().map(|z| z * unit).collect();
            assert_eq!(parabolas(&clock, &heights), [0..30, 30..60]);
        }
    }

    #[test]
    fn what_is_held_and_let_go_is_two_pieces() {
        let clock: Vec<f64> = (0..80).map(|i| f64::from(i) / 100.0).collect();
        let heights: Vec<f64> = clock.iter().map(|t| 2.0 - 4.905 * (t - 0.4).max(0.0).powi(2)).collect();
        let pieces = parabolas(&clock, &heights);
        assert!(pieces.len() == 2 && pieces[1].start.abs_diff(41) < 6, "{pieces:?}");
    }
}
