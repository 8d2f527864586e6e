//! Parameters and gaps of a fit in one line each.

use tunenet_core::diagnose::{Change, Gap, GapOf, Tuned, Value};

use super::{four_digits, in_words, rounded};
use crate::answers::diagnose::Answer;

/// A tuned parameter with its interval and what it was.
pub fn parameter(answer: &Answer, tuned: &Tuned) -> String {
    let object = answer.loaded.objects.get(tuned.object).filter(|_| answer.loaded.objects.len() > 1);
    let object = object.map(|o| format!("{}: ", o.name)).unwrap_or_default();
    let value = Value { object: None, value: tuned.value, interval95: tuned.interval95 };
    let unit = if tuned.unit == "1" { "" } else { &tuned.unit };
    format!("{object}{} {}, was {}", tuned.name, ranged(&value, unit), four_digits(tuned.given))
}

/// How the gap shrank: on the recordings, on those held out, and of a forecast.
pub fn gap_line(gap: &Gap) -> String {
    let words = |value: f64| in_words(value, &gap.unit);
    let to = |change: &Change| format!("{} → {}", words(change.before), words(change.after));
    let of = match gap.of {
        GapOf::Recordings => "",
        GapOf::Segments => " of the flights only",
        GapOf::Events => " of the contacts only",
    };
    let mut line = format!("gap{of} {} → {}", words(gap.before), words(gap.after));
    if let Some(change) = &gap.held_out {
        line = format!("{line}, held out {}", to(change));
    }
    if let Some(change) = &gap.forecast {
        line = format!("{line}, forecast {}", to(change));
    }
    line
}

/// A value with its interval.
pub fn ranged(value: &Value, unit: &str) -> String {
    let (low, high) = value.interval95;
    let half = (high - low) / 2.0;
    let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
    let of = |v: f64| rounded(v, half);
    format!("{}{unit} (95 %: {} to {})", of(value.value), of(low), of(high))
}
