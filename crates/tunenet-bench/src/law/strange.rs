//! What no formula of the grammar says: laws outside it, and forces that depend on a state that nobody sees.

use serde::{Deserialize, Serialize};

use super::term::{Place, length, over};

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Strange {
    /// K1(r/λ)/λ, the force of a screened charge in the plane.
    Yukawa,
    /// 1/r² of a charge and of its images along a closed third dimension.
    KaluzaKlein,
    /// The field of two charges of opposite sign close together.
    Dipole,
    /// A push along a level direction between two heights.
    Band,
    /// An oscillating push whose frequency rises.
    Chirp,
    /// Quadratic drag in air that moves faster higher up.
    ShearedAir,
    /// A spring that is met beyond an angle.
    DeadSpring,
    /// A torque that changes its sign at once.
    SquareWave,
    /// The force of a spin that decays from another value in each recording.
    SpinDecays,
    /// Quadratic drag that decays likewise.
    DragDecays,
    /// Wind that decays likewise.
    FanSlows,
    /// A charge that decays likewise.
    ChargeDecays,
    /// An hidden body on a circle attracts.
    Companion,
    /// Coulomb friction that decays likewise.
    FrictionDecays,
    /// Hysteresis (Bouc 1967, Wen 1976).
    BoucWen,
    /// An hidden mass on a spring.
    HiddenMass,
}

/// One of them, with its numbers: what a scale and an angle mean depends on the kind.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StrangeForce {
    pub kind: Strange,
    pub size: f64,
    /// A length, a time or a rate.
    pub scale: f64,
    /// An angle, rad.
    pub angle: f64,
}

/// The images of a charge that are summed on either side; the rest is an integral.
const IMAGES: i32 = 30;
/// Half of the band's edges and of the square wave's, as a share.
const EDGE: f64 = 0.05;
/// Damping of the hidden mass, as a share of the critical one.
const HIDDEN_DAMPING: f64 = 0.05;

impl StrangeForce {
    /// The acceleration; `hidden` is the hidden state, `own` are two draws of the recording, from 0 to 1.
    pub fn at(&self, place: &Place, hidden: [f64; 2], own: [f64; 2]) -> [f64; 3] {
        let Place { time_s: t, x, v, side } = *place;
        let (size, scale, angle) = (self.size, self.scale, self.angle);
        let level = |push: f64| [push * angle.cos(), push * angle.sin(), 0.0];
        let r = length(x);
        let left = self.left(t, own);
        match self.kind {
            Strange::Yukawa => over(x).map(|u| u * size * bessel_k1(r / scale) / scale),
            Strange::KaluzaKlein => over(x).map(|u| u * size * images(r, scale)),
            Strange::Dipole => dipole(size, [angle.cos(), angle.sin()], x),
            Strange::Band => {
                let edge = |z: f64| ((x[2] - z) / (EDGE * scale)).tanh();
                level(0.5 * size * (edge(scale) - edge(1.6 * scale)))
            }
            Strange::Chirp => level(size * (scale * t * (1.0 + t)).cos()),
            Strange::ShearedAir => {
                let through = [v[0] - scale * x[2] * angle.cos(), v[1] - scale * x[2] * angle.sin(), v[2]];
                through.map(|u| -size * length(through) * u)
            }
            Strange::DeadSpring => [-size * (x[0].abs() - scale).max(0.0) * x[0].signum(), 0.0, 0.0],
            Strange::SquareWave => [size * ((scale * t + angle).sin() / EDGE).tanh(), 0.0, 0.0],
            // About a level axis: what points along it turns the motion up or down.
            Strange::SpinDecays => {
                let [a, b] = [angle.cos() * left, angle.sin() * left];
                [b * v[2], -a * v[2], a * v[1] - b * v[0]]
            }
            Strange::DragDecays => v.map(|u| -left * length(v) * u),
            Strange::FanSlows => level(left),
            Strange::ChargeDecays => over(x).map(|u| u * left / r),
            Strange::Companion => {
                let turned = scale * t + std::f64::consts::TAU * own[0];
                let away = [3.0 * turned.cos() - x[0], 3.0 * turned.sin() - x[1], 0.0];
                away.map(|u| size * u / (length(away).powi(2) + 0.09))
            }
            Strange::FrictionDecays => [-left * side, 0.0, 0.0],
            Strange::BoucWen => [-size * hidden[0], 0.0, 0.0],
            Strange::HiddenMass => [size * (hidden[0] - x[0]), 0.0, 0.0],
        }
    }

    /// What is left of a size that decays.
    fn left(&self, t: f64, own: [f64; 2]) -> f64 {
        // From 0.4 to 1.6 of the size at the start of the recording.
        self.size * (0.4 + 1.2 * own[0]) * (-t / self.scale).exp()
    }

    /// The hidden state at the start of a recording that begins at `angle`.
    pub fn hidden(&self, angle: f64, own: [f64; 2]) -> [f64; 2] {
        match self.kind {
            Strange::BoucWen => [0.6 * (2.0 * own[0] - 1.0), 0.0],
            Strange::HiddenMass => [angle + 0.6 * (2.0 * own[0] - 1.0), 2.0 * (2.0 * own[1] - 1.0)],
            _ => [0.0; 2],
        }
    }

    /// How fast the hidden state changes.
    pub fn slope(&self, place: &Place, [a, b]: [f64; 2]) -> [f64; 2] {
        let (q, rate) = (place.x[0], place.v[0]);
        match self.kind {
            Strange::BoucWen => {
                // Yields where the joint has turned by the scale.
                let y = rate / self.scale;
                [y - 0.5 * y.abs() * a * a.abs() - 0.5 * y * a * a, 0.0]
            }
            Strange::HiddenMass => {
                let omega = self.scale;
                [b, -omega * omega * (a - q) - 2.0 * HIDDEN_DAMPING * omega * b]
            }
            _ => [0.0; 2],
        }
    }

    /// The dry friction that holds a joint at rest, rad/s².
    pub fn holds(&self, t: f64, own: [f64; 2]) -> f64 {
        if self.kind == Strange::FrictionDecays { self.left(t, own).abs() } else { 0.0 }
    }
}

/// The modified Bessel function of the second kind and of order 1: ∫ e^(−x cosh t) cosh t dt over the positive numbers
/// (Abramowitz and Stegun 9.6.24). The trapezoidal rule converges exponentially there.
fn bessel_k1(x: f64) -> f64 {
    const STEP: f64 = 0.1;
    let one = |t: f64| (-x * t.cosh()).exp() * t.cosh();
    let mut sum = 0.5 * one(0.0);
    for i in 1..120 {
        let next = one(STEP * f64::from(i));
        sum += next;
        if next < 1e-17 * sum {
            break;
        }
    }
    STEP * sum
}

/// Σ r/(r² + (n L)²)^(3/2) over all whole n.
fn images(r: f64, circumference: f64) -> f64 {
    let one = |n: f64| r / (r * r + (n * circumference).powi(2)).powf(1.5);
    let near: f64 = (1..=IMAGES).map(|n| 2.0 * one(f64::from(n))).sum();
    // The integral from the middle after the last image: ∫ r/(r² + y²)^(3/2) dy = (1 − y/√(r² + y²))/r.
    let y = (f64::from(IMAGES) + 0.5) * circumference;
    let far = 2.0 / circumference * (1.0 - y / y.hypot(r)) / r;
    one(0.0) + near + far
}

fn dipole(size: f64, axis: [f64; 2], x: [f64; 3]) -> [f64; 3] {
    // In the plane: (2 (p·r̂) r̂ − p)/r², softened at 0.2 m.
    let square = x[0] * x[0] + x[1] * x[1] + 0.04;
    let along = 2.0 * (axis[0] * x[0] + axis[1] * x[1]) / square;
    [size * (along * x[0] - axis[0]) / square, size * (along * x[1] - axis[1]) / square, 0.0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bessel_function_is_that_of_tables() {
        for (x, known) in
            [(0.1, 9.853_844_780_870_606), (1.0, 0.601_907_230_197_234_6), (5.0, 0.004_044_613_445_452_164)]
        {
            assert!((bessel_k1(x) / known - 1.0).abs() < 1e-10, "{x}: {}", bessel_k1(x));
        }
    }

    #[test]
    fn images_are_one_charge_nearby_and_a_line_far_off() {
        assert!((images(0.01, 2.0) * 1e-4 - 1.0).abs() < 1e-4);
        // A line of charges of density 1/L: 2/(L r).
        assert!((images(10.0, 2.0) * 10.0 - 1.0).abs() < 1e-5, "{}", images(10.0, 2.0));
        let long: f64 = (-200_000..=200_000).map(|n| 1.5 / (2.25 + (2.0 * f64::from(n)).powi(2)).powf(1.5)).sum();
        assert!((images(1.5, 2.0) / long - 1.0).abs() < 1e-5, "{} {long}", images(1.5, 2.0));
    }

    #[test]
    fn a_spin_does_no_work_and_its_force_decays() {
        let spin = StrangeForce { kind: Strange::SpinDecays, size: 3.0, scale: 0.5, angle: 0.7 };
        let place = Place { time_s: 0.0, x: [0.0; 3], v: [1.0, -2.0, 0.5], side: 0.0 };
        let (now, later) =
            (spin.at(&place, [0.0; 2], [0.5; 2]), spin.at(&Place { time_s: 0.5, ..place }, [0.0; 2], [0.5; 2]));
        let work: f64 = now.iter().zip(place.v).map(|(a, v)| a * v).sum();
        assert!(work.abs() < 1e-12, "{work}");
        assert!((length(later) / length(now) - (-1.0_f64).exp()).abs() < 1e-12);
    }

    #[test]
    fn hysteresis_saturates_at_one() {
        let force = StrangeForce { kind: Strange::BoucWen, size: 1.0, scale: 0.1, angle: 0.0 };
        let place = Place { time_s: 0.0, x: [0.0; 3], v: [1.0, 0.0, 0.0], side: 1.0 };
        assert_eq!(force.slope(&place, [1.0, 0.0])[0], 0.0);
        assert_eq!(force.slope(&place, [0.0, 0.0])[0], 10.0);
    }
}
