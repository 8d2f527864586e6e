//! Outliers: single samples far from their neighbours (median filter, Hampel 1974).

use super::recording::Set;
use crate::statistics::{mad_sd, median};

/// A sample is an outlier where it leaves the median of its neighbours' residuals by this many robust standard deviations.
const OUTLYING: f64 = 6.0;
/// More than this share of outlying samples is no accident, and they stay.
const MOST_OUTLYING: f64 = 0.05;
/// So near to a contact, s and samples, a contact that is not as simulated leaves its mark.
const NEAR_S: f64 = 0.03;
const NEAR: usize = 2;
/// Accidents do not wait for contacts: where they are so many times as frequent there, and so many at least, they stay.
const GATHERED: f64 = 3.0;
const FEWEST_GATHERED: usize = 4;

/// Sets samples aside that leave their neighbours, by `residuals` in units of the noise; returns how many.
///
/// A misfit between events is smooth, so it moves neighbours together. One at events (contacts last, or the shutter is open) does
/// not; but it is there at every contact, and an accident is not.
pub(in crate::diagnose) fn set_aside(sets: &mut [Set], residuals: &[Vec<f64>]) -> usize {
    let (mut chosen, mut near, mut far) = (Vec::new(), Share::default(), Share::default());
    for (d, (set, values)) in sets.iter().zip(residuals).enumerate() {
        let close = near_contacts(set);
        let width = set.width();
        for i in (0..values.len()).filter(|&i| set.keep[i]) {
            (if close[i / width] { &mut near } else { &mut far }).all += 1;
        }
        for i in outlying(set, values) {
            (if close[i / width] { &mut near } else { &mut far }).outlying += 1;
            chosen.push((d, i, close[i / width]));
        }
    }
    let gathered = near.outlying >= FEWEST_GATHERED && near.of() > GATHERED * far.of();
    chosen.retain(|(_, _, close)| !(gathered && *close));
    for &(d, i, _) in &chosen {
        sets[d].keep[i] = false;
    }
    chosen.len()
}

#[derive(Default)]
struct Share {
    outlying: usize,
    all: usize,
}

impl Share {
    fn of(&self) -> f64 {
        self.outlying as f64 / (self.all as f64).max(1.0)
    }
}

/// Which samples lie near a contact.
fn near_contacts(set: &Set) -> Vec<bool> {
    let clock = set.clock();
    let mut close = vec![false; clock.len()];
    for contact in &set.events {
        let at = clock.partition_point(|t| t < contact);
        let first = clock.partition_point(|t| *t < contact - NEAR_S).min(at.saturating_sub(NEAR));
        let last = clock.partition_point(|t| *t <= contact + NEAR_S).max(at + NEAR).min(clock.len());
        close[first..last].fill(true);
    }
    close
}

/// The values of a recording that leave their neighbours.
fn outlying(set: &Set, residuals: &[f64]) -> Vec<usize> {
    let width = set.width();
    let mut all = Vec::new();
    for channel in 0..width {
        let places: Vec<usize> = (channel..residuals.len()).step_by(width).filter(|&i| set.keep[i]).collect();
        if places.len() < 12 {
            continue;
        }
        let off: Vec<f64> = (0..places.len())
            .map(|k| {
                let (low, high) = (k.saturating_sub(3), (k + 4).min(places.len()));
                let near = (low..high).filter(|&j| j != k).map(|j| residuals[places[j]]);
                residuals[places[k]] - median(near).unwrap_or(0.0)
            })
            .collect();
        let spread = mad_sd(off.iter().copied()).max(0.5);
        let outlying: Vec<usize> = (0..off.len()).filter(|&k| off[k].abs() > OUTLYING * spread).collect();
        if (outlying.len() as f64) < MOST_OUTLYING * places.len() as f64 {
            all.extend(outlying.into_iter().map(|k| places[k]));
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::Observation;
    use crate::simulator::Prepared;

    /// Two seconds at 100 Hz with contacts every 0.4 s, residuals of alternating sign, and these samples far off.
    fn with(outlying: &[usize]) -> (Vec<Set>, Vec<Vec<f64>>) {
        let clock: Vec<f64> = (0..200).map(|k| f64::from(k) * 0.01).collect();
        let rows: Vec<[f64; 3]> = clock.iter().map(|t| [*t, 0.5 * t, (t * 5.0).sin()]).collect();
        let mut set = Set::new(0, 0, false, Prepared::whole(Observation::positions(clock, &rows).unwrap(), 1));
        set.events = vec![0.4, 0.8, 1.2, 1.6];
        let mut residuals: Vec<f64> = (0..600).map(|i| if i % 2 == 0 { 1.0 } else { -1.0 }).collect();
        for k in outlying {
            residuals[3 * k + 2] = 20.0;
        }
        (vec![set], vec![residuals])
    }

    #[test]
    fn accidents_go_and_what_every_contact_shows_stays() {
        let (mut sets, residuals) = with(&[15, 62, 101, 40]);
        assert_eq!(set_aside(&mut sets, &residuals), 4);
        assert!(!sets[0].keep[3 * 62 + 2] && sets[0].keep[3 * 62 + 1]);
        let (mut sets, residuals) = with(&[40, 80, 120, 160]);
        assert_eq!(set_aside(&mut sets, &residuals), 0, "one at every contact");
        let (mut sets, residuals) = with(&[40, 80, 120, 160, 62]);
        assert_eq!(set_aside(&mut sets, &residuals), 1, "the accident goes all the same");
    }
}
