//! As many copies of a program as threads ask at a time.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use super::child::Child;
use super::failure::Failure;
use super::program::Program;
use super::protocol::Answer;

/// Copies of one program that answer alike.
#[derive(Debug)]
pub(super) struct Pool {
    program: Program,
    /// What every copy has to answer to the first request.
    agreed: Answer,
    copies: Mutex<Copies>,
    freed: Condvar,
}

#[derive(Debug)]
struct Copies {
    idle: Vec<Child>,
    /// Idle or asked.
    running: usize,
    /// Once one has failed, no other is asked.
    failure: Option<Failure>,
}

impl Pool {
    /// Starts the first copy, which is asked the same twice: the same parameters have to give the same bits.
    pub fn start(program: Program) -> Result<Self, Failure> {
        let mut first = Child::start(&program)?;
        let agreed = probe(&program, &mut first)?;
        agree(&program, &mut first, &agreed, "asked twice")?;
        let copies = Copies { idle: vec![first], running: 1, failure: None };
        Ok(Self { program, agreed, copies: Mutex::new(copies), freed: Condvar::new() })
    }

    /// One rollout, by whichever copy is free.
    pub fn ask(&self, parameters: &[f64], clock: &[f64]) -> Result<Answer, Failure> {
        let mut child = match self.free()? {
            Some(child) => child,
            None => self.another().map_err(|failure| self.fail(failure))?,
        };
        match child.ask(&self.program, parameters, clock) {
            Ok(answer) => {
                self.copies().idle.push(child);
                self.freed.notify_one();
                Ok(answer)
            }
            Err(failure) => {
                drop(child);
                Err(self.fail(failure))
            }
        }
    }

    fn copies(&self) -> MutexGuard<'_, Copies> {
        self.copies.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A copy that is free; `None` where one more may be started, which then counts as running.
    fn free(&self) -> Result<Option<Child>, Failure> {
        let mut copies = self.copies();
        loop {
            if let Some(failure) = &copies.failure {
                return Err(failure.clone());
            }
            if let Some(child) = copies.idle.pop() {
                return Ok(Some(child));
            }
            if copies.running < self.program.workers {
                copies.running += 1;
                return Ok(None);
            }
            copies = self.freed.wait(copies).unwrap_or_else(PoisonError::into_inner);
        }
    }

    fn another(&self) -> Result<Child, Failure> {
        let mut child = Child::start(&self.program)?;
        agree(&self.program, &mut child, &self.agreed, "asked in two copies of it")?;
        Ok(child)
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
fn end(mut children: Vec<Child>) {
    children.iter_mut().for_each(Child::farewell);
}

fn probe(program: &Program, child: &mut Child) -> Result<Answer, Failure> {
    let present: Vec<f64> = program.parameters.iter().map(|p| p.value).collect();
    child.ask(program, &present, &program.probe)
}

/// Refuses a copy that answers otherwise than the first one did.
fn agree(program: &Program, child: &mut Child, agreed: &Answer, how: &str) -> Result<(), Failure> {
    let answer = probe(program, child)?;
    if answer.is(agreed) {
        return Ok(());
    }
    let difference = match (agreed, &answer) {
        (Answer::Values(a), Answer::Values(b)) => {
            let at = a.iter().zip(b).position(|(a, b)| a.to_bits() != b.to_bits()).unwrap_or(0);
            let (row, channel) = (at / program.headers.len() + 1, &program.headers[at % program.headers.len()]);
            format!("{:?} and {:?} for `{channel}` in row {row}", a[at], b[at])
        }
        _ => "numbers once and an error once".into(),
    };
    let message =
        format!("{}: expected the same answer to the same parameters, found {difference} when {how}", program.shown());
    let hint = "begin every rollout anew, and start every draw of chance from a fixed seed within it";
    Err(Failure::new(message, hint))
}
