//! Plane and hoop for one ball, in Rapier.

use rapier3d::math::{Pose, Vector};
use rapier3d::parry::shape::{Capsule, SharedShape};

use super::Task;
use crate::ball::impact::Obstacle;
use crate::ball::{Scene, State, World};

/// Capsules of the rim. Their chords leave the circle by R·(1 − cos(π/48))/2: 0.1 mm at a hoop of 11 cm.
const RIM_PIECES: u32 = 48;
/// A wire so thin that it has no thickness still needs some in Rapier, m.
const THINNEST_WIRE_M: f64 = 1e-6;

/// A hoop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hoop {
    /// Its centre, m.
    pub centre_m: [f64; 3],
    /// The unit normal of its plane; a ball has to come from the side to which it points.
    pub normal: [f64; 3],
    /// From its centre to the middle of its wire, m.
    pub radius_m: f64,
    /// Half the wire's thickness, m.
    pub rim_radius_m: f64,
}

impl Hoop {
    /// How far a point lies above the hoop's plane, m.
    #[must_use]
    pub fn above(&self, x: [f64; 3]) -> f64 {
        self.split(x).0
    }

    /// From the hoop's centre to a point, m.
    #[must_use]
    pub fn from_centre(&self, x: [f64; 3]) -> f64 {
        let (above, aside) = self.split(x);
        (above * above + aside * aside).sqrt()
    }

    /// From the circle of the rim to a point, m.
    #[must_use]
    pub fn from_rim(&self, x: [f64; 3]) -> f64 {
        let (above, aside) = self.split(x);
        let aside = aside - self.radius_m;
        (above * above + aside * aside).sqrt()
    }

    /// The parts of the way from the centre to a point along the normal and across it, m.
    fn split(&self, x: [f64; 3]) -> (f64, f64) {
        let way = [0, 1, 2].map(|i| x[i] - self.centre_m[i]);
        let above = dot(way, self.normal);
        let across = [0, 1, 2].map(|i| way[i] - above * self.normal[i]);
        (above, dot(across, across).sqrt())
    }

    /// The rim as a ring of capsules.
    fn rim(&self) -> Result<Vec<Obstacle>, String> {
        let (side, front) = Vector::from_array(self.normal).any_orthonormal_pair();
        let turn = std::f64::consts::TAU / f64::from(RIM_PIECES);
        // A chord ends outside the circle by as much as its middle lies inside.
        let reach = self.radius_m * 2.0 / (1.0 + (0.5 * turn).cos());
        let corner = |i: u32| {
            let angle = turn * f64::from(i);
            Vector::from_array(self.centre_m) + (side * angle.cos() + front * angle.sin()) * reach
        };
        let wire = self.rim_radius_m.max(THINNEST_WIRE_M);
        (0..RIM_PIECES)
            .map(|i| {
                let shape = SharedShape::new(Capsule::new(corner(i), corner(i + 1), wire));
                Obstacle::new(shape, Pose::IDENTITY)
            })
            .collect()
    }
}

/// Why a task makes no scene, and what to do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Impossible {
    /// What was expected, and what was found.
    pub message: String,
    /// What to try.
    pub remedy: &'static str,
}

impl std::fmt::Display for Impossible {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.write_str(&self.message)
    }
}

impl std::error::Error for Impossible {}

impl From<String> for Impossible {
    fn from(message: String) -> Self {
        Self { message, remedy: "correct the task file" }
    }
}

/// Plane and hoop for a ball of one size.
#[derive(Clone)]
pub struct ShotScene {
    /// The unit normal of the plane.
    pub plane_normal: [f64; 3],
    /// The hoop.
    pub hoop: Hoop,
    /// The ball's radius, m.
    pub radius_m: f64,
    tilt_rad: [f64; 2],
    rim: Vec<Obstacle>,
}

impl ShotScene {
    /// The scene of a task for a ball of this radius (m).
    ///
    /// # Errors
    /// [`Impossible`] where the plane throws no ball towards the hoop, where the ball is too large for the hoop, or where the
    /// hoop stands in the way of the fall.
    pub fn new(task: &Task, radius_m: f64) -> Result<Self, Impossible> {
        let refuse = |message: String, remedy: &'static str| Err(Impossible { message, remedy });
        let tilt_rad = task.plane.tilt_rad();
        let plane_normal = normal(tilt_rad);
        let hoop = Hoop {
            centre_m: task.hoop.centre_m,
            normal: normal(task.hoop.tilt_rad()),
            radius_m: task.hoop.radius_m,
            rim_radius_m: task.hoop.rim_radius_m,
        };
        let [x, y, _] = hoop.centre_m;
        // A ball that falls straight down is thrown along the slope.
        let towards = plane_normal[0] * x + plane_normal[1] * y;
        if towards <= 1e-9 {
            // A level plane has no minus signs.
            let [nx, ny, nz] = plane_normal.map(|n| n + 0.0);
            return refuse(
                format!(
                    "the plane faces away from the hoop: expected a normal that leans towards ({x}, {y}) m, found \
                     ({nx:.3}, {ny:.3}, {nz:.3})"
                ),
                "turn `plane.tilt_about_x_rad` or `plane.tilt_about_y_rad` the other way: about y, a positive tilt leans \
                 towards x; about x, a negative one towards y",
            );
        }
        if radius_m + hoop.rim_radius_m >= hoop.radius_m {
            return refuse(
                format!(
                    "expected a hoop that the ball fits through, found a ball of {radius_m} m in radius and a hoop of {} m",
                    hoop.radius_m
                ),
                "radii are in metres: correct `hoop.radius_m`, or `ball.radius_m` of the simulation",
            );
        }
        if x.hypot(y) <= hoop.radius_m + hoop.rim_radius_m + radius_m {
            return refuse(
                format!(
                    "the hoop stands in the way of the falling ball: expected its centre more than {:.3} m next to the \
                     place of the bounce, found {:.3} m",
                    hoop.radius_m + hoop.rim_radius_m + radius_m,
                    x.hypot(y)
                ),
                "move `hoop.centre_m` away from the place of the bounce",
            );
        }
        let rim = hoop.rim()?;
        Ok(Self { plane_normal, hoop, radius_m, tilt_rad, rim })
    }

    /// `ball` above the plane: its surface and its size are this scene's. The floor under a recording, and its tilt,
    /// have no bearing on it.
    #[must_use]
    pub fn with_plane(&self, ball: &Scene) -> Scene {
        Scene {
            surface_tilt_about_x_rad: self.tilt_rad[0],
            surface_tilt_about_y_rad: self.tilt_rad[1],
            surface_height_m: -self.radius_m / self.plane_normal[2],
            radius_m: self.radius_m,
            ..ball.clone()
        }
    }

    /// What really happens to a ball that continues from `state` at `time_s`, rim included: where it is at every step until
    /// `end_s`, and whether it touches the rim.
    ///
    /// # Errors
    /// As [`World::advance_to`].
    pub fn among_rim(
        &self,
        ball: &Scene,
        state: &State,
        (time_s, step_s, end_s): (f64, f64, f64),
    ) -> Result<(Vec<State>, bool), String> {
        let mut world = World::among(ball, self.rim.clone(), state, time_s)?;
        let mut states = vec![world.state()];
        let mut steps = 0.0;
        while time_s + (steps + 1.0) * step_s <= end_s {
            steps += 1.0;
            world.advance_to(time_s + steps * step_s)?;
            states.push(world.state());
        }
        Ok((states, !world.impacts().is_empty()))
    }
}

/// The normal of a plane with these tilts about x and y; the same convention as [`Scene::normal`].
fn normal([about_x, about_y]: [f64; 2]) -> [f64; 3] {
    Scene { surface_tilt_about_x_rad: about_x, surface_tilt_about_y_rad: about_y, ..Scene::default() }.normal()
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
