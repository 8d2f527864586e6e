//! Which column of a recording says whether motors are on.

use serde_json::{Value, json};
use tunenet_core::observation::plain;
use tunenet_formats::NamedColumn;
use tunenet_sim::simulation_file::LogColumn;

use crate::view::text::stage;

/// What such a column is called.
const NAMES: [&str; 8] = [
    "torque_on",
    "torque_enable",
    "torque_enabled",
    "motor_on",
    "motor_enable",
    "motor_enabled",
    "motors_on",
    "motors_enabled",
];

/// The only column that says by its name whether motors are on.
pub fn switch(found: &[NamedColumn]) -> Option<LogColumn> {
    let mut all = found.iter().filter(|column| NAMES.contains(&plain(&column.name).as_str()));
    let one = all.next()?;
    all.next().is_none().then(|| LogColumn { column: one.name.clone(), topic: one.topic.clone() })
}

/// Prints which column it is.
pub fn show(switch: Option<&LogColumn>) {
    if let Some(LogColumn { column, .. }) = switch {
        stage("motors", &format!("released where {column} is 0"));
    }
}

/// As an object, or null.
pub fn object(switch: Option<&LogColumn>) -> Value {
    switch.map_or(Value::Null, |LogColumn { column, topic }| json!({ "column": column, "topic": topic }))
}
