//! Step size by doubling (Press et al., Numerical Recipes, 1992, section 16.2) of the classical Runge–Kutta step: for
//! accelerations that depend on place, velocity and time, of which nothing else is known.

use rapier3d::math::Vector;

/// How fine steps are.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fineness {
    /// How far a step may be from two half steps, as a length, m, and as a velocity, m/s.
    tolerance: f64,
    /// A step is halved at most so often; a force that needs more jumps.
    halvings: u32,
}

impl Fineness {
    /// Of forces that a file holds.
    pub const SIMULATED: Self = Self { tolerance: 1e-9, halvings: 10 };
    /// Of forms that a search tries by the thousand, some of which are steep: far below the noise of any recording.
    pub const SEARCHED: Self = Self { tolerance: 1e-7, halvings: 5 };
}

/// What an acceleration may drift beyond what the stages of its step show.
const MARGIN: f64 = 2.0;

/// The classical step of fourth order for x' = v, v' = a(t, x, v).
pub(super) fn runge_kutta(
    (x, v): (Vector, Vector),
    h: f64,
    a: impl Fn(f64, Vector, Vector) -> Vector,
) -> (Vector, Vector) {
    let half = 0.5 * h;
    let k1 = a(0.0, x, v);
    let (x2, v2) = (x + v * half, v + k1 * half);
    let k2 = a(half, x2, v2);
    let (x3, v3) = (x + v2 * half, v + k2 * half);
    let k3 = a(half, x3, v3);
    let (x4, v4) = (x + v3 * h, v + k3 * h);
    let k4 = a(h, x4, v4);
    (x + (v + (v2 + v3) * 2.0 + v4) * (h / 6.0), v + (k1 + (k2 + k3) * 2.0 + k4) * (h / 6.0))
}

/// The length of a step (s), at most `longest`, and how far the acceleration may drift within it, m/s².
pub(super) fn by_doubling(
    (longest, fineness): (f64, Fineness),
    start: (Vector, Vector),
    a: impl Fn(f64, Vector, Vector) -> Vector,
) -> (f64, f64) {
    let mut step = longest;
    for _ in 0..fineness.halvings {
        let whole = runge_kutta(start, step, &a);
        let middle = runge_kutta(start, 0.5 * step, &a);
        let end = runge_kutta(middle, 0.5 * step, |t, x, v| a(t + 0.5 * step, x, v));
        let (of_place, of_velocity) = ((whole.0 - end.0).length(), (whole.1 - end.1).length());
        // What is no number, as a root beyond the surface that a long step looks through, may be one in a shorter step.
        if of_place <= fineness.tolerance && of_velocity <= fineness.tolerance {
            let first = a(0.0, start.0, start.1);
            let drift = |t: f64, (x, v): (Vector, Vector)| (a(t, x, v) - first).length();
            return (step, MARGIN * drift(0.5 * step, middle).max(drift(step, end)));
        }
        step *= 0.5;
    }
    let (x, v) = runge_kutta(start, step, &a);
    (step, MARGIN * (a(step, x, v) - a(0.0, start.0, start.1)).length())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On a spring the motion is a cosine.
    #[test]
    fn steps_follow_an_oscillation() {
        let rate = 40.0_f64;
        let mut state = (Vector::new(0.3, 0.0, 0.0), Vector::ZERO);
        let (mut t, mut steps) = (0.0, 0);
        while t < 1.0 {
            let (step, drift) = by_doubling((1.0 / 60.0, Fineness::SIMULATED), state, |_, x, _| x * (-rate * rate));
            let step = step.min(1.0 - t);
            state = runge_kutta(state, step, |_, x, _| x * (-rate * rate));
            assert!(drift >= 0.0);
            (t, steps) = (t + step, steps + 1);
        }
        assert!(
            (state.0.x - 0.3 * rate.cos()).abs() < 1e-6 && steps < 2000,
            "{} {steps}",
            state.0.x - 0.3 * rate.cos()
        );
    }

    #[test]
    fn an_even_acceleration_takes_the_longest_step() {
        let (step, drift) = by_doubling((0.1, Fineness::SIMULATED), (Vector::ZERO, Vector::ZERO), |_, _, _| {
            Vector::new(0.0, 0.0, -9.81)
        });
        assert_eq!((step, drift), (0.1, 0.0));
    }

    /// A ball at 3 cm falls with 4 m/s; below 0 the acceleration has no value, which a step of 1/60 s would meet.
    #[test]
    fn a_step_that_meets_no_value_is_halved_until_it_meets_none() {
        let start = (Vector::new(0.0, 0.0, 0.03), Vector::new(0.0, 0.0, -4.0));
        let root = |_: f64, x: Vector, _: Vector| Vector::new(0.0, x.z.sqrt(), -9.81);
        let (step, drift) = by_doubling((1.0 / 60.0, Fineness::SEARCHED), start, root);
        assert!(step < 0.03 / 4.0 && step > 1e-4 && drift.is_finite(), "{step} {drift}");
    }
}
