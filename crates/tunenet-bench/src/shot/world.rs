//! The hidden world: steps of Runge and Kutta, impacts found by bisection, impulse formulas. Nothing here is shared with
//! the simulator that is tuned and planned with.

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::ball::ShotBall;
use crate::scene::GRAVITY_M_S2;

pub type Three = [f64; 3];

pub const RADIUS_M: f64 = 0.03;
/// Half the side of the square table that drops fall onto, m.
pub const TABLE_M: f64 = 0.25;
/// The plane of the shot, and the hoop: level, seen from the ball's centre at the impact.
pub const TILT_RAD: f64 = std::f64::consts::FRAC_PI_6;
pub const HOOP_M: Three = [0.80, 0.0, -0.30];
pub const HOOP_RADIUS_M: f64 = 0.11;
/// Restitution that depends on speed has its nominal value here, m/s.
const NOMINAL_M_S: f64 = 3.0;
const STEP_S: f64 = 1.0 / 960.0;
const HALVINGS: usize = 45;
/// Slower rebounds end the bouncing, m/s.
const REST_M_S: f64 = 0.01;
/// A shot that has not come down by then never does, s.
const LONGEST_S: f64 = 4.0;

#[derive(Debug, Clone, Copy)]
pub struct ShotState {
    pub x: Three,
    pub v: Three,
    pub w: Three,
}

/// A drop onto the table, whose top is at 0.
pub struct TableDrop {
    /// The centre at every instant, m.
    pub path_m: Vec<Three>,
    /// When it touched the table, s.
    pub impacts_s: Vec<f64>,
    /// When the ball went over the edge, s.
    pub gone_s: Option<f64>,
}

fn plus(a: Three, b: Three, factor: f64) -> Three {
    [a[0] + b[0] * factor, a[1] + b[1] * factor, a[2] + b[2] * factor]
}

fn dot(a: Three, b: Three) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Three, b: Three) -> Three {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn acceleration(ball: &ShotBall, v: Three) -> Three {
    plus([0.0, 0.0, -GRAVITY_M_S2], v, -ball.drag_1_m * dot(v, v).sqrt())
}

fn flown(ball: &ShotBall, state: &ShotState, h: f64) -> ShotState {
    let slope = |v: Three| acceleration(ball, v);
    let v1 = state.v;
    let a1 = slope(v1);
    let v2 = plus(v1, a1, 0.5 * h);
    let a2 = slope(v2);
    let v3 = plus(v1, a2, 0.5 * h);
    let a3 = slope(v3);
    let v4 = plus(v1, a3, h);
    let a4 = slope(v4);
    let sum = |a: Three, b: Three, c: Three, d: Three| plus(plus(plus(a, b, 2.0), c, 2.0), d, 1.0);
    ShotState {
        x: plus(state.x, sum(v1, v2, v3, v4), h / 6.0),
        v: plus(state.v, sum(a1, a2, a3, a4), h / 6.0),
        w: state.w,
    }
}

/// After an impact on a plane with this normal, its rebound deflected at random.
fn bounced(ball: &ShotBall, before: &ShotState, n: Three, random: &mut ChaCha8Rng) -> ShotState {
    let approach = -dot(before.v, n);
    let e = (ball.restitution * (approach / NOMINAL_M_S).powf(-ball.exponent)).clamp(0.0, 1.0);
    let impulse = (1.0 + e) * approach;
    let mut after = ShotState { v: plus(before.v, n, impulse), ..*before };
    // Stopping the slide of a solid sphere's skin takes 2/7 of it from the centre; Coulomb allows no more than his share.
    let arm = n.map(|c| -c * RADIUS_M);
    let skin = plus(after.v, cross(after.w, arm), 1.0);
    let slide = plus(skin, n, -dot(skin, n));
    let speed = dot(slide, slide).sqrt();
    if speed > 0.0 {
        let taken = (ball.friction * impulse).min(2.0 / 7.0 * speed);
        let impulse = slide.map(|c| -c * taken / speed);
        after.v = plus(after.v, impulse, 1.0);
        after.w = plus(after.w, cross(arm, impulse), 2.5 / (RADIUS_M * RADIUS_M));
    }
    let mut draw = || ball.scatter_rad * random.sample::<f64, _>(StandardNormal);
    let (about_x, about_y) = (draw(), draw());
    let turned = turn(turn(after.v, [1.0, 0.0, 0.0], about_x), [0.0, 1.0, 0.0], about_y);
    // No turn pushes a ball into the plane.
    if dot(turned, n) > 0.0 {
        after.v = turned;
    }
    after
}

/// By Rodrigues' formula.
fn turn(v: Three, axis: Three, angle: f64) -> Three {
    let (sin, cos) = angle.sin_cos();
    let along = dot(axis, v) * (1.0 - cos);
    plus(plus(v.map(|c| c * cos), cross(axis, v), sin), axis, along)
}

/// One step, or the part of it before the ball touches: `gap` is the height above what it may touch.
fn step(ball: &ShotBall, state: &ShotState, h: f64, gap: impl Fn(Three) -> f64) -> (ShotState, f64, bool) {
    let next = flown(ball, state, h);
    if gap(next.x) >= 0.0 || gap(state.x) < 0.0 {
        return (next, h, false);
    }
    let (mut low, mut high) = (0.0, h);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if gap(flown(ball, state, middle).x) >= 0.0 { low = middle } else { high = middle }
    }
    (flown(ball, state, low), low, true)
}

/// A ball released above the table and seen at the instants of `clock`.
pub fn drop(ball: &ShotBall, start: ShotState, clock: &[f64], random: &mut ChaCha8Rng) -> TableDrop {
    let up = [0.0, 0.0, 1.0];
    let (mut state, mut now, mut gone_s, mut lying) = (start, 0.0, None, false);
    let (mut path_m, mut impacts_s) = (Vec::with_capacity(clock.len()), Vec::new());
    for due in clock {
        while due - now > 1e-12 {
            let h = STEP_S.min(due - now);
            if gone_s.is_none() && state.x[0].abs().max(state.x[1].abs()) > TABLE_M {
                (gone_s, lying) = (Some(now), false);
            }
            if lying {
                state.x = plus(state.x, [state.v[0], state.v[1], 0.0], h);
                now += h;
                continue;
            }
            let height = |x: Three| if gone_s.is_some() { f64::INFINITY } else { x[2] - RADIUS_M };
            let (next, took, touches) = step(ball, &state, h, height);
            (state, now) = (next, now + took);
            if touches {
                state = bounced(ball, &state, up, random);
                lying = state.v[2] < REST_M_S;
                impacts_s.push(now);
            }
        }
        path_m.push(state.x);
    }
    TableDrop { path_m, impacts_s, gone_s }
}

/// How a shot ends.
#[derive(Debug, Clone, Copy)]
pub struct Landing {
    /// From the hoop's centre to where the ball falls through the hoop's plane, m.
    pub miss_m: f64,
    /// Whether it falls through the hoop without touching the rim.
    pub goes_in: bool,
}

/// Shoots: a ball released at rest from this height of its centre above the place of the impact.
pub fn shoot(ball: &ShotBall, height_m: f64, spin: Three, random: &mut ChaCha8Rng) -> Landing {
    let n = [TILT_RAD.sin(), 0.0, TILT_RAD.cos()];
    let mut state = ShotState { x: [0.0, 0.0, height_m], v: [0.0; 3], w: spin };
    let (mut now, mut up) = (0.0, false);
    let (mut miss_m, mut rim) = (f64::INFINITY, f64::INFINITY);
    while now < LONGEST_S {
        let height = |x: Three| if up { f64::INFINITY } else { dot(x, n) };
        let (next, took, touches) = step(ball, &state, STEP_S, height);
        let (from, to) = (plus(state.x, HOOP_M, -1.0), plus(next.x, HOOP_M, -1.0));
        if from[2] > 0.0 && to[2] <= 0.0 {
            let share = from[2] / (from[2] - to[2]);
            let at = plus(from, plus(to, from, -1.0), share);
            miss_m = at[0].hypot(at[1]);
        }
        // A step is 4 mm; in tenths of it the rim's distance is known to micrometres.
        for i in 0..10_u32 {
            let at = plus(from, plus(to, from, -1.0), f64::from(i) / 10.0);
            rim = rim.min((at[0].hypot(at[1]) - HOOP_RADIUS_M).hypot(at[2]));
        }
        (state, now) = (next, now + took);
        if touches {
            state = bounced(ball, &state, n, random);
            up = true;
        }
        if up && state.x[2] < HOOP_M[2] - 0.25 {
            break;
        }
    }
    Landing { miss_m, goes_in: miss_m < HOOP_RADIUS_M && rim >= RADIUS_M }
}

#[cfg(test)]
mod tests {
    use super::super::ball::FIXED;
    use super::*;
    use rand::SeedableRng;

    fn smooth() -> ShotBall {
        ShotBall { friction: 0.0, drag_1_m: 0.0, scatter_rad: 0.0, ..FIXED[0].clone() }
    }

    fn random() -> ChaCha8Rng {
        ChaCha8Rng::seed_from_u64(1)
    }

    /// Apex heights fall by e² and a shot is a parabola.
    #[test]
    fn without_air_and_friction_it_is_the_closed_form() {
        let start = ShotState { x: [0.0, 0.0, 0.6 + RADIUS_M], v: [0.0; 3], w: [0.0; 3] };
        let fall = (1.2 / GRAVITY_M_S2).sqrt();
        let apex = fall * (1.0 + 0.79);
        let seen = drop(&smooth(), start, &[0.1, apex], &mut random());
        assert!((seen.path_m[1][2] - RADIUS_M - 0.6 * 0.79 * 0.79).abs() < 1e-9 && seen.gone_s.is_none());
        let (height, e) = (0.4, 0.79);
        let speed = (2.0 * GRAVITY_M_S2 * height).sqrt() * TILT_RAD.cos() * (1.0 + e);
        let (vx, vz) = (speed * TILT_RAD.sin(), speed * TILT_RAD.cos() - (2.0 * GRAVITY_M_S2 * height).sqrt());
        let t = (vz + (vz * vz + 2.0 * GRAVITY_M_S2 * 0.3).sqrt()) / GRAVITY_M_S2;
        let landing = shoot(&smooth(), height, [0.0; 3], &mut random());
        assert!((landing.miss_m - (vx * t - 0.8).abs()).abs() < 1e-5, "{landing:?}");
    }

    #[test]
    fn a_ball_that_is_pushed_goes_over_the_edge() {
        let start = ShotState { x: [0.0, 0.0, 0.6], v: [0.4, 0.0, 0.0], w: [0.0; 3] };
        let clock: Vec<f64> = (0..150).map(|i| f64::from(i) / 60.0).collect();
        let seen = drop(&smooth(), start, &clock, &mut random());
        assert!((seen.gone_s.unwrap() - 0.625).abs() < 0.01 && seen.path_m[149][2] < -1.0);
    }
}
