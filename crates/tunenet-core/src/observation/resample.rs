//! Linear interpolation of an observation onto another clock.

use super::Observation;
use crate::{Error, Result};

/// `observation` at the instants of `clock`, by linear interpolation; exact, bit for bit, at its own instants.
///
/// Instants before the first or after the last sample take that sample's value: a body at rest stays at rest, which is
/// what the paper does with records shorter than its window.
///
/// # Errors
/// [`Error::Observation`] where `clock` cannot be one.
pub fn resample(observation: &Observation, clock: &[f64]) -> Result<Observation> {
    let seen = observation.clock();
    let width = observation.channels().len();
    let mut values = Vec::with_capacity(clock.len() * width);
    let mut after = 0;
    for (i, &t) in clock.iter().enumerate() {
        if i > 0 && t <= clock[i - 1] {
            let what = format!("the new clock at sample {}", i + 1);
            return Err(Error::Observation {
                what,
                expected: format!("more than {}", clock[i - 1]),
                found: format!("{t}"),
            });
        }
        while after < seen.len() && seen[after] < t {
            after += 1;
        }
        if after == seen.len() {
            values.extend_from_slice(observation.row(after - 1));
        } else if after == 0 || seen[after].to_bits() == t.to_bits() {
            values.extend_from_slice(observation.row(after));
        } else {
            let share = (t - seen[after - 1]) / (seen[after] - seen[after - 1]);
            let (low, high) = (observation.row(after - 1), observation.row(after));
            values.extend(low.iter().zip(high).map(|(a, b)| a + share * (b - a)));
        }
    }
    let series = Observation::new(observation.kind(), observation.channels().to_vec(), clock.to_vec(), values)?;
    Ok(observation.same_circumstances(series))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::{Channel, Kind};
    use proptest::prelude::*;

    fn series(clock: Vec<f64>, values: Vec<f64>) -> Observation {
        Observation::new(Kind::Other, vec![Channel::new("a", "1")], clock, values).unwrap()
    }

    proptest! {
        #[test]
        fn its_own_grid_changes_nothing(steps in prop::collection::vec(1e-6f64..10.0, 3..50), seed in any::<u64>()) {
            let clock: Vec<f64> = steps.iter().scan(0.0, |t, d| { *t += d; Some(*t) }).collect();
            let values: Vec<f64> = (0..clock.len()).map(|i| ((seed >> (i % 60)) as f64).sin()).collect();
            let seen = series(clock.clone(), values);
            prop_assert_eq!(resample(&seen, &clock).unwrap(), seen);
        }

        #[test]
        fn a_line_stays_a_line(slope in -5.0f64..5.0, at in 0.0f64..2.0) {
            let seen = series(vec![0.0, 0.7, 2.0], vec![1.0, 1.0 + 0.7 * slope, 1.0 + 2.0 * slope]);
            let new = resample(&seen, &[at, at + 1e-3, at + 2e-3]).unwrap();
            prop_assert!((new.row(0)[0] - (1.0 + slope * at)).abs() < 1e-12);
        }
    }

    #[test]
    fn ends_are_held() {
        let new = resample(&series(vec![0.0, 1.0, 2.0], vec![5.0, 6.0, 7.0]), &[-1.0, 0.5, 9.0]).unwrap();
        assert_eq!(new.values(), [5.0, 5.5, 7.0]);
    }
}
