//! A law as data: a direction times factors of one variable each. What is simulated and what an answer is compared with are the
//! same value.

use serde::{Deserialize, Serialize};

/// Where a body is, at which instant, and how it moves. In the plane z is 0; a joint has its angle as x.
#[derive(Debug, Clone, Copy)]
pub struct Place {
    pub time_s: f64,
    pub x: [f64; 3],
    pub v: [f64; 3],
    /// The direction of a joint's rate where dry friction acts: 1, −1, or 0 where it sticks.
    pub side: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Direction {
    /// Along the velocity.
    Velocity,
    /// Away from the origin.
    Radial,
    /// In the plane of x and y, at this angle to x, rad.
    Level(f64),
    /// Up.
    Vertical,
    /// Of a joint, which has only one.
    Joint,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Variable {
    Speed,
    Radius,
    Height,
    Time,
    Angle,
    Rate,
}

/// A factor as a function of its variable x.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Shape {
    /// |x|^p.
    Power(f64),
    /// |x|^p sign x.
    Odd(f64),
    /// e^(−x/scale).
    Exp(f64),
    /// e^(−((x − place)/width)²).
    Bump { place: f64, width: f64 },
    /// cos(frequency x + phase).
    Wave { frequency: f64, phase: f64 },
    /// ln(1 + x/scale).
    Log(f64),
    /// e^(−(x/scale)²) sign x: the part of dry friction that fades with speed.
    Stribeck(f64),
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Factor {
    pub variable: Variable,
    pub shape: Shape,
}

/// An acceleration: `size` times the factors, along the direction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Term {
    pub direction: Direction,
    pub factors: Vec<Factor>,
    pub size: f64,
}

impl Term {
    pub fn new(direction: Direction, factors: &[(Variable, Shape)]) -> Self {
        let factors = factors.iter().map(|&(variable, shape)| Factor { variable, shape }).collect();
        Self { direction, factors, size: 1.0 }
    }

    /// The acceleration, m/s² or rad/s².
    pub fn at(&self, place: &Place) -> [f64; 3] {
        let size = self.factors.iter().fold(self.size, |size, factor| size * factor.at(place));
        self.direction.unit(place).map(|v| size * v)
    }

    /// The dry friction that holds a joint at rest, rad/s².
    pub fn holds(&self) -> f64 {
        let dry = self.factors.iter().any(|f| matches!(f.shape, Shape::Stribeck(_)));
        if dry { self.size.abs() } else { 0.0 }
    }
}

impl Direction {
    fn unit(self, place: &Place) -> [f64; 3] {
        match self {
            Self::Velocity => over(place.v),
            Self::Radial => over(place.x),
            Self::Level(angle) => [angle.cos(), angle.sin(), 0.0],
            Self::Vertical => [0.0, 0.0, 1.0],
            Self::Joint => [1.0, 0.0, 0.0],
        }
    }
}

impl Variable {
    fn at(self, place: &Place) -> f64 {
        match self {
            Self::Speed => length(place.v),
            Self::Radius => length(place.x),
            Self::Height => place.x[2],
            Self::Time => place.time_s,
            Self::Angle => place.x[0],
            Self::Rate => place.v[0],
        }
    }
}

impl Factor {
    fn at(&self, place: &Place) -> f64 {
        let x = self.variable.at(place);
        match self.shape {
            Shape::Power(p) => x.abs().powf(p),
            Shape::Odd(p) => x.signum() * x.abs().powf(p),
            Shape::Exp(scale) => (-x / scale).exp(),
            Shape::Bump { place, width } => (-((x - place) / width).powi(2)).exp(),
            Shape::Wave { frequency, phase } => (frequency * x + phase).cos(),
            Shape::Log(scale) => (x / scale).ln_1p(),
            Shape::Stribeck(scale) => place.side * (-(x / scale).powi(2)).exp(),
        }
    }
}

pub fn length(a: [f64; 3]) -> f64 {
    (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]).sqrt()
}

/// The unit vector along `a`; of 0 it is 0.
pub fn over(a: [f64; 3]) -> [f64; 3] {
    let length = length(a);
    if length > 0.0 { a.map(|v| v / length) } else { [0.0; 3] }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place() -> Place {
        Place { time_s: 0.5, x: [3.0, 0.0, 4.0], v: [0.0, -2.0, 0.0], side: -1.0 }
    }

    #[test]
    fn a_term_is_the_product_of_its_factors_along_its_direction() {
        let drag = Term::new(
            Direction::Velocity,
            &[(Variable::Speed, Shape::Power(2.0)), (Variable::Height, Shape::Exp(4.0))],
        );
        assert_eq!(drag.at(&place()), [0.0, -4.0 * (-1.0_f64).exp(), 0.0]);
        let inward = Term { size: -5.0, ..Term::new(Direction::Radial, &[(Variable::Radius, Shape::Power(-1.0))]) };
        let at = inward.at(&place());
        assert!((at[0] + 0.6).abs() < 1e-12 && (at[2] + 0.8).abs() < 1e-12, "{at:?}");
    }

    #[test]
    fn dry_friction_follows_the_side_and_holds() {
        let dry = Term { size: -2.0, ..Term::new(Direction::Joint, &[(Variable::Rate, Shape::Stribeck(1.0))]) };
        assert_eq!(dry.at(&Place { v: [0.0; 3], ..place() })[0], 2.0);
        assert_eq!(dry.holds(), 2.0);
    }
}
