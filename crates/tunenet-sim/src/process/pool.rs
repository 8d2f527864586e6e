//! As many copies of a program as threads ask at a time.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use rayon::prelude::*;

use super::child::Child;
use super::failure::Failure;
use super::known::{Asked, agree, probe};
use super::program::Program;
use super::protocol::Answer;

/// After so many answers a copy is asked again what was asked early: one rollout in a hundred, and few are lost to a program
/// that drifts.
const EVERY: u32 = 100;
/// A copy that answered fewer than this since has not had the time to forget.
const FEWEST: u32 = 2;

/// Copies of one program that answer alike.
#[derive(Debug)]
pub(super) struct Pool {
    program: Program,
    /// What every copy is asked first, and has to answer alike.
    agreed: Asked,
    copies: Mutex<Copies>,
    freed: Condvar,
}

#[derive(Debug)]
struct Copies {
    idle: Vec<Running>,
    /// Idle or asked.
    running: usize,
    /// The first rollout that was answered with values, which is asked again now and then.
    early: Option<Arc<Asked>>,
    /// Once one has failed, no other is asked.
    failure: Option<Failure>,
}

/// A running copy, and how many rollouts it answered since it was last held against itself.
#[derive(Debug)]
struct Running {
    child: Child,
    since: u32,
}

impl Pool {
    /// Starts the first copy, which is asked the same twice: the same parameters have to give the same bits.
    pub fn start(program: Program) -> Result<Self, Failure> {
        let mut first = Child::start(&program)?;
        let agreed = probe(&program, &mut first)?;
        agree(&program, &mut first, &agreed, "asked twice")?;
        let copies = Copies { idle: vec![Running { child: first, since: 0 }], running: 1, early: None, failure: None };
        Ok(Self { program, agreed, copies: Mutex::new(copies), freed: Condvar::new() })
    }

    /// One rollout, by whichever copy is free. A copy that has answered many is asked once more for an early one: what it keeps
    /// from rollout to rollout shows there.
    pub fn ask(&self, parameters: &[f64], clock: &[f64]) -> Result<Answer, Failure> {
        let mut copy = match self.free()? {
            Some(copy) => copy,
            None => self.another().map_err(|failure| self.fail(failure))?,
        };
        let answered = copy.child.ask(&self.program, parameters, clock).and_then(|answer| {
            copy.since += 1;
            if copy.since >= EVERY {
                self.hold(&mut copy)?;
            }
            Ok(answer)
        });
        match answered {
            Ok(answer) => {
                let mut copies = self.copies();
                if copies.early.is_none() && matches!(answer, Answer::Values(_)) {
                    copies.early = Some(Arc::new(Asked::new(parameters, clock, &answer)));
                }
                copies.idle.push(copy);
                drop(copies);
                self.freed.notify_one();
                Ok(answer)
            }
            Err(failure) => {
                drop(copy);
                Err(self.fail(failure))
            }
        }
    }

    /// Asks every copy once more for an early rollout, all at the same time. Where one is still asked for something else, the work
    /// is not at its end, and whoever ends it asks.
    pub fn settle(&self) -> Result<(), Failure> {
        let mut copies = self.copies();
        if copies.idle.len() < copies.running {
            return Ok(());
        }
        let mut idle = std::mem::take(&mut copies.idle);
        drop(copies);
        let held = idle.par_iter_mut().filter(|copy| copy.since >= FEWEST).try_for_each(|copy| self.hold(copy));
        self.copies().idle.append(&mut idle);
        self.freed.notify_all();
        held.map_err(|failure| self.fail(failure))
    }

    /// Refuses a copy that no longer answers as it did.
    fn hold(&self, copy: &mut Running) -> Result<(), Failure> {
        let how = format!("asked again after {} other rollouts", copy.since);
        let early = self.copies().early.clone();
        agree(&self.program, &mut copy.child, early.as_deref().unwrap_or(&self.agreed), &how)?;
        copy.since = 0;
        Ok(())
    }

    fn copies(&self) -> MutexGuard<'_, Copies> {
        self.copies.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A copy that is free; `None` where one more may be started, which then counts as running.
    fn free(&self) -> Result<Option<Running>, Failure> {
        let mut copies = self.copies();
        loop {
            if let Some(failure) = &copies.failure {
                return Err(failure.clone());
            }
            if let Some(copy) = copies.idle.pop() {
                return Ok(Some(copy));
            }
            if copies.running < self.program.workers {
                copies.running += 1;
                return Ok(None);
            }
            copies = self.freed.wait(copies).unwrap_or_else(PoisonError::into_inner);
        }
    }

    fn another(&self) -> Result<Running, Failure> {
        let mut child = Child::start(&self.program)?;
        agree(&self.program, &mut child, &self.agreed, "asked in two copies of it")?;
        Ok(Running { child, since: 0 })
    }

    /// Keeps what went wrong first, and lets the other copies go. Whoever asks afterwards hears the same.
    fn fail(&self, failure: Failure) -> Failure {
        let (kept, idle) = {
            let mut copies = self.copies();
            let kept = copies.failure.get_or_insert(failure).clone();
            (kept, std::mem::take(&mut copies.idle))
        };
        self.freed.notify_all();
        end(idle);
        kept
    }
}

impl Drop for Pool {
    fn drop(&mut self) {
        end(std::mem::take(&mut self.copies().idle));
    }
}

/// Bids all farewell before any is waited for.
fn end(mut copies: Vec<Running>) {
    for copy in &mut copies {
        copy.child.farewell();
    }
}
