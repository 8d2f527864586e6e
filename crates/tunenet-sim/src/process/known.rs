//! What a program answered once, and has to answer again: the same request gives the same bits.

use std::sync::Arc;

use super::child::Child;
use super::failure::Failure;
use super::program::Program;
use super::protocol::Answer;
use super::request::Request;

/// A rollout that was asked for, and what was answered.
#[derive(Debug, Clone)]
pub(super) struct Asked {
    pub request: Arc<Request>,
    pub answer: Answer,
}

/// Refuses a copy that answers otherwise than was answered before.
pub(super) fn agree(program: &Program, child: &mut Child, known: &Asked, how: &str) -> Result<(), Failure> {
    let answer = child.ask(program, &known.request)?;
    if answer.is(&known.answer) {
        return Ok(());
    }
    let difference = match (&known.answer, &answer) {
        (Answer::Values(a), Answer::Values(b)) => {
            let at = a.iter().zip(b).position(|(a, b)| a.to_bits() != b.to_bits()).unwrap_or(0);
            let (row, channel) = (at / program.headers.len() + 1, &program.headers[at % program.headers.len()]);
            format!("{:?} and {:?} for `{channel}` in row {row}", a[at], b[at])
        }
        _ => "numbers once and an error once".into(),
    };
    let message =
        format!("{}: expected the same answer to the same parameters, found {difference} when {how}", program.shown());
    let hint = "begin every rollout anew, keep nothing from one to the next, and start every random draw from a fixed seed \
                within it";
    Err(Failure::drift(message, hint))
}
