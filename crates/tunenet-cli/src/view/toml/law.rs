//! The provenance of a file with a law that was found: its intervals, tests and rivals.

use anyhow::Result;
use toml_edit::{Array, InlineTable};
use tunenet_core::law::Member;

use super::provenance::Provenance;
use crate::answers::diagnose::Answer;
use crate::answers::law::Found;

/// The provenance of the file with `law`.
pub fn provenance(seed: u64, answer: &Answer, found: &Found, law: &Member) -> Result<Provenance> {
    let observations = answer.loaded.recorded.iter().zip(&answer.diagnosis.uses).map(|(recorded, used)| {
        let mut one = InlineTable::new();
        one.insert("file", recorded.name.as_str().into());
        one.insert("sha256", recorded.hash.as_str().into());
        one.insert("held_out", used.held_out.into());
        one
    });
    let parameters = found.parameters.iter().zip(&law.parameters).filter(|(p, _)| p.tune);
    let own = parameters.map(|(p, (_, interval))| (p.name.clone(), *interval));
    let inner = law.terms.iter().flat_map(|term| {
        let name = term.carried.effect.name.to_string();
        term.numbers.iter().map(move |n| (format!("{name}.{}", n.key), n.interval95))
    });
    let rivals = found.answer.members.iter().skip(1).map(Member::text);
    let mut made = Provenance::new("diagnose", seed, answer.word())?
        .with("observations", observations.collect::<Array>())
        .with_intervals(own.chain(inner))
        .with("law", law.text())
        .with("bic_gain", law.bic_gain)
        .with("score", law.score)
        .with("residual_force_nats", law.gates.residual_force_nats)
        .with_any("rivals", rivals.collect());
    let numbers = [
        ("heterogeneity_p", law.gates.heterogeneity_p),
        ("held_out_ratio", law.gates.held_out_ratio),
        ("held_out_base", law.gates.held_out_base),
        ("held_out_left", law.gates.held_out_left),
        ("held_out_p", law.gates.held_out_p),
        ("held_out_force_nats", law.gates.held_out_force_nats),
        ("held_out_differ_p", law.gates.held_out_differ_p),
    ];
    for (key, value) in numbers {
        if let Some(value) = value {
            made = made.with(key, value);
        }
    }
    Ok(made)
}
