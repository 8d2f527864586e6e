//! A simulator of any language: a program that speaks lines of JSON.
//!
//! ```text
//! simulation file → Program → Pool of Children ⇄ protocol (one line asks, one line answers)
//! ```
//!
//! | file | subject |
//! |---|---|
//! | `program` | what a simulation file says of the program |
//! | `protocol` | what is said to it, and what may be answered |
//! | `pipes` | reading what it prints, within limits |
//! | `child` | one of it that runs |
//! | `pool` | as many of it as threads ask, which have to agree |
//! | `known` | what one answered, and has to answer again |
//! | `session` | permission to run programs, those that run, their failure and their tally |
//! | `tally` | rollouts that were asked for, refused, or answered unusably |
//! | `failure` | what could go wrong, in one sentence |
//!
//! The program is never trusted with more than its answers: lines have a greatest length, answers a time, and numbers a place.
//! Running it at all needs [permission](Permission), which the caller gives and no file can.

mod child;
mod failure;
mod known;
mod pipes;
mod pool;
mod program;
mod protocol;
mod session;
mod tally;

use std::sync::Arc;

use tunenet_core::observation::{Channel, GREATEST, Kind, Observation};
use tunenet_core::simulator::{Effect, Parameter, Preparation, Prepared, RolloutError, RolloutResult, Simulator};
use tunenet_core::text::visible;
use tunenet_core::{Error, Origin, Result};

use crate::SimulationFile;
use pool::Pool;
use program::Program;
use protocol::Answer;
use tally::Why;

pub use program::{channels, words};
pub use session::{Permission, Session};

/// The whole command that `file` names, word by word in the quotes that a shell needs, between backquotes and fit for a
/// terminal.
#[must_use]
pub fn command(file: &SimulationFile) -> String {
    format!("`{}`", visible(&program::line(&program::words(file))))
}

/// A custom program as a simulator that core can tune and diagnose.
///
/// Rollouts ask one running copy of the program each, of which there are as many as threads ask at a time. The same parameters
/// give the same bits whichever copy answers: every copy is asked the same first, and has to answer as the others did; and an
/// early rollout is asked for again now and then, and [in the end](Session::settle).
#[derive(Debug, Clone)]
pub struct ProcessSimulator {
    parameters: Vec<Parameter>,
    channels: Vec<Channel>,
    pool: Arc<Pool>,
    session: Session,
}

impl ProcessSimulator {
    /// Starts the program that `file` names, in its [folder](SimulationFile::program_folder) and within `session`, which counts
    /// its rollouts and keeps its failure.
    ///
    /// # Errors
    /// [`Error::Setting`] where `session` has no [permission](Permission) to run it;
    /// [`File`](tunenet_formats::Error::File) where the file describes no program, where a program of the session
    /// failed before, or where the program cannot be started or does not speak as it should.
    pub fn start(file: &SimulationFile, session: &Session) -> tunenet_formats::Result<Self> {
        file.process()?;
        session.require_permission(file)?;
        session.failed()?;
        let program = Program::of(file)?;
        let (parameters, channels) = (program.parameters.clone(), program.channels.clone());
        let pool = Arc::new(Pool::start(program).map_err(|failure| failure.error(file.path()))?);
        session.watch(&pool);
        Ok(Self { parameters, channels, pool, session: session.clone() })
    }
}

impl Simulator for ProcessSimulator {
    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn kind(&self) -> Kind {
        Kind::Other
    }

    fn prepare(&self, seen: &Observation) -> Result<Preparation> {
        if seen.kind() != Kind::Other || seen.channels() != self.channels {
            let names = |channels: &[Channel]| channels.iter().map(Channel::header).collect::<Vec<_>>().join(", ");
            return Err(Error::Observation {
                what: "the channels".into(),
                expected: names(&self.channels),
                found: names(seen.channels()),
            });
        }
        Ok(Preparation::Usable(Box::new(Prepared::whole(seen.clone(), self.parameters.len()))))
    }

    /// None: what the program leaves out is unknown. Effects of the measurement are applied around it.
    fn effects(&self) -> Vec<Effect> {
        Vec::new()
    }

    fn with_effects(&self, names: &[&str]) -> Result<Box<dyn Simulator>> {
        if names.is_empty() {
            return Ok(Box::new(self.clone()));
        }
        let expected = "effects of the measurement, since a program has no others".into();
        Err(Error::Setting { origin: Origin::Caller, name: "effects", expected, found: names.join(", ") })
    }

    fn rollout(&self, parameters: &[f64], _nuisances: &[f64], clock: &[f64], values: &mut [f64]) -> RolloutResult {
        // A step that lost its way is no rollout, and no fault of the program.
        if !parameters.iter().chain(clock).all(|number| number.is_finite()) {
            return Err("parameters and times have to be finite".into());
        }
        let tally = self.session.tally();
        let answer = self.pool.ask(parameters, clock);
        if answer.is_ok() {
            tally.asked();
        }
        match answer {
            Ok(Answer::Values(answered)) if answered.len() == values.len() => {
                // Whoever asked refuses them as well: here it is known whose they are.
                if let Some(i) = answered.iter().position(|value| value.abs() > GREATEST) {
                    let (row, channel) = (i / self.channels.len() + 1, &self.channels[i % self.channels.len()]);
                    let what = format!("{:?} for `{}` in row {row}", answered[i], channel.header());
                    tally.lacks(Why::Beyond, &self.parameters, parameters, &what);
                }
                values.copy_from_slice(&answered);
                Ok(())
            }
            // Its length was held against the request already.
            Ok(Answer::Values(answered)) => {
                Err(format!("expected {} numbers, found {}", values.len(), answered.len()).into())
            }
            Ok(Answer::Refused(message)) => {
                tally.lacks(Why::Refused, &self.parameters, parameters, &message);
                Err(message.into())
            }
            Err(failure) => {
                self.session.note(self.pool.file(), &failure);
                Err(RolloutError::Broken(failure.message))
            }
        }
    }
}
