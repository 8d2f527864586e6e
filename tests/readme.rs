//! What README.md and docs/ say, held against the tool and the sources.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use tunenet_sim::shot::task::TASK_KEYS;
use tunenet_sim::simulation_file::schema::{BALL_KEYS, EFFECT_KEYS, Key, PARAMETER_KEYS};
use tunenet_sim::simulation_file::{ARM_EFFECT_KEYS, ARM_KEYS, PROCESS_EFFECT_KEYS, PROCESS_KEYS};

/// Commands that are shown but not run here, and why.
const NOT_RUN: [(&str, &str); 3] = [
    ("make ", "builds and tests everything, this test included"),
    ("cargo ", "builds; the example is run by tests of tunenet-core"),
    ("tunenet bench", "measures for half a minute"),
];
/// What a line begins with where the honest answer is no, and the exit status 3.
const NO: [&str; 4] = ["unusable", "POOR FIT", "NOT IDENTIFIABLE", "REJECTED"];
/// Figures that are shown may differ by this share from machine to machine.
const FIGURE_SLACK: f64 = 0.05;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

fn text(path: impl AsRef<Path>) -> String {
    let path = root().join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// README.md and every page of docs/, from the root.
fn pages() -> Vec<PathBuf> {
    let mut pages = vec![PathBuf::from("README.md")];
    for entry in std::fs::read_dir(root().join("docs")).unwrap() {
        let name = PathBuf::from("docs").join(entry.unwrap().file_name());
        if name.extension().is_some_and(|e| e == "md") {
            pages.push(name);
        }
    }
    pages
}

/// The commands of the `sh` blocks, each with the output lines shown below it.
fn commands(page: &str) -> Vec<(String, Vec<String>)> {
    let mut found: Vec<(String, Vec<String>)> = Vec::new();
    let mut fence = None;
    for line in page.lines() {
        match (fence, line.strip_prefix("```")) {
            (None, Some(language)) => fence = Some(language),
            (Some(_), Some(_)) => fence = None,
            (Some("sh"), None) => {
                let typed = line.strip_prefix("$ ");
                let bare = ["tunenet ", "make ", "cargo "].iter().any(|program| line.starts_with(program));
                if let Some(command) = typed.or(bare.then_some(line)) {
                    found.push((command.into(), Vec::new()));
                } else if let Some((_, output)) = found.last_mut().filter(|_| !line.trim().is_empty()) {
                    output.push(line.into());
                }
            }
            _ => {}
        }
    }
    found
}

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

/// A line as words and figures: numbers that do not belong to a name are cut out.
fn figures(line: &str) -> (String, Vec<f64>) {
    let (mut words, mut numbers, mut digits) = (String::new(), Vec::new(), String::new());
    for c in line.chars().chain([' ']) {
        if c.is_ascii_digit() || (c == '.' && !digits.is_empty()) {
            digits.push(c);
            continue;
        }
        if !digits.is_empty() {
            numbers.extend(digits.trim_end_matches('.').parse::<f64>());
            words.push('#');
            digits.clear();
        }
        // Columns are padded to the width of their figures.
        if c != ' ' || !words.ends_with(' ') {
            words.push(c);
        }
    }
    (words.trim().to_string(), numbers)
}

fn alike(shown: &str, printed: &str) -> bool {
    let ((a, numbers), (b, others)) = (figures(shown), figures(printed));
    let near = |(x, y): (&f64, &f64)| (x - y).abs() <= FIGURE_SLACK * x.abs().max(y.abs());
    a == b && numbers.len() == others.len() && numbers.iter().zip(&others).all(near)
}

#[test]
fn every_command_of_the_readme_does_what_is_shown() {
    let folder = tempfile::tempdir().unwrap();
    copy(&root().join("assets"), &folder.path().join("assets"));
    let tool = Path::new(env!("CARGO_BIN_EXE_tunenet"));
    let path = format!("{}:{}", tool.parent().unwrap().display(), std::env::var("PATH").unwrap_or_default());
    let all = commands(&text("README.md"));
    assert!(all.len() > 10, "only {} commands found", all.len());
    for (command, shown) in all {
        if let Some((_, why)) = NOT_RUN.iter().find(|(start, _)| command.starts_with(start)) {
            eprintln!("not run: {command} ({why})");
            continue;
        }
        let output = Command::new("sh")
            .args(["-c", &command])
            .current_dir(folder.path())
            .env("PATH", &path)
            .env("TUNENET_CACHE", folder.path().join("cache"))
            .output()
            .unwrap_or_else(|e| panic!("{command}: {e}"));
        let printed = format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        let no = shown.iter().any(|line| NO.iter().any(|start| line.starts_with(start)));
        assert_eq!(output.status.code(), Some(if no { 3 } else { 0 }), "{command}: {}\n{printed}", output.status);
        for line in shown {
            assert!(printed.lines().any(|p| alike(&line, p)), "`{command}` does not print\n{line}\nbut\n{printed}");
        }
    }
}

#[test]
fn figures_are_compared_and_words_must_be_equal() {
    assert!(alike("gap  3.46 mm", "gap 3.5 mm") && alike("wrote a, 5 s", "wrote a, 5.1 s"));
    assert!(!alike("gap 3.46 mm", "gap 34.6 mm") && !alike("TUNED 1", "POOR FIT 1") && !alike("1", "1 2"));
}

#[test]
fn every_file_that_is_linked_to_exists() {
    let mut links = 0;
    for page in pages() {
        for part in text(&page).split("](").skip(1) {
            let target = part.split([')', '#']).next().unwrap_or_default();
            if target.is_empty() || target.contains("://") {
                continue;
            }
            let file = root().join(page.parent().unwrap()).join(target);
            assert!(file.exists(), "{} links to {target}, which is not there", page.display());
            links += 1;
        }
    }
    assert!(links > 10, "only {links} links found");
}

/// The rows that docs/files.md must hold for these keys.
fn rows(keys: &[Key]) -> String {
    let mut table = String::from("| key | value | needed | meaning |\n|---|---|---|---|\n");
    for key in keys {
        let needed = if key.required { "yes" } else { "no" };
        let meaning = key.meaning.replace('|', "\\|");
        writeln!(table, "| `{}` | {} | {needed} | {meaning} |", key.path, key.shape.expected()).unwrap();
    }
    table
}

#[test]
fn the_keys_of_a_simulation_file_are_those_of_the_schema() {
    let page = text("docs/files.md");
    let all: [(&str, &[Key]); 8] = [
        ("keys", BALL_KEYS),
        ("arm", ARM_KEYS),
        ("effects", &EFFECT_KEYS),
        ("arm effects", &ARM_EFFECT_KEYS),
        ("process", PROCESS_KEYS),
        ("process effects", &PROCESS_EFFECT_KEYS),
        ("parameters", PARAMETER_KEYS),
        ("task", TASK_KEYS),
    ];
    for (name, keys) in all {
        let (begin, end) = (format!("<!-- {name}: begin -->\n"), format!("<!-- {name}: end -->"));
        let found = page.split_once(&begin).and_then(|(_, rest)| rest.split_once(&end));
        let found = found.unwrap_or_else(|| panic!("docs/files.md lacks its mark `{name}`")).0;
        let expected = rows(keys);
        assert!(found == expected, "docs/files.md should hold between its marks `{name}`:\n{expected}");
    }
}

/// The sources of all crates.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() && path.file_name().is_some_and(|n| n != "tests" && n != "target") {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

#[test]
fn every_warning_has_its_remedy_in_the_docs() {
    let pages = ["tune", "preflight", "diagnose", "track", "arm", "arm-logs", "plan"];
    let page = pages.map(|page| text(format!("docs/{page}.md"))).concat();
    let (mut files, mut codes) = (Vec::new(), 0);
    sources(&root().join("crates"), &mut files);
    for file in files {
        for call in text(&file).split("Note::new(").skip(1) {
            let Some(code) = call.trim_start().strip_prefix('"').and_then(|rest| rest.split('"').next()) else {
                continue;
            };
            assert!(page.contains(&format!("| `{code}` |")), "no page of docs/ lists `{code}` of {}", file.display());
            codes += 1;
        }
    }
    assert!(codes > 20, "only {codes} codes found");
}

#[test]
fn every_check_is_in_the_docs() {
    let (page, mut files, mut codes) = (text("docs/preflight.md"), Vec::new(), 0);
    sources(&root().join("crates/tunenet-core/src/observation/preflight"), &mut files);
    for file in files {
        // Codes are the only texts of the form "word.word" there.
        for quoted in text(&file).split('"').skip(1).step_by(2) {
            let Some((family, word)) = quoted.split_once('.') else { continue };
            if [family, word].iter().all(|w| !w.is_empty() && w.chars().all(|c| c.is_ascii_lowercase())) {
                assert!(page.contains(&format!("| `{quoted}` |")), "docs/preflight.md lacks `{quoted}`");
                codes += 1;
            }
        }
    }
    assert!(codes > 20, "only {codes} codes found");
}

#[test]
fn every_key_of_the_json_is_in_the_docs() {
    let (page, folder) = (text("docs/json.md"), tempfile::tempdir().unwrap());
    let assets = root().join("assets");
    let at = |name: &str| assets.join(name).display().to_string();
    let out = folder.path().join("drop.mcap").display().to_string();
    let (scene, drop, throw) = (at("ball.toml"), at("observations/drop.csv"), at("observations/throw.csv"));
    let light: Vec<String> = (1..=5).map(|i| at(&format!("observations/light_{i}.csv"))).collect();
    let shot = at("shot.toml");
    let runs: [&[&str]; 10] = [
        &["plan", "--sim", &scene, "--task", &shot],
        &["diagnose", "--sim", &scene, "--observation", &light[0], &light[1], &light[2], "--held-out", &light[4]],
        &["tune", "--sim", &scene, "--observation", &drop],
        &["tune", "--sim", &scene, "--set", "parameters.friction.tune=true", "--observation", &throw],
        &["tune", "--sim", &scene, "--observation", &drop, "--each"],
        &["simulate", "--sim", &scene, "--set", "release.height_m=1", "--out", &out],
        &["inspect", &out],
        &["inspect", &scene],
        &["inspect", &drop],
        &["inspect", &drop, &throw],
    ];
    for arguments in runs {
        let output = Command::new(env!("CARGO_BIN_EXE_tunenet"))
            .args(arguments)
            .arg("--json")
            .env("TUNENET_CACHE", folder.path().join("cache"))
            .output()
            .unwrap();
        let object: serde_json::Value =
            serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{arguments:?}: {e}"));
        listed(&object, &page, arguments);
    }
}

/// Every key below `value` stands in `page`; the names of parameters are data, not keys.
fn listed(value: &serde_json::Value, page: &str, arguments: &[&str]) {
    match value {
        serde_json::Value::Object(object) => {
            for (key, inner) in object {
                let data = ["restitution", "friction", "c_1_m"].contains(&key.as_str());
                let word = |text: &str| text.split(|c: char| !c.is_alphanumeric() && c != '_').any(|w| w == key);
                assert!(data || word(page), "docs/json.md does not list `{key}` of {arguments:?}");
                listed(inner, page, arguments);
            }
        }
        serde_json::Value::Array(all) => all.iter().for_each(|inner| listed(inner, page, arguments)),
        _ => {}
    }
}
