//! A point that is reflected at known instants: y' = v between events, v → −r v at each of them.

use std::sync::Arc;

use super::{ClosedForm, Values, effect, start};
use crate::Result;
use crate::observation::{Channel, Observation};
use crate::simulator::{Effect, Parameter, Phase, Segmentation};

/// Time from event to event, the first one so long after t = 0, s.
pub const PERIOD_S: f64 = 0.4;
/// Below this product of rate and time, the solution is its Taylor series in the rate.
const SLOW: f64 = 1e-4;

/// Between events `v' = a − b v`, at each event `y → y + s` and `v → k − r v`. The simulator knows `r` alone; `a` (`push`)
/// and `b` (`friction`) act between events, `s` (`slip`) and `k` (`kick`) at events.
#[derive(Debug, Clone, Copy, Default)]
pub struct Shuttle {
    /// Whether there are no events: one free segment, whose state is that at t = 0 had it been there.
    pub free: bool,
}

impl ClosedForm for Shuttle {
    fn channel(&self) -> Channel {
        Channel::new("y", "m")
    }

    fn parameters(&self) -> Vec<Parameter> {
        Parameter::new("returned", "1", 0.9, 0.0, 1.2).into_iter().collect()
    }

    fn effects(&self) -> Vec<Effect> {
        let segment = |effect| Effect { phase: Phase::Segment, ..effect };
        let event = |effect| Effect { phase: Phase::Event, ..effect };
        vec![
            segment(effect("friction", "rate_1_s", "1/s", (0.0, 3.0), 0.02)),
            segment(effect("push", "a_m_s2", "m/s²", (-3.0, 3.0), 0.02)),
            event(effect("kick", "speed_m_s", "m/s", (-3.0, 3.0), 0.02)),
            event(effect("slip", "step_m", "m", (-1.0, 1.0), 0.01)),
        ]
    }

    fn nuisances(&self, seen: &Observation) -> Result<Vec<Parameter>> {
        let names = [("start.value", "m"), ("start.speed", "m/s")];
        let guessed = start(seen, names, [5.0, 20.0])?;
        let back = guessed[1].value * seen.clock()[0];
        let [value, speed] = [guessed[0].value - back, guessed[1].value];
        Ok(vec![
            Parameter::new("start.value", "m", value, value - 5.0, value + 5.0)?,
            Parameter::new("start.speed", "m/s", speed, speed - 20.0, speed + 20.0)?,
        ])
    }

    fn solution(&self, values: &Values, start: &[f64], t: f64) -> f64 {
        let (rate, push) = (values("friction.rate_1_s"), values("push.a_m_s2"));
        let (mut y, mut v, mut left) = (start[0], start[1], t);
        while !self.free && left >= PERIOD_S {
            let (rested, moved) = integrals(rate, PERIOD_S);
            y += v * rested + push * moved + values("slip.step_m");
            v = values("kick.speed_m_s") - values("returned") * (v * (-rate * PERIOD_S).exp() + push * rested);
            left -= PERIOD_S;
        }
        let (rested, moved) = integrals(rate, left);
        y + v * rested + push * moved
    }

    fn segmentation(&self) -> Option<Arc<dyn Segmentation>> {
        (!self.free).then(|| Arc::new(Instants) as Arc<dyn Segmentation>)
    }

    fn free(&self) -> Option<Self> {
        Some(Self { free: true })
    }
}

/// The integral of e^(−bt) over time, and its own integral.
fn integrals(rate: f64, t: f64) -> (f64, f64) {
    if (rate * t).abs() < SLOW {
        return (t - rate * t * t / 2.0, t * t / 2.0 - rate * t.powi(3) / 6.0);
    }
    let once = -(-rate * t).exp_m1() / rate;
    (once, (t - once) / rate)
}

/// Events at every multiple of [`PERIOD_S`].
#[derive(Debug)]
struct Instants;

impl Segmentation for Instants {
    fn moving(&self, seen: &Observation, _: &[f64]) -> usize {
        seen.len()
    }

    fn events(&self, seen: &Observation) -> Vec<f64> {
        let (first, last) = (seen.clock()[0], seen.clock()[seen.len() - 1]);
        (1u32..).map(|k| f64::from(k) * PERIOD_S).skip_while(|t| *t <= first).take_while(|t| *t < last).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::second_derivative;
    use super::*;

    fn shuttle(free: bool, t: f64) -> (f64, f64, f64) {
        let values = |name: &str| match name {
            "returned" => 0.8,
            "friction.rate_1_s" => 0.6,
            "push.a_m_s2" => 0.4,
            "kick.speed_m_s" => 0.3,
            "slip.step_m" => 0.01,
            _ => 0.0,
        };
        second_derivative(&Shuttle { free }, &values, &[0.1, 1.5], t)
    }

    #[test]
    fn between_events_it_follows_its_equation() {
        for t in [0.2, 0.7, 1.0, 1.5] {
            let (_, v, a) = shuttle(false, t);
            assert!((a - (0.4 - 0.6 * v)).abs() < 1e-4, "{t}: {a} {v}");
        }
        let (_, v, a) = shuttle(true, 1.0);
        assert!((a - (0.4 - 0.6 * v)).abs() < 1e-4, "a free segment has no event");
    }

    #[test]
    fn an_event_steps_pushes_and_reflects() {
        let h = 0.0015;
        let ((before, u, _), (after, v, _)) = (shuttle(false, PERIOD_S - h), shuttle(false, PERIOD_S + h));
        assert!((v - (0.3 - 0.8 * u)).abs() < 0.01, "{u} {v}");
        assert!((after - before - 0.01 - h * (u + v)).abs() < 1e-4);
    }
}
