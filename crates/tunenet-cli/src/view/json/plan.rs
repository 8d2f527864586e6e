//! The answer of `tunenet plan` for programs.

use serde_json::{Value, json};
use tunenet_sim::shot::{Candidate, Rule};

use super::warning;
use crate::answers::plan::Answer;

pub fn object(answer: &Answer) -> Value {
    let best = answer.plan.best();
    json!({
        "schema": "tunenet.plan/1",
        "reachable": answer.plan.reachable,
        "height_m": best.height_m,
        "joint_positions_rad": best.joints_rad.as_deref().unwrap_or_default(),
        "miss_distance_m": best.pass.miss_m,
        "clearance_m": best.pass.clearance_m,
        "success_probability": best.probability,
        "rule": if answer.settings.rule == Rule::Nearest { "nearest" } else { "probability" },
        "draws": answer.settings.draws,
        "candidates": answer.plan.candidates.iter().map(candidate).collect::<Vec<_>>(),
        "seconds": answer.seconds,
        "warnings": answer.notes.iter().map(warning).collect::<Vec<_>>(),
    })
}

fn candidate(one: &Candidate) -> Value {
    json!({
        "height_m": one.height_m,
        "miss_distance_m": one.pass.miss_m,
        "clearance_m": one.pass.clearance_m,
        "goes_in": one.pass.goes_in(),
        "success_probability": one.probability,
        "arm_reaches": one.joints_rad.is_some(),
    })
}
