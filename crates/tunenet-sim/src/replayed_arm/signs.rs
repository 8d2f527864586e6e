//! Sign checks: whether torques have the sign that gravity requires, and whether run and reference are swapped.

use tunenet_core::observation::{Check, State};
use tunenet_core::simulator::Prepared;
use tunenet_core::statistics::dot;

use super::checks::check;
use crate::arm::Joint;
use crate::findings;

/// A joint whose rigid torque is less than this share of the greatest says nothing of its sign: friction outweighs it.
const WEIGHTY: f64 = 0.1;
/// As measured, less than this share of the squares of a torque is explained by the arm and anything that it may hold, ...
const LEAST: f64 = 0.1;
/// ... and with the sign turned, more than this.
const MOST: f64 = 0.5;
/// How well the difference of two runs has to follow the payload, turned round (cosine).
const OPPOSITE: f64 = 0.5;

/// Torques of a run averaged over the windows of the fit, row-major `[window, joint]`.
pub(super) struct Torques {
    /// As measured.
    pub measured: Vec<f64>,
    /// What the arm of the URDF needs, its friction included.
    pub bare: Vec<f64>,
    /// What 1 kg in the payload's place adds.
    pub payload: Vec<f64>,
}

fn column(values: &[f64], joint: usize, joints: usize) -> impl Iterator<Item = f64> {
    values.iter().skip(joint).step_by(joints).copied()
}

/// The share of the squares of `sign · y` that a·bare + b·payload explains, neither number below 0.
fn explained(torques: &Torques, joint: usize, joints: usize, sign: f64) -> f64 {
    let of = |values: &'_ [f64]| column(values, joint, joints).collect::<Vec<_>>();
    let (y, r, p) = (of(&torques.measured), of(&torques.bare), of(&torques.payload));
    let (yy, rr, pp, rp) = (dot(&y, &y), dot(&r, &r), dot(&p, &p), dot(&r, &p));
    let (yr, yp) = (sign * dot(&y, &r), sign * dot(&y, &p));
    let determinant = rr * pp - rp * rp;
    let (a, b) = ((yr * pp - yp * rp) / determinant, (yp * rr - yr * rp) / determinant);
    let gain = if determinant > 1e-9 * rr * pp && a >= 0.0 && b >= 0.0 {
        a * yr + b * yp
    } else {
        let alone = |product: f64, square: f64| if square > 0.0 { product.max(0.0).powi(2) / square } else { 0.0 };
        alone(yr, rr).max(alone(yp, pp))
    };
    if yy > 0.0 { gain / yy } else { 0.0 }
}

/// Names the joints whose torques follow the arm's only with their sign turned.
pub(super) fn signs(torques: &Torques, joints: &[&Joint], currents: bool) -> Check {
    let (kind, n) = (findings::JOINTS_SIGNS, joints.len());
    let size = |values: &[f64], j: usize| column(values, j, n).map(|v| v * v).sum::<f64>().sqrt();
    let greatest = (0..n).map(|j| size(&torques.bare, j)).fold(0.0, f64::max);
    let weighty: Vec<usize> =
        (0..n).filter(|&j| size(&torques.bare, j) > WEIGHTY * greatest && size(&torques.measured, j) > 0.0).collect();
    let turned: Vec<usize> = weighty
        .iter()
        .copied()
        .filter(|&j| explained(torques, j, n, 1.0) < LEAST && explained(torques, j, n, -1.0) > MOST)
        .collect();
    if turned.is_empty() {
        return check(kind, State::Passed, "torques have the sign that the arm needs", "");
    }
    let names: Vec<String> = turned.iter().map(|&j| format!("`{}`", joints[j].name)).collect();
    let which = if turned.len() == weighty.len() && turned.len() > 1 {
        "of all joints that carry weight".to_owned()
    } else {
        format!("of {}", names.join(", "))
    };
    let text = format!("the torques {which} have the opposite sign of those that the arm needs");
    let how =
        if currents { "; a negative number in `arm.current_gain_nm_a` changes the sign of a current" } else { "" };
    let remedy = format!(
        "positive is what the motor exerts about the joint's axis: change the sign of these columns{how}; or the zero of the joint \
         is half a turn off"
    );
    check(kind, State::Failed, text, &remedy)
}

/// Whether the run has the higher load, and not the other way round. `prepared` holds the difference of both.
pub(super) fn swapped(prepared: &Prepared, torques: &Torques, joints: usize) -> Check {
    let kind = findings::REFERENCE_SWAPPED;
    let noise = prepared.noise.as_deref().unwrap_or_default();
    let weigh = |values: &[f64]| -> Vec<f64> {
        values.iter().enumerate().map(|(i, v)| v / noise.get(i % joints).copied().unwrap_or(1.0)).collect()
    };
    let (seen, payload) = (weigh(prepared.seen.values()), weigh(&torques.payload));
    let (both, square, other) = (dot(&seen, &payload), dot(&payload, &payload), dot(&seen, &seen));
    if both < -OPPOSITE * (square * other).sqrt() {
        let text = format!(
            "the run needs less torque than its reference, as if it held {:.3} kg: the two seem to be swapped",
            both / square
        );
        return check(
            kind,
            State::Failed,
            text,
            "pass the run with payload to --observation and the one without to --reference",
        );
    }
    check(kind, State::Passed, "the run has the higher load", "")
}
