//! A ball that falls, bounces, rolls and rests, with every contact resolved at its time of impact.
//!
//! A fixed time step starts each rebound from a random depth inside the floor, which costs a share of the height that no
//! parameter explains. So motion is cut into smooth pieces instead:
//!
//! - [`scene`]: the constants of a ball's world;
//! - [`flight`]: what acts in flight, and the curves that follow;
//! - [`impact`]: when the ball first touches an obstacle, by distance queries of parry;
//! - [`contact`]: what the touch does, by Rapier's solver;
//! - [`effects`]: what may be added to all this, one file each;
//! - `step_size`: how long a step may be where formulas act;
//! - `support`: lying, rolling and sliding, by contacts without rebound;
//! - [`world`]: one rollout, all of this in order.
//!
//! Left out: the ball's own deformation (but for [`Contact::duration_s`]), torques in flight, and twisting friction.
//!
//! ```
//! use tunenet_sim::ball::{Scene, State, impact_times, positions};
//! // 1 m of free fall to the lowest point takes √(2/9.81) s; the ball's centre starts a radius higher.
//! let (scene, start) = (Scene::default(), State::at([0.0, 0.0, 1.02]));
//! let times = impact_times(&scene, &start, 0.0, 2)?;
//! assert!((times[0] - (2.0_f64 / 9.81).sqrt()).abs() < 1e-12);
//! let mut seen = [0.0; 6];
//! positions(&scene, &start, 0.0, &[-1.0, 0.1], &mut seen)?;
//! assert_eq!(seen[..3], [0.0, 0.0, 1.02]);
//! assert!((seen[5] - (1.02 - 0.5 * 9.81 * 0.01)).abs() < 1e-15);
//! # Ok::<(), String>(())
//! ```

pub mod contact;
pub mod effects;
pub mod flight;
pub mod impact;
pub mod range;
pub mod scene;
mod step_size;
mod support;
pub mod world;

pub use contact::Contact;
pub use flight::Forces;
pub use scene::Scene;
pub use world::World;

use range::{GREATEST, within};

/// Where a ball is and how it moves.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct State {
    /// The centre, m.
    pub position_m: [f64; 3],
    /// The centre's velocity, m/s.
    pub velocity_m_s: [f64; 3],
    /// The spin in the world's frame, rad/s.
    pub spin_rad_s: [f64; 3],
}

impl State {
    /// At rest at a position (m).
    #[must_use]
    pub fn at(position_m: [f64; 3]) -> Self {
        Self { position_m, ..Self::default() }
    }

    fn check(&self) -> Result<(), String> {
        for (name, values) in
            [("position_m", self.position_m), ("velocity_m_s", self.velocity_m_s), ("spin_rad_s", self.spin_rad_s)]
        {
            values.into_iter().try_for_each(|value| within(name, value, -GREATEST, GREATEST))?;
        }
        Ok(())
    }
}

/// One impact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Impact {
    /// When, s.
    pub time_s: f64,
    /// The normal speed with which the ball came, m/s.
    pub approach_m_s: f64,
}

/// Rolls out once and writes the ball's centre (m) at every instant of `clock` (s) into `out`, row-major `[sample, 3]`.
/// Before `start_time_s` the ball is held at its start.
///
/// # Errors
/// A sentence where the scene or the start is refused (see [`World::new`]), the clock falls or is not finite, `out` does
/// not hold three numbers for each instant, or the ball cannot be followed (see [`World::advance_to`]).
pub fn positions(
    scene: &Scene,
    start: &State,
    start_time_s: f64,
    clock: &[f64],
    out: &mut [f64],
) -> Result<(), String> {
    if out.len() != 3 * clock.len() {
        return Err(format!(
            "{} instants need {} numbers, but there is room for {}",
            clock.len(),
            3 * clock.len(),
            out.len()
        ));
    }
    let mut world = World::new(scene, start, start_time_s)?;
    let mut before = f64::NEG_INFINITY;
    for (time_s, row) in clock.iter().zip(out.chunks_exact_mut(3)) {
        within("clock", *time_s, f64::MIN, f64::MAX)?;
        if *time_s < before {
            return Err(format!("the clock goes from {before} s to {time_s} s, but has to rise"));
        }
        before = *time_s;
        world.advance_to(time_s.max(start_time_s))?;
        row.copy_from_slice(&world.state().position_m);
        if row.iter().any(|value| !value.is_finite())
            && let Some(part) = world.undefined()
        {
            return Err(format!("{part} by {time_s:.6} s"));
        }
    }
    if let Some(i) = out.iter().position(|value| !value.is_finite()) {
        return Err(format!("the ball's position at {} s is {}", clock[i / 3], out[i]));
    }
    Ok(())
}

/// The times (s) of the first `count` impacts; fewer where the ball comes to rest or flies off before.
///
/// # Errors
/// A sentence where the scene or the start is refused (see [`World::new`]) or the ball cannot be followed.
pub fn impact_times(scene: &Scene, start: &State, start_time_s: f64, count: usize) -> Result<Vec<f64>, String> {
    let mut world = World::new(scene, start, start_time_s)?;
    world.advance_to_impact(count)?;
    Ok(world.impacts().iter().take(count).map(|impact| impact.time_s).collect())
}
