//! The step of the lattice on which quantised readings lie: the least difference between them, refined by least squares over the
//! differences that are whole multiples of it.

/// Share of the differences that have to be whole steps.
const MOSTLY: f64 = 0.98;

/// How many differences are looked at.
const MOST: usize = 20_000;

/// Fewest differences that may show a step of which none of them is one.
const FEWEST_FOR_PARTS: usize = 15;

/// How many steps the least difference may be.
const MOST_PARTS: u32 = 4;

/// The step of the lattice on which `values` lie, in their unit and in any order; `None` where they lie on none, or on one as fine as
/// single precision.
///
/// # Examples
///
/// ```
/// let counts = [0, 3, 4, 9, 17, 18, 40];
/// let radians: Vec<f64> = counts.iter().map(|&n| f64::from(n) * std::f64::consts::TAU / 4096.0).collect();
/// let step = tunenet_core::observation::lattice_step(&radians).unwrap();
/// assert!((step * 4096.0 / std::f64::consts::TAU - 1.0).abs() < 1e-9);
/// ```
#[must_use]
pub fn lattice_step(values: &[f64]) -> Option<f64> {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let most = sorted.first()?.abs().max(sorted.last()?.abs());
    // Readings in single precision are this far from what was measured.
    let rounding = most * f64::from(f32::EPSILON);
    let differences = sorted.windows(2).map(|pair| pair[1] - pair[0]).filter(|d| *d > 4.0 * rounding);
    let mut differences: Vec<f64> = differences.take(MOST).collect();
    differences.sort_unstable_by(f64::total_cmp);
    let least = *differences.first()?;
    let parts = if differences.len() < FEWEST_FOR_PARTS { 1 } else { MOST_PARTS };
    (1..=parts).map(|parts| least / f64::from(parts)).find_map(|first| refined(first, &differences, rounding))
}

/// The step near `first` that the differences are whole numbers of, refined by each of them in turn.
fn refined(first: f64, differences: &[f64], rounding: f64) -> Option<f64> {
    let (mut products, mut squares, mut whole) = (first * 1e-3, 1e-3, 0);
    for difference in differences {
        let step = products / squares;
        let count = (difference / step).round();
        let off = (difference - count * step).abs();
        if count >= 1.0 && off <= 0.1 * step + rounding && off <= 4.0 * rounding + 0.02 * step {
            products += difference * count;
            squares += count * count;
            whole += 1;
        }
    }
    let enough = f64::from(whole) >= MOSTLY * differences.len() as f64;
    // A lattice as fine as the rounding holds everything.
    (enough && products / squares > 16.0 * rounding).then_some(products / squares)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Readings of an encoder in single precision.
    fn stored(counts: impl Iterator<Item = u32>, step: f64, offset: f64) -> Vec<f64> {
        #[expect(clippy::cast_possible_truncation, reason = "as a log stores them")]
        let single = |value: f64| f64::from(value as f32);
        counts.map(|count| single(offset + step * f64::from(count))).collect()
    }

    #[test]
    fn a_step_is_found_through_the_rounding_of_single_precision() {
        let step = 200.0 / 1789.0;
        let mut readings = stored((0..400).map(|i| (i * i * 7 + i * 3) % 911), step, -97.0);
        assert!((lattice_step(&readings).unwrap() / step - 1.0).abs() < 1e-5);
        // The same position, computed by another way: its last digit differs.
        readings.push(readings[7] + 97.0 * f64::from(f32::EPSILON) / 2.0);
        assert!((lattice_step(&readings).unwrap() / step - 1.0).abs() < 1e-5);
    }

    #[test]
    fn a_joint_that_hardly_moves_shows_its_step() {
        let readings = stored([0, 0, 1, 1, 2, 1, 0, 0].into_iter(), 1.5e-3, 0.4);
        assert!((lattice_step(&readings).unwrap() / 1.5e-3 - 1.0).abs() < 1e-3);
    }

    #[test]
    fn smooth_or_constant_numbers_lie_on_none() {
        let smooth: Vec<f64> = (0..400).map(|i| (f64::from(i) * 0.1234).sin() * 2.1).collect();
        assert_eq!(lattice_step(&smooth), None);
        assert_eq!(lattice_step(&[0.25; 50]), None);
        assert_eq!(lattice_step(&[]), None);
        assert_eq!(lattice_step(&[f64::NAN, f64::INFINITY]), None);
    }
}
