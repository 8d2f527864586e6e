//! Conservative advancement (Mirtich 1996): time and place of the first touch of a moving sphere with convex obstacles.

use rapier3d::math::{Pose, Vector};
use rapier3d::parry::query::contact;
use rapier3d::parry::shape::{Ball, HalfSpace, SharedShape};

use super::flight::Path;

/// A fixed convex thing that a ball can hit.
#[derive(Clone)]
pub struct Obstacle {
    shape: SharedShape,
    pose: Pose,
    plane: bool,
}

impl Obstacle {
    /// A convex shape at a pose.
    ///
    /// # Errors
    /// A sentence where the shape is not convex: split such a shape into convex pieces.
    pub fn new(shape: SharedShape, pose: Pose) -> Result<Self, String> {
        if !shape.is_convex() {
            return Err("an obstacle has to be convex: split this shape into convex pieces".into());
        }
        let plane = shape.as_halfspace().is_some();
        Ok(Self { shape, pose, plane })
    }

    /// Everything below the plane through `point` (m) with the given unit normal.
    #[must_use]
    pub fn half_space(point: Vector, normal: Vector) -> Self {
        let shape = SharedShape::new(HalfSpace::new(normal));
        Self { shape, pose: Pose::from_translation(point), plane: true }
    }

    /// Whether its surface is one endless plane.
    pub(crate) fn is_plane(&self) -> bool {
        self.plane
    }

    /// The signed distance from this obstacle to the ball (m) and the outward unit normal there.
    pub(crate) fn gap(&self, centre: Vector, ball: Ball) -> Gap {
        let at = Pose::from_translation(centre);
        // With an endless prediction every distance is reported; nothing else makes a query of a convex shape fail.
        match contact(&self.pose, &*self.shape, &at, &ball, f64::MAX) {
            Ok(Some(contact)) => Gap { distance: contact.dist, normal: contact.normal1 },
            _ => Gap { distance: f64::INFINITY, normal: Vector::ZERO },
        }
    }
}

/// How far away an obstacle is, and in which direction.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Gap {
    pub distance: f64,
    pub normal: Vector,
}

/// How long a path stays free, and what ends it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Outlook {
    /// Until when the path may be followed, seconds after its start; may be infinite.
    pub until: f64,
    /// The first touch: its remaining gap, rounding apart 0, and its normal.
    pub hit: Option<Gap>,
}

/// Queries of one obstacle before a search hands back what is certainly free. Newton's steps need 2 to 6.
const MOST_QUERIES: usize = 64;

/// Searches the path up to its horizon for its first touch with any obstacle that `skip` does not pass over.
///
/// Each query of the distance gives a plane that the obstacle lies behind, because the obstacle is convex. The ball
/// cannot touch before it meets that plane, so the time of meeting it is a safe step, and close to the surface it is
/// Newton's: the search converges from below and cannot jump over an obstacle, however thin.
pub(crate) fn first_touch(obstacles: &[Obstacle], ball: Ball, path: &Path, skip: impl Fn(usize) -> bool) -> Outlook {
    let mut outlook = Outlook { until: path.horizon, hit: None };
    for (_, obstacle) in obstacles.iter().enumerate().filter(|(i, _)| !skip(*i)) {
        let mut t = 0.0;
        for query in 1.. {
            let motion = path.at(t);
            let gap = obstacle.gap(motion.x, ball);
            let (speed, acceleration) = (gap.normal.dot(motion.v), gap.normal.dot(path.acceleration(t, &motion)));
            // The distance is a difference of coordinates and cannot be known better than their last digits.
            let touching = gap.distance <= 1e-13 + 8.0 * f64::EPSILON * motion.x.abs().max_element();
            if touching && (speed < 0.0 || (speed == 0.0 && acceleration < 0.0)) {
                outlook = Outlook { until: t, hit: Some(gap) };
                break;
            }
            // A ball that leaves counts as outside, or rounding would let it fall through.
            let Some(step) = entering(gap.distance.max(0.0), speed, acceleration - path.slack) else { break };
            t += step;
            if t.is_nan() || t >= outlook.until {
                break;
            }
            if query == MOST_QUERIES {
                outlook = Outlook { until: t, hit: None };
                break;
            }
        }
    }
    outlook
}

/// The first time at which `d + v·s + a·s²/2` falls through zero; `d` is not negative.
fn entering(d: f64, v: f64, a: f64) -> Option<f64> {
    let discriminant = v * v - 2.0 * a * d;
    if discriminant < 0.0 || (v >= 0.0 && a >= 0.0) {
        return None;
    }
    let root = discriminant.sqrt();
    // Both are the same root; each is free of cancellation on its side.
    Some(if v < 0.0 { 2.0 * d / (root - v) } else { (v + root) / -a })
}

#[cfg(test)]
mod tests {
    use super::super::flight::Motion;
    use super::*;

    #[test]
    fn a_thin_capsule_is_never_jumped_over() {
        let capsule = SharedShape::capsule_x(0.1, 1e-4);
        let obstacle = Obstacle::new(capsule, Pose::from_translation(Vector::new(0.0, 0.0, -3.0))).unwrap();
        let ball = Ball::new(0.02);
        let start = Motion { x: Vector::new(0.01, 0.005, 0.0), v: Vector::new(0.0, 0.0, -40.0), w: Vector::ZERO };
        let path = Path::even(start, Vector::new(0.0, 0.0, -9.81), Vector::ZERO, f64::INFINITY);
        let outlook = first_touch(&[obstacle], ball, &path, |_| false);
        let end = path.at(outlook.until).x;
        let distance = (end.y * end.y + (end.z + 3.0) * (end.z + 3.0)).sqrt() - 0.0201;
        assert!(distance.abs() < 1e-12, "{distance}");
        assert!((outlook.hit.unwrap().normal - Vector::new(0.0, end.y, end.z + 3.0).normalize()).length() < 1e-12);
    }

    #[test]
    fn a_ball_that_passes_by_hits_nothing() {
        let obstacle = Obstacle::new(SharedShape::cuboid(0.1, 0.1, 0.1), Pose::IDENTITY).unwrap();
        let start = Motion { x: Vector::new(-1.0, 0.1201, 0.0), v: Vector::new(3.0, 0.0, 0.0), w: Vector::ZERO };
        let path = Path::even(start, Vector::ZERO, Vector::ZERO, f64::INFINITY);
        let outlook = first_touch(&[obstacle], Ball::new(0.02), &path, |_| false);
        assert!(outlook.hit.is_none() && outlook.until == f64::INFINITY);
    }
}
