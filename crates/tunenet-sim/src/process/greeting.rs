//! The first line that a program reads, and which version of the protocol it answers with.

use serde_json::{Value as Json, json};

use super::program::Program;
use super::protocol::{Wrong, quoted, said, start, wrong};
use super::version::Version;

/// The first line that a program reads.
pub(super) fn greeting(program: &Program, version: Version) -> Vec<u8> {
    let parameters: Vec<Json> = program.parameters.iter().map(|p| json!({ "name": p.name, "unit": p.unit })).collect();
    let line = match version {
        Version::One => json!({
            "tunenet": 1, "channels": program.headers, "parameters": parameters, "settings": program.settings[0],
        }),
        Version::Two => {
            let coefficient =
                |c: &tunenet_core::simulator::Coefficient| json!({ "key": c.key, "unit": c.unit, "absent": c.absent });
            let effects = program.candidates.iter().map(|effect| {
                let coefficients: Vec<Json> = effect.coefficients.iter().map(coefficient).collect();
                json!({ "name": effect.name, "coefficients": coefficients })
            });
            let inputs = program.inputs.iter();
            let inputs = inputs.map(|i| json!({ "name": i.name, "unit": i.unit, "hold": i.hold.word() }));
            json!({
                "tunenet": 2, "channels": program.headers, "parameters": parameters,
                "effects": effects.collect::<Vec<_>>(), "inputs": inputs.collect::<Vec<_>>(),
                "states": program.states, "settings": program.settings[0],
            })
        }
    };
    format!("{line}\n").into_bytes()
}

/// What a program answered instead.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Older {
    /// For users.
    pub found: String,
    /// Whether it is an error: it may not be about the version.
    pub error: bool,
}

/// What a program answers to the greeting of a version.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Greeted {
    /// It speaks this version.
    Yes,
    /// It may speak an older one, or cannot work at all.
    Older(Older),
}

/// What a program answers to the greeting of `version`.
pub(super) fn greeted(line: &[u8], version: Version) -> Result<Greeted, Wrong> {
    let number = version.number();
    let answer = said(line)?;
    if let Some(error) = answer.error.filter(|error| !error.is_null()) {
        let found = format!("the error {}", quoted(&error));
        return match version {
            Version::Two => Ok(Greeted::Older(Older { found, error: true })),
            Version::One => wrong(&format!("`{{\"tunenet\":{number}}}`"), &found, "see what it says"),
        };
    }
    match answer.tunenet {
        Some(found) if found == number => Ok(Greeted::Yes),
        Some(found) if version == Version::Two && found == 1 => {
            Ok(Greeted::Older(Older { found: "`{\"tunenet\":1}`".into(), error: false }))
        }
        Some(other) => wrong(&format!("protocol {number}"), &quoted(&other), "see docs/process.md for what is spoken"),
        None => wrong(
            &format!("`{{\"tunenet\":{number}}}`"),
            &format!("`{}`", start(line)),
            "answer the first line with it, before any rollout",
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_greeting_names_the_version() {
        assert_eq!(greeted(br#"{"tunenet":2,"name":"bouncer"}"#, Version::Two), Ok(Greeted::Yes));
        assert_eq!(greeted(br#"{"tunenet":1}"#, Version::One), Ok(Greeted::Yes));
        for older in [&br#"{"tunenet":1}"#[..], br#"{"error":"protocol 2?"}"#] {
            assert!(matches!(greeted(older, Version::Two), Ok(Greeted::Older(_))));
        }
        for (line, expected) in [
            (r#"{"tunenet":3}"#, "expected protocol 2, found 3"),
            (r#"{"hello":1}"#, "found `{\"hello\":1}`"),
            ("Traceback", "found `Traceback`"),
        ] {
            let message = greeted(line.as_bytes(), Version::Two).unwrap_err().message;
            assert!(message.contains(expected), "{message}");
        }
        let message = greeted(br#"{"error":"no mesh"}"#, Version::One).unwrap_err().message;
        assert!(message.contains("the error \u{201c}no mesh\u{201d}"), "{message}");
    }
}
