//! How a path goes by the hoop.

use super::flight::Flight;
use super::scene::Hoop;
use crate::ball::State;

/// Pieces into which the way between two states is cut to look for what is nearest.
const PIECES: u32 = 4;
/// Rounds of narrowing afterwards, each to the golden section: half a step of a path to a thousandth of a millimetre, near
/// which a least value does not change.
const ROUNDS: usize = 20;
const GOLDEN: f64 = 0.618_033_988_749_894_8;

/// What a path is worth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pass {
    /// From the hoop's centre to where the path last falls through the hoop's plane, m; where it never does, to the
    /// nearest point of the path.
    pub miss_m: f64,
    /// Whether it falls through the hoop's plane at all.
    pub falls: bool,
    /// From the rim's circle to the nearest point of the path, m.
    pub clearance_m: f64,
    /// How far the ball stays clear of the rim, m; negative where it touches the rim or falls next to the hoop.
    pub margin_m: f64,
}

impl Pass {
    /// Judges a path.
    ///
    /// ```
    /// use tunenet_sim::ball::State;
    /// use tunenet_sim::shot::{Flight, Pass, scene::Hoop};
    /// // Straight down, 2 cm next to the centre of a hoop of 10 cm; the ball is 3 cm in radius.
    /// let hoop = Hoop { centre_m: [0.0; 3], normal: [0.0, 0.0, 1.0], radius_m: 0.1, rim_radius_m: 0.0 };
    /// let state = |z: f64| State { position_m: [0.02, 0.0, z], velocity_m_s: [0.0, 0.0, -1.0], ..State::default() };
    /// let flight = Flight { step_s: 0.1, states: vec![state(0.1), state(0.0), state(-0.1)], bounce: 0, bounce_s: 0.0 };
    /// let pass = Pass::judge(&flight, &hoop, 0.03);
    /// assert!((pass.miss_m - 0.02).abs() < 1e-9 && (pass.clearance_m - 0.08).abs() < 1e-9);
    /// assert!(pass.goes_in() && (pass.margin_m - 0.05).abs() < 1e-9);
    /// ```
    #[must_use]
    pub fn judge(flight: &Flight, hoop: &Hoop, radius_m: f64) -> Self {
        let path = &flight.states[flight.bounce.min(flight.states.len().saturating_sub(1))..];
        let mut crossing = None;
        for pair in path.windows(2) {
            if hoop.above(pair[0].position_m) > 0.0 && hoop.above(pair[1].position_m) <= 0.0 {
                let piece = Piece::new(&pair[0], &pair[1], flight.step_s);
                crossing = Some(hoop.from_centre(piece.at(piece.root(|x| hoop.above(x)))));
            }
        }
        let rim = nearest(path, flight.step_s, |x| hoop.from_rim(x));
        let falls = crossing.is_some();
        let miss_m = crossing.unwrap_or_else(|| nearest(path, flight.step_s, |x| hoop.from_centre(x)));
        let room = rim - hoop.rim_radius_m - radius_m;
        let inside = falls && miss_m < hoop.radius_m;
        // If the ball misses the hoop, the distance to the rim is the miss distance.
        let margin_m = if inside { room } else { -(rim + hoop.rim_radius_m + radius_m) };
        Self { miss_m, falls, clearance_m: rim, margin_m }
    }

    /// Whether the ball falls through the hoop without touching its rim.
    #[must_use]
    pub fn goes_in(&self) -> bool {
        self.margin_m >= 0.0
    }
}

/// The least value along a path of a distance, which changes by no more than the way that is gone.
fn nearest(path: &[State], step_s: f64, of: impl Fn([f64; 3]) -> f64) -> f64 {
    let speed = |state: &State| state.velocity_m_s.iter().map(|v| v * v).sum::<f64>().sqrt();
    let values: Vec<(f64, f64)> = path.iter().map(|state| (of(state.position_m), speed(state))).collect();
    let mut least = values.iter().map(|v| v.0).fold(f64::INFINITY, f64::min);
    for (pair, ends) in path.windows(2).zip(values.windows(2)) {
        // How long it is at most.
        let length = 1.5 * step_s * ends[0].1.max(ends[1].1);
        // Nothing on it can lie nearer than its ends by more than half of that.
        if 0.5 * (ends[0].0 + ends[1].0 - length) < least {
            least = least.min(Piece::new(&pair[0], &pair[1], step_s).nearest(&of));
        }
    }
    least
}

/// The way between two states, as the cubic that has their places and velocities: exact for a parabola.
struct Piece {
    from: State,
    to: State,
    seconds: f64,
}

impl Piece {
    fn new(from: &State, to: &State, seconds: f64) -> Self {
        Self { from: *from, to: *to, seconds }
    }

    /// The place at a share of the way.
    fn at(&self, s: f64) -> [f64; 3] {
        let (a, b) = (s * s * (3.0 - 2.0 * s), s * (1.0 - s));
        [0, 1, 2].map(|i| {
            let (x, y) = (self.from.position_m[i], self.to.position_m[i]);
            let (v, w) = (self.from.velocity_m_s[i] * self.seconds, self.to.velocity_m_s[i] * self.seconds);
            x + a * (y - x) + b * ((1.0 - s) * v - s * w)
        })
    }

    /// Where `of` falls through 0, as a share of the way; it is above 0 at the start.
    fn root(&self, of: impl Fn([f64; 3]) -> f64) -> f64 {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if of(self.at(middle)) > 0.0 { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }

    /// The least value of `of` on the way: near the best of a few places, by the golden section.
    fn nearest(&self, of: impl Fn([f64; 3]) -> f64) -> f64 {
        let value = |s: f64| of(self.at(s));
        let reach = 1.0 / f64::from(PIECES);
        let (mut best, mut least) = (0.0, f64::INFINITY);
        for i in 0..=PIECES {
            let s = reach * f64::from(i);
            let found = value(s);
            if found < least {
                (best, least) = (s, found);
            }
        }
        let (mut low, mut high) = ((best - reach).max(0.0), (best + reach).min(1.0));
        let inner = |low: f64, high: f64| (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
        let (mut a, mut b) = inner(low, high);
        let (mut at_a, mut at_b) = (value(a), value(b));
        for _ in 0..ROUNDS {
            if at_a < at_b {
                (high, b, at_b) = (b, a, at_a);
                a = inner(low, high).0;
                at_a = value(a);
            } else {
                (low, a, at_a) = (a, b, at_b);
                b = inner(low, high).1;
                at_b = value(b);
            }
        }
        at_a.min(at_b).min(least)
    }
}
