//! Table of shapes: functions of one variable with at most two constants inside, evaluated natively.

use std::f64::consts::PI;

use super::space::Nature;

/// A function of one variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Shape {
    /// `x^p` of a positive variable.
    Power,
    /// `|x|^p sign(x)`.
    OddPower,
    /// `exp(-x/c)` of a positive variable.
    Exp,
    /// `exp(-((x - h)/w)^2)`.
    Bump,
    /// `sin(k x)`.
    Sin,
    /// `cos(k x)`.
    Cos,
    /// `cos(k x + f)` of the clock.
    Wave,
    /// `tanh(x/c)`.
    Tanh,
    /// `ln(1 + x/c)` of a positive variable.
    Log,
    /// `1/(1 + x/c)` of a positive variable.
    Saturation,
    /// `exp(-(x/c)^2) sign(x)`.
    Stribeck,
    /// `sign(x)`.
    Sign,
    /// 1 from one instant of the clock to another, 0 outside: no law, but what a response is measured with.
    Window,
}

/// What a constant inside a shape is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// A power's exponent.
    Exponent,
    /// A length, speed or other scale, above 0.
    Scale,
    /// Where a bump has its middle.
    Place,
    /// How wide a bump is, above 0.
    Width,
    /// An angular frequency, above 0.
    Frequency,
    /// A phase, rad.
    Phase,
}

impl Role {
    /// Its name for programs.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Exponent => "exponent",
            Self::Scale => "scale",
            Self::Place => "place",
            Self::Width => "width",
            Self::Frequency => "frequency",
            Self::Phase => "phase",
        }
    }

    /// The letter under which it stands in a formula.
    #[must_use]
    pub const fn letter(self) -> &'static str {
        match self {
            Self::Exponent => "p",
            Self::Scale => "c",
            Self::Place => "h",
            Self::Width => "w",
            Self::Frequency => "k",
            Self::Phase => "f",
        }
    }

    /// Whether it is searched by factors instead of differences.
    pub(super) const fn logarithmic(self) -> bool {
        matches!(self, Self::Scale | Self::Width | Self::Frequency)
    }
}

/// Between which values the recordings move a variable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// The first percentile.
    pub low: f64,
    /// The 99th percentile.
    pub high: f64,
    /// The least value.
    pub least: f64,
    /// The greatest magnitude.
    pub greatest: f64,
}

impl Range {
    fn span(&self) -> f64 {
        (self.high - self.low).max(1e-9 * self.greatest).max(f64::MIN_POSITIVE)
    }
}

/// Frequencies of a search: one for every half turn within the range.
const FREQUENCIES: u32 = 28;
/// The greatest exponent of a power.
const MOST_EXPONENT: f64 = 8.0;
/// Exponents of a search, of positive variables and of signed ones.
const EXPONENTS: [f64; 8] = [-3.0, -2.0, -1.0, 0.5, 1.0, 1.5, 2.0, 3.0];
const ODD_EXPONENTS: [f64; 5] = [0.5, 1.0, 1.5, 2.0, 3.0];

impl Shape {
    /// Shapes of a variable that the recordings move within `range`.
    pub(super) fn of(nature: Nature, range: &Range) -> Vec<Self> {
        match nature {
            Nature::Clock => vec![Self::Wave],
            _ if range.least > 0.0 => vec![Self::Power, Self::Exp, Self::Bump, Self::Log, Self::Saturation],
            Nature::Number => vec![Self::OddPower, Self::Bump, Self::Sin, Self::Cos, Self::Tanh],
            Nature::Rate => vec![Self::OddPower, Self::Bump, Self::Tanh, Self::Stribeck, Self::Sign],
            Nature::FirstOrder => {
                vec![Self::OddPower, Self::Bump, Self::Sin, Self::Cos, Self::Tanh, Self::Stribeck, Self::Sign]
            }
        }
    }

    /// Its name for programs.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Power => "power",
            Self::OddPower => "odd_power",
            Self::Exp => "exp",
            Self::Bump => "bump",
            Self::Sin => "sin",
            Self::Cos | Self::Wave => "cos",
            Self::Tanh => "tanh",
            Self::Log => "log",
            Self::Saturation => "saturation",
            Self::Stribeck => "stribeck",
            Self::Sign => "sign",
            Self::Window => "window",
        }
    }

    /// What its constants are.
    #[must_use]
    pub const fn roles(self) -> &'static [Role] {
        match self {
            Self::Power | Self::OddPower => &[Role::Exponent],
            Self::Exp | Self::Tanh | Self::Log | Self::Saturation | Self::Stribeck => &[Role::Scale],
            Self::Bump => &[Role::Place, Role::Width],
            Self::Sin | Self::Cos => &[Role::Frequency],
            Self::Wave => &[Role::Frequency, Role::Phase],
            Self::Sign => &[],
            Self::Window => &[Role::Place, Role::Place],
        }
    }

    /// Its value at `x`, on which side of 0 the variable is (−1 to 1), with its constants.
    #[must_use]
    #[inline]
    pub fn value(self, x: f64, side: f64, constants: &[f64]) -> f64 {
        let c = constants.first().copied().unwrap_or(1.0);
        match self {
            Self::Power => power(x, c),
            Self::OddPower => power(x.abs(), c) * x.signum(),
            Self::Exp => (-x / c).exp(),
            Self::Bump => {
                let u = (x - c) / constants[1];
                (-u * u).exp()
            }
            Self::Sin => (c * x).sin(),
            Self::Cos => (c * x).cos(),
            Self::Wave => (c * x + constants[1]).cos(),
            Self::Tanh => (x / c).tanh(),
            Self::Log => (1.0 + x / c).ln(),
            Self::Saturation => 1.0 / (1.0 + x / c),
            Self::Stribeck => (-(x / c) * (x / c)).exp() * side,
            Self::Sign => side,
            Self::Window => f64::from(u8::from(x >= c && x < constants[1])),
        }
    }

    /// Whether it is a power.
    pub(super) const fn is_power(self) -> bool {
        matches!(self, Self::Power | Self::OddPower)
    }

    /// Whether it jumps where its variable is 0.
    #[must_use]
    pub const fn jumps(self) -> bool {
        matches!(self, Self::Stribeck | Self::Sign)
    }

    /// The bounds of a constant.
    pub(super) fn bounds(self, place: usize, range: &Range) -> (f64, f64) {
        let (span, greatest) = (range.span(), range.greatest.max(f64::MIN_POSITIVE));
        match self.roles()[place] {
            Role::Exponent if self == Self::OddPower => (0.2, MOST_EXPONENT),
            Role::Exponent => (-MOST_EXPONENT, MOST_EXPONENT),
            Role::Scale => (0.003 * greatest, 40.0 * greatest),
            Role::Place if self == Self::Window => (-1e9, 1e9),
            Role::Place => (range.low - 2.0 * span, range.high + 2.0 * span),
            Role::Width => (0.02 * span, 10.0 * span),
            Role::Frequency => (0.2 * PI / span, 2.0 * f64::from(FREQUENCIES) * PI / span),
            Role::Phase => (-3.0 * PI, 3.0 * PI),
        }
    }

    /// Constants with which a search begins.
    pub(super) fn grid(self, range: &Range) -> Vec<Vec<f64>> {
        let scales = |shares: &[f64]| shares.iter().map(|share| vec![share * range.greatest]).collect();
        match self {
            Self::Power => EXPONENTS.map(|p| vec![p]).to_vec(),
            Self::OddPower => ODD_EXPONENTS.map(|p| vec![p]).to_vec(),
            Self::Exp => scales(&[0.05, 0.12, 0.25, 0.5, 1.0, 2.0]),
            Self::Tanh | Self::Stribeck => scales(&[0.02, 0.06, 0.15, 0.4, 0.8]),
            Self::Log | Self::Saturation => scales(&[0.02, 0.08, 0.3, 1.0]),
            Self::Bump => {
                let place = |i: u8| range.low + range.span() * f64::from(i) / 4.0;
                let each = (0..5).flat_map(|i| [0.12, 0.35].map(|w| vec![place(i), w * range.span()]));
                each.collect()
            }
            Self::Sin | Self::Cos => (1..=16).map(|j| vec![0.5 * f64::from(j) * PI / range.span()]).collect(),
            Self::Wave => (1..=FREQUENCIES).map(|j| vec![f64::from(j) * PI / range.span(), 0.0]).collect(),
            Self::Sign | Self::Window => vec![Vec::new()],
        }
    }

    /// How far a first step of a search goes from a point of the grid: a factor, or a difference.
    pub(super) fn reach(self, place: usize, range: &Range) -> f64 {
        match self.roles()[place] {
            Role::Exponent => 0.35,
            Role::Place => 0.12 * range.span(),
            Role::Scale | Role::Width => 1.5,
            Role::Frequency if self == Self::Wave => 1.15,
            Role::Frequency => 1.25,
            Role::Phase => 0.5,
        }
    }
}

/// A power, whole ones without a logarithm.
#[inline]
fn power(x: f64, p: f64) -> f64 {
    if p == 1.0 {
        x
    } else if p == 2.0 {
        x * x
    } else {
        x.powf(p)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_have_their_closed_forms() {
        for (shape, x, constants, wanted) in [
            (Shape::Power, 2.0, &[3.0][..], 8.0),
            (Shape::OddPower, -2.0, &[2.0], -4.0),
            (Shape::Exp, 2.0, &[2.0], (-1.0_f64).exp()),
            (Shape::Bump, 1.0, &[3.0, 2.0], (-1.0_f64).exp()),
            (Shape::Wave, 0.0, &[3.0, PI], -1.0),
            (Shape::Log, 3.0, &[1.0], 4.0_f64.ln()),
            (Shape::Saturation, 3.0, &[1.0], 0.25),
            (Shape::Stribeck, -2.0, &[2.0], -(-1.0_f64).exp()),
            (Shape::Window, 1.0, &[1.0, 2.0], 1.0),
            (Shape::Window, 2.0, &[1.0, 2.0], 0.0),
        ] {
            let found = shape.value(x, x.signum(), constants);
            assert!((found - wanted).abs() < 1e-15, "{shape:?}: {found}");
        }
    }

    #[test]
    fn what_stops_at_0_may_jump_there() {
        let range = |least| Range { low: -1.0, high: 1.0, least, greatest: 1.0 };
        let has = |nature, shape| Shape::of(nature, &range(-1.0)).contains(&shape);
        assert_eq!(
            [Nature::Number, Nature::Rate, Nature::FirstOrder].map(|n| has(n, Shape::Sign)),
            [false, true, true]
        );
        assert_eq!([Nature::Number, Nature::Rate, Nature::FirstOrder].map(|n| has(n, Shape::Sin)), [true, false, true]);
        assert!(!Shape::of(Nature::FirstOrder, &range(0.1)).contains(&Shape::Sign));
    }

    #[test]
    fn grids_lie_within_the_bounds() {
        let range = Range { low: 0.1, high: 2.0, least: 0.1, greatest: 2.1 };
        for shape in [Nature::Clock, Nature::Number].into_iter().flat_map(|nature| Shape::of(nature, &range)) {
            for point in shape.grid(&range) {
                for (i, value) in point.iter().enumerate() {
                    let (low, high) = shape.bounds(i, &range);
                    assert!((low..=high).contains(value), "{shape:?} {point:?}");
                }
            }
        }
    }
}
