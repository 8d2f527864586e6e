//! Units that differ from the column's name, detected by the apparent gravity.

use super::Expected;
use super::gravity::ApparentGravity;
use crate::findings;
use tunenet_core::finding::FindingKind;
use tunenet_core::observation::{Check, three_digits};

/// How many times too large a length is where it stands in this unit instead of metres.
const LENGTHS: [(&str, &str, f64); 5] = [
    ("millimetres", "z_mm", 1000.0),
    ("centimetres", "z_cm", 100.0),
    ("inches", "", 1.0 / 0.0254),
    ("feet", "", 1.0 / 0.3048),
    ("kilometres", "", 0.001),
];
/// How many times too large a time is where it stands in this unit instead of seconds.
const TIMES: [(&str, &str, f64); 3] =
    [("milliseconds", "t_ms", 1e3), ("microseconds", "t_us", 1e6), ("nanoseconds", "t_ns", 1e9)];
/// A unit is named where its factor agrees to this share, air and errors of scale included ...
const AGREES: f64 = 0.12;
/// ... and for factors far from any other cause to this one: air may halve the fall.
const AGREES_FAR: f64 = 0.75;

/// Whether lengths stand in metres and times in seconds.
pub(crate) fn check(found: Option<&ApparentGravity>, expected: &Expected) -> Check {
    const KIND: FindingKind = findings::UNITS_WRONG;
    let Some(found) = found else {
        return Check::not_run(KIND, "no free flight is long enough to check the units");
    };
    let ratio = found.value_m_s2 / expected.gravity_m_s2;
    if !found.implausible(expected.gravity_m_s2) {
        return Check::passed(KIND, "lengths are in metres and times in seconds");
    }
    let lengths =
        LENGTHS.iter().map(|(unit, column, factor)| (format!("lengths are in {unit}, not metres"), *column, *factor));
    let times = TIMES
        .iter()
        .map(|(unit, column, factor)| (format!("times are in {unit}, not seconds"), *column, factor.powi(-2)));
    let both = TIMES.iter().flat_map(|(time, _, t)| {
        LENGTHS[..2].iter().map(move |(length, column, l)| {
            (format!("lengths are in {length} and times in {time}"), *column, l / t.powi(2))
        })
    });
    let near = |factor: f64| {
        let far = !(0.05..20.0).contains(&factor);
        (ratio / factor).ln().abs() < if far { AGREES_FAR } else { AGREES }
    };
    let best = lengths
        .chain(times)
        .chain(both)
        .filter(|c| near(c.2))
        .min_by(|a, b| (ratio / a.2).ln().abs().total_cmp(&(ratio / b.2).ln().abs()));
    match best {
        Some((unit, column, _)) => {
            let text = format!(
                "{unit}: the acceleration of free flight is {} m/s², {} times the expected one",
                three_digits(found.value_m_s2),
                three_digits(ratio)
            );
            let remedy = if column.is_empty() {
                "convert the columns to metres".into()
            } else {
                let unit = column.split_once('_').map_or("", |(_, unit)| unit);
                if column.starts_with('t') {
                    format!(
                        "put the unit into the column's name, such as `{column}`, or map it: `--columns {column}=NAME`"
                    )
                } else {
                    format!(
                        "put the unit into the names of all lengths, such as `{column}`, or map every one of them: \
                         `--columns x_{unit}=NAME,y_{unit}=NAME,z_{unit}=NAME`"
                    )
                }
            };
            Check::failed(KIND, text, remedy)
        }
        None => Check::passed(KIND, "no common unit explains the fall"),
    }
}
