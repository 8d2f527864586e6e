//! What `inspect` says of datasets and networks.

use serde_json::{Value, json};
use tunenet_core::network::{DatasetHeader, Model, Shard};
use tunenet_formats::Error;

use crate::view::answer::Printout;

/// A dataset of rollout pairs.
pub fn dataset(header: &DatasetHeader, shard: Option<Shard>, broken: Option<&Error>, shown: &mut Printout) -> Value {
    let of = shard.map_or_else(String::new, |shard| {
        let block = shard.block(header.pairs);
        format!("shard {shard}, {} of ", block.end - block.start)
    });
    shown.row("dataset", &format!("{of}{} pairs, preset {}, seed {}", header.pairs, header.preset, header.seed));
    let rows: Vec<Vec<String>> = header
        .parameters
        .iter()
        .map(|p| {
            let learned = if p.tuned { "learned" } else { "fixed" };
            vec![p.name.clone(), format!("{} to {}", p.min, p.max), p.unit.clone(), learned.into()]
        })
        .collect();
    shown.table(&rows);
    match (broken, shard) {
        (None, None) => shown.row("usable", "train a network"),
        (None, Some(_)) => shown.row("unusable", "a single shard: combine all shards with `tunenet merge`"),
        (Some(error), _) => shown.row("unusable", &error.to_string()),
    }
    json!({
        "kind": if shard.is_some() { "shard" } else { "dataset" }, "shard": shard.map(|shard| shard.to_string()),
        "reason": broken.map(ToString::to_string), "preset": header.preset, "pairs": header.pairs, "seed": header.seed,
        "frames": header.clock.len(),
        "parameters": header.parameters.iter().map(|p| json!({
            "name": p.name, "min": p.min, "max": p.max, "unit": p.unit, "tune": p.tuned,
        })).collect::<Vec<_>>(),
        "warnings": [],
    })
}

/// A trained network.
pub fn model(model: &Model, shown: &mut Printout) -> Value {
    let parameters = model.parameters();
    shown.row("model", &format!("preset `{}`, seed {}", model.preset().name, model.seed()));
    let rows: Vec<Vec<String>> =
        parameters.iter().map(|p| vec![p.name.clone(), format!("{} to {}", p.min, p.max), p.unit.clone()]).collect();
    shown.table(&rows);
    json!({
        "kind": "model", "preset": model.preset().name, "seed": model.seed(),
        "parameters": parameters.iter().map(|p| json!({
            "name": p.name, "min": p.min, "max": p.max, "unit": p.unit,
        })).collect::<Vec<_>>(),
        "warnings": [],
    })
}
