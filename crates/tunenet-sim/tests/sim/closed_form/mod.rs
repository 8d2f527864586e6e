//! What a ball does, from formulas alone: the judge of the simulated ball. Nothing here uses the code under test.

/// Height of the lowest point (m) at time `t` (s) of a ball let go from `fall` (m), without air.
///
/// Bounce k leaves with e^k times the first speed and lasts 2·e^k·v/g.
pub fn drop(fall: f64, g: f64, e: f64, t: f64) -> f64 {
    let first = (2.0 * fall / g).sqrt();
    if t <= first {
        return fall - 0.5 * g * t * t;
    }
    let mut left = t - first;
    let mut speed = e * g * first;
    // Below 1e-9 m/s a bounce is 5e-20 m high.
    while speed > 1e-9 {
        let duration = 2.0 * speed / g;
        if left <= duration {
            return left * (speed - 0.5 * g * left);
        }
        left -= duration;
        speed *= e;
    }
    0.0
}

/// As [`drop`], with quadratic drag `c` (1/m): ln-cosh arcs down, ln-cos arcs up. Terminal speed is √(g/c).
pub fn drop_with_drag(fall: f64, g: f64, e: f64, c: f64, t: f64) -> f64 {
    let terminal = (g / c).sqrt();
    let scale = terminal * terminal / g;
    // A fall of h from rest ends with √(1 − exp(−2·h/scale)) of the terminal speed and takes arcosh(exp(h/scale))·terminal/g,
    // here in forms that keep their digits for the smallest hops.
    let share = |h: f64| (-(-2.0 * h / scale).exp_m1()).sqrt();
    let duration = |h: f64| (h / scale + share(h).ln_1p()) * terminal / g;
    let down = |h: f64, t: f64| h - scale * (g * t / terminal).cosh().ln();

    let (mut apex, mut left) = (fall, t);
    loop {
        let falling = duration(apex);
        if left <= falling {
            return down(apex, left);
        }
        left -= falling;
        let speed = e * terminal * share(apex);
        if speed < 1e-6 {
            return 0.0;
        }
        let angle = (speed / terminal).atan();
        let rising = angle * terminal / g;
        apex = 0.5 * scale * (speed / terminal).powi(2).ln_1p();
        if left <= rising {
            return scale * ((angle - g * left / terminal).cos() / angle.cos()).ln();
        }
        left -= rising;
    }
}

pub type Three = [f64; 3];

pub fn dot(a: Three, b: Three) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn cross(a: Three, b: Three) -> Three {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub fn add(a: Three, scale: f64, b: Three) -> Three {
    [a[0] + scale * b[0], a[1] + scale * b[1], a[2] + scale * b[2]]
}

/// Velocity and spin of a solid sphere after an impact on a plane with unit normal `n`.
///
/// Per mass, the normal impulse is `(1 + e)·v_n`. Stopping the slip u of the contact point takes 2/7·|u|, because an
/// impulse j changes u by j·(1 + r²/(2/5·r²)) = 7/2·j; Coulomb allows at most μ times the normal impulse.
pub fn impact(n: Three, r: f64, e: f64, mu: f64, v: Three, w: Three) -> (Three, Three) {
    let normal = -(1.0 + e) * dot(n, v);
    let arm = [-r * n[0], -r * n[1], -r * n[2]];
    let skin = add(v, 1.0, cross(w, arm));
    let slip = add(skin, -dot(skin, n), n);
    let size = dot(slip, slip).sqrt();
    let mut impulse = [normal * n[0], normal * n[1], normal * n[2]];
    if size > 0.0 {
        impulse = add(impulse, -(mu * normal).min(2.0 / 7.0 * size) / size, slip);
    }
    (add(v, 1.0, impulse), add(w, 5.0 / (2.0 * r * r), cross(arm, impulse)))
}
