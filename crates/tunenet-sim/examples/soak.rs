//! Tunes again and again in one process, and says how much memory it holds: `soak [CALLS]`, run from the root of the project.
//! It ends with status 1 where memory grew by more than a tenth after the first hundred calls.

use std::path::Path;
use std::process::ExitCode;

use tunenet_core::tune::{Settings, tune};
use tunenet_formats::{ReadOptions, read};
use tunenet_sim::{Session, SimulationFile, built_in, simulator};

/// What one run of the tool does: files are read, the simulator and, for drops, the network are made, and it is tuned.
fn call(number: u32) -> Result<(), Box<dyn std::error::Error>> {
    // Most calls are short ones, so that there can be many.
    let (file, assignment) = match number % 8 {
        0 => ("assets/observations/drop.csv", "ball.radius_m=0.02"),
        1 => ("assets/observations/table_tennis.csv", "effects.quadratic_drag.c_1_m=0.1317"),
        _ => ("assets/observations/bounces.csv", "ball.radius_m=0.02"),
    };
    let mut scene = SimulationFile::read(Path::new("assets/ball.toml"))?;
    scene.set(assignment)?;
    let seen = read(file, &ReadOptions::default())?.observation;
    let ball = simulator(&scene, seen.kind(), &Session::default())?;
    let model = file.ends_with("drop.csv").then(built_in::ball).transpose()?;
    // Every call starts elsewhere.
    let start = 0.1 + 0.8 * f64::from(number % 97) / 97.0;
    let settings = Settings { initial: vec![("restitution".into(), start)], ..Settings::default() };
    let outcome = tune(&ball, &[seen], model.as_ref(), &settings)?;
    assert!(!outcome.parameters.is_empty(), "{file} was rejected");
    Ok(())
}

/// Resident memory in kB, where the system tells (Linux).
fn resident_kb() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    line.trim().trim_end_matches(" kB").parse().ok()
}

fn main() -> Result<ExitCode, Box<dyn std::error::Error>> {
    let calls: u32 = std::env::args().nth(1).map_or(Ok(10_000), |text| text.parse())?;
    let mut early = None;
    for number in 1..=calls {
        call(number)?;
        if [100, 1000].contains(&number) || number == calls {
            let held = resident_kb();
            println!("{number} calls: {} kB", held.map_or("unknown".into(), |kb| kb.to_string()));
            early = early.or(held);
        }
    }
    let grown = early.zip(resident_kb()).is_some_and(|(early, late)| late > early + early / 10);
    Ok(if grown { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}
