//! An observation from a text table.

use std::path::Path;

use super::bounces::doubt;
use super::scan::{Scan, scan};
use crate::findings;
use crate::quantity::Quantity;
use crate::recording::{ReadOptions, Recording};
use crate::{Error, Result};
use tunenet_core::observation::{FEWEST_SAMPLES, Kind, Note, Observation};

pub(crate) fn read(path: &Path, options: &ReadOptions) -> Result<Recording> {
    let scan = scan(path, options)?;
    scan.check(options.skip_broken)?;
    let mut notes = scan.notes();
    let samples = scan.values.len() / scan.layout.channels.len();
    if samples < FEWEST_SAMPLES {
        let message = format!("expected at least {FEWEST_SAMPLES} samples, found {samples}");
        return Err(Error::file(path, message, "record for longer"));
    }
    if scan.layout.kind == Kind::EventTimes {
        let observation = bounce_times(path, scan, &mut notes)?;
        return Ok(Recording { observation, notes });
    }
    let Scan { layout, clock, values, .. } = scan;
    let observation = Observation::new(layout.kind, layout.channels, clock, values)?;
    Ok(Recording { observation, notes })
}

/// Most impacts of one list that are fitted. What a rollout costs grows with them, and each of a longer list has lost next to
/// nothing against the one before.
const MOST_BOUNCES: usize = 2_000;

/// Numbered impacts are taken as they are; without numbers the list ends where counting would go wrong.
fn bounce_times(path: &Path, scan: Scan, notes: &mut Vec<Note>) -> Result<Observation> {
    let Scan { layout, mut clock, mut values, lines, .. } = scan;
    let all = values.len();
    if all > MOST_BOUNCES {
        let text = format!("the first {MOST_BOUNCES} of {all} impacts are used: more would not sharpen the answer");
        notes.push(Note::new(findings::BOUNCES_MANY, text, ""));
        values.truncate(MOST_BOUNCES);
        clock.truncate(MOST_BOUNCES);
    }
    if layout.clock.is_some() {
        return Ok(Observation::new(layout.kind, layout.channels, clock, values)?);
    }
    if let Some(doubt) = doubt(&values) {
        let text = format!(
            "the interval before line {} is {:.4} s after one of {:.4} s, so a click was missed or false: \
             {} excluded",
            lines[doubt.from],
            doubt.interval_s,
            doubt.before_s,
            match values.len() - doubt.from - 1 {
                0 => "that time is".into(),
                after => format!("that time and the {after} after it are"),
            }
        );
        notes.push(Note::new(
            findings::BOUNCES_MISSED,
            text,
            "number the impacts in a column `bounce_number` to use them",
        ));
        values.truncate(doubt.from);
        if values.len() < FEWEST_SAMPLES {
            let message = format!(
                "expected at least {FEWEST_SAMPLES} impacts in a row, found {} before the missed or false click at line {}",
                values.len(),
                lines[doubt.from]
            );
            let hint = "delete the false times, or number the impacts in a column `bounce_number`";
            return Err(Error::file(path, message, hint));
        }
    }
    Ok(Observation::event_times(&Quantity::BounceTime.channel().name, values)?)
}
