//! Sensitivity of the estimates to assumed constants (sensitivity coefficients of the GUM, JCGM 100:2008, section 5.1.3).
//!
//! The fit takes an assumed constant as exact. Everything is fitted again with it at the end of its range; where that moves an
//! estimate by a good part of its interval, the user is asked for the constant. Intervals stay: they are those of the value
//! that was given.

use crate::Result;
use crate::estimate::{Fit, Interval, Problem};
use crate::findings;
use crate::observation::{Note, three_digits};
use crate::simulator::Assumed;

/// A constant that moves no estimate by more than this share of its half-width is not asked for.
const MATTERS: f64 = 0.5;

/// A note for each constant that matters.
///
/// # Errors
/// Where the simulator refuses the end of the range.
pub(super) fn ask(problem: &Problem, fit: &Fit, intervals: &[Interval]) -> Result<Vec<Note>> {
    let mut notes = Vec::new();
    for (number, assumed) in problem.simulator.assumed().into_iter().enumerate() {
        let log = problem.log.map(|log| log.variant(number + 1));
        let there = Problem { simulator: assumed.at_upper.as_ref(), log: log.as_ref(), ..*problem };
        let there = there.fit(fit.point.clone(), 1.0)?;
        let moved = problem.free.iter().zip(intervals).map(|(&free, interval)| {
            let half_width = 0.5 * (interval.high.value - interval.low.value);
            (free, (there.point.parameters[free] - fit.point.parameters[free]).abs(), half_width)
        });
        let share = |(_, moved, half_width): &(usize, f64, f64)| moved / half_width;
        let most = moved.filter(|one| share(one) > MATTERS).max_by(|a, b| share(a).total_cmp(&share(b)));
        notes.extend(most.map(|most| note(problem, &assumed, most)));
    }
    Ok(notes)
}

fn note(problem: &Problem, assumed: &Assumed, (parameter, moved, half_width): (usize, f64, f64)) -> Note {
    let Assumed { setting, value, range: (low, high), unit, .. } = assumed;
    let name = &problem.simulator.parameters()[parameter].name;
    let text = format!(
        "`{setting}` = {value} {unit} is assumed, not measured: a local value from {low} to {high} {unit} moves `{name}` by up to {}, \
         which its 95 % interval of ± {} does not account for",
        three_digits(moved),
        three_digits(half_width)
    );
    Note::new(findings::CONSTANT_ASSUMED, text, format!("set `{setting}` to the local value, with four digits"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::{Channel, Observation};
    use crate::simulator::{Parameter, RolloutResult, Simulator};

    /// Distance fallen in t from a start at rest, `k g t²/2`: an estimate of k rests on g alone.
    #[derive(Clone)]
    struct Fall {
        gravity: f64,
        parameters: Vec<Parameter>,
        channels: Vec<Channel>,
    }

    impl Simulator for Fall {
        fn parameters(&self) -> &[Parameter] {
            &self.parameters
        }
        fn channels(&self) -> &[Channel] {
            &self.channels
        }
        fn assumed(&self) -> Vec<Assumed> {
            let at_upper = Box::new(Self { gravity: 9.83, ..self.clone() });
            let (setting, unit) = ("world.gravity_m_s2", "m/s²");
            vec![Assumed { setting, value: self.gravity, range: (9.79, 9.83), unit, at_upper }]
        }
        fn rollout(&self, p: &[f64], _: &[f64], clock: &[f64], values: &mut [f64]) -> RolloutResult {
            values.iter_mut().zip(clock).for_each(|(value, t)| *value = 0.5 * p[0] * self.gravity * t * t);
            Ok(())
        }
    }

    fn asked(noise: f64) -> Vec<Note> {
        let parameters = vec![Parameter::new("share", "1", 1.0, 0.0, 2.0).unwrap()];
        let fall = Fall { gravity: 9.81, parameters, channels: vec![Channel::new("fallen", "m")] };
        let clock: Vec<f64> = (0..100).map(|i| 0.01 * f64::from(i)).collect();
        let wave = |i: usize| noise * (i as f64 * 2.4).sin();
        let values = clock.iter().enumerate().map(|(i, t)| 0.5 * 9.81 * t * t + wave(i)).collect();
        let seen = Observation::new(fall.kind(), fall.channels.clone(), clock, values).unwrap();
        let outcome = crate::tune::tune(&fall, &[seen], None, &crate::tune::Settings::default()).unwrap();
        outcome.notes.into_iter().filter(|note| note.kind == findings::CONSTANT_ASSUMED).collect()
    }

    /// 9.83 in the place of 9.81 makes the share 0.2 % smaller.
    #[test]
    fn a_constant_that_moves_an_estimate_by_more_than_its_interval_is_asked_for() {
        let notes = asked(1e-4);
        assert!(notes.len() == 1 && notes[0].text.contains("moves `share` by up to 0.00203"), "{notes:?}");
        assert!(asked(0.2).is_empty());
    }
}
