//! As many copies of a program as threads ask at a time.

use std::path::Path;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::child::Child;
use super::failure::Failure;
use super::known::{Asked, agree, probe};
use super::program::Program;
use super::protocol::Answer;

/// After so many answers, drawn afresh each time, a copy is asked again for a rollout: one in a hundred, and few are lost to a
/// program that drifts.
const EVERY: std::ops::RangeInclusive<u32> = 50..=150;
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

/// A running copy, and what it answered since it was last held against itself.
#[derive(Debug)]
struct Running {
    child: Child,
    /// How many rollouts it answered, and how many of them since then.
    all: u32,
    since: u32,
    /// After how many answers it is held against itself.
    until: u32,
    /// One of those since, each with equal probability, and which one, from 1.
    drawn: Option<(u32, Asked)>,
    /// Draws when and what it is asked again: of every copy the same at every run, and nothing that a program could count on.
    draw: ChaCha8Rng,
}

impl Running {
    /// The copy that started as number `number`, from 0.
    fn new(child: Child, number: usize) -> Self {
        let mut draw = ChaCha8Rng::seed_from_u64(number as u64);
        let until = draw.random_range(EVERY);
        Self { child, all: 0, since: 0, until, drawn: None, draw }
    }

    /// Takes note of one more answer.
    fn answered(&mut self, parameters: &[f64], clock: &[f64], answer: &Answer) {
        (self.all, self.since) = (self.all.saturating_add(1), self.since + 1);
        // The last of n replaces the one that is kept once in n times: every one is kept with the same probability.
        if self.draw.random_range(0..self.since) == 0 {
            self.drawn = Some((self.since, Asked::new(parameters, clock, answer)));
        }
    }

    /// Refuses a copy that no longer answers `known` as it did `ago` rollouts ago.
    fn hold(&mut self, program: &Program, known: &Asked, ago: u32) -> Result<(), Failure> {
        let how = format!("asked again after {ago} other rollout{}", if ago == 1 { "" } else { "s" });
        agree(program, &mut self.child, known, &how)
    }

    /// Asks again for what was drawn of the last rollouts, unless it was the very last.
    fn hold_drawn(&mut self, program: &Program) -> Result<(), Failure> {
        match self.drawn.take() {
            Some((number, known)) if number < self.since => self.hold(program, &known, self.since - number),
            _ => Ok(()),
        }
    }

    fn begin_anew(&mut self) {
        (self.since, self.until, self.drawn) = (0, self.draw.random_range(EVERY), None);
    }
}

/// Who answers next.
enum Taken {
    Idle(Box<Running>),
    New(usize),
}

impl Pool {
    /// Starts the first copy, which is asked the same twice: the same parameters have to give the same bits.
    pub fn start(program: Program) -> Result<Self, Failure> {
        let mut first = Child::start(&program)?;
        let agreed = probe(&program, &mut first)?;
        agree(&program, &mut first, &agreed, "asked twice")?;
        let copies = Copies { idle: vec![Running::new(first, 0)], running: 1, early: None, failure: None };
        Ok(Self { program, agreed, copies: Mutex::new(copies), freed: Condvar::new() })
    }

    /// The simulation file that names the program.
    pub fn file(&self) -> &Path {
        &self.program.file
    }

    /// One rollout, by whichever copy is free. A copy that has answered many is asked once more for an early one, or for any of
    /// those since: what it keeps from rollout to rollout shows there.
    pub fn ask(&self, parameters: &[f64], clock: &[f64]) -> Result<Answer, Failure> {
        let mut copy = match self.free()? {
            Taken::Idle(copy) => *copy,
            Taken::New(number) => self.another(number).map_err(|failure| self.fail(failure))?,
        };
        let answered = copy.child.ask(&self.program, parameters, clock).and_then(|answer| {
            copy.answered(parameters, clock, &answer);
            if copy.since >= copy.until {
                // Either shows what the other does not: what it keeps for good, and what it got wrong for a while.
                if copy.draw.random() { self.hold_early(&mut copy) } else { copy.hold_drawn(&self.program) }?;
                copy.begin_anew();
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

    /// Asks every copy once more for an early rollout, and for one of its last, all at the same time. Where one is still asked
    /// for something else, the work is not at its end, and the end of it asks again.
    pub fn settle(&self) -> Result<(), Failure> {
        let mut copies = self.copies();
        if copies.idle.len() < copies.running {
            return Ok(());
        }
        let mut idle = std::mem::take(&mut copies.idle);
        drop(copies);
        let held = idle.par_iter_mut().filter(|copy| copy.since >= FEWEST).try_for_each(|copy| {
            self.hold_early(copy)?;
            copy.hold_drawn(&self.program)?;
            copy.begin_anew();
            Ok(())
        });
        self.copies().idle.append(&mut idle);
        self.freed.notify_all();
        held.map_err(|failure| self.fail(failure))
    }

    /// Refuses a copy that no longer answers an early rollout as it, or another copy, did.
    fn hold_early(&self, copy: &mut Running) -> Result<(), Failure> {
        let early = self.copies().early.clone();
        copy.hold(&self.program, early.as_deref().unwrap_or(&self.agreed), copy.all)
    }

    fn copies(&self) -> MutexGuard<'_, Copies> {
        self.copies.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A copy that is free, or the number of one more that may be started, which then counts as running.
    fn free(&self) -> Result<Taken, Failure> {
        let mut copies = self.copies();
        loop {
            if let Some(failure) = &copies.failure {
                return Err(failure.clone());
            }
            if let Some(copy) = copies.idle.pop() {
                return Ok(Taken::Idle(Box::new(copy)));
            }
            if copies.running < self.program.workers {
                copies.running += 1;
                return Ok(Taken::New(copies.running - 1));
            }
            copies = self.freed.wait(copies).unwrap_or_else(PoisonError::into_inner);
        }
    }

    fn another(&self, number: usize) -> Result<Running, Failure> {
        let mut child = Child::start(&self.program)?;
        agree(&self.program, &mut child, &self.agreed, "asked in two copies of it")?;
        Ok(Running::new(child, number))
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
