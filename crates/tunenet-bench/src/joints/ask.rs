//! The tool under test, started as a user starts it. A simulation file, a manifest and recordings are all that it gets.

use anyhow::{Context, Result};
use serde_json::Value;

use super::files::Files;
use crate::tool::{Said, answered};

/// What the tool said.
pub enum Reply {
    Answered(Answer),
    /// No answer: the last line of its errors.
    Failed(String),
}

/// What `tunenet diagnose --json` says, as far as this bench reads it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Answer {
    /// `named`, `one_of`, `none`, `unknown` or `insufficient`.
    pub verdict: String,
    pub effects: Vec<Place>,
    pub doubt: bool,
    pub rollouts: u64,
    pub seconds: f64,
}

/// An effect of the answer with what could be in its place.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Place {
    pub name: String,
    pub alternatives: Vec<String>,
    /// Whether it is a gain that is larger than stated.
    pub gain_above: bool,
}

impl Answer {
    /// # Errors
    /// Where the object is not one of `diagnose`.
    pub fn read(object: &Value) -> Result<Self> {
        let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
        let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
        // Of one joint a number, of several a list.
        let first = |value: &Value| value.as_f64().or_else(|| value[0].as_f64());
        let place = |effect: &Value| Place {
            name: text(&effect["name"]),
            alternatives: list(&effect["alternatives"]).iter().map(text).collect(),
            gain_above: first(&effect["coefficients"]["factor"]["value"]).is_some_and(|factor| factor > 1.0),
        };
        Ok(Self {
            verdict: object["verdict"].as_str().context("expected a `verdict`")?.to_owned(),
            effects: list(&object["effects"]).iter().map(place).collect(),
            doubt: !object["doubt"].is_null(),
            rollouts: object["rollouts"].as_u64().context("expected `rollouts`")?,
            seconds: object["seconds"].as_f64().context("expected `seconds`")?,
        })
    }

    /// The answer in a few words.
    pub fn words(&self) -> String {
        let place = |place: &Place| {
            let all = std::iter::once(&place.name).chain(&place.alternatives);
            let all: Vec<&str> = all.map(String::as_str).collect();
            if all.len() > 1 { format!("{{{}}}", all.join(", ")) } else { all.concat() }
        };
        let places = self.effects.iter().map(place).collect::<Vec<_>>().join(" + ");
        let doubt = if self.doubt { " (in doubt)" } else { "" };
        if places.is_empty() { self.verdict.clone() } else { format!("{places}{doubt}") }
    }
}

/// Asks the installed tool about a set.
///
/// # Errors
/// Where it cannot be started, or its files cannot be read.
pub fn ask(files: &Files) -> Result<Reply> {
    let (simulation, manifest) = (files.simulation.display().to_string(), files.manifest.display().to_string());
    let given =
        ["diagnose", "--json", "--quiet", "--jobs", "1", "--sim", simulation.as_str(), "--manifest", manifest.as_str()];
    Ok(match answered(&given, &files.folder)? {
        Said::Failed(why) => Reply::Failed(why),
        Said::Answered(object) => match Answer::read(&object) {
            Ok(answer) => Reply::Answered(answer),
            Err(error) => Reply::Failed(format!("an answer of another form: {error:#}")),
        },
    })
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn an_answer_is_read() {
        let answer = Answer::read(&json!({
            "verdict": "one_of",
            "effects": [
                { "name": "firmware_gain", "alternatives": ["duty_limit"], "coefficients": { "factor": { "value": 1.5 } } },
                { "name": "backlash", "alternatives": [], "coefficients": { "gap_rad": { "value": [0.01] } } },
            ],
            "doubt": null, "rollouts": 900, "seconds": 0.5,
        }));
        let answer = answer.unwrap();
        assert!(answer.effects[0].gain_above && !answer.effects[1].gain_above && !answer.doubt);
        assert_eq!(answer.words(), "{firmware_gain, duty_limit} + backlash");
        assert!(Answer::read(&json!({ "verdict": "none" })).is_err());
    }
}
