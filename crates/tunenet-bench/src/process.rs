//! Whole processes of `tunenet`, timed and weighed from outside.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use tunenet_cli::files::programs;

/// How often the memory of a child is read.
const LOOK_EVERY: Duration = Duration::from_millis(1);

/// What one run cost.
#[derive(Debug, Clone, Copy)]
pub struct ProcessCost {
    /// Wall time, s.
    pub seconds: f64,
    /// Greatest resident memory, bytes; `None` where the system does not report it.
    pub peak_bytes: Option<u64>,
}

/// Runs `tunenet` with `arguments`.
pub fn run(arguments: &[&str]) -> Result<ProcessCost> {
    run_program(&programs::sibling(programs::TUNENET)?, arguments)
}

/// Runs `tunenet` with `arguments` on so many threads.
pub fn run_on(threads: usize, arguments: &[&str]) -> Result<ProcessCost> {
    let mut command = Command::new(programs::sibling(programs::TUNENET)?);
    command.env("RAYON_NUM_THREADS", threads.to_string());
    run_command(command, arguments)
}

/// Runs `program` with `arguments`.
pub fn run_program(program: &Path, arguments: &[&str]) -> Result<ProcessCost> {
    run_command(Command::new(program), arguments)
}

fn run_command(mut command: Command, arguments: &[&str]) -> Result<ProcessCost> {
    let program = std::path::PathBuf::from(command.get_program());
    let began = Instant::now();
    let mut child = command
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .with_context(|| format!("starting {}", program.display()))?;
    // Read while it runs: a full pipe would stop it.
    let said = child.stderr.take().map(|mut stderr| {
        std::thread::spawn(move || {
            let mut bytes = Vec::new();
            std::io::Read::read_to_end(&mut stderr, &mut bytes).map(|_| bytes)
        })
    });
    let mut peak_bytes = None;
    let status = loop {
        if let Some(status) = child.try_wait()? {
            break status;
        }
        // The kernel keeps the greatest value itself, so looking now and then misses only the last few milliseconds.
        peak_bytes = high_water(child.id()).or(peak_bytes);
        std::thread::sleep(LOOK_EVERY);
    };
    let seconds = began.elapsed().as_secs_f64();
    let said = said.and_then(|reader| reader.join().ok()).transpose()?.unwrap_or_default();
    // Status 3, no usable result, is a valid answer.
    if !matches!(status.code(), Some(0 | 3)) {
        let text = String::from_utf8_lossy(&said);
        let name = program.file_stem().unwrap_or_default().to_string_lossy();
        bail!("`{name} {}` failed: {}", arguments.join(" "), text.trim());
    }
    Ok(ProcessCost { seconds, peak_bytes })
}

/// The greatest resident memory of a process so far, from Linux's process table.
fn high_water(id: u32) -> Option<u64> {
    let status = std::fs::read_to_string(format!("/proc/{id}/status")).ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kilobytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes * 1024)
}
