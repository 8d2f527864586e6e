//! Diagnosis of what is driven by a measured motion: an arm, whose torques are computed and not simulated forwards.
//!
//! ```text
//! logs → tune → derivatives by every coefficient at once → the best effect, fitted → again beside it → is the rest noise?
//! ```
//!
//! Nothing here goes its own way after a start, so that predictions are all but linear in every coefficient: one set of
//! derivatives serves every candidate, and what bends (an encoder's offset, a gear's twist) is fitted by a few steps more.
//!
//! | file | what |
//! |---|---|
//! | `logs` | the recordings, predictions, derivatives |
//! | `fit` | weighted least squares over some of the coefficients, within their bounds |
//! | `choose` | forward, pruned, with what could stand in each effect's place |
//! | `certain` | of those, what nothing else could be, where something is left in any case |
//! | `judge` | whether the rest is noise, or small enough; verdict |
//! | `answer` | the diagnosis in words and numbers |
//! | `experiment` | what to record next |

mod answer;
mod certain;
mod choose;
mod experiment;
mod fit;
mod judge;
mod logs;

use crate::Result;
use crate::diagnose::input::{Progress, Recording, Settings, Subject};
use crate::diagnose::{Diagnosis, Use};
use crate::findings;
use crate::observation::Note;
use choose::Chosen;
use logs::Logs;

/// As [`diagnose`](crate::diagnose::diagnose), of recordings that were driven.
///
/// # Errors
/// As there.
pub(in crate::diagnose) fn diagnose(
    subjects: &[Subject],
    recordings: &[Recording],
    settings: &Settings,
    progress: &dyn Fn(Progress),
) -> Result<Diagnosis> {
    let mut uses: Vec<Use> = Vec::new();
    let mut logs = Logs::new(subjects, recordings, &mut uses, progress)?;
    if logs.runs.is_empty() {
        let note = Note::new(findings::RECORDINGS_NONE, "no recording can be used", "see what is noted of each");
        return Ok(answer::insufficient(uses, vec![note]));
    }
    let mut notes = Vec::new();
    if settings.set_aside && !logs.runs.iter().any(|r| r.held_out) {
        logs.set_aside()?;
        let text = "the last third of each recording is held out for validation";
        notes.push(Note::new(findings::HELD_OUT_CHOSEN, text, ""));
    }
    progress(Progress::Tuning);
    let base = logs.tuned()?;
    logs.weigh(&base)?;
    let base = logs.fit_from(&base.point, &base.active, None)?;
    progress(Progress::Scoring { candidates: logs.entries.len(), effects: 0 });
    let chosen = Chosen::search(&logs, base, settings)?;
    progress(Progress::Judging);
    let (chosen, further) = chosen.certain(&logs, settings)?;
    answer::answer(&logs, &chosen, further, settings, uses, notes)
}
