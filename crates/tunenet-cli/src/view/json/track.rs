//! The answer of `tunenet track` as JSON.

use serde::Serialize;
use serde_json::{Value, json};

const SCHEMA: &str = "tunenet.track/1";

/// The answer for scripts: what was found, behind what it was found in.
pub fn object(video: &str, verdict: &str, facts: &impl Serialize) -> serde_json::Result<Value> {
    let mut object = json!({ "schema": SCHEMA, "file": video, "verdict": verdict });
    if let (Value::Object(object), Value::Object(facts)) = (&mut object, serde_json::to_value(facts)?) {
        object.extend(facts);
    }
    Ok(object)
}
