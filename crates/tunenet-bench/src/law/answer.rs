//! What `tunenet diagnose --law --json` says, as far as this bench reads it.

use anyhow::{Context, Result};
use serde_json::Value;

#[derive(Debug, Clone, Default, PartialEq)]
pub struct Answer {
    /// `law`, `named`, `one_of`, `none`, `unknown` or `insufficient`.
    pub verdict: String,
    /// The search's own verdict, and why it refused, in a word.
    pub law_verdict: String,
    pub reason: Option<String>,
    pub members: Vec<Member>,
    /// Laws that a gate refused, with the gate.
    pub refused: Vec<Refused>,
    /// Effects of the catalogue: those of the answer, and those left to choose from.
    pub effects: Vec<Effect>,
    pub candidates: Vec<String>,
    /// Of the catalogue and of the search together.
    pub rollouts: u64,
    pub seconds: f64,
}

/// A law of the answer.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Member {
    pub text: String,
    pub terms: Vec<SaidTerm>,
}

#[derive(Debug, Clone, Default, PartialEq)]
pub struct SaidTerm {
    pub directions: Vec<String>,
    pub factors: Vec<SaidFactor>,
    pub coefficients: Vec<SaidConstant>,
}

#[derive(Debug, Clone, Default, PartialEq)]
pub struct SaidFactor {
    pub kind: String,
    pub variable: String,
    pub constants: Vec<SaidConstant>,
}

/// A constant within a factor, with its role, or a coefficient, with its direction.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SaidConstant {
    pub key: String,
    pub role: String,
    pub direction: String,
    pub value: f64,
    /// `None` where an end is no number.
    pub interval95: Option<[f64; 2]>,
    pub fixed: bool,
}

#[derive(Debug, Clone, Default, PartialEq)]
pub struct Refused {
    pub text: String,
    pub gate: String,
}

/// An effect of the catalogue with its coefficients.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Effect {
    pub name: String,
    pub coefficients: Vec<SaidConstant>,
}

fn text(value: &Value) -> String {
    value.as_str().unwrap_or_default().to_owned()
}

fn all<T>(list: &Value, one: impl Fn(&Value) -> T) -> Vec<T> {
    list.as_array().into_iter().flatten().map(one).collect()
}

impl Answer {
    /// # Errors
    /// Where the object is not one of `diagnose`.
    pub fn read(object: &Value) -> Result<Self> {
        let law = &object["law"];
        let counted = |key: &str| object[key].as_f64().with_context(|| format!("expected `{key}`"));
        Ok(Self {
            verdict: object["verdict"].as_str().context("expected a `verdict`")?.to_owned(),
            law_verdict: text(&law["verdict"]),
            reason: law["reason"].as_str().map(str::to_owned),
            members: all(&law["members"], member),
            refused: all(&law["refused"], |one| Refused { text: text(&one["text"]), gate: text(&one["gate"]) }),
            effects: all(&object["effects"], effect),
            candidates: all(&object["candidates"], text),
            rollouts: object["rollouts"].as_u64().context("expected `rollouts`")?,
            seconds: counted("seconds")? + law["seconds"].as_f64().unwrap_or(0.0),
        })
    }

    /// Whether one answer is given: a formula, or effects of the catalogue.
    pub fn alone(&self) -> bool {
        matches!(self.verdict.as_str(), "law" | "named")
    }

    /// Whether the answer is what the search found, and not the catalogue's: a law that equals an effect of the catalogue counts only
    /// where the catalogue has no answer.
    pub fn by_law(&self) -> bool {
        match self.law_verdict.as_str() {
            "law" | "one_of" => matches!(self.verdict.as_str(), "law" | "one_of"),
            "named" => self.effects.is_empty() && !self.members.is_empty(),
            _ => false,
        }
    }

    /// The answer in a few words.
    pub fn words(&self) -> String {
        let laws = self.members.iter().map(|member| member.text.as_str()).collect::<Vec<_>>().join("; ");
        let names: Vec<&str> = self.effects.iter().map(|effect| effect.name.as_str()).collect();
        let left: Vec<&str> = self.candidates.iter().map(String::as_str).collect();
        match self.verdict.as_str() {
            "law" | "named" if self.by_law() => laws,
            "named" => names.join(" + "),
            "one_of" if self.by_law() => format!("{{{laws}}}"),
            "one_of" => format!("{{{}}}", if left.is_empty() { names } else { left }.join(", ")),
            other => self.reason.as_ref().map_or_else(|| other.to_owned(), |reason| format!("{other} ({reason})")),
        }
    }
}

fn member(object: &Value) -> Member {
    Member { text: text(&object["text"]), terms: all(&object["terms"], term) }
}

fn term(object: &Value) -> SaidTerm {
    SaidTerm {
        directions: all(&object["directions"], text),
        factors: all(&object["factors"], |one| SaidFactor {
            kind: text(&one["kind"]),
            variable: text(&one["variable"]),
            constants: all(&one["constants"], constant),
        }),
        coefficients: all(&object["coefficients"], constant),
    }
}

fn constant(object: &Value) -> SaidConstant {
    let ends: Vec<f64> = object["interval95"].as_array().into_iter().flatten().filter_map(Value::as_f64).collect();
    SaidConstant {
        key: text(&object["key"]),
        role: text(&object["role"]),
        direction: text(&object["direction"]),
        value: object["value"].as_f64().unwrap_or(f64::NAN),
        interval95: ends.try_into().ok(),
        fixed: object["fixed"].as_bool().unwrap_or(false),
    }
}

fn effect(object: &Value) -> Effect {
    let coefficients = object["coefficients"].as_object().into_iter().flatten();
    Effect {
        name: text(&object["name"]),
        coefficients: coefficients.map(|(key, value)| SaidConstant { key: key.clone(), ..constant(value) }).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_law_is_read_with_its_constants() {
        let answer = Answer::read(&json!({
            "verdict": "law", "effects": [], "candidates": [], "rollouts": 8200, "seconds": 2.1,
            "law": { "verdict": "law", "reason": null, "rollouts": 100, "seconds": 1.0, "members": [{ "text": "k * speed_m_s^p along v", "terms": [{
                "formula": "k * speed_m_s^p", "directions": ["v"],
                "factors": [{ "kind": "power", "variable": "speed_m_s", "constants": [
                    { "key": "p", "role": "exponent", "value": 1.5, "unit": "1", "interval95": [1.46, 1.55], "fixed": true }
                ]}],
                "coefficients": [{ "key": "k", "direction": "v", "value": -0.12, "unit": "m/s²", "interval95": [-0.13, -0.11] }]
            }]}], "refused": [{ "text": "other", "bic_gain": 1.0, "gate": "held_out" }] }
        }))
        .unwrap();
        assert!(answer.alone() && answer.words() == "k * speed_m_s^p along v");
        assert!(answer.rollouts == 8200 && (answer.seconds - 3.1).abs() < 1e-12);
        let term = &answer.members[0].terms[0];
        assert!(term.factors[0].constants[0].fixed && term.coefficients[0].interval95 == Some([-0.13, -0.11]));
        assert_eq!(answer.refused[0].gate, "held_out");
    }

    #[test]
    fn an_answer_of_the_catalogue_needs_no_law() {
        let answer = Answer::read(&json!({
            "verdict": "one_of", "rollouts": 10, "seconds": 0.1, "candidates": ["wind", "magnus"],
            "effects": [{ "name": "wind", "coefficients": { "ax_m_s2": { "value": 0.2, "unit": "m/s²", "interval95": [0.1, 0.3] } } }]
        }))
        .unwrap();
        assert_eq!(answer.words(), "{wind, magnus}");
        assert_eq!(answer.effects[0].coefficients[0].interval95, Some([0.1, 0.3]));
        assert!(Answer::read(&json!({ "rollouts": 1 })).is_err());
    }

    #[test]
    fn a_law_with_a_name_counts_where_the_catalogue_has_no_answer() {
        let said = |effects: Value| {
            let member = json!({ "text": "a * speed_m_s^2 along v", "terms": [] });
            Answer::read(&json!({
                "verdict": "one_of", "rollouts": 10, "seconds": 0.1, "candidates": ["wind"], "effects": effects,
                "law": { "verdict": "named", "members": [member] }
            }))
            .unwrap()
        };
        assert_eq!(said(json!([])).words(), "{a * speed_m_s^2 along v}");
        assert_eq!(said(json!([{ "name": "wind", "coefficients": {} }])).words(), "{wind}");
    }
}
