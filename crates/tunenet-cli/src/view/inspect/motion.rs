//! What `inspect` says of the motion of a ball.

use serde_json::{Value, json};
use tunenet_ball::preflight::ApparentGravity;
use tunenet_core::observation::{Check, Kind, State};

use crate::answers::motion::Motion;
use crate::view::answer::Printout;
use crate::view::json::warning;
use crate::view::text::{in_words, tally};

/// Adds what was found to the text.
pub fn render(motion: &Motion, shown: &mut Printout) {
    let plural = |n: usize, what: &str| if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") };
    let noise = motion.noise.map(|n| {
        let unit = if motion.kind == Kind::Positions { "m" } else { "s" };
        format!(", noise {}", in_words(n, unit))
    });
    let flights = motion.preflight.gravity.map(|g| format!("{} of free flight, ", plural(g.flights, "stretch")));
    let flights = flights.map(|text| text.replace("stretchs", "stretches"));
    let bounces = plural(motion.bounces, "bounce");
    shown.row("motion", &format!("{}{bounces}{}", flights.unwrap_or_default(), noise.unwrap_or_default()));
    if let Some(gravity) = motion.preflight.gravity {
        render_gravity(&gravity, "", motion.expected.gravity_m_s2, shown);
    }
    shown.row("checked", &tally(&motion.preflight.checks));
    for check in &motion.preflight.checks {
        match check.state {
            State::Noticed | State::Failed => check.note().iter().for_each(|note| shown.warn(note)),
            State::NotRun | State::Passed => {}
        }
    }
}

/// "3 bounces", gravity and the checks, for a table of several files.
pub fn row(motion: &Motion) -> Vec<String> {
    let gravity = motion.preflight.gravity.map_or_else(|| "-".into(), |g| g.text());
    let noticed = motion.preflight.checks.iter().filter(|c| matches!(c.state, State::Noticed | State::Failed));
    let noticed: Vec<&str> = noticed.map(|c| c.kind.code()).collect();
    let noticed = if noticed.is_empty() { "all passed".into() } else { noticed.join(", ") };
    vec![motion.bounces.to_string(), gravity, noticed]
}

/// Adds what was found to the object of a file.
pub fn add_to(motion: &Motion, object: &mut Value) {
    object["bounces"] = json!(motion.bounces);
    object["gravity"] = json!(motion.preflight.gravity.as_ref().map(gravity_json));
    if motion.kind == Kind::Positions {
        object["noise_m"] = json!(motion.noise);
        object["causes"] = json!(motion.causes());
    }
    object["preflight"] = json!(motion.preflight.checks);
    if let Some(warnings) = object["warnings"].as_array_mut() {
        let notes = motion.preflight.checks.iter().filter_map(Check::note);
        warnings.extend(notes.map(|note| warning(&note)));
    }
}

/// As JSON has it.
pub fn gravity_json(gravity: &ApparentGravity) -> Value {
    let (low, high) = gravity.interval95_m_s2;
    json!({
        "value_m_s2": gravity.value_m_s2, "interval95_m_s2": [low, high],
        "flights": gravity.flights, "samples": gravity.samples,
    })
}

/// "gravity  9.62 m/s² (95 %: 9.58 to 9.66), 1.9 % below 9.81".
pub fn render_gravity(gravity: &ApparentGravity, from: &str, expected: f64, shown: &mut Printout) {
    let percent = 100.0 * (gravity.value_m_s2 / expected - 1.0);
    let place = if gravity.differs(expected) {
        format!("{:.1} % {} {expected}", percent.abs(), if percent < 0.0 { "below" } else { "above" })
    } else {
        format!("{expected} expected")
    };
    shown.row("gravity", &format!("{}{from}, {place}", gravity.text()));
}
