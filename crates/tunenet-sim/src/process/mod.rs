//! A simulator of any language: a program that speaks lines of JSON.
//!
//! ```text
//! simulation file → Program → Pool of Children ⇄ protocol (one line asks, one line answers)
//! ```
//!
//! | file | subject |
//! |---|---|
//! | `program` | what a simulation file says of the program |
//! | `greeting` | the first line, and which version of the protocol it speaks |
//! | `protocol` | what is said to it afterwards, and what may be answered |
//! | `request` | recordings, each announced once, and rollouts of them |
//! | `cache` | what was answered already |
//! | `pipes` | reading what it prints, within limits |
//! | `child` | one of it that runs |
//! | `pool` | as many of it as threads ask, which have to agree |
//! | `known` | what one answered, and has to answer again |
//! | `session` | permission to run programs, those that run, their failure and their tally |
//! | `version` | the versions of the protocol |
//! | `tally` | rollouts that were asked for, refused, or answered unusably |
//! | `failure` | what could go wrong, in one sentence |
//!
//! The program is never trusted with more than its answers: lines have a greatest length, answers a time, and numbers a place.
//! Running it at all needs [permission](Permission), which the caller gives and no file can.

mod cache;
mod child;
mod failure;
mod greeting;
mod known;
mod pipes;
mod pool;
mod program;
mod protocol;
mod request;
mod session;
mod tally;
mod version;

use std::sync::Arc;

use tunenet_core::observation::GREATEST;
use tunenet_core::simulator::{Declared, Model, Parameter, RolloutError, RolloutResult, Run};
use tunenet_core::text::visible;
use tunenet_formats::Result;

use crate::{SimulationFile, declared};
use pool::Pool;
use program::Program;
use protocol::Answer;
use request::Request;
use tally::Why;

pub use program::words;
pub use session::{Permission, Session};

/// The whole command that `file` names, word by word in the quotes that a shell needs, between backquotes and fit for a
/// terminal.
#[must_use]
pub fn command(file: &SimulationFile) -> String {
    format!("`{}`", visible(&program::line(&program::words(file))))
}

/// A custom program as a simulator that core can tune and diagnose, with the inputs, states and candidates that its file declares.
pub type ProcessSimulator = Declared<ProcessModel>;

/// A custom program that simulates.
///
/// Rollouts ask one running copy of the program each, of which there are as many as threads ask at a time. The same request
/// gives the same bits whichever copy answers: every copy is asked the same first, and has to answer as the others did; and an
/// early rollout is asked for again now and then, and [in the end](Session::settle). Equal requests are asked once.
#[derive(Debug, Clone)]
pub struct ProcessModel {
    /// The parameters, then the coefficients of all candidates at their absent values.
    numbers: Vec<Parameter>,
    pool: Arc<Pool>,
    session: Session,
}

/// Starts the program that `file` names, in its [folder](SimulationFile::program_folder) and within `session`, which counts
/// its rollouts and keeps its failure.
///
/// # Errors
/// As [`start_setups`].
pub fn start(file: &SimulationFile, session: &Session) -> Result<ProcessSimulator> {
    start_setups(&[file], session)
}

/// As [`start`], for recordings in several setups ([`Circumstances::setup`](tunenet_core::observation::Circumstances::setup) is a
/// position in `files`): files that differ in their settings and initial states alone.
///
/// # Errors
/// [`Setting`](tunenet_core::Error::Setting) where `session` has no [permission](Permission) to run it;
/// [`File`](tunenet_formats::Error::File) where the file describes no program, where a program of the session
/// failed before, or where the program cannot be started or does not speak as it should.
///
/// # Panics
/// Where `files` is empty.
pub fn start_setups(files: &[&SimulationFile], session: &Session) -> Result<ProcessSimulator> {
    let file = files[0];
    file.process()?;
    session.require_permission(file)?;
    session.failed()?;
    let program = Program::of(files)?;
    let (parameters, channels) = (program.parameters.clone(), program.channels.clone());
    let candidates = program.candidates.clone();
    let states = files.iter().map(|file| declared::states(file)).collect::<Result<Vec<_>>>()?;
    let mut numbers = parameters.clone();
    for effect in &candidates {
        numbers.extend(effect.parameters(None)?);
    }
    let pool = Arc::new(Pool::start(program, session.rechecked()).map_err(|failure| failure.error(file.path()))?);
    session.watch(&pool);
    let model = ProcessModel { numbers, pool, session: session.clone() };
    declared::with_candidates(Declared::new(model, parameters, channels).setups(states), file)
}

impl Model for ProcessModel {
    /// A program knows its recordings by their first instants.
    fn starts_earlier(&self) -> bool {
        false
    }

    fn simulate(&self, run: &Run, values: &mut [f64]) -> RolloutResult {
        // A step that lost its way is no rollout, and no fault of the program.
        let numbers = [run.parameters, run.coefficients].concat();
        if !numbers.iter().chain(run.start).chain(run.times_s).all(|number| number.is_finite()) {
            return Err("parameters and times have to be finite".into());
        }
        let program = self.pool.program();
        if run.recording.inputs.len() != program.inputs.len() {
            let names: Vec<String> = program.inputs.iter().map(|input| format!("`{}`", input.name)).collect();
            return Err(format!("the program needs the inputs {} of a recording", names.join(", ")).into());
        }
        let tally = self.session.tally();
        let name = &run.recording.name;
        let whose = if name.is_empty() { String::new() } else { format!(" (simulating {name})") };
        let answer = self.pool.ask(Request::of(run, self.pool.recording(run.recording)));
        let fresh = answer.as_ref().is_ok_and(|(_, fresh)| *fresh);
        if fresh {
            tally.asked();
        }
        match answer.as_ref().map(|(answer, _)| answer.as_ref()) {
            Ok(Answer::Values(answered)) if answered.len() == values.len() => {
                // Whoever asked refuses them as well: here it is known whose they are.
                if let Some(i) = answered.iter().position(|value| value.abs() > GREATEST).filter(|_| fresh) {
                    let (row, channel) = (i / program.headers.len() + 1, &program.headers[i % program.headers.len()]);
                    let what = format!("{:?} for `{channel}` in row {row}{whose}", answered[i]);
                    tally.lacks(Why::Beyond, &self.numbers, &numbers, &what);
                }
                values.copy_from_slice(answered);
                Ok(())
            }
            // Its length was held against the request already.
            Ok(Answer::Values(answered)) => {
                Err(format!("expected {} numbers, found {}", values.len(), answered.len()).into())
            }
            Ok(Answer::Refused(message)) => {
                if fresh {
                    tally.lacks(Why::Refused, &self.numbers, &numbers, &format!("{message}{whose}"));
                }
                Err(message.clone().into())
            }
            Err(failure) => {
                self.session.note(self.pool.file(), failure);
                Err(RolloutError::Broken(failure.message.clone()))
            }
        }
    }
}
