//! The answer of `tunenet tune` as JSON; docs/json.md lists the keys.

use serde_json::{Map, Value, json};
use tunenet_core::observation::Note;
use tunenet_core::tune::{ChannelGap, Outcome, Region};
use tunenet_sim::ChosenNetwork;

use super::warning;
use crate::answers::tune::{Spent, forced};

const SCHEMA: &str = "tunenet.tune/1";

/// The object of `--json`; `names` are those of all recordings that were given.
pub fn object(outcome: &Outcome, names: &[String], chosen: &ChosenNetwork, spent: Spent) -> Value {
    let parameters: Map<String, Value> = outcome
        .parameters
        .iter()
        .map(|p| {
            let (low, high) = p.interval95;
            let one = json!({
                "value": p.value, "unit": p.unit, "interval95": [low, high],
                "before": p.before, "bounds": [p.bounds.0, p.bounds.1], "identified": p.identified,
                "status": p.status,
            });
            (p.name.clone(), one)
        })
        .collect();
    let iterations: Vec<Value> = outcome
        .iterations
        .iter()
        .map(|i| {
            let named: Map<String, Value> =
                outcome.free.iter().zip(&i.parameters).map(|(n, v)| (n.clone(), json!(v))).collect();
            json!({ "k": i.k, "parameters": named, "rmse": i.rmse })
        })
        .collect();
    let mut object = json!({
        "schema": SCHEMA,
        "verdict": outcome.verdict,
        "parameters": parameters,
        "model": {
            "source": chosen.source.code(), "text": chosen.text, "train_seconds": chosen.train_seconds,
        },
        "iterations": iterations,
        "stop": outcome.stop,
        "gap": outcome.gap.as_ref().map(|g| json!({
            "unit": g.unit, "before": g.before, "after": g.after, "noise_floor": g.noise_floor,
        })),
        "gaps": gaps(outcome, names),
        "estimated": outcome.nuisances.iter().map(|own| {
            own.iter().map(|p| json!({ "name": p.name, "value": p.value, "unit": p.unit })).collect::<Vec<_>>()
        }).collect::<Vec<_>>(),
        "preflight": outcome.preflight,
        "forced": forced(outcome),
        "recordings": names.iter().zip(&outcome.used).map(|(name, used)| json!({ "file": name, "used": used })).collect::<Vec<_>>(),
        "rollouts": outcome.rollouts,
        "seconds": spent.seconds,
        "warnings": outcome.notes.iter().map(warning).collect::<Vec<_>>(),
    });
    if spent.re_asks > 0 {
        object["re_asks"] = json!(spent.re_asks);
    }
    if outcome.correlation.nrows() > 1 {
        let rows: Vec<Vec<f64>> = outcome.correlation.row_iter().map(|r| r.iter().copied().collect()).collect();
        object["correlation"] = json!({ "parameters": outcome.free, "matrix": rows });
    }
    if !outcome.tied.is_empty() {
        object["tied"] = json!(outcome.tied);
    }
    if let Some(region) = &outcome.region95 {
        object["region95"] = region_json(region);
    }
    object
}

/// The gap of each recording used, channel by channel.
fn gaps(outcome: &Outcome, names: &[String]) -> Vec<Value> {
    let used: Vec<&String> = names.iter().zip(&outcome.used).filter(|(_, used)| **used).map(|(name, _)| name).collect();
    let one = |gap: &ChannelGap| {
        json!({
            "file": used.get(gap.recording), "channel": gap.channel, "unit": gap.unit,
            "before": gap.before, "after": gap.after, "noise_floor": gap.noise_floor,
        })
    };
    outcome.gaps.iter().map(one).collect()
}

fn region_json(region: &Region) -> Value {
    let covariance = region
        .covariance
        .as_ref()
        .map(|c| c.row_iter().map(|r| r.iter().copied().collect()).collect::<Vec<Vec<f64>>>());
    json!({
        "parameters": region.parameters, "centre": region.centre, "covariance": covariance,
        "quantile": region.quantile, "boundary": region.boundary,
    })
}

/// The object of a recording that nothing could be read from, and why.
pub fn rejected(why: &Note) -> Value {
    json!({
        "schema": SCHEMA, "verdict": "rejected", "parameters": {}, "iterations": [], "gap": null, "rollouts": 0,
        "seconds": 0.0, "recordings": [], "warnings": [warning(why)],
    })
}
