//! What a rollout costs on top of the simulation itself where a program simulates: 216 samples of one channel, asked for and answered in
//! lines of JSON. This executable is the program as well, so that nothing but the speaking is measured; where Python 3 is there, the
//! same by a program of a few lines in it, which says what Python's own JSON costs.

use std::hint::black_box;
use std::io::{BufRead, Write};
use std::path::Path;

use criterion::{Criterion, criterion_group};
use tunenet_core::simulator::Simulator;
use tunenet_sim::process::{self, Permission};
use tunenet_sim::{ProcessSimulator, Session, SimulationFile};

/// The argument with which this executable is the program.
const ANSWER: &str = "--answer-lines";
const SAMPLES: usize = 216;
const PYTHON: &str = "import json, sys\n\
    print('{\"tunenet\":1}', flush=True)\n\
    sys.stdin.readline()\n\
    for r in map(json.loads, sys.stdin):\n    \
    print(json.dumps({'id': r['id'], 'values': [[t * r['parameters']['k']] for t in r['times_s']]}), flush=True)\n";

/// Answers every line: time by time the instant times `k`.
fn answer() {
    let (input, mut output) = (std::io::stdin().lock(), std::io::stdout().lock());
    for line in input.lines() {
        let request: serde_json::Value = serde_json::from_str(&line.expect("a line")).expect("JSON");
        let line = match request["times_s"].as_array() {
            None => serde_json::json!({ "tunenet": 1 }),
            Some(times) => {
                let k = request["parameters"]["k"].as_f64().expect("a number");
                let values: Vec<[f64; 1]> = times.iter().map(|t| [t.as_f64().expect("a number") * k]).collect();
                serde_json::json!({ "id": request["id"], "values": values })
            }
        };
        writeln!(output, "{line}").and_then(|()| output.flush()).expect("somebody who listens");
    }
}

fn program(command: &[&str]) -> tunenet_formats::Result<ProcessSimulator> {
    let words: Vec<String> = command.iter().map(|word| serde_json::json!(word).to_string()).collect();
    let text = format!(
        "kind = \"process\"\n[process]\ncommand = [{}]\nchannels = [\"z_m\"]\n[parameters.k]\nvalue = 1\nmin = 0\nmax = 2\n",
        words.join(", ")
    );
    let file = SimulationFile::parse(Path::new("bench.toml"), &text)?;
    process::start(&file, &Session::new(Permission::Granted))
}

fn rollouts(criterion: &mut Criterion) {
    let clock: Vec<f64> = (0..SAMPLES).map(|i| i as f64 / 72.0).collect();
    let mut values = vec![0.0; SAMPLES];
    let own = std::env::current_exe().expect("the path of this executable");
    let own = own.to_string_lossy();
    let mut group = criterion.benchmark_group("rollout by a program, 216 samples");
    for (name, command) in [("in Rust", vec![&*own, ANSWER]), ("in Python", vec!["python3", "-c", PYTHON])] {
        match program(&command) {
            Ok(program) => {
                // What was answered already is not asked for again.
                let mut k = 0.7;
                group.bench_function(name, |bencher| {
                    bencher.iter(|| {
                        k += 1e-9;
                        program.rollout(black_box(&[k]), &[], &clock, &mut values).expect("an answer");
                    });
                });
            }
            Err(error) => println!("{name}: skipped, {error}"),
        }
    }
    group.finish();
}

criterion_group!(benches, rollouts);

fn main() {
    if std::env::args().any(|argument| argument == ANSWER) {
        return answer();
    }
    benches();
    Criterion::default().configure_from_args().final_summary();
}
