//! A point that falls along a line, followed by the classical Runge–Kutta step, as a host of further terms.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use crate::Result;
use crate::law::{Carried, Direction, Host, Nature, Space, Term, Variable, Visit, Visiting};
use crate::observation::{Channel, Kind, Observation};
use crate::simulator::{Parameter, Preparation, Prepared, RolloutResult, Simulator};

/// Steps in a second.
const RATE_HZ: f64 = 400.0;

/// A recording of a path that starts at 0 m.
pub fn observed(seconds: f64, noise_m: f64, seed: u64, path_m: &dyn Fn(f64) -> f64) -> Observation {
    let mut draw = ChaCha8Rng::seed_from_u64(seed);
    let clock: Vec<f64> = (0..=150_u32).map(|k| f64::from(k) / 100.0).filter(|t| *t <= seconds).collect();
    let values = clock.iter().map(|t| path_m(*t) + noise_m * draw.sample::<f64, _>(StandardNormal)).collect();
    Observation::new(Kind::Other, vec![Channel::new("x", "m")], clock, values).unwrap()
}

/// The host.
pub struct Line {
    space: Space,
}

impl Line {
    pub fn new() -> Self {
        let variable = |name: &str, unit: &str, nature| Variable { name: name.into(), unit: unit.into(), nature };
        let variables = vec![
            variable("x_m", "m", Nature::Number),
            variable("v_m_s", "m/s", Nature::Rate),
            variable("t_s", "s", Nature::Clock),
        ];
        let directions = vec![Direction { components: vec!["x".into()] }];
        Self { space: Space { directions, variables, axes: vec![0], taken: Vec::new() } }
    }

    pub fn simulator(&self) -> Box<dyn Visiting> {
        self.carrying(&[]).unwrap()
    }
}

impl Host for Line {
    fn space(&self) -> &Space {
        &self.space
    }

    fn carrying(&self, terms: &[Carried]) -> Result<Box<dyn Visiting>> {
        let mut parameters = vec![Parameter::new("gravity", "m/s²", 9.0, 5.0, 15.0)?];
        for one in terms {
            parameters.extend(one.effect.parameters(None)?);
        }
        let terms = terms.iter().map(|one| one.term.clone()).collect();
        Ok(Box::new(Falling { parameters, channels: vec![Channel::new("x", "m")], terms }))
    }

    fn unit(&self, _direction: usize, powers: &[(usize, f64)]) -> String {
        let each = powers.iter().map(|(v, p)| format!("/({})^{p}", self.space.variables[*v].unit));
        std::iter::once("m/s²".to_owned()).chain(each).collect()
    }
}

struct Falling {
    parameters: Vec<Parameter>,
    channels: Vec<Channel>,
    terms: Vec<Term>,
}

impl Falling {
    fn acceleration(&self, parameters: &[f64], t: f64, x: f64, v: f64) -> f64 {
        let (mut at, mut sum) = (1, -parameters[0]);
        for term in &self.terms {
            let numbers = &parameters[at..at + term.constants()];
            at += term.constants();
            sum += numbers[0] * term.product(numbers, &[x, v, t], &[x.signum(), v.signum(), 1.0]);
        }
        sum
    }

    fn states(&self, parameters: &[f64], start: &[f64], from: f64, clock: &[f64]) -> Vec<(f64, f64, f64)> {
        let (mut t, mut x, mut v) = (from, start[0], start[1]);
        let mut all = Vec::new();
        for &wanted in clock {
            while t < wanted - 1e-12 {
                let h = (wanted - t).min(1.0 / RATE_HZ);
                let a = |t: f64, x: f64, v: f64| self.acceleration(parameters, t, x, v);
                let (k1, l1) = (v, a(t, x, v));
                let (k2, l2) = (v + 0.5 * h * l1, a(t + 0.5 * h, x + 0.5 * h * k1, v + 0.5 * h * l1));
                let (k3, l3) = (v + 0.5 * h * l2, a(t + 0.5 * h, x + 0.5 * h * k2, v + 0.5 * h * l2));
                let (k4, l4) = (v + h * l3, a(t + h, x + h * k3, v + h * l3));
                x += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
                v += h / 6.0 * (l1 + 2.0 * l2 + 2.0 * l3 + l4);
                t += h;
            }
            all.push((wanted, x, v));
        }
        all
    }
}

impl Simulator for Falling {
    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn prepare(&self, seen: &Observation) -> Result<Preparation> {
        let mut prepared = Prepared::whole(seen.clone(), self.parameters.len());
        let (first, later) = (seen.row(0)[0], seen.row(10)[0]);
        let speed = (later - first) / (seen.clock()[10] - seen.clock()[0]) + 0.5;
        prepared.nuisances = vec![
            Parameter::new("start.x", "m", first, first - 1.0, first + 1.0)?,
            Parameter::new("start.v", "m/s", speed, speed - 5.0, speed + 5.0)?,
        ];
        Ok(Preparation::Usable(Box::new(prepared)))
    }

    fn rollout(&self, parameters: &[f64], nuisances: &[f64], clock: &[f64], values: &mut [f64]) -> RolloutResult {
        let states = self.states(parameters, nuisances, clock[0], clock);
        values.iter_mut().zip(states).for_each(|(value, (_, x, _))| *value = x);
        Ok(())
    }
}

impl Visiting for Falling {
    fn visits(
        &self,
        recording: &Prepared,
        parameters: &[f64],
        nuisances: &[f64],
        instants_s: &[f64],
    ) -> Result<Vec<Visit>> {
        let states = self.states(parameters, nuisances, recording.seen.clock()[0], instants_s);
        let visit = |(t, x, v): (f64, f64, f64)| Visit { variables: vec![x, v, t], components: vec![vec![vec![1.0]]] };
        Ok(states.into_iter().map(visit).collect())
    }
}
