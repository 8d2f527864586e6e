//! The hidden balls.

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// What a ball of the hidden world is.
#[derive(Debug, Clone, PartialEq)]
pub struct ShotBall {
    pub name: &'static str,
    pub restitution: f64,
    /// Coulomb's coefficient.
    pub friction: f64,
    /// Quadratic drag, 1/m.
    pub drag_1_m: f64,
    /// Standard deviation of the turn of every rebound about each of two axes, rad.
    pub scatter_rad: f64,
    /// How restitution falls with speed: e (v / 3 m/s)^−exponent.
    pub exponent: f64,
    /// Standard deviation of the spin with which it is released, about each level axis, rad/s.
    pub spin_rad_s: f64,
}

const fn ball(name: &'static str, restitution: f64, friction: f64, drag_1_m: f64, scatter_deg: f64) -> ShotBall {
    let scatter_rad = scatter_deg.to_radians();
    ShotBall { name, restitution, friction, drag_1_m, scatter_rad, exponent: 0.0, spin_rad_s: 0.0 }
}

/// Balls of the size and weight of a table-tennis ball or more, from smooth to lumpy: names are only names. The first
/// three stay; in place of the others three are drawn.
pub const FIXED: [ShotBall; 3] = [
    ball("gel", 0.79, 0.02, 0.010, 0.5),
    ball("table tennis", 0.83, 0.02, 0.100, 1.0),
    ball("holed", 0.62, 0.03, 0.060, 4.0),
];
/// Names of the drawn ones, and how far their rebounds are turned, degrees.
const DRAWN: [(&str, std::ops::Range<f64>); 3] =
    [("drawn, even", 0.5..1.5), ("drawn, rough", 1.0..2.5), ("drawn, lumpy", 4.0..7.0)];
const RESTITUTION: std::ops::Range<f64> = 0.60..0.85;
const FRICTION: std::ops::Range<f64> = 0.02..0.04;
/// Between the natural logarithms of 0.01 and 0.1 1/m.
const LOG_DRAG: std::ops::Range<f64> = -4.605..-2.303;

/// The six balls of a seed.
pub fn all(random: &mut ChaCha8Rng) -> Vec<ShotBall> {
    let drawn = DRAWN.map(|(name, scatter)| {
        let (e, mu) = (random.random_range(RESTITUTION), random.random_range(FRICTION));
        ball(name, e, mu, random.random_range(LOG_DRAG).exp(), random.random_range(scatter))
    });
    FIXED.into_iter().chain(drawn).collect()
}

impl ShotBall {
    /// The same in a richer world: hard hits rebound less, and releases have spin.
    pub fn richer(self) -> Self {
        Self { exponent: 0.08, spin_rad_s: 15.0, ..self }
    }

    /// With which spin a hand lets it go, rad/s.
    pub fn spin(&self, random: &mut ChaCha8Rng) -> [f64; 3] {
        let mut normal = || self.spin_rad_s * random.sample::<f64, _>(StandardNormal);
        [normal(), normal(), 0.0]
    }
}
