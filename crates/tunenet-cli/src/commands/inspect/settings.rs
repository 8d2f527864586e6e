//! What a TOML file is: a simulation, the task of a shot, or a manifest of recordings.

use std::path::Path;

use anyhow::Result;
use serde_json::{Value, json};
use toml_edit::DocumentMut;
use tunenet_formats::read_text;
use tunenet_sim::shot::Task;
use tunenet_sim::simulation_file::Domain;
use tunenet_sim::{SimulationFile, process};

use crate::view::answer::Printout;
use crate::view::inspect::declared;

/// Looks into it; what is none of these is refused as a simulation file.
pub fn look(path: &Path, shown: &mut Printout) -> Result<Value> {
    let text = read_text(path)?;
    let document = text.parse::<DocumentMut>().unwrap_or_default();
    if document.get("kind").and_then(|kind| kind.as_str()) == Some("shot") {
        let task = Task::read(path)?;
        let [low, high] = [task.release.heights_m.0, task.release.heights_m.1];
        shown.row("task", "of a shot");
        shown.row(
            "usable",
            &format!("plan a release from {low} to {high} m: `tunenet plan --sim TUNED.toml --task` with this file"),
        );
        return Ok(json!({ "kind": "task", "for": "plan a shot", "heights_m": [low, high], "warnings": [] }));
    }
    if let Some(observations) = document.get("observation").and_then(|all| all.as_array_of_tables()) {
        shown.row("manifest", &format!("of {} recordings", observations.len()));
        shown.row("usable", "diagnose them together: `tunenet diagnose --sim FILE.toml --manifest` with this file");
        return Ok(
            json!({ "kind": "manifest", "for": "diagnose", "observations": observations.len(), "warnings": [] }),
        );
    }
    simulation(&SimulationFile::read(path)?, shown)
}

fn simulation(file: &SimulationFile, shown: &mut Printout) -> Result<Value> {
    let parameters = file.parameters()?;
    let rows: Vec<Vec<String>> = parameters
        .iter()
        .map(|p| {
            let tuned = if p.tune { "tuned" } else { "fixed" };
            vec![p.name.clone(), p.value.to_string(), format!("{} to {}", p.min, p.max), p.unit.clone(), tuned.into()]
        })
        .collect();
    let program = (file.domain() == Domain::Process).then(|| process::command(file));
    match &program {
        Some(program) => {
            shown.row("process", &format!("a simulation file that runs {program}, only with `--allow-process`"));
        }
        None => shown.row(file.domain().name(), "a simulation file"),
    }
    shown.table(&rows);
    let mut object = json!({
        "kind": "simulation",
        "parameters": parameters.iter().map(|p| json!({
            "name": p.name, "value": p.value, "min": p.min, "max": p.max, "unit": p.unit, "tune": p.tune,
        })).collect::<Vec<_>>(),
        "warnings": [],
    });
    if program.is_some() {
        object["command"] = process::words(file).into();
    }
    if file.domain().declares() {
        declared::show(file, shown);
        declared::add_to(file, &mut object)?;
    }
    Ok(object)
}
