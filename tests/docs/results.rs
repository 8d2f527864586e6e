//! What the pages show of measured tables is what the checked-in results hold, and these say how they were made.

use super::page::{root, text};

/// What stands between the marks of a name on a page.
fn pasted(page: &str, name: &str) -> String {
    let (begin, end) = (format!("<!-- {name}: begin -->\n"), format!("<!-- {name}: end -->"));
    let all = text(page);
    let from = all.find(&begin).unwrap_or_else(|| panic!("{page} has no mark of {name}")) + begin.len();
    let to = from + all[from..].find(&end).unwrap_or_else(|| panic!("{page}: {name} never ends"));
    all[from..to].to_owned()
}

/// A result's text below its title and command, its headings one lower: what `results/make.sh` pastes.
fn body(file: &str) -> String {
    let all = text(file);
    let command = all.find("\n    tunenet ").unwrap_or_else(|| panic!("{file} does not say what was run")) + 1;
    let below = all[command..].split_once('\n').map_or("", |(_, below)| below);
    let lower = |line: &str| if line.starts_with("## ") { format!("#{line}\n") } else { format!("{line}\n") };
    below.trim_start_matches('\n').lines().map(lower).collect()
}

#[test]
fn pages_show_what_the_results_hold() {
    for part in ["table1", "table2", "table3", "figure2", "figure3"] {
        let file = format!("results/paper/{part}.md");
        assert_eq!(
            pasted("docs/paper.md", part),
            body(&file),
            "docs/paper.md is not of the last run: `results/make.sh paper`"
        );
        for format in ["csv", "json", "svg"] {
            let path = root().join("results/paper").join(format!("{part}.{format}"));
            let expected = match format {
                "json" => true,
                "svg" => part.starts_with("figure"),
                _ => matches!(part, "table1" | "table2"),
            };
            assert!(path.is_file() || !expected, "{} is missing", path.display());
        }
    }
    for figure in ["figure2.svg", "figure3.svg"] {
        assert_eq!(text(format!("docs/{figure}")), text(format!("results/paper/{figure}")), "docs/{figure} is older");
    }
}

/// Page, mark, and the file that is pasted there: below its title and command, as it is, or between fences.
#[test]
fn pages_show_what_the_other_results_hold() {
    for (page, mark, file) in [
        ("docs/evidence-shot.md", "shot", "shot/shot.md"),
        ("docs/evidence.md", "goals", "diagnose/goals.md"),
        ("docs/evidence.md", "driven", "driven/goals.md"),
        ("docs/evidence.md", "regions", "regions/regions.md"),
        ("docs/evidence.md", "rollouts", "rollouts/rollouts.md"),
        ("docs/evidence.md", "recorded", "recorded/recorded.md"),
        ("docs/evidence.md", "law", "law/goals.md"),
        ("docs/evidence.md", "joints", "joints/goals.md"),
    ] {
        assert_eq!(pasted(page, mark), body(&format!("results/{file}")), "{page}: `results/make.sh`, {mark}");
    }
    for (page, mark, file) in [
        ("docs/evidence.md", "speed", "speed/speed.md"),
        ("docs/grow.md", "grow", "grow/grow.md"),
        ("docs/evidence.md", "preflight", "preflight/printed.md"),
    ] {
        assert_eq!(pasted(page, mark), text(format!("results/{file}")), "{page}: `results/make.sh`, {mark}");
    }
    for (page, mark, file) in
        [("docs/evidence.md", "arm", "arm/printed.md"), ("docs/evidence.md", "intervals", "intervals/printed.md")]
    {
        let fenced = format!("```text\n{}\n```\n", text(format!("results/{file}")).trim_end());
        assert_eq!(pasted(page, mark), fenced, "{page}: `results/make.sh`, {mark}");
    }
}

/// Every folder says by which commit, command and machine it was made, and the command is the one that its page names.
#[test]
fn results_say_how_they_were_made() {
    let mut folders = 0;
    for entry in std::fs::read_dir(root().join("results")).unwrap() {
        let path = entry.unwrap().path();
        if !path.is_dir() {
            continue;
        }
        folders += 1;
        let run = std::fs::read_to_string(path.join("run.txt")).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let of = |key: &str| {
            let line = run.lines().find_map(|line| line.strip_prefix(key));
            line.unwrap_or_else(|| panic!("{}: no {key}", path.display())).trim()
        };
        assert!(of("commit").len() == 40 && of("commit").bytes().all(|b| b.is_ascii_hexdigit()), "{run}");
        assert!(of("command").starts_with("tunenet bench ") && of("machine").contains("cores of"), "{run}");
        assert!(of("seconds").split(' ').next().is_some_and(|s| s.parse::<u64>().is_ok()), "{run}");
    }
    assert!(folders >= 11, "results hold {folders} folders");
    for (page, name) in [
        ("docs/paper.md", "paper"),
        ("docs/evidence-shot.md", "shot"),
        ("docs/evidence.md", "diagnose"),
        ("docs/evidence.md", "arm"),
        ("docs/evidence.md", "driven"),
        ("docs/evidence.md", "law"),
        ("docs/evidence.md", "joints"),
        ("docs/evidence.md", "intervals"),
        ("docs/evidence.md", "regions"),
        ("docs/evidence.md", "rollouts"),
        ("docs/evidence.md", "preflight"),
        ("docs/grow.md", "grow"),
        ("docs/evidence.md", "speed"),
    ] {
        let run = text(format!("results/{name}/run.txt"));
        let command = run.lines().find_map(|line| line.strip_prefix("command ")).unwrap();
        assert!(text(page).contains(command), "{page} does not name the command of results/{name}: {command}");
    }
}
