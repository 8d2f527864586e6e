//! Omitted-variable bias (Wooldridge 2010, section 4.3.1) of effects that every real body shows and the simulation leaves out.
//!
//! A little of such an effect, as the drag of air, hides in the parameters: the residual still looks like noise, and the interval
//! excludes the truth. Everything is fitted again with its coefficient free; where that fit is better by more than chance, the interval
//! reaches to where the other fit puts the parameter.

use crate::Result;
use crate::estimate::{Fit, Interval, Problem, ScaleEstimate};
use crate::findings;
use crate::observation::{Note, three_digits, with_decimals};
use crate::simulator::{Effect, Prepared};

/// A gain of likelihood (as a square of standard deviations) from which the coefficient is taken for seen.
const SEEN: f64 = 9.0;
/// Two steps show at least this share of the gain.
const BRIEFLY: f64 = 0.5;
/// A coefficient that moves no estimate by more than this share of its half-width is not reported.
const MATTERS: f64 = 0.5;

/// What an effect that is left out does to the estimates.
pub(super) struct Omission {
    /// How far each free parameter moves with it.
    pub moves: Vec<f64>,
    /// What the user should know.
    pub note: Note,
}

/// Widens the `intervals` of the free parameters at `fit` by what effects do that are always there and left out.
///
/// # Errors
/// Where the simulator refuses the effect.
pub(super) fn widen(
    problem: &Problem,
    fit: &Fit,
    scale: &ScaleEstimate,
    intervals: &mut [Interval],
) -> Result<Vec<Omission>> {
    let mut found = Vec::new();
    for (number, effect) in problem.simulator.effects().iter().filter(|effect| effect.always).enumerate() {
        let variant = problem.simulator.assumed().len() + 1 + number;
        found.extend(omission(problem, (fit, scale), effect, variant, intervals)?);
    }
    Ok(found)
}

fn omission(
    problem: &Problem,
    (fit, scale): (&Fit, &ScaleEstimate),
    effect: &Effect,
    variant: usize,
    intervals: &mut [Interval],
) -> Result<Option<Omission>> {
    let simulator = problem.simulator.with_effects(&[&effect.name])?;
    let before = problem.simulator.parameters().len();
    let added = before..simulator.parameters().len();
    let recordings: Vec<Prepared> = problem.recordings.iter().map(|one| one.with_parameters(added.len())).collect();
    let free: Vec<usize> = problem.free.iter().copied().chain(added.clone()).collect();
    let mut start = fit.point.clone();
    let typical = effect.coefficients.iter().map(|c| (c.absent + c.typical).clamp(c.min, c.max));
    start.parameters.extend(typical);
    let log = problem.log.map(|log| log.variant(variant));
    let with = Problem {
        simulator: simulator.as_ref(),
        recordings: &recordings,
        noise: problem.noise,
        free: &free,
        log: log.as_ref(),
    };
    let near = with.fit_briefly(start, None)?;
    if scale.excess(fit.cost - near.cost) < BRIEFLY * SEEN {
        return Ok(None);
    }
    let there = with.fit(near.point, 1.0)?;
    if there.cut_short || scale.excess(fit.cost - there.cost) < SEEN {
        return Ok(None);
    }
    let mut moves = Vec::with_capacity(intervals.len());
    let mut most: Option<(f64, &str, f64)> = None;
    for (k, (&position, interval)) in problem.free.iter().zip(intervals.iter_mut()).enumerate() {
        let parameter = &problem.simulator.parameters()[position];
        let half_width = scale.quantile() * scale.sd(there.covariance[(k, k)]);
        let (value, moved) =
            (there.point.parameters[position], there.point.parameters[position] - fit.point.parameters[position]);
        let own = 0.5 * (interval.high.value - interval.low.value);
        moves.push(moved);
        if half_width.is_finite() {
            interval.low.value = interval.low.value.min(value - half_width).max(parameter.min);
            interval.high.value = interval.high.value.max(value + half_width).min(parameter.max);
        }
        let share = moved.abs() / own;
        if share > MATTERS && most.is_none_or(|(greatest, ..)| share > greatest) {
            most = Some((share, parameter.name.as_ref(), value));
        }
    }
    let note = most.map(|(_, name, value)| {
        let coefficients: Vec<String> = added
            .map(|i| format!("`{}` = {}", simulator.parameters()[i].name, three_digits(there.point.parameters[i])))
            .collect();
        let text = format!(
            "the simulation leaves out `{}`, and the recordings show some of it: with {}, `{name}` is {}. \
             The 95 % interval includes that value",
            effect.name,
            coefficients.join(" and "),
            with_decimals(value, 4)
        );
        Note::new(
            findings::EFFECT_OMITTED,
            text,
            "search for the missing effect with a diagnosis of the same recordings",
        )
    });
    Ok(note.map(|note| Omission { moves, note }))
}

#[cfg(test)]
mod tests {
    use rand::{Rng as _, SeedableRng as _};
    use rand_distr::StandardNormal;

    use super::*;
    use crate::observation::{Channel, Kind, Observation};
    use crate::simulator::{Coefficient, Parameter, Phase, RolloutResult, Simulator};
    use crate::tune::{Outcome, Settings, Verdict, tune};

    /// y = b t − c t², without `c` unless it carries that effect.
    #[derive(Clone)]
    struct Slowing {
        parameters: Vec<Parameter>,
        channels: Vec<Channel>,
        always: bool,
    }

    impl Slowing {
        fn new(always: bool) -> Self {
            let speed = Parameter::new("speed", "m/s", 0.9, 0.0, 2.0).unwrap();
            Self { parameters: vec![speed], channels: vec![Channel::new("y", "m")], always }
        }

        fn effect(&self) -> Effect {
            let coefficient = Coefficient::new("c_m_s2", "m/s²", 0.0, (0.0, 1.0), 0.01);
            Effect { always: self.always, ..Effect::new("drag", Phase::Segment, "it slows down", vec![coefficient]) }
        }
    }

    impl Simulator for Slowing {
        fn parameters(&self) -> &[Parameter] {
            &self.parameters
        }
        fn channels(&self) -> &[Channel] {
            &self.channels
        }
        fn effects(&self) -> Vec<Effect> {
            if self.parameters.len() > 1 { Vec::new() } else { vec![self.effect()] }
        }
        fn with_effects(&self, _: &[&str]) -> Result<Box<dyn Simulator>> {
            let mut with = self.clone();
            with.parameters.extend(self.effect().parameters(None)?);
            Ok(Box::new(with))
        }
        fn rollout(&self, p: &[f64], _: &[f64], clock: &[f64], values: &mut [f64]) -> RolloutResult {
            let drag = p.get(1).copied().unwrap_or(0.0);
            clock.iter().zip(values).for_each(|(t, y)| *y = p[0] * t - drag * t * t);
            Ok(())
        }
    }

    /// The tuning to 200 samples of y = t − c t² over 1 s with white noise of 10 mm.
    fn tuned(always: bool, drag: f64, seed: u64) -> Outcome {
        let clock: Vec<f64> = (1..=200).map(|i| 0.005 * f64::from(i)).collect();
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        let mut noise = || 0.01 * random.sample::<f64, _>(StandardNormal);
        let values = clock.iter().map(|t| t - drag * t * t + noise()).collect();
        let slowing = Slowing::new(always);
        let seen = Observation::new(Kind::Other, slowing.channels.clone(), clock, values).unwrap();
        tune(&slowing, &[seen], None, &Settings::default()).unwrap()
    }

    fn holds_the_truth(outcome: &Outcome) -> bool {
        let (low, high) = outcome.parameters[0].interval95;
        low < 1.0 && 1.0 < high
    }

    /// By least squares the speed is lower than the truth by 3 c / 4, or 0.026: 20 standard deviations. The curvature that is left
    /// raises the residual by 6 % of its square only, which looks like noise.
    #[test]
    fn an_interval_reaches_to_the_value_with_an_effect_that_is_always_there() {
        let mut held = 0;
        for (without, with) in (0..10).map(|seed| (tuned(false, 0.035, seed), tuned(true, 0.035, seed))) {
            assert!(without.verdict == Verdict::Tuned && !holds_the_truth(&without), "{:?}", without.parameters);
            assert_eq!(with.verdict, Verdict::Tuned);
            held += usize::from(holds_the_truth(&with));
            let said = with.notes.iter().find(|note| note.kind == findings::EFFECT_OMITTED).unwrap();
            assert!(said.text.contains("`drag.c_m_s2`") && said.text.contains("`speed` is"), "{}", said.text);
            assert_eq!(without.parameters[0].value, with.parameters[0].value, "the estimate stays");
        }
        assert!(held >= 9, "{held} of 10 intervals hold the truth");
    }

    #[test]
    fn nothing_is_widened_where_the_recordings_show_none_of_it() {
        for seed in 0..10 {
            assert_eq!(tuned(true, 0.0, seed).parameters, tuned(false, 0.0, seed).parameters, "{seed}");
        }
    }
}
