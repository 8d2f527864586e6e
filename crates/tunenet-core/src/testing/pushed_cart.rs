//! A cart that a known force pushes: the closed form of m x″ + c x′ + k x = F(t − d) for sums of sinusoids (complex frequency
//! response and the two modes of the homogeneous equation).

use nalgebra::Complex;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use crate::Result;
use crate::observation::{Channel, Circumstances, Hold, Input, Kind, Observation};

/// Frequencies of a force, Hz.
const FREQUENCIES_HZ: (f64, f64) = (0.2, 2.5);
/// Amplitude of each sinusoid of a force, N.
const AMPLITUDES_N: (f64, f64) = (1.0, 4.0);
const SINUSOIDS: usize = 4;
/// The force is sampled at this rate, Hz, from before the recording begins: straight lines between samples change it by 1e-5.
const FORCE_RATE_HZ: f64 = 2000.0;
const BEFORE_S: f64 = 0.5;
/// Length of a recording and its rate.
const SECONDS: f64 = 4.0;
const RATE_HZ: f64 = 100.0;

/// A cart on a track, at rest at x = 0 m until a recording begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PushedCart {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Viscous damping, N·s/m; above 0, and not critical.
    pub damping_ns_m: f64,
    /// How much later the force acts than it is recorded, s.
    pub delay_s: f64,
    /// Stiffness of a spring whose rest position is x = 0 m, N/m.
    pub stiffness_n_m: f64,
}

/// One sinusoid of a force: amplitude in N, angular frequency in rad/s, phase in rad.
type Sinusoid = [f64; 3];

impl PushedCart {
    /// Recordings with forces of their own as [inputs](Circumstances::inputs), and white noise of standard deviation `noise_m`;
    /// everything drawn from `seed`.
    ///
    /// # Errors
    /// Where the noise is no number.
    pub fn recordings(&self, count: usize, noise_m: f64, seed: u64) -> Result<Vec<Observation>> {
        let mut draw = ChaCha8Rng::seed_from_u64(seed);
        (0..count).map(|_| self.recording(&force(&mut draw), noise_m, &mut draw)).collect()
    }

    fn recording(&self, force: &[Sinusoid], noise_m: f64, draw: &mut ChaCha8Rng) -> Result<Observation> {
        let even =
            |from: f64, rate: f64| (0_u32..).map(move |k| from + f64::from(k) / rate).take_while(|t| *t <= SECONDS);
        let times: Vec<f64> = even(-BEFORE_S, FORCE_RATE_HZ).collect();
        let values = times.iter().map(|t| force.iter().map(|[a, w, p]| a * (w * t + p).sin()).sum()).collect();
        let input = Input::sampled(Channel::new("force", "N"), Hold::Linear, times, values)?;
        let clock: Vec<f64> = even(0.0, RATE_HZ).collect();
        let seen = |t: &f64| self.position_m(force, *t) + noise_m * draw.sample::<f64, _>(StandardNormal);
        let values = clock.iter().map(seen).collect();
        let seen = Observation::new(Kind::Other, vec![Channel::new("x", "m")], clock, values)?;
        Ok(seen.under(Circumstances::driven_by(vec![input])))
    }

    /// The position `t` seconds after it was at rest at 0 m.
    fn position_m(&self, force: &[Sinusoid], t: f64) -> f64 {
        let forced = |t: f64| -> [f64; 2] {
            let each = force.iter().map(|[amplitude, w, phase]| {
                let response = Complex::new(self.stiffness_n_m - self.mass_kg * w * w, self.damping_ns_m * w).inv();
                let turned = response * Complex::from_polar(*amplitude, w * (t - self.delay_s) + phase);
                [turned.im, w * turned.re]
            });
            each.fold([0.0; 2], |[x, v], [dx, dv]| [x + dx, v + dv])
        };
        let [x0, v0] = forced(0.0);
        let (half, square) = (0.5 * self.damping_ns_m / self.mass_kg, self.stiffness_n_m / self.mass_kg);
        let root = Complex::new(half * half - square, 0.0).sqrt();
        let (slow, fast) = (root - half, -root - half);
        // Both modes together undo position and velocity of the forced motion at the start.
        let of_slow = (Complex::from(-v0) + fast * x0) / (slow - fast);
        let of_fast = Complex::from(-x0) - of_slow;
        forced(t)[0] + (of_slow * (slow * t).exp() + of_fast * (fast * t).exp()).re
    }
}

fn force(draw: &mut ChaCha8Rng) -> Vec<Sinusoid> {
    let one = |_| {
        let amplitude = draw.random_range(AMPLITUDES_N.0..AMPLITUDES_N.1);
        let frequency_hz = draw.random_range(FREQUENCIES_HZ.0..FREQUENCIES_HZ.1);
        [amplitude, std::f64::consts::TAU * frequency_hz, draw.random_range(0.0..std::f64::consts::TAU)]
    };
    (0..SINUSOIDS).map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_position_satisfies_its_equation_from_rest() {
        let cart = PushedCart { mass_kg: 1.8, damping_ns_m: 2.1, delay_s: 0.03, stiffness_n_m: 0.0 };
        for cart in [cart, PushedCart { stiffness_n_m: 9.0, ..cart }] {
            let force = force(&mut ChaCha8Rng::seed_from_u64(3));
            let at = |t: f64| cart.position_m(&force, t);
            let h = 1e-3;
            assert!(
                at(0.0).abs() < 1e-12 && (at(h) - at(-h)).abs() < 1e-5 * h.sqrt(),
                "{} {}",
                at(0.0),
                at(h) - at(-h)
            );
            for k in 1..40 {
                let t = 0.1 * f64::from(k);
                let (v, a) = ((at(t + h) - at(t - h)) / (2.0 * h), (at(t + h) - 2.0 * at(t) + at(t - h)) / (h * h));
                let pushed: f64 = force.iter().map(|[a, w, p]| a * (w * (t - cart.delay_s) + p).sin()).sum();
                let balance = cart.mass_kg * a + cart.damping_ns_m * v + cart.stiffness_n_m * at(t) - pushed;
                assert!(balance.abs() < 1e-3, "{t}: {balance}");
            }
        }
    }

    #[test]
    fn recordings_differ_and_follow_from_the_seed() {
        let cart = PushedCart { mass_kg: 1.0, damping_ns_m: 1.0, delay_s: 0.0, stiffness_n_m: 0.0 };
        let all = cart.recordings(2, 1e-3, 5).unwrap();
        assert_eq!(all, cart.recordings(2, 1e-3, 5).unwrap());
        assert_ne!(all[0], all[1]);
        assert_eq!(all[0].circumstances().unwrap().inputs[0].series().clock()[0], -BEFORE_S);
    }
}
