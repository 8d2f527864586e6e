//! A ball followed from bounce to bounce: Runge–Kutta steps in the air, impacts found as roots of the height.

use super::vector::{Vector, dot, plus};
use super::world::{BallWorld, BlindState, RADIUS_M};

/// The classical method's error at this step is far below a micrometre.
const STEP_S: f64 = 1.0 / 480.0;
/// Halvings of a step: down to the clock's last bits.
const HALVINGS: usize = 50;
/// A ball that leaves the floor more slowly stays on it, m/s.
const REST_M_S: f64 = 2e-3;

/// How a ball is thrown.
#[derive(Debug, Clone)]
pub struct BlindThrow {
    pub position_m: Vector,
    pub velocity_m_s: Vector,
    /// Standard normal draws for each bounce of a ball that is not round.
    pub scatter: Vec<[f64; 2]>,
}

impl BlindThrow {
    /// Two normal draws of this throw: the last of its bounces' that no recording reaches.
    pub fn own(&self) -> [f64; 2] {
        self.scatter.last().copied().unwrap_or_default()
    }
}

/// A bounce that takes its time.
struct Contact {
    began_s: f64,
    lasts_s: f64,
    before: BlindState,
    after: BlindState,
}

impl Contact {
    /// The centre `since` seconds after the touch: on a spring with a damper normal to the floor, under an even push along
    /// it. Half a period of x'' + 2γx' + (ω² + γ²)x = 0 returns exp(−γπ/ω) of the speed.
    fn at(&self, since: f64, normal: Vector) -> Vector {
        let (down, up) = (-dot(self.before.v, normal), dot(self.after.v, normal));
        let omega = std::f64::consts::PI / self.lasts_s;
        let gamma = -(up / down).max(1e-6).ln() / self.lasts_s;
        let depth = down / omega * (-gamma * since).exp() * (omega * since).sin();
        let along = |v: Vector| plus(v, normal, -dot(v, normal));
        let gained = since * since / (2.0 * self.lasts_s);
        let slid = plus(plus([0.0; 3], along(self.before.v), since - gained), along(self.after.v), gained);
        plus(plus(self.before.x, slid, 1.0), normal, -depth)
    }
}

/// A thrown ball; it is asked for instants that never fall.
pub struct BlindBall<'a> {
    world: &'a BallWorld,
    throw: &'a BlindThrow,
    normal: Vector,
    time_s: f64,
    state: BlindState,
    bounces: usize,
    /// The contact that it is in.
    contact: Option<Contact>,
    resting: bool,
}

impl<'a> BlindBall<'a> {
    pub fn new(world: &'a BallWorld, throw: &'a BlindThrow) -> Self {
        let state = BlindState { x: throw.position_m, v: throw.velocity_m_s, w: [0.0; 3] };
        let normal = world.normal();
        Self { world, throw, normal, time_s: 0.0, state, bounces: 0, contact: None, resting: false }
    }

    /// The centre at `until`, m; before the throw, on the flight that leads to it.
    pub fn at(&mut self, until: f64) -> Vector {
        if until < 0.0 {
            return self.flown(until).x;
        }
        while until - self.time_s > 1e-13 {
            if let Some(contact) = &self.contact {
                let since = (until - contact.began_s).min(contact.lasts_s);
                self.time_s = contact.began_s + since;
                if since < contact.lasts_s {
                    return contact.at(since, self.normal);
                }
                self.state = BlindState { x: contact.at(since, self.normal), ..contact.after };
                self.contact = None;
                continue;
            }
            let h = STEP_S.min(until - self.time_s);
            let next = self.flown(h);
            if self.resting || self.gap(&next) >= 0.0 {
                (self.state, self.time_s) = (next, self.time_s + h);
                continue;
            }
            let (mut low, mut high) = (0.0, h);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                if self.gap(&self.flown(middle)) >= 0.0 { low = middle } else { high = middle }
            }
            let landed = self.flown(low);
            self.time_s += low;
            let scatter = self.throw.scatter.get(self.bounces).copied().unwrap_or_default();
            self.state = self.world.bounce(landed, self.normal, (self.bounces, self.time_s), scatter);
            self.bounces += 1;
            let lasts_s = self.world.contact_s();
            if lasts_s > 0.0 {
                self.contact = Some(Contact { began_s: self.time_s, lasts_s, before: landed, after: self.state });
            }
            self.resting = dot(self.state.v, self.normal) < REST_M_S;
        }
        self.state.x
    }

    /// From the floor to the lowest point, m.
    fn gap(&self, state: &BlindState) -> f64 {
        dot(state.x, self.normal) - RADIUS_M
    }

    /// The state after flying, or sliding, for `h` seconds.
    fn flown(&self, h: f64) -> BlindState {
        let BlindState { x, v, w } = self.state;
        let slope = |dt: f64, x: Vector, v: Vector| {
            let a = self.world.acceleration(self.time_s + dt, x, v, self.throw.own());
            if self.resting { plus(a, self.normal, -dot(a, self.normal)) } else { a }
        };
        let v = if self.resting { plus(v, self.normal, -dot(v, self.normal)) } else { v };
        let a1 = slope(0.0, x, v);
        let v2 = plus(v, a1, h / 2.0);
        let a2 = slope(h / 2.0, plus(x, v, h / 2.0), v2);
        let v3 = plus(v, a2, h / 2.0);
        let a3 = slope(h / 2.0, plus(x, v2, h / 2.0), v3);
        let v4 = plus(v, a3, h);
        let a4 = slope(h, plus(x, v3, h), v4);
        let mean = |one: Vector, two: Vector, three: Vector, four: Vector| -> Vector {
            std::array::from_fn(|i| (one[i] + 2.0 * (two[i] + three[i]) + four[i]) / 6.0)
        };
        BlindState { x: plus(x, mean(v, v2, v3, v4), h), v: plus(v, mean(a1, a2, a3, a4), h), w }
    }
}

#[cfg(test)]
mod tests {
    use super::super::hidden::{EffectKind, HiddenEffect};
    use super::*;

    fn world(kind: Option<EffectKind>, size: f64) -> BallWorld {
        let hidden = kind.map(|kind| HiddenEffect { kind, size, sign: 1.0, turn: 0.0, lift: 0.0 });
        BallWorld { restitution: 0.8, hidden: hidden.into_iter().collect() }
    }

    fn throw(height: f64, velocity_m_s: Vector) -> BlindThrow {
        BlindThrow { position_m: [0.0, 0.0, height + RADIUS_M], velocity_m_s, scatter: vec![] }
    }

    #[test]
    fn bounces_follow_the_geometric_series() {
        let (world, throw) = (world(None, 0.0), throw(1.0, [1.0, 0.0, 0.0]));
        let mut ball = BlindBall::new(&world, &throw);
        let fall = (2.0_f64 / 9.81).sqrt();
        // The apex after the second bounce lies at e⁴ of the height.
        let x = ball.at(fall * (1.0 + 2.0 * 0.8 + 0.64));
        assert!((x[2] - RADIUS_M - 0.8_f64.powi(4)).abs() < 1e-10, "{x:?}");
        assert!((x[0] - fall * 3.24).abs() < 1e-12);
    }

    #[test]
    fn a_flight_leads_to_the_throw() {
        let (world, throw) = (world(None, 0.0), throw(1.0, [1.0, 0.0, 0.5]));
        let x = BlindBall::new(&world, &throw).at(-0.02);
        assert!((x[0] + 0.02).abs() < 1e-12 && (x[2] - RADIUS_M - 1.0 + 0.01 + 4.905 * 4e-4).abs() < 1e-12, "{x:?}");
    }

    #[test]
    fn a_contact_that_lasts_presses_the_ball_in_and_lets_it_go_as_a_short_one() {
        let (world, throw) = (world(Some(EffectKind::ContactTime), 0.01), throw(1.0, [1.0, 0.0, 0.0]));
        let (mut ball, touch) = (BlindBall::new(&world, &throw), (2.0_f64 / 9.81).sqrt());
        assert!(ball.at(touch + 0.004)[2] < RADIUS_M - 0.005);
        let x = ball.at(touch + 0.01 + touch * 0.8);
        assert!((x[2] - RADIUS_M - 0.64).abs() < 1e-9 && (x[0] - touch * 1.8 - 0.01).abs() < 1e-9, "{x:?}");
    }

    #[test]
    fn drag_follows_the_logarithm_of_a_hyperbolic_cosine() {
        let (c, t) = (0.1_f64, 0.5_f64);
        let (world, throw) = (world(Some(EffectKind::QuadraticDrag), c), throw(3.0, [0.0; 3]));
        let fallen = 3.0 + RADIUS_M - BlindBall::new(&world, &throw).at(t)[2];
        let expected = ((9.81 * c).sqrt() * t).cosh().ln() / c;
        assert!((fallen - expected).abs() < 1e-10, "{fallen} {expected}");
    }

    #[test]
    fn a_sphere_that_grips_keeps_five_sevenths_of_its_slide() {
        let (world, throw) = (world(Some(EffectKind::BounceFriction), 0.9), throw(1.0, [0.7, 0.0, 0.0]));
        let mut ball = BlindBall::new(&world, &throw);
        ball.at(0.6);
        assert!((ball.state.v[0] - 0.5).abs() < 1e-12 && (ball.state.w[1] * RADIUS_M - 0.5).abs() < 1e-12);
    }
}
