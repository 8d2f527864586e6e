//! Programs of one's own are run with leave alone; each of their failures is told in one sentence, nothing that they say is more than
//! text, and no process is left behind.

use std::time::{Duration, Instant};

use crate::common::{Folder, Ran};
use crate::process::failing::{ends_or_hangs, misspeaks, overdoes};
use crate::process::programs::{GOOD, PENDULUM_SCENE, alive, gone, pendulum, program, python, scene};

/// Nothing of a file is run without the flag, whatever the file and the command line say.
#[test]
fn no_file_is_run_without_permission() {
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
    folder.write("task.toml", include_str!("../../assets/shot.toml"));
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
        assert!(ran.stdout.is_empty() == (code != 0), "{line}: {}", ran.stdout);
        assert_eq!(folder.names(), before, "{line}: {}", ran.stderr);
    }
}

/// Every way in which a program can fail has its sentence and its remedy; nothing is waited for in vain, nothing is left.
#[test]
fn every_failure_of_a_program_is_told() {
    if !python("json") {
        return;
    }
    let cases = [ends_or_hangs(), misspeaks(), overdoes()].concat();
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

/// What cannot be started is told as well.
#[test]
fn a_program_that_is_not_there_is_told() {
    let folder = Folder::new();
    folder.write("plain.txt", "no program");
    for (command, wanted) in [
        ("[\"no-such-program\"]", &["`no-such-program` could not be started in", "No such file", "install it"][..]),
        ("[\"./none.py\"]", &["`./none.py` could not be started", "seen from the folder"]),
        ("[\"./plain.txt\"]", &["Permission denied", "chmod +x"]),
        ("[\"echo hello; touch ran\"]", &["`'echo hello; touch ran'` could not be started"]),
        ("[]", &["process.command`: expected [\"text\", …], at least one"]),
        ("[\"\"]", &["a program's name first"]),
    ] {
        folder.write("a.toml", scene(command));
        crate::common::refused(&folder, "simulate --sim a.toml --allow-process --out a.csv", wanted);
    }
    folder.write("a.toml", scene("[\"python3\"]").replace("[record]", "folder = \"none\"\n[record]"));
    crate::common::refused(
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
    crate::common::refused(&folder, "tune --sim a.toml --allow-process --observation a.csv --json", wanted);
    crate::common::refused(&folder, "diagnose --sim a.toml --allow-process --observation a.csv --json", wanted);
    crate::common::refused(&folder, "gen process --sim a.toml --allow-process --pairs 3 --out a.mcap", wanted);
    // A page that tells of it shows its words and does not run them.
    let each =
        folder.run("tune --sim a.toml --allow-process --observation a.csv --each --report a.html --json").ends(1);
    assert!(each.json()["observations"][0]["error"].as_str().unwrap().contains("<script>alert"));
    let page = folder.text("a.html");
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
        let page = folder.text("page.html");
        assert!(page.contains("&lt;script&gt;alert(1)&lt;/script&gt;"), "{command}");
        for raw in ["<script>alert", "<img src=x", "\"onload=\"", "</script><script>"] {
            assert!(!page.contains(raw), "{command}: {raw}");
        }
    }
    // A channel's name cannot even be such a thing.
    folder.write("hostile.toml", PENDULUM_SCENE.replace("\"angle_rad\"", "\"<script>_m\""));
    crate::common::refused(
        &folder,
        "inspect hostile.toml",
        &["`process.channels`: expected lower-case names with their units", "`<script>_m`"],
    );
    folder.write("hostile.toml", PENDULUM_SCENE.replace("unit = \"m\"", "unit = \"\\u001b[2J\""));
    crate::common::refused(&folder, "inspect hostile.toml", &["without control characters"]);
}

/// What a program refuses, or answers beyond all reckoning, at the values of the file is no fault of the recording.
#[test]
fn a_refusal_of_the_files_own_values_is_told_as_that() {
    if !python("json") {
        return;
    }
    let folder = Folder::new();
    let row = |i: u32| format!("{},{}\n", f64::from(i) / 20.0, (-0.7 * f64::from(i) / 20.0).exp());
    folder.write("seen.csv", format!("t_s,angle_rad\n{}", (0..40).map(row).collect::<String>()));
    folder.write("a.toml", scene("[\"python3\", \"a.py\"]"));
    let no = "print(json.dumps({'id': id, 'error': 'too short'}), flush=True)";
    let huge = "print(json.dumps({'id': id, 'values': [[1e160]] * n}), flush=True)";
    let answered = "the program answered 1e160 for `angle_rad` at sample 1 to ";
    let beyond = ": expected a finite number of at most 1e100";
    for (answer, told, why) in [(no, "the program refused ", ": too short"), (huge, answered, beyond)] {
        folder.write("a.py", program(answer));
        let own = format!("error: a.toml: {told}the file's own values (k=1){why}");
        let wanted = [own.as_str(), "parameters.k.value=…"];
        crate::common::refused(&folder, "tune --sim a.toml --allow-process --observation seen.csv --json", &wanted);
        crate::common::refused(&folder, "diagnose --sim a.toml --allow-process --observation seen.csv --json", &wanted);
        let within = format!("a.toml: {told}k=");
        let wanted = [within.as_str(), why, "narrow the bounds"];
        crate::common::refused(&folder, "gen process --sim a.toml --allow-process --pairs 3 --out a.mcap", &wanted);
    }
    // Large numbers that can be reckoned with leave no infinity in the answer.
    folder.write("a.py", program("print(json.dumps({'id': id, 'values': [[1e99]] * n}), flush=True)"));
    let ran = folder.run("tune --sim a.toml --allow-process --observation seen.csv --json").ends(3);
    let gap = &ran.json()["gap"];
    assert!(gap["before"].as_f64().is_some_and(|gap| gap > 9e98), "{gap}");
    assert!(!ran.stderr.contains("inf"), "{}", ran.stderr);
    // Nor a row of digits that nobody counts, in any of the sentences.
    let digits = |text: &str| text.split(|c: char| !c.is_ascii_digit()).map(str::len).max().unwrap_or(0);
    let ran = folder.run("tune --sim a.toml --allow-process --observation seen.csv").ends(3);
    let text = ran.stderr;
    assert!(digits(&ran.stdout) < 16, "{}", ran.stdout);
    assert!(
        text.contains("warning[fit.poor]: the tuned rollout leaves ")
            && ran.stdout.contains("e99")
            && digits(&text) < 16,
        "{text}"
    );
    let text = folder.run("diagnose --sim a.toml --allow-process --report a.html --observation seen.csv");
    assert!(digits(&text.stdout) < 16 && digits(&text.stderr) < 16, "{}{}", text.stdout, text.stderr);
    let page = folder.text("a.html");
    let shown: Vec<&str> = page.split('<').filter_map(|part| part.split_once('>')).map(|(_, text)| text).collect();
    let shown = shown.join(" ");
    assert!(digits(&shown) < 20, "{shown}");
}

/// Values that a program refuses in the middle of a fit bound what it can find, and end nothing.
#[test]
fn a_fit_ends_beside_what_the_program_refuses() {
    if !python("json") {
        return;
    }
    let folder = Folder::new();
    let edge = "k = request['parameters']['k']\nrows = [[math.exp(-k * t)] for t in request['times_s']]\n\
                print(json.dumps({'id': id, 'error': 'too quick'} if k > 1.2 else {'id': id, 'values': rows}), flush=True)";
    folder.write("edge.py", program(edge));
    folder.write("a.toml", scene("[\"python3\", \"edge.py\"]").replace("max = 2", "max = 20"));
    let row = |i: u32| format!("{},{}\n", f64::from(i) / 20.0, (-1.6 * f64::from(i) / 20.0).exp());
    folder.write("a.csv", format!("t_s,angle_rad\n{}", (0..40).map(row).collect::<String>()));
    let ran = folder.run("tune --sim a.toml --allow-process --observation a.csv --report a.html --json").ends(3);
    let (answer, warnings) = (&ran.json()["parameters"]["k"], ran.json()["warnings"].to_string());
    let value = answer["value"].as_f64().unwrap_or_default();
    let high = answer["interval95"][1].as_f64().unwrap_or(f64::INFINITY);
    assert!((1.1999..=1.2).contains(&value) && (value..=1.2).contains(&high), "{answer}");
    assert!(warnings.contains("program.refused") && warnings.contains("fit.poor"), "{warnings}");
}

/// A command is shown whole and word by word before leave is given to run it; what is left out of a sentence is counted.
#[test]
fn a_command_is_shown_whole() {
    let folder = Folder::new();
    let long = format!("true; {}touch ran", " ".repeat(500));
    folder.write("a.toml", scene(&format!("[\"sh\", \"-c\", \"{long}\", \"\", \"\\u202e\\u200bdneirf\"]")));
    let ran = folder.run("inspect a.toml").ends(0);
    let whole = format!("`sh -c '{long}' '' '\u{fffd}\u{fffd}dneirf'`");
    assert!(ran.stdout.contains(&whole), "{}", ran.stdout);
    let left_out = whole.chars().count() - 2 - 160;
    let told = format!("({left_out} more characters, which `tunenet inspect a.toml` shows)");
    let ran = folder.run("simulate --sim a.toml --out a.csv").ends(2);
    assert!(ran.stderr.contains(&told), "no `{told}` in {}", ran.stderr);
}

/// A program that keeps something from rollout to rollout answers well at first: it is asked again what it was asked early.
#[test]
fn a_program_that_drifts_is_told_by_every_command() {
    if !python("json") {
        return;
    }
    let folder = Folder::new();
    // Right to the last bit for ten rollouts, and ever more wrong by a part in a billion.
    let drifts = "k = request['parameters']['k']\nwrong = 1e-9 * max(id - 12, 0)\n\
                  rows = [[math.exp(-k * t) + wrong] for t in request['times_s']]\n\
                  print(json.dumps({'id': id, 'values': rows}), flush=True)";
    folder.write("drifts.py", program(drifts));
    folder.write("a.toml", scene("[\"python3\", \"drifts.py\"]"));
    let row = |i: u32| format!("{},{}\n", f64::from(i) / 20.0, (-0.7 * f64::from(i) / 20.0).exp());
    folder.write("a.csv", format!("t_s,angle_rad\n{}", (0..40).map(row).collect::<String>()));
    let wanted = &[
        "a.toml: `python3 drifts.py`: expected the same answer to the same parameters",
        "for `angle_rad` in row 1 when asked again after",
        "keep nothing from one to the next",
    ];
    // In the end where there were few rollouts, and after a hundred where there are many: no pair of them is kept.
    crate::common::refused(&folder, "tune --sim a.toml --allow-process --observation a.csv --json", wanted);
    crate::common::refused(&folder, "diagnose --sim a.toml --allow-process --observation a.csv --json", wanted);
    crate::common::refused(&folder, "gen process --sim a.toml --allow-process --pairs 10 --out a.mcap", wanted);
    crate::common::refused(&folder, "gen process --sim a.toml --allow-process --pairs 2000 --out a.mcap", wanted);
}

/// Asking again costs at most one rollout in fifty.
#[test]
fn asking_again_costs_little() {
    if !python("json") {
        return;
    }
    let folder = Folder::new();
    let counts = "k = request['parameters']['k']\nopen('asked.txt', 'a').write(f'{k!r}\\n')\n\
                  rows = [[math.exp(-k * t)] for t in request['times_s']]\n\
                  print(json.dumps({'id': id, 'values': rows}), flush=True)";
    folder.write("counts.py", program(counts));
    folder.write("a.toml", scene("[\"python3\", \"counts.py\"]").replace("[record]", "workers = 1\n[record]"));
    folder.run("gen process --sim a.toml --allow-process --pairs 300 --out a.mcap").ends(0);
    let text = folder.text("asked.txt");
    let asked: Vec<&str> = text.lines().collect();
    let different: std::collections::BTreeSet<&str> = asked.iter().copied().collect();
    let (pairs, again) = (asked.len(), asked.len() - different.len());
    assert!(pairs > 600 && again > 5 && again * 50 <= pairs, "{again} of {pairs}");
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

/// The program that a simulation file names is read with it, and never written over.
#[test]
fn a_program_is_never_written_over() {
    let folder = pendulum();
    let tune = "tune --sim pendulum.toml --allow-process --observation swing.csv --overwrite";
    for output in ["--out pendulum.py", "--report pendulum.py"] {
        crate::common::refused(&folder, &format!("{tune} {output}"), &["pendulum.py: this file is read as an input"]);
    }
    assert!(folder.read("pendulum.py") == crate::process::programs::PENDULUM.as_bytes());
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
    let text = folder.text("a.csv");
    for (i, line) in text.lines().skip(1).enumerate() {
        let (t, value) = line.split_once(',').unwrap();
        let [t, value] = [t, value].map(|v| v.parse::<f64>().unwrap());
        assert_eq!(t, i as f64 / 20.0);
        assert!((value / (-t).exp() - 1.0).abs() < 1e-15, "{line}");
    }
}
