//! Regula falsi alternating with bisection along a ray of a profile-likelihood contour: where the ray leaves the joint region of two
//! parameters.

use super::interval::{ScaleEstimate, fit_with_fixed};
use super::output_error::Problem;
use super::problem::Point;

/// The edge is found to this share of its distance from the origin, or of the root of the misfit there.
const EDGE_SHARE: f64 = 0.01;
const MOST_HALVINGS: usize = 12;

/// A ray in the plane of two parameters, everything else fitted again along it.
pub(super) struct Ray<'a> {
    pub problem: &'a Problem<'a>,
    pub scale: &'a ScaleEstimate,
    /// Positions of the two among the simulator's parameters.
    pub positions: [usize; 2],
    /// The best point, and its cost.
    pub best: (&'a Point, f64),
    /// Where the ray begins; within the region.
    pub origin: [f64; 2],
    /// Where it leads. At a length of 1 the edge is expected.
    pub direction: [f64; 2],
}

impl Ray<'_> {
    /// The last place whose misfit is at most `quantile`, or where the ray meets a bound or what the simulator refuses before,
    /// and the rollouts it took.
    ///
    /// The root of the misfit is nearly linear along a ray, so a place is interpolated; where it is not (a flat stretch, a
    /// kink), every second guess halves what is left.
    pub fn edge(&self, quantile: f64) -> ([f64; 2], usize) {
        let (mut rollouts, mut near) = (0, self.best.0.clone());
        let (limit, most) = (quantile.sqrt(), self.most());
        let (mut inner, mut outer) = ((0.0, 0.0), (1f64.min(most), f64::INFINITY));
        loop {
            let (root, point) = self.misfit(&near, outer.0, &mut rollouts);
            outer.1 = root;
            if root > limit {
                break;
            }
            (inner, near) = (outer, point);
            if outer.0 >= most {
                return (self.at(most), rollouts);
            }
            outer.0 = (1.5 * outer.0).min(most);
        }
        for guess in 0..MOST_HALVINGS {
            if outer.0 - inner.0 <= EDGE_SHARE * outer.0 {
                break;
            }
            let share = if guess % 2 == 0 { (limit - inner.1) / (outer.1 - inner.1) } else { 0.5 };
            let between = inner.0 + share.clamp(0.05, 0.95) * (outer.0 - inner.0);
            let (root, point) = self.misfit(&near, between, &mut rollouts);
            if (root / limit - 1.0).abs() < EDGE_SHARE {
                return (self.at(between), rollouts);
            }
            if root <= limit {
                (inner, near) = ((between, root), point);
            } else {
                outer = (between, root);
            }
        }
        (self.at(f64::midpoint(inner.0, outer.0)), rollouts)
    }

    /// The root of the misfit at this length, fitted from `near`, and where that fit ended; infinite where the simulator
    /// refuses.
    fn misfit(&self, near: &Point, length: f64, rollouts: &mut usize) -> (f64, Point) {
        let start = near.with(&self.positions, &self.at(length));
        let Ok(fit) = fit_with_fixed(self.problem, start, &self.positions, self.scale) else {
            *rollouts += self.problem.recordings.len();
            return (f64::INFINITY, near.clone());
        };
        *rollouts += fit.rollouts;
        (self.scale.excess(fit.cost - self.best.1).sqrt(), fit.point)
    }

    /// The length at which a bound is met.
    fn most(&self) -> f64 {
        let room = |i: usize| {
            let (low, high) = self.bounds(i);
            match self.direction[i] {
                r if r > 0.0 => (high - self.origin[i]) / r,
                r if r < 0.0 => (low - self.origin[i]) / r,
                _ => f64::INFINITY,
            }
        };
        room(0).min(room(1)).max(0.0)
    }

    fn at(&self, length: f64) -> [f64; 2] {
        [0, 1].map(|i| {
            let (low, high) = self.bounds(i);
            (self.origin[i] + self.direction[i] * length).clamp(low, high)
        })
    }

    fn bounds(&self, i: usize) -> (f64, f64) {
        let p = &self.problem.simulator.parameters()[self.positions[i]];
        (p.min, p.max)
    }
}
