//! Long runs that are killed go on where they stopped, and end with the bytes of a run that was not.
#![cfg(unix)]

mod common;

use std::process::{Child, Stdio};
use std::time::Duration;

use common::{DROP, Folder, Noise};

/// Starts `line` and kills it `after` a while; the while begins once `trace` is there, where one is awaited. Says whether
/// it was still running.
fn killed(folder: &Folder, line: &str, trace: Option<&str>, after: Duration) -> bool {
    let mut command = folder.command();
    command.args(line.split_whitespace()).stdout(Stdio::null()).stderr(Stdio::null());
    let mut child = command.spawn().unwrap();
    let waits = |child: &mut Child| child.try_wait().unwrap().is_none();
    while trace.is_some_and(|trace| !folder.path(trace).exists()) && waits(&mut child) {
        std::thread::sleep(Duration::from_millis(2));
    }
    std::thread::sleep(after);
    let running = waits(&mut child);
    child.kill().unwrap();
    child.wait().unwrap();
    running
}

/// A long run, and how it is killed.
struct Run {
    line: &'static str,
    out: &'static str,
    /// What it goes on from.
    trace: &'static str,
    rounds: u64,
    /// Most kills in a round.
    kills: u32,
    /// Longest time that a run is left alone, s.
    longest_s: f64,
}

/// Kills a run at random moments of its course, several times for each round, then lets it end. `out` has to hold `old`
/// until it is replaced, and the bytes of an uninterrupted run afterwards.
fn survives(run: &Run, prepare: &dyn Fn(&Folder)) {
    let Run { line, out, .. } = *run;
    let reference = Folder::new();
    prepare(&reference);
    reference.run(line).ends(0);
    let expected = reference.read(out);
    let (mut hits, mut traces) = (0, 0);
    for seed in 0..run.rounds {
        let folder = Folder::new();
        prepare(&folder);
        let before = folder.names();
        // A finished file of an earlier run stands there in every other round.
        if seed % 2 == 1 {
            folder.write(out, "old");
        }
        let mut draw = Noise(seed);
        for kill in 0..run.kills {
            // The first kill comes while there is something to go on from; the others come at any time.
            let trace = (kill == 0).then_some(run.trace);
            if !killed(&folder, line, trace, Duration::from_secs_f64(draw.between(0.0, run.longest_s))) {
                break;
            }
            hits += 1;
            traces += u64::from(folder.path(run.trace).exists());
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
    assert!(hits >= run.rounds, "only {hits} runs were killed before their end");
    assert!(traces >= run.rounds / 2, "only {traces} of {hits} killed runs left something to go on from");
}

#[test]
fn gen_goes_on_after_a_kill() {
    let run = Run {
        line: "gen ball --sim drop.toml --pairs 8000 --seed 3 --out pairs.mcap --overwrite",
        out: "pairs.mcap",
        trace: "pairs.mcap.partial",
        rounds: 5,
        kills: 3,
        longest_s: 0.15,
    };
    survives(&run, &|folder| {
        folder.write("drop.toml", DROP);
    });
}

#[test]
fn train_goes_on_after_a_kill() {
    // Long enough for a checkpoint or two, which are written every other second.
    let run = Run {
        line: "train --data pairs.mcap --preset paper --seed 3 --out m.safetensors --overwrite",
        out: "m.safetensors",
        trace: "m.safetensors.checkpoint",
        rounds: 2,
        kills: 2,
        longest_s: 0.5,
    };
    survives(&run, &|folder| {
        folder.write("drop.toml", DROP);
        folder.run("gen ball --sim drop.toml --pairs 12000 --out pairs.mcap").ends(0);
    });
}
