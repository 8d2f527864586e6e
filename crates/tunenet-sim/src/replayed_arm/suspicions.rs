//! Plausibility checks of a tuned payload.

use tunenet_core::observation::{Check, State};
use tunenet_core::tune::{Estimate, Outcome, Verdict};

use super::checks::check;
use crate::SimulationFile;
use crate::findings;

/// A payload that reaches from its link to twice its centre of mass and is thinner than this, kg/m³, is none that a hand
/// holds: foam has 20.
const THINNEST_KG_M3: f64 = 5.0;
/// Length of a tool, m, of any mass.
const LONGEST_TOOL_M: f64 = 0.2;
const PLACES: [&str; 3] = ["payload_com_x", "payload_com_y", "payload_com_z"];

/// Adds what is suspicious of the payload that `outcome` found with the simulation `file` to its notes and checks. `referenced`:
/// whether a run without payload was aligned with it.
pub fn suspect(file: &SimulationFile, outcome: &mut Outcome, referenced: bool) {
    let mut found = Vec::new();
    found.extend(gain(outcome, referenced));
    found.extend(alone(outcome, referenced));
    found.extend(place(file, outcome));
    found.extend(moved(file, outcome));
    outcome.notes.extend(found.iter().filter_map(Check::note));
    for (used, checks) in outcome.used.iter().zip(&mut outcome.preflight) {
        if *used {
            checks.extend(found.iter().cloned());
        }
    }
}

fn estimate<'a>(outcome: &'a Outcome, name: &str) -> Option<&'a Estimate> {
    outcome.parameters.iter().find(|p| p.name == name)
}

/// Mass and gain that are both free.
fn gain(outcome: &Outcome, referenced: bool) -> Option<Check> {
    let at = |name: &str| outcome.free.iter().position(|n| n == name);
    let (mass, gain) = (at("payload_mass")?, at("torque_gain")?);
    let correlation = outcome.correlation[(mass, gain)];
    let remedy = "calibrate the gain first: a run with a known payload (`parameters.payload_mass.tune=false`) and its `--reference`; \
                  then weigh with `--reference` and `parameters.torque_gain.tune=false`";
    let text = if referenced {
        format!(
            "with a reference, only the product of `payload_mass` and `torque_gain` is determined (correlation {correlation:.2})"
        )
    } else {
        format!(
            "only the link masses of the URDF separate `payload_mass` from `torque_gain` (correlation {correlation:.2}): what \
             is wrong in them, and friction, is in neither interval"
        )
    };
    Some(check(findings::PAYLOAD_GAIN, State::Noticed, text, remedy))
}

/// A payload that is weighed with the URDF's own masses, although something is left that they do not explain.
fn alone(outcome: &Outcome, referenced: bool) -> Option<Check> {
    estimate(outcome, "payload_mass").filter(|_| !referenced && outcome.verdict == Verdict::PoorFit)?;
    let text = "without a reference run, friction and errors of the URDF's masses are attributed to the payload, by \
                more than its interval says";
    let remedy = "record the same motion without payload and give it with `--reference`";
    Some(check(findings::PAYLOAD_ALONE, State::Noticed, text, remedy))
}

/// A centre of mass where no payload of that mass has one.
fn place(file: &SimulationFile, outcome: &Outcome) -> Option<Check> {
    let parameters = file.parameters().ok()?;
    let known = |name: &str| parameters.iter().find(|p| p.name == name).map_or(0.0, |p| p.value);
    let mass = estimate(outcome, "payload_mass").map_or_else(|| known("payload_mass"), |p| p.value);
    let tuned: Vec<&Estimate> = PLACES.iter().filter_map(|name| estimate(outcome, name)).collect();
    if tuned.is_empty() || mass <= 0.0 {
        return None;
    }
    let at = PLACES.map(|name| estimate(outcome, name).map_or_else(|| known(name), |p| p.value));
    let distance = at.iter().map(|v| v * v).sum::<f64>().sqrt();
    let unsure = tuned.iter().map(|p| (0.5 * (p.interval95.1 - p.interval95.0)).powi(2)).sum::<f64>().sqrt();
    let farthest = (0.5 * (mass / THINNEST_KG_M3).cbrt()).max(LONGEST_TOOL_M);
    let kind = findings::PAYLOAD_PLACE;
    if distance - unsure <= farthest {
        return Some(check(kind, State::Passed, format!("the centre of mass lies {distance:.3} m from its link"), ""));
    }
    let text = format!(
        "the centre of mass lies {distance:.3} m from its link, which is implausible for a payload of {mass:.3} kg (at most {farthest:.2} m)"
    );
    let remedy = "check the joints' order and zeros and the torque constants; without a `--reference`, errors of the URDF and friction \
                  are taken for a payload";
    Some(check(kind, State::Noticed, text, remedy))
}

/// A centre of mass that contradicts the one that was tuned before.
fn moved(file: &SimulationFile, outcome: &Outcome) -> Option<Check> {
    let (mut both, mut apart) = (false, Vec::new());
    for now in PLACES.iter().filter_map(|name| estimate(outcome, name)) {
        let Some((low, high)) = file.tuned95(&now.name) else { continue };
        both = true;
        if now.interval95.0 > high || now.interval95.1 < low {
            apart.push(format!("`{}` {:.3} m, was {:.3} m", now.name, now.value, now.before));
        }
    }
    let kind = findings::PAYLOAD_MOVED;
    if apart.is_empty() {
        return both.then(|| check(kind, State::Passed, "the centre of mass agrees with the one tuned before", ""));
    }
    let text = format!(
        "the centre of mass differs from the one that this file was tuned to ({}) by more than both intervals allow",
        apart.join("; ")
    );
    let remedy = "is it the same payload, mounted in the same way? otherwise joint zeros or the signs of columns differ between the logs";
    Some(check(kind, State::Noticed, text, remedy))
}
