//! The weight of a load along a motion, by the addition theorems of sine and cosine: from one step to the next the angle changes by
//! little, and four terms of their series are exact to the last digit.

use super::one_joint::Load;

/// Angles up to this change by series, rad: the first term that is left out is below 3e-16.
const SMALL_RAD: f64 = 0.02;
/// After so many steps sine and cosine are taken anew, before their roundings add up.
const STEPS: u32 = 128;

/// The torque of the weight as the angle goes on.
#[derive(Debug, Clone, Copy)]
pub(super) struct SwingingWeight<'a> {
    load: &'a Load,
    sine: f64,
    cosine: f64,
    /// Steps until they are taken anew.
    left: u32,
}

impl<'a> SwingingWeight<'a> {
    /// At this position.
    pub fn at(load: &'a Load, q: f64) -> Self {
        let (sine, cosine) = if load.amplitude == 0.0 { (0.0, 1.0) } else { (q + load.phase).sin_cos() };
        Self { load, sine, cosine, left: STEPS }
    }

    /// The torque where it is.
    #[inline]
    pub fn torque(&self) -> f64 {
        self.load.constant - self.load.amplitude * self.sine
    }

    /// Goes on by `change` (rad) to `q`.
    #[inline]
    pub fn go(&mut self, change: f64, q: f64) {
        if self.load.amplitude == 0.0 {
            return;
        }
        // What is not a number is not small.
        let small = change.abs() <= SMALL_RAD;
        if self.left == 0 || !small {
            *self = Self::at(self.load, q);
            return;
        }
        let square = change * change;
        let sine = change * (1.0 + square * (-1.0 / 6.0 + square * (1.0 / 120.0)));
        let cosine = 1.0 + square * (-0.5 + square * (1.0 / 24.0 - square * (1.0 / 720.0)));
        (self.sine, self.cosine) = (self.sine * cosine + self.cosine * sine, self.cosine * cosine - self.sine * sine);
        self.left -= 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps of several sizes, forth and back: an angle of many turns is itself a sum of many roundings.
    #[test]
    fn it_is_the_sine_to_the_last_digits() {
        let load = Load { inertia: 1.0, constant: 0.3, amplitude: 2.0, phase: 0.7 };
        for size in [1e-5, 3e-3, 0.02, -0.011, 0.05, 1.0] {
            let mut weight = SwingingWeight::at(&load, 0.1);
            let mut q = 0.1;
            for k in 0..20_000 {
                let step = if k / 500 % 2 == 0 { size } else { -size };
                q += step;
                weight.go(step, q);
                let error = weight.torque() - load.torque(q);
                assert!(error.abs() < 1e-12, "{error} at {q} by {step}");
            }
        }
        let still = Load { amplitude: 0.0, ..load };
        let mut weight = SwingingWeight::at(&still, 0.0);
        weight.go(0.01, 0.01);
        assert_eq!(weight.torque(), still.constant);
        let mut weight = SwingingWeight::at(&load, 0.0);
        weight.go(f64::NAN, f64::NAN);
        assert!(weight.torque().is_nan());
    }
}
