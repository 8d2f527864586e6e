//! The scene of a custom program.

use std::path::PathBuf;

use serde::Deserialize;

use super::{Candidates, Inputs, Record, Starts};

/// A program that simulates.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct ProcessScene {
    /// The program, and how to speak with it.
    pub process: Process,
    /// What is written of it.
    #[serde(default)]
    pub record: Record,
    /// What drives the thing.
    #[serde(default)]
    pub inputs: Inputs,
    /// Where its states start.
    #[serde(default)]
    pub start: Starts,
    /// Effects that it may lack.
    #[serde(default)]
    pub candidates: Candidates,
}

/// A program, and how to speak with it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Process {
    /// Its name or path, then its arguments.
    pub command: Vec<String>,
    /// What it predicts: names with their units.
    pub channels: Vec<String>,
    /// Where it runs, from the folder of the file; that folder where it is `None`.
    #[serde(default)]
    pub folder: Option<PathBuf>,
    /// How long it may take to answer, s.
    #[serde(default = "timeout_s")]
    pub timeout_s: f64,
    /// How long it may take to start, s: large libraries load for a while.
    #[serde(default = "start_timeout_s")]
    pub start_timeout_s: f64,
    /// How many of it run at a time; one for each core where it is `None`.
    #[serde(default)]
    pub workers: Option<usize>,
}

fn timeout_s() -> f64 {
    10.0
}

fn start_timeout_s() -> f64 {
    60.0
}
