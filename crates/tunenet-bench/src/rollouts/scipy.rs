//! Branch, Coleman and Li (1999): the trust-region reflective method of scipy, a process that asks for residuals by lines of JSON.

use std::io::{BufRead, BufReader, ErrorKind, Write};
use std::process::{Child, Command, Stdio};

use anyhow::{Context, Result, bail};
use serde::{Deserialize, Serialize};
use tunenet_cli::view::text::note;

const SCRIPT: &str = include_str!("trf.py");
/// Names another Python than `python3`.
const PYTHON: &str = "TUNENET_PYTHON";

/// What is minimised: from where, within which bounds.
#[derive(Debug, Clone, Serialize)]
pub struct Bounded {
    pub start: Vec<f64>,
    pub low: Vec<f64>,
    pub high: Vec<f64>,
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
enum Said {
    Point(Vec<f64>),
    Answer(Vec<f64>),
    Missing(String),
}

/// The point of the least squares; `None` where Python or scipy is not there. `residuals` has `None` where a point cannot be
/// simulated.
///
/// # Errors
/// Where Python ends without an answer.
pub fn trf(problem: &Bounded, residuals: impl FnMut(&[f64]) -> Option<Vec<f64>>) -> Result<Option<Vec<f64>>> {
    let python = std::env::var_os(PYTHON).unwrap_or_else(|| "python3".into());
    let mut command = Command::new(&python);
    let started = command.args(["-c", SCRIPT]).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn();
    let mut child = match started {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        started => started.with_context(|| format!("starting {}", python.display()))?,
    };
    let talked = talk(&mut child, problem, residuals);
    if talked.is_err() {
        // It may wait for an answer; that it has ended already is no error.
        let _ = child.kill();
    }
    child.wait()?;
    talked.with_context(|| format!("least squares by {}", python.display()))
}

fn talk(
    child: &mut Child,
    problem: &Bounded,
    mut residuals: impl FnMut(&[f64]) -> Option<Vec<f64>>,
) -> Result<Option<Vec<f64>>> {
    let (Some(mut to), Some(from)) = (child.stdin.take(), child.stdout.take()) else {
        bail!("the process has no standard input or output");
    };
    // A process without scipy ends before it reads this; its line says so.
    let sent = writeln!(to, "{}", serde_json::to_string(problem)?);
    for line in BufReader::new(from).lines() {
        match serde_json::from_str(&line?)? {
            Said::Point(point) => writeln!(to, "{}", serde_json::to_string(&residuals(&point))?)?,
            Said::Answer(point) => return Ok(Some(point)),
            Said::Missing(why) => {
                note(&format!("the column of scipy stays empty: {why}"));
                return Ok(None);
            }
        }
    }
    sent?;
    bail!("expected a line with the answer, found the end of its output; its standard error says why")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_fitted_where_scipy_is_there() {
        let problem = Bounded { start: vec![0.5, 0.5], low: vec![0.0, 0.0], high: vec![5.0, 5.0] };
        let mut calls = 0;
        let line = |p: &[f64]| {
            calls += 1;
            Some((0..9).map(|i| p[0] + p[1] * f64::from(i) - (1.5 + 0.25 * f64::from(i))).collect())
        };
        let Some(found) = trf(&problem, line).unwrap() else {
            eprintln!("skipped: Python or scipy is not there");
            return;
        };
        assert!((found[0] - 1.5).abs() < 1e-6 && (found[1] - 0.25).abs() < 1e-6, "{found:?}");
        assert!(calls >= 3, "{calls}");
    }
}
