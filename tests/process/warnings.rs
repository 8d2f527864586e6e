//! What a program cannot simulate while it is tuned to is told and not only passed over; that it is worked on is shown; and what it
//! gets wrong for a while alone is found.

use std::process::Command;

use crate::common::{Folder, Ran};
use crate::process::programs::{program, python, scene};

/// A folder with a program that answers exp(-k t) after `first`, its scene, and what it would show at k = 0.7.
fn decay(first: &str, scene_of: &dyn Fn(String) -> String) -> Folder {
    let folder = Folder::new();
    let answers = "rows = [[math.exp(-k * t)] for t in request['times_s']]\n\
                   print(json.dumps({'id': id, 'values': rows}), flush=True)";
    folder.write("a.py", program(&format!("k = request['parameters']['k']\n{first}{answers}")));
    folder.write("a.toml", scene_of(scene("[\"python3\", \"a.py\"]")));
    let row = |i: u32| format!("{},{}\n", f64::from(i) / 20.0, (-0.7 * f64::from(i) / 20.0).exp());
    folder.write("a.csv", format!("t_s,angle_rad\n{}", (0..40).map(row).collect::<String>()));
    folder
}

const TUNE: &str = "tune --sim a.toml --allow-process --observation a.csv";

/// The one warning with this code.
#[track_caller]
fn warned(json: &serde_json::Value, code: &str) -> String {
    let all: Vec<&serde_json::Value> =
        json["warnings"].as_array().unwrap().iter().filter(|w| w["code"] == code).collect();
    assert!(all.len() == 1 && all[0]["remedy"].as_str().unwrap().contains("narrow `min` and `max`"), "{json:#}");
    all[0]["text"].as_str().unwrap().into()
}

/// Bounds that a program refuses are searched all the same, and that is told once, with where and why; whatever the threads.
#[test]
fn rollouts_that_a_program_refuses_are_told() {
    if !python("json") {
        return;
    }
    let refuses =
        "if k < 0.3:\n    print(json.dumps({'id': id, 'error': f'too stiff at {k}'}), flush=True)\n    continue\n";
    let folder = decay(refuses, &|scene| scene);
    let ran = folder.run(&format!("{TUNE} --json")).ends(0);
    let text = warned(&ran.json(), "program.refused");
    assert!(
        text.starts_with("the program refused ")
            && text.contains(" rollouts, of these nearest to the file's values k="),
        "{text}"
    );
    let numbers: Vec<u64> = text.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    assert!(numbers.len() >= 2 && numbers[0] > 0 && numbers[0] < numbers[1], "{text}");
    let said = text.strip_suffix(" (simulating a.csv)").unwrap_or_else(|| panic!("{text}"));
    let k: f64 = said.rsplit(' ').next().unwrap().parse().unwrap();
    assert!(k < 0.3 && said.ends_with(&format!("k={k}: too stiff at {k}")), "{text}");
    for threads in ["1", "3"] {
        let mut command = folder.command();
        command.env("RAYON_NUM_THREADS", threads).args(TUNE.split_whitespace());
        let told = Ran::from(command.output().unwrap()).ends(0).stderr;
        assert!(told.contains(&format!("warning[program.refused]: {text}\n  try: narrow")), "{threads}: {told}");
    }
    let each = folder.run(&format!("{TUNE} --each --json")).ends(0).json();
    assert_eq!(warned(&each["observations"][0], "program.refused"), text);
    // Narrower bounds need no warning.
    let narrow = folder.run(&format!("{TUNE} --set parameters.k.min=0.3 --json")).ends(0).json();
    assert!(narrow["warnings"].as_array().unwrap().iter().all(|w| w["code"] != "program.refused"), "{narrow:#}");
    let diagnosed = folder.run("diagnose --sim a.toml --allow-process --observation a.csv --json");
    warned(&diagnosed.json(), "program.refused");
}

/// A number that nobody can reckon with is an answer and no refusal.
#[test]
fn answers_beyond_all_reckoning_are_told() {
    if !python("json") {
        return;
    }
    let huge = "if k < 0.3:\n    rows = [[0.0], [-1e160]] * (n // 2)\n    \
                print(json.dumps({'id': id, 'values': rows}), flush=True)\n    continue\n";
    let folder = decay(huge, &|scene| scene);
    let ran = folder.run(&format!("{TUNE} --json")).ends(0);
    let text = warned(&ran.json(), "program.beyond");
    assert!(text.starts_with("the program answered numbers beyond 1e100 in ") && !text.contains("refused"), "{text}");
    assert!(text.ends_with("-1e160 for `angle_rad` in row 2 (simulating a.csv)"), "{text}");
}

/// A program that answers wrong for a while, and right whenever a hundred rollouts have passed, is found out.
#[test]
fn a_program_that_is_wrong_for_a_while_is_told() {
    if !python("json") {
        return;
    }
    // Whoever asks again after every hundred rollouts, as requests 103, 204 and so on, hears nothing but right answers.
    let wrong = "k += 1e-9 if 30 <= (id - 3) % 101 < 60 else 0\n";
    let folder = decay(wrong, &|scene| scene.replace("[record]", "workers = 1\n[record]"));
    // Each time it is asked again, three of ten times it is found out; in which order threads ask varies.
    crate::common::refused(
        &folder,
        "gen process --sim a.toml --allow-process --pairs 3000 --out a.mcap",
        &["expected the same answer to the same parameters", "when asked again after"],
    );
}

/// On a terminal slow work shows that it goes on; without one, and with `--json`, nothing does.
#[cfg(unix)]
#[test]
fn a_slow_program_is_seen_to_work_on_a_terminal() {
    if !python("pty") {
        return;
    }
    let folder = decay("time.sleep(0.02)\n", &|scene| scene);
    let on_a_terminal = |arguments: &str| {
        let tunenet = folder.command();
        let mut command = Command::new("python3");
        let spawn = "import os, pty, sys\nsys.exit(os.waitstatus_to_exitcode(pty.spawn(sys.argv[1:])))";
        command.args(["-c", spawn]).arg(tunenet.get_program()).args(arguments.split_whitespace());
        command.current_dir(tunenet.get_current_dir().unwrap()).env("TERM", "xterm").env_remove("NO_COLOR");
        command.stdin(std::process::Stdio::null());
        Ran::from(command.output().unwrap()).ends(0).stdout
    };
    let seen = on_a_terminal(TUNE);
    let counts = |text: &str| -> Vec<u64> {
        let after = text.split("tuning, ").skip(1).filter_map(|rest| rest.split_once(" rollouts"));
        after.filter_map(|(count, _)| count.parse().ok()).collect()
    };
    let shown = counts(&seen);
    assert!(shown.iter().any(|count| *count > 0) && shown.is_sorted(), "{shown:?} in {seen}");
    assert!(seen.contains("TUNED"), "{seen}");
    assert!(!on_a_terminal(&format!("{TUNE} --json")).contains("tuning"));
    assert!(!folder.run(TUNE).ends(0).stderr.contains("tuning"));
}
