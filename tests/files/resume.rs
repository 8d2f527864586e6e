//! Long runs that are killed go on where they stopped, and end with the bytes of a run that was not.
#![cfg(unix)]

use std::process::{Child, Stdio};
use std::time::Duration;

use crate::common::{DROP, Folder, Noise};

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

/// How often each command is killed: as `TUNENET_KILLS` says, else a few times.
fn wanted(few: u64) -> u64 {
    std::env::var("TUNENET_KILLS").map_or(few, |text| text.parse().expect("TUNENET_KILLS is a whole number"))
}

/// A long run, and how it is killed.
struct Run {
    line: &'static str,
    /// What it writes in the end.
    out: &'static str,
    /// What it goes on from.
    trace: &'static str,
    /// Least kills in all; rounds go on until there were as many.
    least: u64,
    /// Most kills in a round.
    kills: u32,
    /// Longest time that a run is left alone, s.
    longest_s: f64,
}

/// Kills a run at random moments of its course, several times for each round, then lets it end. `out` has to hold `old`
/// until it is replaced, and what an uninterrupted run writes afterwards.
fn survives(run: &Run, prepare: &dyn Fn(&Folder)) {
    let Run { line, out, .. } = *run;
    let reference = Folder::new();
    prepare(&reference);
    reference.run(line).ends(0);
    let (expected, names) = (reference.read(out), reference.names());
    let (mut hits, mut traces, mut seed) = (0, 0, 0);
    while hits < run.least {
        let folder = Folder::new();
        prepare(&folder);
        // A finished file of an earlier run stands there in every other round.
        let old = seed % 2 == 1 && !out.contains('/');
        if old {
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
                assert!(old && found == b"old" || found == expected, "seed {seed}: {} bytes", found.len());
            }
        }
        folder.run(line).ends(0);
        assert!(folder.read(out) == expected, "seed {seed}: other bytes than an uninterrupted run");
        assert_eq!(folder.names(), names, "seed {seed}: something stays behind, or is not there");
        seed += 1;
        assert!(seed < 10 * run.least, "only {hits} runs were killed before their end");
    }
    eprintln!("{}: killed {hits} times in {seed} rounds", line.split(" --").next().unwrap());
    assert!(2 * traces >= seed, "only {traces} of {hits} killed runs left something to go on from");
}

#[test]
fn gen_goes_on_after_a_kill() {
    let run = Run {
        line: "gen ball --sim drop.toml --pairs 8000 --seed 3 --out pairs.mcap --overwrite",
        out: "pairs.mcap",
        trace: "pairs.mcap.partial",
        least: wanted(8),
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
        least: wanted(2),
        kills: 1,
        longest_s: 0.5,
    };
    survives(&run, &|folder| {
        folder.write("drop.toml", DROP);
        folder.run("gen ball --sim drop.toml --pairs 7000 --out pairs.mcap").ends(0);
    });
}

#[test]
fn bench_goes_on_after_a_kill() {
    let run = Run {
        line: "bench diagnose --quick --only clean --seed 3 --out b",
        out: "b/diagnose.json",
        trace: "b/cells",
        least: wanted(3),
        kills: 3,
        longest_s: 1.0,
    };
    survives(&run, &|_| {});
}
