//! Every command that README and docs show is run, and does what is shown; those that are not run are listed, and parsed.
#![cfg(unix)]

use std::path::Path;
use std::process::{Command, Output};

use crate::docs::page::{Page, Shown, pages, root, text};

/// Commands that are shown but not run: the page or `*`, how they begin, and why. Their flags are parsed all the same.
const NOT_RUN: [(&str, &str, &str); 7] = [
    ("*", "make ", "builds and tests everything, this test included; the target has to exist"),
    ("*", "cargo ", "builds for minutes; CI installs, and tests run the example"),
    ("CONTRIBUTING.md", "TUNENET_KILLS", "kills for minutes; cargo test does it with fewer kills"),
    ("CONTRIBUTING.md", "time ", "needs a release build without video, which takes minutes"),
    ("*", "docker ", "needs a daemon; the Dockerfile is held against this workspace below"),
    ("docs/arm-logs.md", "", "recordings of others, which are not here; tests/arm/replay.rs runs these where they are"),
    (
        "CONTRIBUTING.md",
        "fuzz/",
        "needs the whole tree and hours; tests/files/fuzzed.rs runs the same targets on their corpora",
    ),
];
/// What has to be there before a page begins, and is not made on it: the reader's own.
const GIVEN: [(&str, &str); 1] = [("docs/track.md", "tunenet init ball")];
/// What a line begins with where the honest answer is no, and the exit status 3.
const NO: [&str; 6] = ["unusable", "POOR FIT", "NOT IDENTIFIABLE", "REJECTED", "ONE OF", "OUT OF REACH"];

/// What a line begins with where `inspect` describes a file that is refused, and the exit status 1.
const REFUSED: &str = "unusable expected";

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let into = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            copy(&entry.path(), &into);
        } else {
            std::fs::copy(entry.path(), into).unwrap();
        }
    }
}

/// A folder with a copy of `assets/`, in which `tunenet` and `cargo` are what the tests say.
struct Place {
    folder: tempfile::TempDir,
    path: String,
}

impl Place {
    /// `dry`: both only parse what they are told.
    fn new(dry: bool) -> Self {
        let folder = tempfile::tempdir().unwrap();
        copy(&root().join("assets"), &folder.path().join("assets"));
        let tool = Path::new(env!("CARGO_BIN_EXE_tunenet"));
        let first = if dry {
            let bin = folder.path().join("bin");
            std::fs::create_dir(&bin).unwrap();
            // `--help` comes last: what is wrong before it is refused first. Behind `--` it would be somebody else's.
            let cargo = std::env::var("CARGO").unwrap_or_else(|_| env!("CARGO").into());
            for (name, program) in [("tunenet", tool.display().to_string()), ("cargo", cargo)] {
                let script = format!(
                    "#!/bin/sh\nleft=$#\nwhile [ $left -gt 0 ]; do\n  word=$1; shift; left=$((left - 1))\n  \
                     if [ \"$word\" = -- ]; then shift $left; break; fi\n  set -- \"$@\" \"$word\"\ndone\n\
                     exec '{program}' \"$@\" --help > /dev/null\n"
                );
                crate::common::executable(&bin.join(name), &script);
            }
            bin
        } else {
            tool.parent().unwrap().to_path_buf()
        };
        Self { path: format!("{}:{}", first.display(), std::env::var("PATH").unwrap_or_default()), folder }
    }

    fn run(&self, command: &str) -> Output {
        let mut shell = Command::new("sh");
        // Both streams in one, in their order, as a terminal shows them.
        shell.args(["-c", &format!("exec 2>&1\n{command}")]).current_dir(self.folder.path()).env("PATH", &self.path);
        shell.env("TUNENET_CACHE", self.folder.path().join("cache")).env("NO_COLOR", "1");
        // A task of an array, for `--shard auto`.
        for (name, value) in [("ID", "0"), ("MIN", "0"), ("COUNT", "4"), ("STEP", "1")] {
            shell.env(format!("SLURM_ARRAY_TASK_{name}"), value);
        }
        shell.output().unwrap_or_else(|e| panic!("{command}: {e}"))
    }
}

/// A line without the padding of its columns, and without the time that it took.
fn plain(line: &str) -> String {
    let words: Vec<&str> = line.split_whitespace().collect();
    match words.iter().position(|w| w.starts_with("rollouts")) {
        Some(at) if words.get(at + 2) == Some(&"s,") => [&words[..=at], &words[at + 2..]].concat().join(" "),
        _ => words.join(" "),
    }
}

/// Runs one command; what is shown below it has to be printed, in this order.
fn holds(place: &Place, page: &Page, variables: &str, shown: &Shown) -> Result<(), String> {
    let Shown { command, output, .. } = shown;
    let ran = place.run(&format!("{variables}{command}"));
    let printed = String::from_utf8_lossy(&ran.stdout);
    let no = output.iter().any(|line| NO.iter().any(|start| line.starts_with(start)));
    let refused = output.iter().any(|line| line.starts_with(REFUSED));
    let status = match (refused, no) {
        (true, _) => 1,
        (false, true) => 3,
        (false, false) => 0,
    };
    if ran.status.code() != Some(status) {
        return Err(format!("{}: `{command}`: {}\n{printed}", page.name, ran.status));
    }
    let mut rest = printed.lines().map(plain);
    for line in output {
        if !rest.any(|p| p == plain(line)) {
            return Err(format!("{}: `{command}` does not print, here,\n{line}\nbut\n{printed}", page.name));
        }
    }
    Ok(())
}

/// The lines of `printed` that a page should show in place of `shown`: for each the same line or else the most similar one.
fn similar(shown: &[String], printed: &str) -> Vec<String> {
    let words = |line: &str| plain(line).split(' ').map(str::to_owned).collect::<Vec<_>>();
    let alike = |a: &str, b: &str| {
        let (a, b) = (words(a), words(b));
        let same = a.iter().filter(|word| b.contains(word)).count();
        200 * same / (a.len() + b.len()).max(1) + usize::from(a.first() == b.first()) * 100
    };
    let all: Vec<&str> = printed.lines().filter(|line| !line.trim().is_empty()).collect();
    let mut places: Vec<usize> = shown
        .iter()
        .filter_map(|line| (0..all.len()).rev().max_by_key(|i| (plain(all[*i]) == plain(line), alike(all[*i], line))))
        .collect();
    places.sort_unstable();
    places.dedup();
    places.into_iter().map(|i| all[i].to_owned()).collect()
}

/// Runs the commands of all pages and pastes what they print in place of what is shown: for use after a change of the output,
/// with `cargo test --workspace --test tunenet paste -- --ignored`, and to be read before it is committed.
#[test]
#[ignore = "writes to the documentation"]
fn paste_outputs() {
    for page in pages() {
        let (place, variables) = (Place::new(false), page.variables());
        if !given(&place, &page) {
            continue;
        }
        let mut text = page.text.clone();
        let due = page.commands().into_iter().filter(|shown| !shown.long && not_run(&page, &shown.command).is_none());
        for shown in due {
            if holds(&place, &page, &variables, &shown).is_err() && !shown.output.is_empty() {
                let ran = place.run(&format!("{variables}{}", shown.command));
                let new = similar(&shown.output, &String::from_utf8_lossy(&ran.stdout)).join("\n");
                text = text.replacen(&shown.output.join("\n"), &new, 1);
            }
        }
        std::fs::write(root().join(&page.name), text).unwrap();
    }
}

fn not_run<'a>(page: &Page, command: &str) -> Option<&'a str> {
    // A variable of the environment may stand in front.
    let bare = command.split_once("=… ").map_or(command, |(_, rest)| rest);
    let listed = |(on, start, _): &&(&str, &str, &str)| (*on == "*" || *on == page.name) && bare.starts_with(start);
    NOT_RUN.iter().find(listed).map(|(.., why)| *why)
}

#[test]
fn every_command_that_is_shown_does_what_is_shown() {
    let (mut faults, mut run) = (Vec::new(), 0);
    let all = pages();
    std::thread::scope(|scope| {
        let started: Vec<_> = all.iter().map(|page| scope.spawn(move || all_of(page))).collect();
        for page in started {
            let (count, found) = page.join().unwrap();
            run += count;
            faults.extend(found);
        }
    });
    assert!(faults.is_empty(), "{}", faults.join("\n\n"));
    assert!(run > 30, "only {run} commands were run");
}

/// Runs the commands of one page, in one folder; how many, and what is wrong.
fn all_of(page: &Page) -> (usize, Vec<String>) {
    let commands = page.commands();
    let variables = page.variables();
    let due = commands.iter().filter(|shown| !shown.long && not_run(page, &shown.command).is_none());
    let place = Place::new(false);
    if !given(&place, page) {
        eprintln!("{}: not run without video", page.name);
        return (0, Vec::new());
    }
    let results: Vec<_> = due.map(|shown| holds(&place, page, &variables, shown)).collect();
    (results.len(), results.into_iter().filter_map(Result::err).collect())
}

/// Puts there what the reader brings; says whether it could be done.
fn given(place: &Place, page: &Page) -> bool {
    for (_, command) in GIVEN.iter().filter(|(name, _)| *name == page.name) {
        assert!(place.run(command).status.success(), "{command}");
    }
    if page.name != "docs/track.md" {
        return true;
    }
    #[cfg(feature = "video")]
    std::fs::write(place.folder.path().join("drop.mp4"), crate::video::film::Film::default().avi()).unwrap();
    cfg!(feature = "video")
}

#[test]
fn what_is_not_run_is_parsed_and_every_flag_exists() {
    let place = Place::new(true);
    let (mut faults, mut parsed) = (Vec::new(), 0);
    for page in pages() {
        let spans = page.spans();
        let spoken = spans.iter().filter(|s| ["tunenet ", "cargo "].iter().any(|program| s.contains(program)));
        let shown: Vec<String> = page.commands().into_iter().map(|shown| shown.command).collect();
        for command in shown.iter().chain(spoken).filter(|c| !c.starts_with("docker ")) {
            // Only these two: what else stands in a line is the shell's.
            if !["tunenet", "cargo"].iter().any(|program| command.split_whitespace().any(|word| word == *program)) {
                continue;
            }
            let ran = place.run(&format!("{}{}", page.variables(), command.replace('…', "")));
            if !ran.status.success() {
                faults.push(format!("{}: `{command}`: {}", page.name, String::from_utf8_lossy(&ran.stdout)));
            }
            parsed += 1;
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(parsed > 60, "only {parsed} commands were parsed");
}

/// No daemon runs it here: at least what it names has to be there, and be what `make build` asks for.
#[test]
fn the_dockerfile_installs_what_this_workspace_needs() {
    let (image, makefile) = (text("Dockerfile"), text("Makefile"));
    let packages = makefile.lines().find_map(|line| line.strip_prefix("PACKAGES := ")).unwrap();
    for package in packages.split_whitespace() {
        assert!(image.split_whitespace().any(|word| word == package), "the Dockerfile lacks {package}");
    }
    let path = image.split_once("--path ").unwrap().1.split_whitespace().next().unwrap();
    assert!(root().join(path).join("Cargo.toml").exists() && root().join("rust-toolchain.toml").exists(), "{path}");
    let manifest = text("crates/tunenet-cli/Cargo.toml");
    let entry = image.split_once("ENTRYPOINT [\"").unwrap().1.split('"').next().unwrap();
    assert!(manifest.contains(&format!("name = \"{entry}\"")), "{entry}");
}

#[test]
fn a_flag_that_does_not_exist_is_found() {
    let place = Place::new(true);
    assert!(place.run("tunenet tune --sim a.toml --observation b.csv --report c.html").status.success());
    assert!(!place.run("tunenet tune --sim a.toml --observation b.csv --rapport c.html").status.success());
    assert!(!place.run("tunenet bench shot --trails 20").status.success());
    assert!(!place.run("cargo test --workspac -- --nocapture").status.success());
    assert!(place.run("cargo test --workspace -- --nocapture").status.success());
}

#[test]
fn flags_in_running_text_are_flags_of_some_command() {
    let helped = |command: &str| {
        let ran = Command::new(env!("CARGO_BIN_EXE_tunenet")).args(command.split_whitespace()).arg("--help").output();
        String::from_utf8(ran.unwrap().stdout).unwrap()
    };
    let commands = helped("");
    let known: Vec<&str> = commands.lines().skip_while(|l| !l.starts_with("Commands:")).skip(1).collect();
    let known: Vec<&str> =
        known.into_iter().take_while(|l| !l.is_empty()).filter_map(|l| l.split_whitespace().next()).collect();
    assert!(known.len() > 10, "{known:?}");
    let mut help: String = known.iter().filter(|name| **name != "help").map(|name| helped(name)).collect();
    let benches = helped("bench");
    let benches = benches.lines().skip_while(|l| !l.starts_with("Commands:")).skip(1).take_while(|l| !l.is_empty());
    for name in
        benches.filter(|l| l.starts_with("  ") && !l.starts_with("   ")).filter_map(|l| l.split_whitespace().next())
    {
        help.push_str(&helped(&format!("bench {name}")));
    }
    // Of the programs around it.
    let others = ["--ignored", "--nocapture", "--workspace", "--no-default-features"];
    for page in pages() {
        for span in page.spans().iter().filter(|s| s.starts_with("--")) {
            let flag = span.split([' ', '=']).next().unwrap();
            let there = help.split(|c: char| !(c.is_alphanumeric() || c == '-')).any(|word| word == flag);
            assert!(there || others.contains(&flag), "{}: no command has `{flag}`", page.name);
        }
    }
}

#[test]
fn commands_stand_in_blocks_that_are_run_and_reasons_are_needed() {
    let all = pages();
    for page in &all {
        let hidden = page.hidden_commands();
        assert!(hidden.is_empty(), "{}: these lines belong into an `sh` block: {hidden:?}", page.name);
    }
    for (on, start, why) in NOT_RUN {
        assert!(why.len() > 20, "{start}");
        let used = all
            .iter()
            .any(|p| (on == "*" || on == p.name) && p.commands().iter().any(|c| c.command.starts_with(start)));
        assert!(used, "nothing is shown that begins with `{start}` on {on}; remove it from the list");
    }
    let makefile = text("Makefile");
    for page in &all {
        let commands = page.commands().into_iter().map(|c| c.command).chain(page.spans());
        for command in commands {
            let Some(target) = command.strip_prefix("make ").and_then(|rest| rest.split_whitespace().next()) else {
                continue;
            };
            assert!(makefile.contains(&format!("\n{target}:")), "{}: no target `{target}`", page.name);
        }
    }
}
