//! What an outcome says: the object of `--json`, the text for readers, and notes.

use serde_json::{Map, Value, json};
use tunenet_core::tune::{Iteration, Outcome, Region, Verdict};

use super::SCHEMA;
use super::model::Chosen;
use super::written::is_written;
use crate::answers::tune::{forced, reason};
use crate::args::Tune;
use crate::files::names;
use crate::view::answer::Printout;
use crate::view::json;
use crate::view::text::{between, four_digits, in_words, list, note, rounded, stage, tally, verbose};

/// The object of `--json`.
pub fn as_json(outcome: &Outcome, chosen: &Chosen, seconds: f64) -> Value {
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
        "model": chosen.json(),
        "iterations": iterations,
        "stop": outcome.stop,
        "gap": outcome.gap.as_ref().map(|g| json!({
            "unit": g.unit, "before": g.before, "after": g.after, "noise_floor": g.noise_floor,
        })),
        "estimated": outcome.nuisances.iter().map(|own| {
            own.iter().map(|p| json!({ "name": p.name, "value": p.value, "unit": p.unit })).collect::<Vec<_>>()
        }).collect::<Vec<_>>(),
        "preflight": outcome.preflight,
        "forced": forced(outcome),
        "rollouts": outcome.rollouts,
        "seconds": seconds,
        "warnings": outcome.notes.iter().map(json::warning).collect::<Vec<_>>(),
    });
    if outcome.correlation.nrows() > 1 {
        let rows: Vec<Vec<f64>> = outcome.correlation.row_iter().map(|r| r.iter().copied().collect()).collect();
        object["correlation"] = json!({ "parameters": outcome.free, "matrix": rows });
    }
    if let Some(region) = &outcome.region95 {
        object["region95"] = region_json(region);
    }
    object
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

/// The verdict in one sentence.
pub fn sentence(outcome: &Outcome) -> String {
    let word = match outcome.verdict {
        Verdict::Tuned => "TUNED",
        Verdict::Rejected => "REJECTED",
        Verdict::PoorFit => "POOR FIT",
        Verdict::NotIdentifiable => "NOT IDENTIFIABLE",
    };
    let values: Vec<String> = outcome
        .parameters
        .iter()
        .map(|p| {
            let (low, high) = p.interval95;
            let half = (high - low) / 2.0;
            let unit = if p.unit == "1" { String::new() } else { format!(" {}", p.unit) };
            if p.identified {
                let range = between(&rounded(low, half), &rounded(high, half));
                let before = four_digits(p.before);
                format!("{} {}{unit} (95 %: {range}), was {before}", p.name, rounded(p.value, half))
            } else {
                format!("{} unknown", p.name)
            }
        })
        .collect();
    let reason = reason(outcome);
    let forced = if forced(outcome) { "FORCED, " } else { "" };
    match (values.is_empty(), reason) {
        (true, Some(note)) => format!("{word}  {}", note.text),
        (false, Some(note)) => format!("{forced}{word}  {}: {}", values.join(", "), note.text),
        _ => format!("{forced}{word}  {}", values.join(", ")),
    }
}

/// Which checks the recordings passed and which network was used, on standard error.
pub fn render_start(options: &Tune, outcome: &Outcome, chosen: &Chosen) {
    for (path, checks) in options.observation.iter().zip(&outcome.preflight).filter(|(_, checks)| !checks.is_empty()) {
        let which = if options.observation.len() > 1 { format!("{}: ", names::file_name(path)) } else { String::new() };
        stage("checked", &format!("{which}{}", tally(checks)));
    }
    chosen.render();
    note("");
}

/// The answer for readers.
pub fn printout(outcome: &Outcome) -> Printout {
    let mut shown = Printout::default();
    shown.verdict(&sentence(outcome));
    if let Some(gap) = &outcome.gap {
        let unit = &gap.unit;
        let (before, after, floor) =
            (in_words(gap.before, unit), in_words(gap.after, unit), in_words(gap.noise_floor, unit));
        let rows = [
            vec!["gap (RMS)".into(), "before".into(), "after".into(), "noise floor".into()],
            vec![String::new(), before, after, floor],
        ];
        shown.table(&rows);
        shown.line("");
    }
    for own in outcome.nuisances.iter().filter(|own| !own.is_empty()) {
        let each: Vec<String> = own.iter().map(|p| format!("{} {}", p.name, in_words(p.value, &p.unit))).collect();
        shown.line(&list("  also from the data:", &each));
    }
    if verbose() {
        shown.table(&iterations(outcome));
    }
    shown.warn_all(&outcome.notes);
    shown
}

/// The parameters and the RMSE of every iteration.
fn iterations(outcome: &Outcome) -> Vec<Vec<String>> {
    let head = ["iteration".to_owned(), "RMSE".to_owned()].into_iter().chain(outcome.free.iter().cloned());
    let row = |i: &Iteration| {
        let values = i.parameters.iter().copied().map(four_digits);
        [i.k.to_string(), four_digits(i.rmse)].into_iter().chain(values).collect()
    };
    std::iter::once(head.collect()).chain(outcome.iterations.iter().map(row)).collect()
}

/// What was written, and what it cost, on standard error.
pub fn render_end(options: &Tune, outcome: &Outcome, seconds: f64) {
    let wrote = match &options.out {
        Some(out) if is_written(outcome) => format!("wrote {}, ", out.display()),
        Some(out) => format!("{} not written, since nothing was tuned; ", out.display()),
        None => String::new(),
    };
    note(&format!("{wrote}{} rollouts, {seconds:.1} s, seed {}", outcome.rollouts, options.common.seed));
}
