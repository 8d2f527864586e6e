//! Long runs that are killed go on where they stopped, and end with the bytes of a run that was not.
#![cfg(unix)]

mod common;

use std::process::Stdio;
use std::time::{Duration, Instant};

use common::{DROP, Folder, Noise};

/// Runs `line` to its end and says how long it took.
fn whole(folder: &Folder, line: &str) -> Duration {
    let began = Instant::now();
    folder.run(line).ends(0);
    began.elapsed()
}

/// Starts `line` and kills it after `after`; says whether it was still running.
fn killed(folder: &Folder, line: &str, after: Duration) -> bool {
    let mut command = folder.command();
    command.args(line.split_whitespace()).stdout(Stdio::null()).stderr(Stdio::null());
    let mut child = command.spawn().unwrap();
    std::thread::sleep(after);
    let running = child.try_wait().unwrap().is_none();
    child.kill().unwrap();
    child.wait().unwrap();
    running
}

/// Kills `line` at random moments of its run, several times for each round, then lets it end. `out` has to hold `old`
/// until it is replaced, and the bytes of an uninterrupted run afterwards.
fn survives(line: &str, out: &str, rounds: u64, prepare: &dyn Fn(&Folder)) {
    let reference = Folder::new();
    prepare(&reference);
    let duration = whole(&reference, line);
    let expected = reference.read(out);
    let mut hits: u64 = 0;
    for seed in 0..rounds {
        let folder = Folder::new();
        prepare(&folder);
        let before = folder.names();
        // A finished file of an earlier run stands there in every other round.
        if seed % 2 == 1 {
            folder.write(out, "old");
        }
        let mut draw = Noise(seed);
        for _ in 0..3 {
            if !killed(&folder, line, duration.mul_f64(draw.between(0.05, 0.9))) {
                break;
            }
            hits += 1;
            if folder.path(out).exists() {
                let found = folder.read(out);
                assert!(found == b"old" && seed % 2 == 1 || found == expected, "seed {seed}: {} bytes", found.len());
            }
        }
        folder.run(line).ends(0);
        assert!(folder.read(out) == expected, "seed {seed}: other bytes than an uninterrupted run");
        let mut wanted = before;
        wanted.push(out.into());
        wanted.sort();
        assert_eq!(folder.names(), wanted, "seed {seed}: something stays behind");
    }
    assert!(hits >= rounds / 2, "only {hits} runs were killed before their end");
}

#[test]
fn gen_goes_on_after_a_kill() {
    let line = "gen ball --sim drop.toml --pairs 8000 --seed 3 --out pairs.mcap";
    survives(line, "pairs.mcap", 5, &|folder| {
        folder.write("drop.toml", DROP);
    });
}

#[test]
fn train_goes_on_after_a_kill() {
    let line = "train --data pairs.mcap --preset paper --seed 3 --out m.safetensors";
    survives(line, "m.safetensors", 4, &|folder| {
        folder.write("drop.toml", DROP);
        folder.run("gen ball --sim drop.toml --pairs 400 --out pairs.mcap").ends(0);
    });
}
