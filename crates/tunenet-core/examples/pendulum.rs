//! A simulator of your own, made tunable: a pendulum's length and damping from one recorded swing.
use tunenet_core::Error;
use tunenet_core::observation::{Channel, Kind, Observation};
use tunenet_core::simulator::{Parameter, RolloutResult, Simulator, rollout};
use tunenet_core::tune::{Outcome, Settings, tune};

struct Pendulum([Parameter; 2], [Channel; 1]);
impl Simulator for Pendulum {
    fn parameters(&self) -> &[Parameter] {
        &self.0
    }
    fn channels(&self) -> &[Channel] {
        &self.1
    }
    fn rollout(&self, p: &[f64], _: &[f64], clock: &[f64], angles: &mut [f64]) -> RolloutResult {
        let slope = |s: [f64; 2]| [s[1], -9.81 / p[0] * s[0].sin() - p[1] * s[1]];
        let (mut s, mut now) = ([0.5, 0.0], 0.0); // angle and rate: let go half a radian off the vertical
        for (&t, angle) in clock.iter().zip(angles) {
            let ahead = |k: [f64; 2], h: f64| [s[0] + h * k[0], s[1] + h * k[1]];
            let (h, a) = (t - now, slope(s)); // one Runge-Kutta step from sample to sample
            let b = slope(ahead(a, h / 2.0));
            let c = slope(ahead(b, h / 2.0));
            let d = slope(ahead(c, h));
            (s, now) = (ahead([0, 1].map(|i| (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]) / 6.0), h), t);
            *angle = s[0];
        }
        Ok(())
    }
}
pub(crate) fn tuned() -> Result<Outcome, Error> {
    let known = [Parameter::new("length", "m", 1.0, 0.2, 2.0)?, Parameter::new("damping", "1/s", 0.1, 0.0, 1.0)?];
    let pendulum = Pendulum(known, [Channel::new("angle", "rad")]);
    let clock: Vec<f64> = (0..300).map(|i| f64::from(i) / 60.0).collect();
    let angles = rollout(&pendulum, &[0.62, 0.24], &[], &clock)?; // what your sensor saw stands here
    let seen = Observation::new(Kind::Other, pendulum.channels().to_vec(), clock, angles)?;
    tune(&pendulum, &[seen], None, &Settings::default())
}
pub(crate) fn main() -> Result<(), Error> {
    tuned().map(|outcome| outcome.parameters.iter().for_each(|p| println!("{} = {:.4} {}", p.name, p.value, p.unit)))
}
