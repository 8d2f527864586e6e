//! The true motion: a base model with a hidden force, bounces and dry friction exactly where they happen.

use serde::{Deserialize, Serialize};
use tunenet_core::statistics::root_mean_square;

use super::arena::{Arena, Base, RADIUS_M, Run};
use super::cash_karp::{Motion, State, follow};
use super::strange::StrangeForce;
use super::term::{Place, Term};

/// What is hidden.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Force {
    Nothing,
    Law(Term),
    Strange(StrangeForce),
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct World {
    pub base: Base,
    pub force: Force,
}

/// Steps of at most this share of a sample.
const OF_A_SAMPLE: f64 = 1.0 / 8.0;
/// A ball that leaves the floor more slowly stays on it, m/s.
const REST_M_S: f64 = 2e-3;
/// Events between two stamps; more means that nothing sensible moves.
const MOST_EVENTS: usize = 1000;

impl Force {
    /// The same at this size.
    pub fn sized(&self, size: f64) -> Self {
        match self {
            Self::Nothing => Self::Nothing,
            Self::Law(term) => Self::Law(Term { size: size * term.size, ..term.clone() }),
            Self::Strange(force) => Self::Strange(StrangeForce { size: size * force.size, ..force.clone() }),
        }
    }

    fn at(&self, place: &Place, hidden: [f64; 2], own: [f64; 2]) -> [f64; 3] {
        match self {
            Self::Nothing => [0.0; 3],
            Self::Law(term) => term.at(place),
            Self::Strange(force) => force.at(place, hidden, own),
        }
    }

    /// The dry friction that holds a joint at rest, rad/s².
    fn holds(&self, t: f64, own: [f64; 2]) -> f64 {
        match self {
            Self::Nothing => 0.0,
            Self::Law(term) => term.holds(),
            Self::Strange(force) => force.holds(t, own),
        }
    }
}

/// How a body moves until the next event.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Mode {
    /// Freely, or a joint that turns to this side.
    Moves(f64),
    /// A joint that dry friction holds, or a ball that lies on the floor.
    Rests,
}

struct Segment<'a> {
    world: &'a World,
    run: &'a Run,
    mode: Mode,
    /// Begin and end of the interval between two stamps, with the input there.
    from: (f64, f64),
    to: (f64, f64),
}

impl Segment<'_> {
    fn driven(&self, t: f64) -> f64 {
        let (before, after) = (self.from, self.to);
        before.1 + (after.1 - before.1) * (t - before.0) / (after.0 - before.0)
    }

    fn acceleration(&self, t: f64, state: &State, side: f64) -> [f64; 3] {
        let (x, v) = ([state[0], state[1], state[2]], [state[3], state[4], state[5]]);
        let base = self.world.base.acceleration(x, v, self.driven(t));
        let place = Place { time_s: t, x, v, side };
        let hidden = self.world.force.at(&place, [state[6], state[7]], self.run.own);
        std::array::from_fn(|i| base[i] + hidden[i])
    }

    fn jointed(&self) -> bool {
        self.world.base.arena == Arena::Pendulum
    }

    fn holds(&self, t: f64) -> f64 {
        if self.jointed() { self.world.force.holds(t, self.run.own) } else { 0.0 }
    }

    /// After an event: the state and the mode.
    fn after(&mut self, t: f64, state: &mut State) {
        if !self.jointed() {
            let up = -self.world.base.numbers[0] * state[5];
            state[2] = RADIUS_M;
            state[5] = if up < REST_M_S { 0.0 } else { up };
            self.mode = if up < REST_M_S { Mode::Rests } else { Mode::Moves(0.0) };
            return;
        }
        state[3] = 0.0;
        let net = self.acceleration(t, state, 0.0)[0];
        let stays = self.mode != Mode::Rests && net.abs() <= self.holds(t);
        self.mode = if stays { Mode::Rests } else { Mode::Moves(net.signum()) };
    }
}

impl Motion for Segment<'_> {
    fn slope(&self, t: f64, state: &State) -> State {
        let side = if let Mode::Moves(side) = self.mode { side } else { 0.0 };
        let mut a = self.acceleration(t, state, side);
        let mut v = [state[3], state[4], state[5]];
        if self.mode == Mode::Rests {
            let held = if self.jointed() { 0 } else { 2 };
            (a[held], v[held]) = (0.0, 0.0);
        }
        let hidden = match &self.world.force {
            Force::Strange(force) => {
                let place =
                    Place { time_s: t, x: [state[0], state[1], state[2]], v: [state[3], state[4], state[5]], side };
                force.slope(&place, [state[6], state[7]])
            }
            _ => [0.0; 2],
        };
        [v[0], v[1], v[2], a[0], a[1], a[2], hidden[0], hidden[1]]
    }

    fn gap(&self, t: f64, state: &State) -> f64 {
        match (self.world.base.arena, self.mode) {
            (Arena::Flight, Mode::Moves(_)) => state[2] - RADIUS_M,
            (Arena::Pendulum, Mode::Moves(side)) if self.holds(t) > 0.0 => side * state[3],
            (Arena::Pendulum, Mode::Rests) => self.holds(t) - self.acceleration(t, state, 0.0)[0].abs(),
            _ => 1.0,
        }
    }
}

impl World {
    /// The recorded numbers at each instant of `clock`, row-major, without noise. Not all are finite where the force is not.
    pub fn seen(&self, run: &Run, clock: &[f64]) -> Vec<f64> {
        let channels = self.base.arena.channels();
        let mut out = Vec::with_capacity(channels * clock.len());
        let mut state = [0.0; 8];
        state[..6].copy_from_slice(&run.start);
        if let Force::Strange(force) = &self.force {
            state[6..].copy_from_slice(&force.hidden(run.start[0], run.own));
        }
        out.extend_from_slice(&state[..channels]);
        let input = |i: usize| run.input.get(i).copied().unwrap_or_default();
        let mut mode = Mode::Moves(if state[3] < 0.0 { -1.0 } else { 1.0 });
        for (i, ends) in clock.windows(2).enumerate() {
            let (from, to) = ((ends[0], input(i)), (ends[1], input(i + 1)));
            let mut segment = Segment { world: self, run, mode, from, to };
            let mut now = ends[0];
            for events in 0.. {
                let (at, next, happened) = follow(&segment, now, state, to.0, OF_A_SAMPLE * (to.0 - from.0));
                (now, state) = (at, next);
                if !happened {
                    break;
                }
                if events == MOST_EVENTS {
                    state = [f64::NAN; 8];
                    break;
                }
                segment.after(now, &mut state);
            }
            mode = segment.mode;
            out.extend_from_slice(&state[..channels]);
        }
        out
    }
}

/// Root mean square of the differences; infinite where one of them is no number.
pub fn apart(a: &[f64], b: &[f64]) -> f64 {
    let found = root_mean_square(a.iter().zip(b).map(|(a, b)| a - b));
    if found.is_finite() { found } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::super::arena::SOFT_M;
    use super::super::strange::Strange;
    use super::super::term::{Direction, Shape, Variable};
    use super::*;

    fn world(arena: Arena, numbers: [f64; 2], force: Force) -> World {
        World { base: Base { arena, numbers }, force }
    }

    fn run(start: [f64; 6]) -> Run {
        Run { start, own: [0.5; 2], input: Vec::new() }
    }

    fn law(size: f64, direction: Direction, factors: &[(Variable, Shape)]) -> Force {
        Force::Law(Term { size, ..Term::new(direction, factors) })
    }

    #[test]
    fn bounces_follow_the_geometric_series() {
        let ball = world(Arena::Flight, [0.8, 0.0], Force::Nothing);
        let fall = (2.0_f64 / 9.81).sqrt();
        // The apex after the second bounce lies at e⁴ of the height.
        let clock = [0.0, 0.1, fall * (1.0 + 2.0 * 0.8 + 0.64)];
        let seen = ball.seen(&run([0.0, 0.0, 1.0 + RADIUS_M, 1.0, 0.0, 0.0]), &clock);
        assert!((seen[8] - RADIUS_M - 0.8_f64.powi(4)).abs() < 1e-9, "{seen:?}");
        assert!((seen[6] - clock[2]).abs() < 1e-9);
        // It comes to rest after fall (1 + e)/(1 − e) and slides on.
        let seen = ball.seen(&run([0.0, 0.0, 1.0 + RADIUS_M, 1.0, 0.0, 0.0]), &[0.0, 1.0, 2.0, 3.0, 5.0]);
        assert!(seen[14] == RADIUS_M && (seen[12] - 5.0).abs() < 1e-9, "{seen:?}");
    }

    #[test]
    fn drags_follow_their_closed_forms() {
        // Vertical fall with quadratic drag: ln cosh; sideways with linear drag: an exponential.
        let (c, t) = (0.3_f64, 0.4_f64);
        let square = law(-c, Direction::Velocity, &[(Variable::Speed, Shape::Power(2.0))]);
        let seen = world(Arena::Flight, [0.8, 0.0], square).seen(&run([0.0, 0.0, 3.0, 0.0, 0.0, 0.0]), &[0.0, t]);
        let fallen = ((9.81 * c).sqrt() * t).cosh().ln() / c;
        assert!((3.0 - seen[5] - fallen).abs() < 1e-9, "{seen:?}");
        let linear = law(-c, Direction::Velocity, &[(Variable::Speed, Shape::Power(1.0))]);
        let seen = world(Arena::Plane, [0.0; 2], linear).seen(&run([0.0, 0.0, 0.0, 2.0, 0.0, 0.0]), &[0.0, t]);
        assert!((seen[2] - 2.0 / c * (1.0 - (-c * t).exp())).abs() < 1e-9, "{seen:?}");
    }

    #[test]
    fn a_circle_stays_one_around_the_centre() {
        let centre = world(Arena::Centre, [1.2, 0.0], Force::Nothing);
        let speed = (1.2 * 1.7 * 1.7 / (1.7 * 1.7 + SOFT_M * SOFT_M)).sqrt();
        let clock: Vec<f64> = (0..100).map(|i| 0.05 * f64::from(i)).collect();
        let seen = centre.seen(&run([1.7, 0.0, 0.0, 0.0, speed, 0.0]), &clock);
        for (t, at) in clock.iter().zip(seen.chunks_exact(2)) {
            let turn = speed / 1.7 * t;
            assert!((at[0] - 1.7 * turn.cos()).hypot(at[1] - 1.7 * turn.sin()) < 1e-8, "{t} {at:?}");
        }
    }

    #[test]
    fn dry_friction_that_does_not_fade_stops_a_joint_and_holds_it() {
        // Without gravity and damping a joint with a constant brake c turns by w²/(2c) and stays; an input below c does not
        // move it.
        let brake = law(-2.0, Direction::Joint, &[(Variable::Rate, Shape::Stribeck(1e6))]);
        let joint = world(Arena::Pendulum, [0.0; 2], brake);
        let clock = [0.0, 0.5, 2.0, 3.0, 4.0];
        let start = [0.1, 0.0, 0.0, 2.0, 0.0, 0.0];
        let seen = joint.seen(&Run { input: vec![0.0, 0.0, 0.0, 1.9, 1.9], ..run(start) }, &clock);
        assert!((seen[1] - (0.1 + 1.0 - 0.25)).abs() < 1e-9, "{seen:?}");
        assert!(seen[2..].iter().all(|q| (q - 1.1).abs() < 1e-9), "{seen:?}");
        // A ramp to 4 over a second from 2 s on exceeds 2 after half of it: (4 τ)²… the cube of the rest of the second.
        let seen = joint.seen(&Run { input: vec![0.0, 0.0, 0.0, 4.0], ..run(start) }, &clock[..4]);
        assert!((seen[3] - 1.1 - 4.0 * 0.5_f64.powi(3) / 6.0).abs() < 1e-9, "{seen:?}");
    }

    #[test]
    fn without_coupling_an_hidden_mass_changes_nothing() {
        let force = StrangeForce { kind: Strange::HiddenMass, size: 0.0, scale: 7.0, angle: 0.0 };
        let joint = world(Arena::Pendulum, [25.0, 0.0], Force::Strange(force));
        // With no coupling the joint is a pendulum: a small swing is a cosine.
        let seen = joint.seen(&run([1e-4, 0.0, 0.0, 0.0, 0.0, 0.0]), &[0.0, 0.25, 0.5]);
        assert!((seen[1] - 1e-4 * 1.25_f64.cos()).abs() < 1e-10 && (seen[2] - 1e-4 * 2.5_f64.cos()).abs() < 1e-10);
    }

    #[test]
    fn numbers_that_are_not_finite_are_infinitely_far() {
        assert_eq!(apart(&[1.0, f64::NAN], &[1.0, 2.0]), f64::INFINITY);
        assert_eq!(apart(&[1.0, 4.0], &[1.0, 2.0]), 2.0_f64.sqrt());
    }
}
