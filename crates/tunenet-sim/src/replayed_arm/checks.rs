//! Checks of a log of joints before anything is computed from it.

use tunenet_core::finding::FindingKind;

use tunenet_core::observation::Observation;
use tunenet_core::observation::{Check, State};
use tunenet_core::statistics::{dot, extent};

use super::filter::{slope, smooth};
use super::recorded::{columns, even_step};
use crate::arm::{Joint, JointKind};
use crate::findings;

/// Positions may exceed their limits by this much, rad: figures of files are rounded, and arms give a little.
const OVERSHOOT_RAD: f64 = 0.05;
/// No joint of an arm without limits is logged beyond this, rad (six turns); in degrees that is a tenth of a turn.
const FARTHEST_RAD: f64 = 40.0;
/// A joint that moves less than this, rad, says nothing of units or speeds.
const STILL_RAD: f64 = 0.02;
/// Samples have to fill this share of a log.
const LEAST_FILLED: f64 = 0.5;
/// How far a ratio may be off a degree's.
const NEAR: f64 = 0.2;
const DEGREES: f64 = 180.0 / std::f64::consts::PI;
/// Speeds that are this many times the slope of the positions, or as many times less, have another unit, or the clock has.
const OTHER_UNIT: f64 = 2.0;
/// Speeds that follow the slope of the positions less than this (cosine) are those of another joint.
const ALIKE: f64 = 0.7;
/// Cut-off for comparing speeds, Hz.
const SPEEDS_HZ: f64 = 5.0;

pub(super) fn check(kind: FindingKind, state: State, text: impl Into<String>, remedy: &str) -> Check {
    Check { kind, state, text: text.into(), remedy: remedy.into() }
}

/// All checks of the log `seen` of an arm with these joints, in an order in which the first failure is the reason.
/// `gains` says whether torque constants are given.
pub(super) fn checks(seen: &Observation, joints: &[&Joint], gains: bool) -> Vec<Check> {
    let mut found = vec![count(seen, joints), clock(seen)];
    if found.iter().any(|c| c.state == State::Failed) {
        return found;
    }
    found.push(effort(seen, gains));
    found.push(units(seen, joints));
    if found[3].state != State::Failed {
        found.push(limits(seen, joints));
        found.push(speeds(seen, joints));
    }
    found
}

fn count(seen: &Observation, joints: &[&Joint]) -> Check {
    let (kind, found) = (findings::JOINTS_COUNT, columns(seen, "q").len());
    let names = || joints.iter().map(|j| format!("`{}`", j.name)).collect::<Vec<_>>().join(", ");
    if found == 0 {
        return check(kind, State::Failed, "expected joint positions, found none", "record `q1_rad`, …");
    }
    if found != joints.len() {
        let text = format!("expected {} joints ({}), found {found}", joints.len(), names());
        let remedy = "number the columns in the order of the URDF, with `--columns` where the names differ; of joints beyond \
                      `arm.payload_link` nothing is read";
        return check(kind, State::Failed, text, remedy);
    }
    check(kind, State::Passed, format!("{found} joints"), "")
}

/// A log whose gaps are many times as long as itself would have to be filled by guesses.
fn clock(seen: &Observation) -> Check {
    let (kind, clock) = (findings::JOINTS_CLOCK, seen.clock());
    let (span, step) = (clock[clock.len() - 1] - clock[0], even_step(clock));
    let share = clock.len() as f64 * step / span;
    if share < LEAST_FILLED {
        let text = format!("samples are {step:.4} s apart and fill {:.0} % of {span:.1} s", 100.0 * share);
        return check(kind, State::Failed, text, "cut the log where its gaps are, and check the unit of the time");
    }
    check(kind, State::Passed, "the clock has no long gaps", "")
}

fn effort(seen: &Observation, gains: bool) -> Check {
    let kind = findings::JOINTS_EFFORT;
    match (columns(seen, "tau").is_empty(), columns(seen, "i").is_empty(), gains) {
        (false, ..) => check(kind, State::Passed, "torques are measured", ""),
        (true, false, true) => check(kind, State::Passed, "torques from currents, by `arm.current_gain_nm_a`", ""),
        (true, false, false) => {
            let text = "expected torques, or currents with their torque constants, found only currents";
            let remedy =
                "write `arm.current_gain_nm_a = [..]`, the N·m of each joint for 1 A, into the simulation file";
            check(kind, State::Failed, text, remedy)
        }
        (true, true, _) => {
            let text = "expected torques (effort) or motor currents, found only positions and speeds";
            let remedy = "record `effort` in JointState, or columns `tau1_nm`, … or `i1_a`, …";
            check(kind, State::Failed, text, remedy)
        }
    }
}

/// So many times its limit, and a position is none in radians.
const BEYOND: f64 = 3.0;

/// One column of positions: what it is called, how far it may reach (rad), and its place.
struct Column {
    name: String,
    limit_rad: f64,
    position: usize,
    speed: Option<usize>,
}

/// Whether the log `seen` of an unknown arm is in radians and seconds: a suspicion is noticed, never more.
#[must_use]
pub fn suspect_units(seen: &Observation) -> Check {
    let speeds = columns(seen, "dq");
    let one = |(k, position): (usize, usize)| {
        let name = seen.channels()[position].name.clone();
        Column { name, limit_rad: FARTHEST_RAD, position, speed: speeds.get(k).copied() }
    };
    let found = units_of(seen, columns(seen, "q").into_iter().enumerate().map(one).collect());
    let state = if found.state == State::Failed { State::Noticed } else { found.state };
    Check { state, ..found }
}

/// The first joint that cannot be in radians: far beyond what it may reach, or faster or slower than its speeds say by the size
/// of a degree.
fn units(seen: &Observation, joints: &[&Joint]) -> Check {
    let speeds = columns(seen, "dq");
    let one = |(k, (joint, position)): (usize, (&&Joint, usize))| {
        let limit = joint.limits.lower.abs().max(joint.limits.upper.abs());
        let limit_rad = if limit.is_finite() { BEYOND * limit } else { FARTHEST_RAD };
        let turns = joint.kind != JointKind::Prismatic;
        turns.then(|| Column { name: joint.name.clone(), limit_rad, position, speed: speeds.get(k).copied() })
    };
    units_of(seen, joints.iter().zip(columns(seen, "q")).enumerate().filter_map(one).collect())
}

fn units_of(seen: &Observation, all: Vec<Column>) -> Check {
    let kind = findings::JOINTS_UNITS;
    let remedy = "name the columns `q1_deg`, … and `dq1_deg_s`, … (with `--columns` where the names are others), or record radians";
    for Column { name, limit_rad, position, speed } in all {
        let (low, high) = extent(seen.column(position));
        let farthest = low.abs().max(high.abs());
        if farthest > limit_rad {
            // No arm's own limits stand behind a whole number of turns.
            let limits = if limit_rad == FARTHEST_RAD {
                String::new()
            } else {
                format!(" Or is its limit of {:.2} wrong?", limit_rad / BEYOND)
            };
            let text =
                format!("`{name}` reaches {farthest:.1}, which is not a possible angle in radians: degrees?{limits}");
            return check(kind, State::Failed, text, remedy);
        }
        let Some((ratio, alike)) = speed.and_then(|speed| ratio(seen, position, speed)) else { continue };
        let near = |expected: f64| (ratio / expected - 1.0).abs() < NEAR;
        if near(DEGREES) || near(1.0 / DEGREES) {
            let which = if near(DEGREES) { "speeds" } else { "positions" };
            let text = format!(
                "the speeds of `{name}` are {ratio:.3} times the slope of its positions: the {which} are in degrees"
            );
            return check(kind, State::Failed, text, remedy);
        }
        if alike > ALIKE && !(1.0 / OTHER_UNIT..=OTHER_UNIT).contains(&ratio) {
            let text = format!("the speeds of `{name}` are {ratio:.3} times the slope of its positions");
            let remedy = "is the clock in milliseconds (name it `t_ms`), or in frames?";
            return check(kind, State::Failed, text, remedy);
        }
    }
    check(kind, State::Passed, "angles are in radians, and the clock in seconds", "")
}

/// Measured speeds over the slope of the positions, and the cosine between both; nothing where the joint hardly moves.
fn ratio(seen: &Observation, position: usize, speed: usize) -> Option<(f64, f64)> {
    let (low, high) = extent(seen.column(position));
    if high - low < STILL_RAD {
        return None;
    }
    let clock = seen.clock();
    let step = (clock[clock.len() - 1] - clock[0]) / (clock.len() - 1) as f64;
    let cutoff = SPEEDS_HZ.min(0.2 / step);
    let smoothed = |column: usize| smooth(&seen.column(column).collect::<Vec<_>>(), cutoff, 1.0 / step);
    let (slope, speed) = (slope(&smoothed(position), step), smoothed(speed));
    let (both, own, other) = (dot(&slope, &speed), dot(&slope, &slope), dot(&speed, &speed));
    (own > 0.0 && other > 0.0).then(|| (both / own, both / (own * other).sqrt()))
}

fn limits(seen: &Observation, joints: &[&Joint]) -> Check {
    let kind = findings::JOINTS_LIMITS;
    for (joint, &column) in joints.iter().zip(&columns(seen, "q")) {
        let (low, high) = (joint.limits.lower - OVERSHOOT_RAD, joint.limits.upper + OVERSHOOT_RAD);
        if let Some((i, q)) = seen.column(column).enumerate().find(|(_, q)| !(low..=high).contains(q)) {
            let text = format!(
                "`{}` stands at {q:.3} rad at {:.3} s: expected {} to {}",
                joint.name,
                seen.clock()[i],
                joint.limits.lower,
                joint.limits.upper
            );
            let remedy = "check order and zero of the joints, and the limits of the URDF";
            return check(kind, State::Failed, text, remedy);
        }
    }
    let free =
        |j: &&&Joint| !j.limits.lower.is_finite() && !j.limits.upper.is_finite() && j.kind != JointKind::Continuous;
    let unlimited: Vec<String> = joints.iter().filter(free).map(|j| format!("`{}`", j.name)).collect();
    let absent =
        format!("the URDF gives no limits of {} (none, or lower equal to upper): not checked", unlimited.join(", "));
    if !unlimited.is_empty() && unlimited.len() == joints.len() {
        return check(kind, State::NotRun, absent, "");
    }
    let rest = if unlimited.is_empty() { String::new() } else { format!("; {absent}") };
    check(kind, State::Passed, format!("the motion stays within the limits of the joints{rest}"), "")
}

fn speeds(seen: &Observation, joints: &[&Joint]) -> Check {
    let kind = findings::JOINTS_SPEEDS;
    let (positions, speeds) = (columns(seen, "q"), columns(seen, "dq"));
    if speeds.is_empty() {
        return check(kind, State::NotRun, "no speeds are recorded", "");
    }
    for ((joint, &position), &speed) in joints.iter().zip(&positions).zip(&speeds) {
        if let Some((_, alike)) = ratio(seen, position, speed).filter(|(_, alike)| *alike < ALIKE) {
            let text = format!(
                "the speeds of `{}` are not the slope of its positions (cosine {alike:.2}); only positions are used",
                joint.name
            );
            return check(kind, State::Noticed, text, "check the order of the columns, and signs");
        }
    }
    check(kind, State::Passed, "speeds are the slopes of the positions", "")
}
