//! Least squares of other packages, in a Python process that asks for residuals by lines of JSON: the trust-region reflective method of
//! scipy (Branch, Coleman and Li 1999), and the Gauss–Newton method of `mujoco.sysid`.

use std::io::{BufRead, BufReader, ErrorKind, Write};
use std::process::{Child, Command, Stdio};

use anyhow::{Context, Result, bail};
use serde::{Deserialize, Serialize};
use tunenet_cli::view::text::note;

const SCRIPT: &str = include_str!("least_squares.py");
/// Names another Python than `python3`.
const PYTHON: &str = "TUNENET_PYTHON";

/// Whose method it is.
#[derive(Debug, Clone, Copy)]
pub enum Package {
    Scipy,
    /// `mujoco.sysid.optimize` with its own optimiser.
    Mujoco,
}

impl Package {
    const fn name(self) -> &'static str {
        match self {
            Self::Scipy => "scipy",
            Self::Mujoco => "mujoco",
        }
    }
}

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

/// The point of the least squares; `None` where Python or the package is not there. `residuals` has `None` where a point cannot be
/// simulated.
///
/// # Errors
/// Where Python ends without an answer.
pub fn least_squares(
    package: Package,
    problem: &Bounded,
    residuals: impl FnMut(&[f64]) -> Option<Vec<f64>>,
) -> Result<Option<Vec<f64>>> {
    let python = std::env::var_os(PYTHON).unwrap_or_else(|| "python3".into());
    let mut command = Command::new(&python);
    let started = command.args(["-c", SCRIPT, package.name()]).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn();
    let mut child = match started {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        started => started.with_context(|| format!("starting {}", python.display()))?,
    };
    let talked = talk(package, &mut child, problem, residuals);
    if talked.is_err() {
        // It may wait for an answer; that it has ended already is no error.
        let _ = child.kill();
    }
    child.wait()?;
    talked.with_context(|| format!("least squares by {}", python.display()))
}

fn talk(
    package: Package,
    child: &mut Child,
    problem: &Bounded,
    mut residuals: impl FnMut(&[f64]) -> Option<Vec<f64>>,
) -> Result<Option<Vec<f64>>> {
    let (Some(mut to), Some(from)) = (child.stdin.take(), child.stdout.take()) else {
        bail!("the process has no standard input or output");
    };
    // A process without the package ends before it reads this; its line says so.
    let sent = writeln!(to, "{}", serde_json::to_string(problem)?);
    for line in BufReader::new(from).lines() {
        match serde_json::from_str(&line?)? {
            Said::Point(point) => writeln!(to, "{}", serde_json::to_string(&residuals(&point))?)?,
            Said::Answer(point) => return Ok(Some(point)),
            Said::Missing(why) => {
                note(&format!("the column of {} stays empty: {why}", package.name()));
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
    fn a_line_is_fitted_by_each_package_that_is_there() {
        let problem = Bounded { start: vec![0.5, 0.5], low: vec![0.0, 0.0], high: vec![5.0, 5.0] };
        for package in [Package::Scipy, Package::Mujoco] {
            let mut calls = 0;
            let line = |p: &[f64]| {
                calls += 1;
                Some((0..9).map(|i| p[0] + p[1] * f64::from(i) - (1.5 + 0.25 * f64::from(i))).collect())
            };
            let Some(found) = least_squares(package, &problem, line).unwrap() else {
                eprintln!("skipped: Python or {} is not there", package.name());
                continue;
            };
            assert!((found[0] - 1.5).abs() < 1e-6 && (found[1] - 0.25).abs() < 1e-6, "{package:?} {found:?}");
            assert!(calls >= 3, "{calls}");
        }
    }
}
