//! A thrown ball by brute force: Runge–Kutta of fourth order in steps of 1/20000 s, impacts found by bisection, and
//! impulse formulas. Nothing here uses the code under test.

use super::closed_form::{Three, add, cross, dot, impact};

const STEP: f64 = 5e-5;

/// What the ball is, how it starts, and what acts on it.
#[derive(Debug, Clone, Default)]
pub struct World {
    pub gravity: f64,
    pub radius: f64,
    pub height: f64,
    pub restitution: f64,
    pub friction: f64,
    pub x: Three,
    pub v: Three,
    pub w: Three,
    pub quadratic: f64,
    pub linear: f64,
    pub wind: [f64; 2],
    pub magnus: Three,
    pub exponent: f64,
    pub tilt: [f64; 2],
    pub loss: f64,
    pub duration: f64,
    pub kicks: Vec<[f64; 2]>,
}

/// Rx(a)·Ry(b)·z.
fn tilted([a, b]: [f64; 2]) -> Three {
    [b.sin(), -a.sin() * b.cos(), a.cos() * b.cos()]
}

impl World {
    fn acceleration(&self, v: Three) -> Three {
        let drag = self.quadratic * dot(v, v).sqrt() + self.linear;
        add(add([self.wind[0], self.wind[1], -self.gravity], -drag, v), 1.0, cross(self.magnus, v))
    }

    /// The same step as everybody's, with stages for the position of its own.
    fn step(&self, x: Three, v: Three, h: f64) -> (Three, Three) {
        let (x1, v1) = (v, self.acceleration(v));
        let (x2, v2) = (add(v, 0.5 * h, v1), self.acceleration(add(v, 0.5 * h, v1)));
        let (x3, v3) = (add(v, 0.5 * h, v2), self.acceleration(add(v, 0.5 * h, v2)));
        let (x4, v4) = (add(v, h, v3), self.acceleration(add(v, h, v3)));
        let sum = |k: [Three; 4]| add(add(add(k[0], 2.0, k[1]), 2.0, k[2]), 1.0, k[3]);
        (add(x, h / 6.0, sum([x1, x2, x3, x4])), add(v, h / 6.0, sum([v1, v2, v3, v4])))
    }

    /// Positions at the instants of a rising clock, row-major. Ends badly where the ball comes to rest.
    pub fn positions(&self, clock: &[f64]) -> Vec<f64> {
        let normal = tilted(self.tilt);
        let gap = |x: Three| dot(add(x, -self.height, [0.0, 0.0, 1.0]), normal) - self.radius;
        let (mut t, mut x, mut v, mut w) = (0.0, self.x, self.v, self.w);
        let mut bounces = 0;
        let mut out = Vec::new();
        let mut next = clock.iter().copied().peekable();
        while let Some(&due) = next.peek() {
            if due - t <= STEP {
                let (there, _) = self.step(x, v, due - t);
                if gap(there) >= 0.0 {
                    out.extend(there);
                    next.next();
                    continue;
                }
            }
            let (there, faster) = self.step(x, v, STEP);
            if gap(there) >= 0.0 {
                (x, v, t) = (there, faster, t + STEP);
                continue;
            }
            let (mut low, mut high) = (0.0, STEP);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if gap(self.step(x, v, middle).0) >= 0.0 { low = middle } else { high = middle }
            }
            (x, v) = self.step(x, v, low);
            t += low;
            let before = v;
            let struck = match self.kicks.get(bounces) {
                Some(kick) if self.tilt == [0.0; 2] => tilted(*kick),
                _ => normal,
            };
            bounces += 1;
            let e = (self.restitution * (-dot(v, struck) / 3.0).powf(-self.exponent)).clamp(0.0, 1.0);
            (v, w) = impact(struck, self.radius, e, self.friction, v, w);
            let skin = add(v, 1.0, cross(w, add([0.0; 3], -self.radius, normal)));
            let slip = add(skin, -dot(skin, normal), normal);
            // An impulse j changes slip by 7/2 j and spin by r × j over 2/5 r².
            let impulse = add([0.0; 3], -2.0 / 7.0 * self.loss, slip);
            v = add(v, 1.0, impulse);
            w = add(w, -2.5 / self.radius, cross(normal, impulse));
            if self.duration > 0.0 {
                let (start, end, duration) = (t, v, self.duration);
                while let Some(&due) = next.peek().filter(|due| **due < start + duration) {
                    out.extend(self.pressed(x, before, end, normal, due - start));
                    next.next();
                }
                x = self.pressed(x, before, end, normal, duration);
                t += duration;
            }
        }
        out
    }

    /// In contact: a mass on a spring with a damper, integrated as such, and evenly changing speed along the surface.
    fn pressed(&self, x: Three, before: Three, after: Three, normal: Three, t: f64) -> Three {
        let (vn, end) = (dot(before, normal), dot(after, normal));
        // A damped oscillator that passes its origin again after the duration, slower by e.
        let damping = -(end / -vn).ln() / self.duration;
        let stiffness = (std::f64::consts::PI / self.duration).powi(2) + damping * damping;
        let force = |depth: f64, speed: f64| -stiffness * depth - 2.0 * damping * speed;
        let steps = 2000;
        let h = t / f64::from(steps);
        let (mut depth, mut speed) = (0.0, vn);
        for _ in 0..steps {
            let (k1, l1) = (speed, force(depth, speed));
            let (k2, l2) = (speed + 0.5 * h * l1, force(depth + 0.5 * h * k1, speed + 0.5 * h * l1));
            let (k3, l3) = (speed + 0.5 * h * l2, force(depth + 0.5 * h * k2, speed + 0.5 * h * l2));
            let (k4, l4) = (speed + h * l3, force(depth + h * k3, speed + h * l3));
            depth += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
            speed += h / 6.0 * (l1 + 2.0 * l2 + 2.0 * l3 + l4);
        }
        let along = |u: Three| add(u, -dot(u, normal), normal);
        let (first, last) = (along(before), along(after));
        let mean = add(first, 0.5 * t / self.duration, add(last, -1.0, first));
        add(add(x, t, mean), depth, normal)
    }
}

/// Way on a plane of a ball that rolls with this drive and against this resistance (m/s²), by tiny steps; it stays where
/// it stops.
pub fn roll(drive: [f64; 2], start: [f64; 2], resistance: f64, clock: &[f64]) -> Vec<[f64; 2]> {
    let h = 1e-5;
    let force = |v: [f64; 2]| {
        let speed = v[0].hypot(v[1]).max(1e-12);
        [drive[0] - resistance * v[0] / speed, drive[1] - resistance * v[1] / speed]
    };
    let (mut t, mut x, mut v) = (0.0, [0.0; 2], start);
    let mut out = Vec::new();
    for due in clock {
        while t + h <= *due {
            let a = force(v);
            let middle = [v[0] + 0.5 * h * a[0], v[1] + 0.5 * h * a[1]];
            let a = force(middle);
            for axis in 0..2 {
                x[axis] += h * middle[axis];
                v[axis] += h * a[axis];
            }
            t += h;
        }
        let rest = due - t;
        out.push([x[0] + rest * v[0], x[1] + rest * v[1]]);
    }
    out
}
