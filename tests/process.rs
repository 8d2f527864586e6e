//! Programs of one's own as simulators: tuned and diagnosed like ours, run with leave alone, and each of their failures told in
//! one sentence, with no process left behind.

mod common;

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use common::{Folder, Noise, Ran};

const PENDULUM: &str = include_str!("../assets/process/pendulum.py");
const MUJOCO: &str = include_str!("../assets/process/mujoco_pendulum.py");
const PENDULUM_SCENE: &str = include_str!("../assets/process/pendulum.toml");
const MUJOCO_SCENE: &str = include_str!("../assets/process/mujoco_pendulum.toml");

/// Whether Python can do `import NAME`; says where it cannot.
fn python(import: &str) -> bool {
    let there =
        Command::new("python3").args(["-c", &format!("import {import}")]).output().is_ok_and(|o| o.status.success());
    if !there {
        eprintln!("skipped: no python3 that can `import {import}`");
    }
    there
}

/// A swing by the classical Runge–Kutta method, which the programs do not use: length and damping of θ'' = -g/l sin θ - d θ',
/// with `stretch` times the length for the mass that is not in one point.
struct Swing {
    length_m: f64,
    damping_1_s: f64,
    stretch: f64,
    noise_rad: f64,
    /// How much later than true the stamps are.
    late_s: f64,
    /// A torque beside the law, which no program knows: this times sin(7 t), rad/s².
    shaken: f64,
    start_rad: f64,
    seed: u64,
}

impl Default for Swing {
    fn default() -> Self {
        Self {
            length_m: 0.62,
            damping_1_s: 0.24,
            stretch: 1.0,
            noise_rad: 2e-3,
            late_s: 0.0,
            shaken: 0.0,
            start_rad: 0.5,
            seed: 7,
        }
    }
}

impl Swing {
    fn csv(&self, header: &str) -> String {
        let slope = |t: f64, [angle, rate]: [f64; 2]| {
            let pull = -9.81 / (self.length_m * self.stretch) * angle.sin();
            [rate, pull - self.damping_1_s * rate + self.shaken * (7.0 * t).sin()]
        };
        let (mut state, mut noise, mut text) = ([self.start_rad, 0.0], Noise(self.seed), format!("{header}\n"));
        const STEPS: u32 = 40;
        let h = 1.0 / (72.0 * f64::from(STEPS));
        for sample in 0..216_u32 {
            let time = f64::from(sample) / 72.0;
            writeln!(text, "{},{}", time + self.late_s, state[0] + self.noise_rad * noise.normal()).unwrap();
            for step in 0..STEPS {
                let t = time + f64::from(step) * h;
                let ahead = |k: [f64; 2], h: f64| [state[0] + h * k[0], state[1] + h * k[1]];
                let a = slope(t, state);
                let b = slope(t + h / 2.0, ahead(a, h / 2.0));
                let c = slope(t + h / 2.0, ahead(b, h / 2.0));
                let d = slope(t + h, ahead(c, h));
                state = [0, 1].map(|i| state[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
            }
        }
        text
    }
}

/// A folder with the pendulum's program, its scene and a swing that others reckoned.
fn pendulum() -> Folder {
    let folder = Folder::new();
    folder.write("pendulum.py", PENDULUM);
    folder.write("pendulum.toml", PENDULUM_SCENE);
    folder.write("swing.csv", Swing::default().csv("t_s,angle_rad"));
    folder
}

#[track_caller]
fn holds(json: &serde_json::Value, name: &str, truth: f64, near: f64) {
    let one = &json["parameters"][name];
    let [value, low, high] =
        [&one["value"], &one["interval95"][0], &one["interval95"][1]].map(|v| v.as_f64().unwrap_or(f64::NAN));
    assert!((value - truth).abs() < near, "{name}: {one}");
    // The seed was not chosen: an interval of 95 % may miss the truth, but not by its own width again.
    let slack = 0.5 * (high - low);
    assert!((low - slack..=high + slack).contains(&truth) && low < high, "{name}: {one}");
}

#[test]
fn a_program_is_tuned_to_what_another_integrator_made() {
    if !python("json") {
        return;
    }
    let folder = pendulum();
    let line = "tune --sim pendulum.toml --allow-process --observation swing.csv --json --out tuned.toml";
    let first = folder.run(line).ends(0);
    let json = first.json();
    assert_eq!(json["verdict"], "tuned");
    assert_eq!(json["parameters"]["length"]["unit"], "m");
    holds(&json, "length", 0.62, 2e-3);
    holds(&json, "damping", 0.24, 2e-2);
    let gap = json["gap"]["after"].as_f64().unwrap();
    assert!((gap / 2e-3 - 1.0).abs() < 0.2, "{}", json["gap"]);

    // The same seed gives the same bytes, whatever the number of threads and of copies.
    let tuned = folder.read("tuned.toml");
    for workers in ["1", "3"] {
        let mut command = folder.command();
        command.env("RAYON_NUM_THREADS", workers).args(line.split_whitespace());
        Ran::from(command.output().unwrap()).ends(0);
        assert!(folder.read("tuned.toml") == tuned, "{workers} workers");
    }
    // What was written is run with leave alone, too.
    let refused = folder.run("simulate --sim tuned.toml --out again.csv").ends(2);
    assert!(
        refused.stderr.contains("`--allow-process`: expected this flag, since tuned.toml names the program"),
        "{}",
        refused.stderr
    );
    folder.run("simulate --sim tuned.toml --allow-process --out again.csv").ends(0);
    assert!(String::from_utf8(folder.read("again.csv")).unwrap().starts_with("t_s,angle_rad\n0.0,0.5\n"));

    // A file that is written elsewhere still finds its program.
    std::fs::create_dir(folder.path("elsewhere")).unwrap();
    folder.run("tune --sim pendulum.toml --allow-process --observation swing.csv --out elsewhere/tuned.toml").ends(0);
    let text = String::from_utf8(folder.read("elsewhere/tuned.toml")).unwrap();
    assert!(text.contains("kind = \"process\"") && text.contains("folder = \"..\""), "{text}");
    folder.run("simulate --sim elsewhere/tuned.toml --allow-process --out elsewhere/again.csv").ends(0);
    assert!(folder.read("elsewhere/again.csv") == folder.read("again.csv"));
}

#[test]
fn mujoco_is_tuned_to_what_another_integrator_made() {
    if !python("mujoco") {
        return;
    }
    let folder = Folder::new();
    folder.write("mujoco_pendulum.py", MUJOCO);
    folder.write("scene.toml", MUJOCO_SCENE);
    // A ball of .05 m: I = m l² + 2/5 m r², so that it swings like a point on a longer rod.
    let (length_m, radius_m, mass_kg, damping) = (0.7, 0.05, 0.5, 0.04);
    let stretch = 1.0 + 0.4 * radius_m * radius_m / (length_m * length_m);
    let inertia = mass_kg * length_m * length_m * stretch;
    let swing = Swing { length_m, stretch, damping_1_s: damping / inertia, ..Swing::default() };
    folder.write("swing.csv", swing.csv("t_s,angle_rad"));
    let json = folder.run("tune --sim scene.toml --allow-process --observation swing.csv --json").ends(0).json();
    holds(&json, "length", length_m, 2e-3);
    holds(&json, "damping", damping, 4e-3);
}

#[test]
fn a_program_is_diagnosed() {
    if !python("json") {
        return;
    }
    let folder = pendulum();
    let mut manifest = String::new();
    for (seed, start_rad) in [(1, 0.5), (2, 0.9), (3, 0.25)] {
        let late = Swing { seed, late_s: 0.04, start_rad, ..Swing::default() };
        folder.write(&format!("late_{seed}.csv"), late.csv("t_s,angle_rad"));
        let entry = format!("file = \"late_{seed}.csv\"\nobject = \"{seed}\"\nsettings.start_rad = {start_rad}\n");
        writeln!(manifest, "[[observation]]\n{entry}").unwrap();
        let shaken = Swing { seed, shaken: 2.0, ..Swing::default() };
        folder.write(&format!("shaken_{seed}.csv"), shaken.csv("t_s,angle_rad"));
    }
    folder.write("late.toml", manifest);
    let diagnose =
        |what: &str| folder.run(&format!("diagnose --sim pendulum.toml --allow-process --json --out improved {what}"));
    let none = diagnose("--observation swing.csv").ends(0).json();
    assert_eq!(none["verdict"], "none");
    std::fs::remove_file(folder.path("improved")).unwrap();

    // Swings that begin otherwise are objects with settings of their own; the clock that is late is common to all.
    let named = diagnose("--manifest late.toml").ends(0).json();
    assert_eq!((named["verdict"].as_str(), named["effects"][0]["name"].as_str()), (Some("named"), Some("time_offset")));
    let offset = &named["effects"][0]["coefficients"]["offset_s"]["value"];
    assert!((offset.as_f64().unwrap() - 0.04).abs() < 2e-3, "{offset}");
    let improved = String::from_utf8(folder.read("improved/2.toml")).unwrap();
    for wanted in ["kind = \"process\"", "[effects.time_offset]", "start_rad = 0.9", "folder = \"..\""] {
        assert!(improved.contains(wanted), "no {wanted} in:\n{improved}");
    }
    let refused = folder.run("tune --sim improved/2.toml --observation late_2.csv").ends(2);
    assert!(refused.stderr.contains("--allow-process"));
    let again = folder.run("tune --sim improved/2.toml --allow-process --observation late_2.csv --json").ends(0).json();
    holds(&again, "length", 0.62, 2e-3);
    std::fs::remove_dir_all(folder.path("improved")).unwrap();

    // What shakes the hinge is in no catalogue of a measurement.
    let unknown = diagnose("--observation shaken_1.csv shaken_2.csv shaken_3.csv").ends(3).json();
    assert_eq!(unknown["verdict"], "unknown");
}

#[test]
fn pairs_are_generated_and_a_network_learns_from_them() {
    if !python("json") {
        return;
    }
    let folder = pendulum();
    let refused = folder.run("gen process --sim pendulum.toml --pairs 4 --out pairs.mcap").ends(2);
    assert!(refused.stderr.contains("--allow-process"));
    let few = "--set record.frames=40 --set record.rate_hz=20";
    folder.run(&format!("gen process --sim pendulum.toml --allow-process {few} --pairs 40 --out pairs.mcap")).ends(0);
    folder.run("inspect pairs.mcap").ends(0);
    folder.run("train --data pairs.mcap --preset paper --out model.safetensors").ends(0);
    let line = "tune --sim pendulum.toml --allow-process --observation swing.csv --model model.safetensors --json";
    let json = folder.run(line);
    assert!(matches!(json.code, Some(0 | 3)), "{}", json.stderr);
    assert_eq!(json.json()["model"]["source"], "given");
}

#[test]
fn what_is_not_a_programs_is_refused() {
    let folder = pendulum();
    folder.write("task.toml", include_str!("../assets/shot.toml"));
    folder.write("a.mp4", b"\0\0\0\x18ftypisom");
    for (line, code, wanted) in [
        ("plan --sim pendulum.toml --task task.toml", 1, "found that of a program"),
        ("simulate --sim pendulum.toml --allow-process --bounces --out a.csv", 2, "`--bounces`"),
        ("simulate --sim pendulum.toml --allow-process --out a.mcap", 2, "ends in .csv"),
        ("gen ball --sim pendulum.toml --out a.mcap", 1, "expected `kind = \"ball\"` here, found \"process\""),
        ("tune --sim pendulum.toml --observation a.mp4 --allow-process", 1, "found a film"),
        ("tune --sim pendulum.toml --observation swing.csv --set parameters.weight.value=1", 2, "(length, damping)"),
        (
            "tune --sim pendulum.toml --observation swing.csv --set process.channels=[\"<b>\"]",
            2,
            "names with their units",
        ),
        ("tune --sim pendulum.toml --observation swing.csv --set kind=ball", 2, "\"process\" for `kind`"),
    ] {
        let ran = folder.run(line).ends(code);
        assert!(ran.stderr.contains(wanted), "{line}: {}", ran.stderr);
        assert!(!folder.path("a.csv").exists() && !folder.path("a.mcap").exists(), "{line}");
    }
    folder.write("other.csv", "t_s,theta\n0,1\n1,2\n2,3\n");
    common::refused(
        &folder,
        "tune --sim pendulum.toml --observation other.csv --allow-process",
        &["expected a column `angle_rad`", "found `t_s`, `theta`", "`--columns angle_rad=theta`"],
    );
}

#[test]
fn inspect_knows_the_channels_and_runs_nothing() {
    let folder = pendulum();
    folder.write("pendulum.toml", PENDULUM_SCENE.replace("\"pendulum.py\"", "\"-c\", \"open('ran', 'w')\""));
    let ran = folder.run("inspect swing.csv").ends(3);
    assert!(ran.stderr.contains("where a program of yours simulates `angle_rad`"), "{}", ran.stderr);
    let json = folder.run("inspect swing.csv --sim pendulum.toml --json").ends(0).json();
    assert_eq!((json["usable"].as_bool(), json["columns"][1]["read_as"].as_str()), (Some(true), Some("angle_rad")));
    let json = folder.run("inspect pendulum.toml --json").ends(0).json();
    assert_eq!((json["command"][0].as_str(), json["channels"][0].as_str()), (Some("python3"), Some("angle_rad")));
    assert!(!folder.path("ran").exists());
}

/// Nothing of a file is run without the flag, whatever the file and the command line say.
#[test]
fn no_file_is_run_without_leave() {
    let folder = pendulum();
    let evil = PENDULUM_SCENE.replace("command = [\"python3\", \"pendulum.py\"]", "command = [\"touch\", \"ran\"]");
    folder.write(
        "evil.toml",
        format!("{evil}\n[provenance]\ntool = \"tunenet 0.1.0\"\ncommand = \"tune --allow-process\"\n"),
    );
    folder.write("allowing.toml", evil.replace("[record]", "allow_process = true\n[record]"));
    folder.write(
        "setting.toml",
        format!("{evil}\n[settings.allow_process]\nyes = true\n")
            .replace("[settings]\ngravity_m_s2 = 9.81\nstart_rad = 0.5\n", ""),
    );
    folder.write("manifest.toml", "[[observation]]\nfile = \"swing.csv\"\nprocess.command = [\"touch\", \"ran\"]\n");
    folder.write("task.toml", include_str!("../assets/shot.toml"));
    let before = folder.names();
    for (line, code) in [
        ("tune --sim evil.toml --observation swing.csv", 2),
        ("tune --sim evil.toml --observation swing.csv --each", 2),
        ("tune --sim setting.toml --observation swing.csv --set process.command=[\"touch\",\"ran\"]", 2),
        ("tune --sim allowing.toml --observation swing.csv", 1),
        ("tune --sim evil.toml --observation swing.csv --set allow_process=true", 2),
        ("diagnose --sim evil.toml --observation swing.csv", 2),
        ("diagnose --sim evil.toml --manifest manifest.toml", 2),
        // Leave for one program is none for another that a manifest names.
        ("diagnose --sim pendulum.toml --allow-process --manifest manifest.toml", 1),
        ("simulate --sim evil.toml --out a.csv", 2),
        ("gen process --sim evil.toml --out a.mcap", 2),
        ("gen ball --sim evil.toml --allow-process --out a.mcap", 1),
        ("plan --sim evil.toml --task task.toml", 1),
        ("inspect evil.toml", 0),
        ("inspect swing.csv --sim evil.toml", 0),
    ] {
        let ran = folder.run(line).ends(code);
        assert!(ran.stdout.is_empty() && !ran.stderr.contains("panicked"), "{line}: {}", ran.stdout);
        assert_eq!(folder.names(), before, "{line}: {}", ran.stderr);
    }
}

/// Beginning of a program that greets and answers with `answer`, a piece of Python with `request` and `id`.
fn program(answer: &str) -> String {
    format!(
        "import json, math, os, sys, time\nprint('{{\"tunenet\":1}}', flush=True)\nsys.stdin.readline()\n\
         for line in sys.stdin:\n    request = json.loads(line)\n    id, n = request['id'], len(request['times_s'])\n    \
         good = json.dumps({{'id': id, 'values': [[math.exp(-t)] for t in request['times_s']]}})\n{}",
        answer.lines().map(|line| format!("    {line}\n")).collect::<String>()
    )
}

const GOOD: &str = "print(good, flush=True)";

/// Whether any process still has `mark` among its arguments.
fn alive(mark: &str) -> Vec<String> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir("/proc").into_iter().flatten().flatten() {
        let Ok(pid) = entry.file_name().to_string_lossy().parse::<u32>() else { continue };
        let words = std::fs::read(entry.path().join("cmdline")).unwrap_or_default();
        if String::from_utf8_lossy(&words).contains(mark) && pid != std::process::id() {
            found.push(String::from_utf8_lossy(&words).replace('\0', " "));
        }
    }
    found
}

/// Waits until no process has `mark` among its arguments.
#[track_caller]
fn gone(mark: &str) {
    let until = Instant::now() + Duration::from_secs(5);
    while !alive(mark).is_empty() {
        assert!(Instant::now() < until, "left behind: {:?}", alive(mark));
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Every way in which a program can fail has its sentence and its remedy; nothing is waited for in vain, nothing is left.
#[test]
fn every_failure_of_a_program_is_told() {
    if !python("json") {
        return;
    }
    let greet = "import sys, time\nprint('{\"tunenet\":1}', flush=True)\n";
    let cases: Vec<(&str, String, &[&str], &str)> = vec![
        (
            "exits at once",
            "import sys\nsys.exit(3)\n".into(),
            &["the first line", "it ended (exit status: 3)"],
            "by hand",
        ),
        ("exits when asked", program("sys.exit('no mesh')"), &["request 1 (k=1)", "its last words: `no mesh`"], "why"),
        (
            "dies of an error",
            program("raise ValueError('<script>\\x1b[31m')"),
            &["exit status: 1", "ValueError: <script>\u{fffd}[31m`"],
            "standard error ended with",
        ),
        ("dies of a signal", program("os.kill(os.getpid(), 9)"), &["signal: 9"], "input ends"),
        (
            "hangs at the start",
            "import time\ntime.sleep(100)\n".into(),
            &["the first line", "within 1 s, found none, and stopped it"],
            "process.start_timeout_s",
        ),
        (
            "hangs later",
            program("time.sleep(100)"),
            &["request 1", "within 1 s, found none, and stopped it"],
            "process.timeout_s",
        ),
        ("does not flush", program("sys.stdout.write(good + '\\n')"), &["within 1 s"], "flush=True"),
        ("does not read", format!("{greet}time.sleep(100)\n"), &["within 1 s, found none"], "line by line"),
        (
            "closes its output",
            program("os.close(1); time.sleep(100)"),
            &["it closed its standard output"],
            "every line",
        ),
        (
            "prints garbage",
            program("print('Hello', flush=True)"),
            &["expected one JSON object on a line, found `Hello`"],
            "standard error",
        ),
        (
            "prints debug text first",
            program("print('t =', 1)\nprint(good, flush=True)"),
            &["found `t = 1`"],
            "nothing else on standard output",
        ),
        (
            "prints debug text afterwards",
            program("print(good)\nprint('done', flush=True)"),
            &["request 2", "found `done`"],
            "nothing else",
        ),
        (
            "prints bytes",
            program("os.write(1, b'\\xff\\x00\\xfe\\n')"),
            &["expected text in UTF-8"],
            "one line of JSON",
        ),
        (
            "greets another",
            "import time\nprint('{\"tunenet\": 7}', flush=True)\ntime.sleep(9)\n".into(),
            &["expected protocol 1, found 7"],
            "docs/process.md",
        ),
        (
            "another id",
            program("print(good.replace('\"id\": ', '\"id\": 9'), flush=True)"),
            &["expected the answer to request 1, found `\"id\": 91`"],
            "one line",
        ),
        (
            "too few rows",
            program("print(json.dumps({'id': id, 'values': [[1.0]]}), flush=True)"),
            &["expected 16 rows in `values`, found 1"],
            "times_s",
        ),
        (
            "rows too long",
            program("print(json.dumps({'id': id, 'values': [[1.0, 2.0]] * n}), flush=True)"),
            &["expected 1 number in row 1 of `values` (angle_rad), found 2"],
            "process.channels",
        ),
        (
            "no rows",
            program("print(json.dumps({'id': id, 'values': [1.0] * n}), flush=True)"),
            &["expected `values` as one row for each"],
            "error",
        ),
        (
            "not a number",
            program("print(json.dumps({'id': id, 'values': [[0.0], [math.nan]] * n}), flush=True)"),
            &["expected finite numbers, found `NaN` in row 2"],
            "cannot be simulated",
        ),
        (
            "null",
            program("print(json.dumps({'id': id, 'values': [[0.0], [None]] * (n // 2)}), flush=True)"),
            &["found `null` for `angle_rad` in row 2"],
            "cannot be simulated",
        ),
        (
            "no answer in it",
            program("print(json.dumps({'id': id}), flush=True)"),
            &["expected `values` or `error`"],
            "error",
        ),
        (
            "an endless line",
            program("while True: os.write(1, b'x' * 65536)"),
            &["at most 66560 bytes, found a longer line"],
            "one on each line",
        ),
        (
            "endless lines",
            "import os\nwhile True: os.write(1, b'x\\n' * 30000)\n".into(),
            &["found `x`"],
            "one line of JSON",
        ),
        (
            "chance",
            program("import random\nprint(json.dumps({'id': id, 'values': [[random.random()]] * n}), flush=True)"),
            &["expected the same answer to the same parameters", "row 1"],
            "fixed seed",
        ),
        (
            "its own start",
            program("print(json.dumps({'id': id, 'error': 'no pendulum is so short'}), flush=True)"),
            &["the simulator refused k=1: no pendulum is so short"],
            "",
        ),
    ];
    for (i, (what, text, wanted, hint)) in cases.iter().enumerate() {
        let folder = Folder::new();
        let mark = format!("mark_{}_{i}.py", std::process::id());
        folder.write(&mark, text);
        // Only what hangs is waited for briefly: a machine may be slow.
        let (mut hurried, hangs) =
            (scene(&format!("[\"python3\", \"{mark}\"]")), wanted.iter().any(|w| w.contains("within 1 s")));
        if hangs {
            let key = if *hint == "process.start_timeout_s" { "start_timeout_s" } else { "\ntimeout_s" };
            hurried = hurried.replace(&format!("{key} = 30"), &format!("{key} = 1"));
        }
        folder.write("a.toml", hurried);
        let began = Instant::now();
        let mut command = folder.command();
        command.env_remove("PYTHONUNBUFFERED").args("simulate --sim a.toml --allow-process --out a.csv".split(' '));
        let ran = Ran::from(command.output().unwrap());
        assert_eq!(ran.code, Some(1), "{what}: {}", ran.stderr);
        assert!(began.elapsed() < Duration::from_secs(40), "{what}: {:?}", began.elapsed());
        assert!(ran.stdout.is_empty() && !folder.path("a.csv").exists(), "{what}");
        let sentence = ran.stderr.lines().next().unwrap_or_default();
        assert!(sentence.starts_with("error: "), "{what}: {}", ran.stderr);
        for text in *wanted {
            assert!(sentence.contains(text), "{what}: no `{text}` in:\n{}", ran.stderr);
        }
        assert!(ran.stderr.contains(hint) && !ran.stderr.contains('\u{1b}'), "{what}: no `{hint}` in:\n{}", ran.stderr);
        gone(&mark);
    }
}

fn scene(command: &str) -> String {
    format!(
        "kind = \"process\"\n[process]\ncommand = {command}\nchannels = [\"angle_rad\"]\ntimeout_s = 30\nstart_timeout_s = 30\n\
         [record]\nrate_hz = 20\nframes = 40\n[parameters.k]\nvalue = 1\nmin = 0\nmax = 2\n"
    )
}

/// What cannot be started is told as well.
#[test]
fn a_program_that_is_not_there_is_told() {
    let folder = Folder::new();
    folder.write("plain.txt", "no program");
    for (command, wanted) in [
        ("[\"no-such-program\"]", &["`no-such-program` could not be started in", "No such file", "install it"][..]),
        ("[\"./none.py\"]", &["`./none.py` could not be started", "seen from the folder"]),
        ("[\"./plain.txt\"]", &["Permission denied", "chmod +x"]),
        ("[\"echo hello; touch ran\"]", &["`echo hello; touch ran` could not be started"]),
        ("[]", &["process.command`: expected [\"text\", …], at least one"]),
        ("[\"\"]", &["a program's name first"]),
    ] {
        folder.write("a.toml", scene(command));
        common::refused(&folder, "simulate --sim a.toml --allow-process --out a.csv", wanted);
    }
    folder.write("a.toml", scene("[\"python3\"]").replace("[record]", "folder = \"none\"\n[record]"));
    common::refused(
        &folder,
        "simulate --sim a.toml --allow-process --out a.csv",
        &["`process.folder`: expected a folder"],
    );
}

/// A program that fails while it is tuned to stops the tuning at once, and is told rather than what the fit made of it.
#[test]
fn a_program_that_fails_later_is_told_by_every_command() {
    if !python("json") {
        return;
    }
    let folder = Folder::new();
    let mark = format!("later_{}.py", std::process::id());
    folder.write(
        &mark,
        program(&format!("if request['parameters']['k'] != 1: sys.exit('<script>alert(1)</script>')\n{GOOD}")),
    );
    folder.write("a.toml", scene(&format!("[\"python3\", \"{mark}\"]")));
    let row = |i: u32| format!("{},{}\n", f64::from(i) / 20.0, (-0.7 * f64::from(i) / 20.0).exp());
    folder.write("a.csv", format!("t_s,angle_rad\n{}", (0..40).map(row).collect::<String>()));
    let wanted = &["a.toml: `python3 ", "it ended (exit status: 1); its last words: `<script>alert(1)</script>`"];
    common::refused(&folder, "tune --sim a.toml --allow-process --observation a.csv --json", wanted);
    common::refused(&folder, "diagnose --sim a.toml --allow-process --observation a.csv --json", wanted);
    common::refused(&folder, "gen process --sim a.toml --allow-process --pairs 3 --out a.mcap", wanted);
    // A page that tells of it shows its words and does not run them.
    let each =
        folder.run("tune --sim a.toml --allow-process --observation a.csv --each --report a.html --json").ends(1);
    assert!(each.json()["observations"][0]["error"].as_str().unwrap().contains("<script>alert"));
    let page = String::from_utf8(folder.read("a.html")).unwrap();
    assert!(page.contains("&lt;script&gt;alert(1)&lt;/script&gt;") && !page.contains("<script>alert"), "{page}");
    gone(&mark);
}

/// Names, units and refusals of a program stand on the pages of `tune` and `diagnose` as text.
#[test]
fn hostile_text_stays_text_on_pages() {
    if !python("json") {
        return;
    }
    let folder = pendulum();
    let hostile = PENDULUM_SCENE
        .replace("unit = \"m\"", "unit = \"<script>alert(1)</script>\"")
        .replace("unit = \"1/s\"", "unit = '\"onload=\"alert(2)'")
        .replace("gravity_m_s2 = 9.81", "gravity_m_s2 = 9.81\nnote = \"</script><script>alert(3)</script>\"");
    folder.write("hostile.toml", hostile);
    folder.write("<img src=x onerror=alert(4)>.csv", folder.read("swing.csv"));
    for command in ["tune", "diagnose"] {
        let mut run = folder.command();
        run.args([command, "--sim", "hostile.toml", "--allow-process", "--report", "page.html", "--observation"]);
        Ran::from(run.arg("<img src=x onerror=alert(4)>.csv").output().unwrap()).ends(0);
        let page = String::from_utf8(folder.read("page.html")).unwrap();
        assert!(page.contains("&lt;script&gt;alert(1)&lt;/script&gt;"), "{command}");
        for raw in ["<script>alert", "<img src=x", "\"onload=\"", "</script><script>"] {
            assert!(!page.contains(raw), "{command}: {raw}");
        }
    }
    // A channel's name cannot even be such a thing.
    folder.write("hostile.toml", PENDULUM_SCENE.replace("\"angle_rad\"", "\"<script>_m\""));
    common::refused(
        &folder,
        "inspect hostile.toml",
        &["`process.channels`: expected names with their units", "`<script>_m`"],
    );
    folder.write("hostile.toml", PENDULUM_SCENE.replace("unit = \"m\"", "unit = \"\\u001b[2J\""));
    common::refused(&folder, "inspect hostile.toml", &["without control characters"]);
}

/// Children end with their parent, also where it is killed: their input ends.
#[test]
fn nothing_is_left_where_tunenet_is_killed() {
    if !python("json") {
        return;
    }
    let folder = Folder::new();
    let mark = format!("killed_{}.py", std::process::id());
    folder.write(&mark, program(&format!("if request['parameters']['k'] != 1: time.sleep(0.2)\n{GOOD}")));
    folder.write("a.toml", scene(&format!("[\"python3\", \"{mark}\"]")));
    let row = |i: u32| format!("{},{}\n", f64::from(i) / 20.0, (-0.7 * f64::from(i) / 20.0).exp());
    folder.write("a.csv", format!("t_s,angle_rad\n{}", (0..40).map(row).collect::<String>()));
    let mut command = folder.command();
    command.args(["tune", "--sim", "a.toml", "--allow-process", "--observation", "a.csv"]);
    let mut tunenet = command.stderr(std::process::Stdio::null()).spawn().unwrap();
    let until = Instant::now() + Duration::from_secs(10);
    while alive(&mark).is_empty() && Instant::now() < until {
        std::thread::sleep(Duration::from_millis(10));
    }
    if cfg!(target_os = "linux") {
        assert!(!alive(&mark).is_empty());
    }
    tunenet.kill().unwrap();
    tunenet.wait().unwrap();
    gone(&mark);
}

/// A flood on standard error fills no pipe.
#[test]
fn much_on_standard_error_holds_up_nobody() {
    if !python("json") {
        return;
    }
    let folder = Folder::new();
    folder.write("a.py", program(&format!("sys.stderr.write('chatter\\n' * 100000)\n{GOOD}")));
    folder.write("a.toml", scene("[\"python3\", \"a.py\"]"));
    let ran = folder.run("simulate --sim a.toml --allow-process --out a.csv").ends(0);
    assert!(!ran.stderr.contains("chatter"), "{}", ran.stderr);
    // Numbers come through to the last bit.
    let text = String::from_utf8(folder.read("a.csv")).unwrap();
    for (i, line) in text.lines().skip(1).enumerate() {
        let (t, value) = line.split_once(',').unwrap();
        let [t, value] = [t, value].map(|v| v.parse::<f64>().unwrap());
        assert_eq!(t, i as f64 / 20.0);
        assert!((value / (-t).exp() - 1.0).abs() < 1e-15, "{line}");
    }
}

/// What `init process` writes works as it stands.
#[test]
fn what_init_writes_can_be_tuned_with() {
    let folder = Folder::new();
    let json = folder.run("init process --json").ends(0).json();
    assert_eq!(json["file"], "process.toml");
    assert_eq!(folder.read("pendulum.py"), PENDULUM.as_bytes());
    folder.run("inspect process.toml").ends(0);
    common::refused(&folder, "init process", &["process.toml: expected a new name"]);
    folder.run("init process --out other.toml").ends(0);
    folder.write("pendulum.py", "# mine\n");
    common::refused(&folder, "init process --out third.toml", &["pendulum.py: expected a new name"]);
    if !python("json") {
        return;
    }
    folder.run("init process --overwrite").ends(0);
    folder.write("swing.csv", Swing::default().csv("t_s,angle_rad"));
    let json = folder.run("tune --sim process.toml --allow-process --observation swing.csv --json").ends(0).json();
    holds(&json, "length", 0.62, 2e-3);
}

/// Pages of the documentation show the programs as they are.
#[test]
fn the_documentation_shows_the_programs_that_are_tested() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/process.md");
    let page = std::fs::read_to_string(page).unwrap();
    assert!(page.contains(PENDULUM) && page.contains(MUJOCO), "docs/process.md differs from assets/process");
}
