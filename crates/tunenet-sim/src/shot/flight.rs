//! One shot: the fall, the bounce, and the way to the hoop.

use super::scene::ShotScene;
use crate::ball::flight::{Motion, Path};
use crate::ball::{Scene, State, World};

/// Seconds between the states of a path.
pub const STEP_S: f64 = 1.0 / 120.0;
/// A ball that has not come back down to the hoop by then never will, s.
const LONGEST_S: f64 = 10.0;
/// A ball rolling on the plane, or flying off, is followed no farther from the hoop than this many times its distance.
const FARTHEST: f64 = 20.0;

/// The path of a shot that meets no rim.
#[derive(Debug, Clone, PartialEq)]
pub struct Flight {
    /// Time between two states after the bounce, s.
    pub step_s: f64,
    /// Release, bounce, and then a state at every step until the ball is below the hoop.
    pub states: Vec<State>,
    /// Which of them leaves the plane.
    pub bounce: usize,
    /// When, seconds after the release.
    pub bounce_s: f64,
}

impl ShotScene {
    /// Lets `ball` go from `release` (centre in m, from the impact point) and follows it until it is below the hoop. The
    /// plane acts once.
    ///
    /// # Errors
    /// A sentence where the ball never reaches the plane or cannot be followed.
    pub fn fly(&self, ball: &Scene, release: &State) -> Result<Flight, String> {
        let scene = self.with_plane(ball);
        let mut world = World::new(&scene, release, 0.0)?;
        world.advance_to_impact(1)?;
        let Some(impact) = world.impacts().first().copied() else {
            return Err("the ball never bounces off the plane".into());
        };
        let left_s = impact.time_s + scene.contact.duration_s;
        // A contact that lasts ends here at the latest; a ball that is released at once is only just off the plane.
        let bounce_s = left_s.max(world.time_s());
        world.advance_to(bounce_s)?;
        let start = world.state();
        let hoop = &self.hoop;
        let far = FARTHEST * (1.0 + hoop.from_centre([0.0; 3]));
        // Below the hoop by more than rim and ball reach.
        let done = -(2.0 * self.radius_m + hoop.rim_radius_m + 0.5 * hoop.radius_m);
        let field = scene.field();
        let mut path = Path::flight(motion(&start), bounce_s, &field);
        let (mut states, mut since, mut steps) = (vec![*release, start], 0.0, 0.0);
        while steps * STEP_S < LONGEST_S {
            steps += 1.0;
            // Pieces of bent flight end where their steps do.
            while steps * STEP_S - since > path.horizon {
                since += path.horizon;
                path = Path::flight(path.at(path.horizon), bounce_s + since, &field);
            }
            let Motion { x, v, w } = path.at(steps * STEP_S - since);
            states.push(State { position_m: x.to_array(), velocity_m_s: v.to_array(), spin_rad_s: w.to_array() });
            let (x, v) = (x.to_array(), v.to_array());
            let leaving = (0..3).map(|i| (x[i] - hoop.centre_m[i]) * v[i]).sum::<f64>() > 0.0;
            if v[2] < 0.0 && leaving && hoop.above(x) < done || hoop.from_centre(x) > far {
                break;
            }
        }
        Ok(Flight { step_s: STEP_S, states, bounce: 1, bounce_s })
    }
}

fn motion(state: &State) -> Motion {
    let State { position_m, velocity_m_s, spin_rad_s } = *state;
    Motion { x: position_m.into(), v: velocity_m_s.into(), w: spin_rad_s.into() }
}
