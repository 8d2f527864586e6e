//! What a program answered once, and has to answer again: the same parameters give the same bits.

use super::child::Child;
use super::failure::Failure;
use super::program::Program;
use super::protocol::Answer;

/// A rollout that was asked for, and what was answered.
#[derive(Debug, Clone)]
pub(super) struct Asked {
    parameters: Vec<f64>,
    clock: Vec<f64>,
    answer: Answer,
}

impl Asked {
    pub fn new(parameters: &[f64], clock: &[f64], answer: &Answer) -> Self {
        Self { parameters: parameters.to_vec(), clock: clock.to_vec(), answer: answer.clone() }
    }
}

/// What every copy is asked first: the parameters of the file.
pub(super) fn probe(program: &Program, child: &mut Child) -> Result<Asked, Failure> {
    let present: Vec<f64> = program.parameters.iter().map(|p| p.value).collect();
    let answer = child.ask(program, &present, &program.probe)?;
    Ok(Asked::new(&present, &program.probe, &answer))
}

/// Refuses a copy that answers otherwise than was answered before.
pub(super) fn agree(program: &Program, child: &mut Child, known: &Asked, how: &str) -> Result<(), Failure> {
    let answer = child.ask(program, &known.parameters, &known.clock)?;
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
