//! As many copies of a program as threads ask at a time.
//!
//! Whoever asks puts the request into a queue and waits. Whoever waits and finds a copy free takes its share of the queue to it, in
//! one line where the program knows batches, and hands out the answers.

use std::collections::VecDeque;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use tunenet_core::observation::Circumstances;

use super::cache::{Cache, Known};
use super::child::Child;
use super::failure::Failure;
use super::known::{Asked, agree};
use super::program::Program;
use super::protocol::Answer;
use super::request::{Recording, Recordings, Request};

/// After so many answers, drawn afresh each time, a copy is asked again for a rollout: one in a hundred, and few are lost to a
/// program that drifts.
const EVERY: std::ops::RangeInclusive<u32> = 50..=150;
/// A copy that answered fewer than this since has not had the time to forget.
const FEWEST: u32 = 2;
/// Most rollouts in one line.
const MOST_IN_BATCH: usize = 64;

/// Copies of one program that answer alike.
#[derive(Debug)]
pub(super) struct Pool {
    program: Program,
    state: Mutex<State>,
    changed: Condvar,
    /// Rollouts that were asked for again, to hold copies against themselves and each other.
    rechecks: Arc<AtomicU64>,
}

#[derive(Debug)]
struct State {
    recordings: Recordings,
    cache: Cache,
    /// What is to be asked.
    queue: VecDeque<Arc<Request>>,
    idle: Vec<Running>,
    /// Idle or asked.
    running: usize,
    /// What every copy is asked first, and has to answer alike; `None` before anything was asked.
    agreed: Option<Arc<Asked>>,
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
    fn answered(&mut self, request: &Arc<Request>, answer: &Answer) {
        (self.all, self.since) = (self.all.saturating_add(1), self.since + 1);
        // The last of n replaces the one that is kept once in n times: every one is kept with the same probability.
        if self.draw.random_range(0..self.since) == 0 {
            self.drawn = Some((self.since, Asked { request: Arc::clone(request), answer: answer.clone() }));
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
    /// Starts the first copy, which is asked the same twice: the same parameters have to give the same bits. `rechecks` counts what
    /// is asked again.
    pub fn start(program: Program, rechecks: Arc<AtomicU64>) -> Result<Self, Failure> {
        let mut first = Running::new(Child::start(&program)?, 0);
        let mut recordings = Recordings::default();
        let probe = program.probe.clone().map(|probe| {
            let start_s = probe.times_s.first().copied().unwrap_or(0.0);
            let recording = recordings.of(&Circumstances { start_s, ..Circumstances::default() });
            Arc::new(Request {
                recording,
                parameters: program.parameters.iter().map(|p| p.value).collect(),
                coefficients: probe.coefficients,
                start: probe.start,
                times_s: probe.times_s,
            })
        });
        let agreed = probe
            .map(|request| {
                let answer = first.child.ask(&program, &request)?;
                let asked = Asked { request, answer };
                rechecks.fetch_add(2, Ordering::Relaxed);
                agree(&program, &mut first.child, &asked, "asked twice")?;
                Ok(Arc::new(asked))
            })
            .transpose()?;
        let state = State {
            recordings,
            cache: Cache::default(),
            queue: VecDeque::new(),
            idle: vec![first],
            running: 1,
            agreed,
            early: None,
            failure: None,
        };
        Ok(Self { program, state: Mutex::new(state), changed: Condvar::new(), rechecks })
    }

    /// The program that runs.
    pub fn program(&self) -> &Program {
        &self.program
    }

    /// The simulation file that names the program.
    pub fn file(&self) -> &Path {
        &self.program.file
    }

    /// The recording with these circumstances.
    pub fn recording(&self, known: &Circumstances) -> Arc<Recording> {
        self.state().recordings.of(known)
    }

    /// One rollout, by whichever copy is free, and whether it was simulated for this request: an equal one is not asked for again.
    pub fn ask(&self, request: Request) -> Result<(Arc<Answer>, bool), Failure> {
        let request = Arc::new(request);
        let mut fresh = false;
        let mut state = self.state();
        loop {
            if let Some(failure) = &state.failure {
                return Err(failure.clone());
            }
            match state.cache.of(&request) {
                Known::Answered(answer) => return Ok((answer, fresh)),
                Known::Awaited => {}
                Known::No => {
                    fresh = true;
                    state.cache.awaits(&request);
                    state.queue.push_back(Arc::clone(&request));
                }
            }
            let taken = if state.queue.is_empty() { None } else { self.free(&mut state) };
            let Some(taken) = taken else {
                state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
                continue;
            };
            let batch = self.share(&mut state);
            let (agreed, early) = (state.agreed.clone(), state.early.clone());
            drop(state);
            let worked = self.work(taken, &batch, agreed.as_deref(), early.as_deref());
            state = self.state();
            match worked {
                Ok((copy, answers)) => Self::keep(&mut state, copy, &batch, answers),
                Err(failure) => {
                    drop(state);
                    return Err(self.fail(failure));
                }
            }
            self.changed.notify_all();
        }
    }

    /// What one copy takes of the queue, where others may take theirs.
    fn share(&self, state: &mut State) -> Vec<Arc<Request>> {
        // Before anything is agreed on, one rollout is asked for.
        let copies = 1 + state.idle.len() + self.program.workers.saturating_sub(state.running);
        let most = if state.agreed.is_none() { 1 } else { state.queue.len().div_ceil(copies).min(MOST_IN_BATCH) };
        state.queue.drain(..most).collect()
    }

    /// Asks a copy, and now and then for something that it answered already: an early rollout, or any of those since. What it keeps
    /// from rollout to rollout shows there.
    fn work(
        &self,
        taken: Taken,
        batch: &[Arc<Request>],
        agreed: Option<&Asked>,
        early: Option<&Asked>,
    ) -> Result<(Running, Vec<Answer>), Failure> {
        let mut copy = match taken {
            Taken::Idle(copy) => *copy,
            Taken::New(number) => self.another(number, agreed)?,
        };
        let answers = copy.child.ask_all(&self.program, batch)?;
        for (request, answer) in batch.iter().zip(&answers) {
            copy.answered(request, answer);
        }
        if agreed.is_none() {
            let first = Asked { request: Arc::clone(&batch[0]), answer: answers[0].clone() };
            self.again(&mut copy, &first, "asked twice")?;
        }
        if copy.since >= copy.until {
            // Either shows what the other does not: what it keeps for good, and what it got wrong for a while.
            if copy.draw.random() { self.hold_early(&mut copy, early.or(agreed)) } else { self.hold_drawn(&mut copy) }?;
            copy.begin_anew();
        }
        Ok((copy, answers))
    }

    fn keep(state: &mut State, copy: Running, batch: &[Arc<Request>], answers: Vec<Answer>) {
        for (request, answer) in batch.iter().zip(answers) {
            let asked = || Arc::new(Asked { request: Arc::clone(request), answer: answer.clone() });
            if state.agreed.is_none() {
                state.agreed = Some(asked());
            }
            if state.early.is_none() && matches!(answer, Answer::Values(_)) {
                state.early = Some(asked());
            }
            state.cache.keep(request, answer);
        }
        state.idle.push(copy);
    }

    /// Asks every copy once more for an early rollout, and for one of its last, all at the same time. Where one is still asked
    /// for something else, the work is not at its end, and the end of it asks again.
    pub fn settle(&self) -> Result<(), Failure> {
        let mut state = self.state();
        if state.idle.len() < state.running {
            return Ok(());
        }
        let mut idle = std::mem::take(&mut state.idle);
        let early = state.early.clone().or_else(|| state.agreed.clone());
        drop(state);
        let held = idle.par_iter_mut().filter(|copy| copy.since >= FEWEST).try_for_each(|copy| {
            self.hold_early(copy, early.as_deref())?;
            self.hold_drawn(copy)?;
            copy.begin_anew();
            Ok(())
        });
        self.state().idle.append(&mut idle);
        self.changed.notify_all();
        held.map_err(|failure| self.fail(failure))
    }

    /// Refuses a copy that answers `known` otherwise, `how` it was asked.
    fn again(&self, copy: &mut Running, known: &Asked, how: &str) -> Result<(), Failure> {
        self.rechecks.fetch_add(1, Ordering::Relaxed);
        agree(&self.program, &mut copy.child, known, how)
    }

    /// Refuses a copy that no longer answers `known` as it did `ago` rollouts ago.
    fn hold(&self, copy: &mut Running, known: &Asked, ago: u32) -> Result<(), Failure> {
        let how = format!("asked again after {ago} other rollout{}", if ago == 1 { "" } else { "s" });
        self.again(copy, known, &how)
    }

    /// Refuses a copy that no longer answers an early rollout as it, or another copy, did.
    fn hold_early(&self, copy: &mut Running, early: Option<&Asked>) -> Result<(), Failure> {
        early.map_or(Ok(()), |early| self.hold(copy, early, copy.all))
    }

    /// Asks again for what was drawn of the last rollouts, unless it was the very last.
    fn hold_drawn(&self, copy: &mut Running) -> Result<(), Failure> {
        match copy.drawn.take() {
            Some((number, known)) if number < copy.since => self.hold(copy, &known, copy.since - number),
            _ => Ok(()),
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A copy that is free, or the number of one more that may be started, which then counts as running.
    fn free(&self, state: &mut State) -> Option<Taken> {
        if let Some(copy) = state.idle.pop() {
            return Some(Taken::Idle(Box::new(copy)));
        }
        // Another has to answer what is agreed on as the first did.
        if state.running < self.program.workers && state.agreed.is_some() {
            state.running += 1;
            return Some(Taken::New(state.running - 1));
        }
        None
    }

    fn another(&self, number: usize, agreed: Option<&Asked>) -> Result<Running, Failure> {
        let mut copy = Running::new(Child::start(&self.program)?, number);
        if let Some(agreed) = agreed {
            self.again(&mut copy, agreed, "asked in two copies of it")?;
        }
        Ok(copy)
    }

    /// Keeps what went wrong first, and lets the other copies go. Whoever asks afterwards hears the same.
    fn fail(&self, failure: Failure) -> Failure {
        let (kept, idle) = {
            let mut state = self.state();
            let kept = state.failure.get_or_insert(failure).clone();
            (kept, std::mem::take(&mut state.idle))
        };
        self.changed.notify_all();
        end(idle);
        kept
    }
}

impl Drop for Pool {
    fn drop(&mut self) {
        end(std::mem::take(&mut self.state().idle));
    }
}

/// Bids all farewell before any is waited for.
fn end(mut copies: Vec<Running>) {
    for copy in &mut copies {
        copy.child.farewell();
    }
}
