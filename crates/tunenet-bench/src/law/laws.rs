//! The laws that are hidden, each with its inner constants drawn.

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};

use super::arena::Arena;
use super::motion::Force;
use super::strange::{Strange, StrangeForce};
use super::term::{Direction, Shape, Term, Variable};

/// The names of the laws inside the grammar, with their arenas.
pub const INSIDE: [(&str, Arena); 26] = [
    ("drag-1", Arena::Flight),
    ("drag-1.5", Arena::Flight),
    ("drag-2", Arena::Flight),
    ("drag-2.5", Arena::Flight),
    ("drag-3", Arena::Flight),
    ("log-drag", Arena::Flight),
    ("fan-jet", Arena::Flight),
    ("floor-magnet", Arena::Flight),
    ("wind", Arena::Flight),
    ("oscillating-wind", Arena::Flight),
    ("thinning-drag", Arena::Flight),
    ("inverse-r", Arena::Plane),
    ("inverse-square", Arena::Plane),
    ("inverse-r-1.5", Arena::Plane),
    ("screened", Arena::Plane),
    ("oscillating-charge", Arena::Plane),
    ("cubic", Arena::Plane),
    ("field-at-centre", Arena::Centre),
    ("hubble-at-centre", Arena::Centre),
    ("drag-at-centre", Arena::Centre),
    ("sine-2q", Arena::Pendulum),
    ("stribeck", Arena::Pendulum),
    ("cubic-spring", Arena::Pendulum),
    ("damped-spot", Arena::Pendulum),
    ("quadratic-damping", Arena::Pendulum),
    ("oscillating-torque", Arena::Pendulum),
];

/// Laws that no product of two factors says.
pub const OUTSIDE: [(&str, Arena, Strange); 8] = [
    ("bessel-k1", Arena::Plane, Strange::Yukawa),
    ("image-sum", Arena::Plane, Strange::KaluzaKlein),
    ("dipole", Arena::Plane, Strange::Dipole),
    ("band", Arena::Flight, Strange::Band),
    ("chirp", Arena::Flight, Strange::Chirp),
    ("sheared-air", Arena::Flight, Strange::ShearedAir),
    ("dead-spring", Arena::Pendulum, Strange::DeadSpring),
    ("square-wave", Arena::Pendulum, Strange::SquareWave),
];

/// Forces that depend on a hidden state.
pub const HIDDEN_STATE: [(&str, Arena, Strange); 8] = [
    ("spin-decays", Arena::Flight, Strange::SpinDecays),
    ("drag-decays", Arena::Flight, Strange::DragDecays),
    ("fan-slows", Arena::Flight, Strange::FanSlows),
    ("charge-decays", Arena::Plane, Strange::ChargeDecays),
    ("companion", Arena::Plane, Strange::Companion),
    ("friction-decays", Arena::Pendulum, Strange::FrictionDecays),
    ("bouc-wen", Arena::Pendulum, Strange::BoucWen),
    ("hidden-mass", Arena::Pendulum, Strange::HiddenMass),
];

/// The single-body laws of `DiscoverPhysics`; the last two are outside the grammar.
pub const DISCOVER: [&str; 6] = ["gravity", "fractional", "coulomb", "oscillator", "yukawa", "kaluza-klein"];
/// Their strength, and the length of the last two, m.
pub const DISCOVER_STRENGTH: f64 = 1.6;
const DISCOVER_LENGTH_M: f64 = 2.0;
const DISCOVER_RAD_S: f64 = 1.5;

/// A law inside the grammar, of size 1; its sign is drawn where both make sense.
pub fn inside(name: &str, random: &mut ChaCha8Rng) -> Term {
    use Shape::{Bump, Exp, Log, Odd, Power, Stribeck, Wave};
    use Variable::{Angle, Height, Radius, Rate, Speed, Time};
    let phase = random.random_range(0.0..TAU);
    let either = if random.random() { 1.0 } else { -1.0 };
    // Far enough from both axes that both components show.
    let level = FRAC_PI_4 + random.random_range(-0.35..0.35) + FRAC_PI_2 * f64::from(random.random_range(0..4));
    let share: f64 = random.random();
    let within = |low: f64, high: f64| low + (high - low) * share;
    let other: f64 = random.random();
    let (level, along, away) = (Direction::Level(level), Direction::Velocity, Direction::Radial);
    let (sign, direction, factors) = match name {
        "drag-1" => (-1.0, along, vec![(Speed, Power(1.0))]),
        "drag-1.5" => (-1.0, along, vec![(Speed, Power(1.5))]),
        "drag-2" | "drag-at-centre" => (-1.0, along, vec![(Speed, Power(2.0))]),
        "drag-2.5" => (-1.0, along, vec![(Speed, Power(2.5))]),
        "drag-3" => (-1.0, along, vec![(Speed, Power(3.0))]),
        "log-drag" => (-1.0, along, vec![(Speed, Log(within(0.8, 2.0)))]),
        "fan-jet" => (1.0, level, vec![(Height, Bump { place: within(0.5, 1.0), width: 0.15 + 0.15 * other })]),
        // What acts straight up: the only law of that direction.
        "floor-magnet" => (either, Direction::Vertical, vec![(Height, Power(-3.0))]),
        "wind" | "field-at-centre" => (1.0, level, vec![]),
        "oscillating-wind" => (1.0, level, vec![(Time, Wave { frequency: within(4.0, 12.0), phase })]),
        "thinning-drag" => (-1.0, along, vec![(Speed, Power(2.0)), (Height, Exp(within(0.4, 1.0)))]),
        "inverse-r" => (either, away, vec![(Radius, Power(-1.0))]),
        "inverse-square" => (either, away, vec![(Radius, Power(-2.0))]),
        "inverse-r-1.5" => (either, away, vec![(Radius, Power(-1.5))]),
        "screened" => (either, away, vec![(Radius, Exp(within(1.0, 2.5))), (Radius, Power(-1.0))]),
        "oscillating-charge" => {
            (1.0, away, vec![(Time, Wave { frequency: within(1.0, 3.0), phase }), (Radius, Power(-1.0))])
        }
        "cubic" => (either, away, vec![(Radius, Power(3.0))]),
        "hubble-at-centre" => (either, away, vec![(Radius, Power(1.0))]),
        "sine-2q" => (either, Direction::Joint, vec![(Angle, Wave { frequency: 2.0, phase: -FRAC_PI_2 })]),
        "stribeck" => (-1.0, Direction::Joint, vec![(Rate, Stribeck(within(0.5, 1.5)))]),
        "cubic-spring" => (either, Direction::Joint, vec![(Angle, Odd(3.0))]),
        "damped-spot" => {
            let bump = Bump { place: within(-0.3, 0.3), width: 0.15 + 0.15 * other };
            (-1.0, Direction::Joint, vec![(Angle, bump), (Rate, Odd(1.0))])
        }
        "quadratic-damping" => (-1.0, Direction::Joint, vec![(Rate, Odd(2.0))]),
        "oscillating-torque" => (1.0, Direction::Joint, vec![(Time, Wave { frequency: within(3.0, 15.0), phase })]),
        _ => unreachable!("`{name}` is no law of the bench"),
    };
    Term { size: sign, ..Term::new(direction, &factors) }
}

/// A force that no formula of the grammar says, of size 1.
pub fn strange(kind: Strange, random: &mut ChaCha8Rng) -> StrangeForce {
    let (low, high) = match kind {
        Strange::Yukawa | Strange::KaluzaKlein => (1.0, 2.5),
        Strange::Dipole => (1.0, 1.0),
        // The lower edge of the band; its upper one is at 1.6 times that.
        Strange::Band => (0.4, 0.7),
        Strange::Chirp => (3.0, 6.0),
        // The wind at a height of 1 m, m/s.
        Strange::ShearedAir => (1.0, 3.0),
        Strange::DeadSpring => (0.25, 0.5),
        Strange::SquareWave => (4.0, 10.0),
        // Times of decay, s: a part of the recording.
        Strange::SpinDecays | Strange::DragDecays | Strange::FanSlows => (0.5, 1.0),
        Strange::ChargeDecays => (2.0, 4.0),
        Strange::FrictionDecays => (1.3, 2.6),
        Strange::Companion => (0.5, 1.2),
        Strange::BoucWen => (0.05, 0.15),
        Strange::HiddenMass => (6.0, 12.0),
    };
    let scale = low + (high - low) * random.random::<f64>();
    let angle = random.random_range(0.0..TAU);
    let both = matches!(kind, Strange::Yukawa | Strange::KaluzaKlein | Strange::ChargeDecays);
    let size = if both && random.random() { -1.0 } else { 1.0 };
    StrangeForce { kind, size, scale, angle }
}

/// A law of `DiscoverPhysics` at its full size; it attracts, and the oscillator by turns.
pub fn discover(name: &str) -> Force {
    let law = |factors: &[(Variable, Shape)]| {
        Force::Law(Term { size: -DISCOVER_STRENGTH, ..Term::new(Direction::Radial, factors) })
    };
    let strange =
        |kind| Force::Strange(StrangeForce { kind, size: -DISCOVER_STRENGTH, scale: DISCOVER_LENGTH_M, angle: 0.0 });
    let power = |p| (Variable::Radius, Shape::Power(p));
    match name {
        "gravity" => law(&[power(-1.0)]),
        "fractional" => law(&[power(-1.5)]),
        "coulomb" => law(&[power(-2.0)]),
        "oscillator" => law(&[(Variable::Time, Shape::Wave { frequency: DISCOVER_RAD_S, phase: 0.0 }), power(-1.0)]),
        "yukawa" => strange(Strange::Yukawa),
        "kaluza-klein" => strange(Strange::KaluzaKlein),
        _ => unreachable!("`{name}` is no law of DiscoverPhysics"),
    }
}

/// The inward acceleration of such a law at a distance, without its change with time, m/s².
pub fn discover_inward(name: &str, r: f64) -> f64 {
    let place = super::term::Place { time_s: 0.0, x: [r, 0.0, 0.0], v: [0.0; 3], side: 0.0 };
    match discover(name) {
        Force::Nothing => 0.0,
        Force::Law(term) => term.at(&place)[0],
        Force::Strange(force) => force.at(&place, [0.0; 2], [0.0; 2])[0],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::set::stream;

    #[test]
    fn every_law_inside_has_at_most_two_factors_and_a_name_of_its_own() {
        for (i, (name, _)) in INSIDE.iter().enumerate() {
            let term = inside(name, &mut stream("test", 1, name, 0));
            assert!(term.factors.len() <= 2 && term.size.abs() == 1.0, "{name}: {term:?}");
            assert!(INSIDE[..i].iter().all(|(other, _)| other != name));
        }
        let counts = [Arena::Flight, Arena::Plane, Arena::Centre, Arena::Pendulum]
            .map(|arena| INSIDE.iter().filter(|(_, a)| *a == arena).count());
        assert_eq!(counts, [11, 6, 3, 6]);
    }

    #[test]
    fn laws_of_discover_physics_have_their_strengths() {
        assert_eq!(discover_inward("gravity", 2.0), -0.8);
        assert_eq!(discover_inward("coulomb", 2.0), -0.4);
        // K1(1)/2 at a distance of one length.
        assert!((discover_inward("yukawa", 2.0) + 1.6 * 0.601_907_230_197_234_6 / 2.0).abs() < 1e-9);
    }
}
