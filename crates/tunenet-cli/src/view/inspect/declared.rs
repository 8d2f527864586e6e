//! What `inspect` says of the inputs, initial states and candidates that a simulation file declares.

use anyhow::Result;
use serde_json::{Value, json};
use tunenet_sim::scene::{First, Input, Start, StartValue};
use tunenet_sim::{SimulationFile, declared};

use crate::view::answer::Printout;

/// In words: what is predicted, what drives it, and where it starts.
pub fn show(file: &SimulationFile, shown: &mut Printout) {
    let listed = |names: Vec<String>| names.join(", ");
    let headers = file.headers();
    if !headers.is_empty() {
        shown.row("predicts", &listed(headers));
    }
    if file.inputs().len() > 0 {
        shown.row("inputs", &listed(file.inputs().map(|(name, input)| described_input(name, input)).collect()));
    }
    if file.starts().len() > 0 {
        shown.row("starts", &listed(file.starts().map(|(name, start)| described_start(name, start)).collect()));
    }
    if file.candidates().len() > 0 {
        shown.row("candidates", &listed(file.candidates().map(|(name, _)| name.to_owned()).collect()));
    }
}

/// The same as keys.
pub fn add_to(file: &SimulationFile, object: &mut Value) -> Result<()> {
    let channels = declared::channels(file)?;
    if channels.is_empty() {
        return Ok(());
    }
    object["channels"] = channels.iter().map(tunenet_core::observation::Channel::header).collect();
    let input = |(name, input): (&str, &Input)| {
        let unit = input.channel(name).map(|channel| channel.unit);
        json!({ "name": name, "unit": unit, "hold": input.hold.word(), "default": input.default })
    };
    object["inputs"] = file.inputs().map(input).collect();
    let start = |(name, start): (&str, &Start)| {
        let value = match start.value {
            StartValue::Number(value) => json!(value),
            StartValue::Word(First::First) => json!("first"),
        };
        json!({ "name": name, "value": value, "sd": start.sd, "min": start.min, "max": start.max })
    };
    object["starts"] = file.starts().map(start).collect();
    object["candidates"] = file.candidates().map(|(name, _)| name).collect();
    Ok(())
}

fn described_input(name: &str, input: &Input) -> String {
    let column = input.column.as_ref().map_or_else(String::new, |column| format!(" (column `{column}`)"));
    let default = input.default.map_or_else(String::new, |default| format!(" (default {default})"));
    format!("{name}{column}{default}")
}

fn described_start(name: &str, start: &Start) -> String {
    let value = match start.value {
        StartValue::Number(value) => value.to_string(),
        StartValue::Word(First::First) => "first sample".into(),
    };
    let how = match (start.sd, start.min.zip(start.max)) {
        (Some(sd), _) => format!(", estimated with prior ±{sd}"),
        (None, Some((min, max))) => format!(", estimated within {min} to {max}"),
        (None, None) => String::new(),
    };
    format!("{name} = {value}{how}")
}
