//! The tables of findings in docs/, generated from the kinds that the crates declare.
//!
//! `TUNENET_DOCS_WRITE=1 cargo test --workspace --test tunenet findings` writes the rows again.

use std::collections::BTreeSet;
use std::path::Path;

use tunenet_core::finding::{FindingKind, Severity};

const PAGES: [&str; 9] = ["tune", "preflight", "diagnose", "track", "arm", "arm-logs", "robot", "plan", "grow"];

fn kinds() -> Vec<FindingKind> {
    let mut all = tunenet_core::findings::ALL.to_vec();
    all.extend(tunenet_ball::findings::ALL);
    all.extend(tunenet_formats::findings::ALL);
    all.extend(tunenet_sim::findings::ALL);
    all.extend(tunenet_video_protocol::findings::ALL);
    all.extend(tunenet_cli::findings::ALL);
    all
}

fn row(kind: FindingKind) -> String {
    let cell = |text: &str| text.replace('|', "\\|");
    let severity = if kind.severity() == Severity::Note { " (note)" } else { "" };
    format!("| `{}`{severity} | {} | {} |", kind.code(), cell(kind.meaning()), cell(kind.remedy()))
}

/// The kind that a line of a page lists, where it is a row of a table of findings.
fn listed(line: &str, kinds: &[FindingKind]) -> Option<FindingKind> {
    let (code, _) = line.strip_prefix("| `")?.split_once('`')?;
    kinds.iter().copied().find(|kind| kind.code() == code)
}

#[test]
fn pages_list_every_finding_as_the_crates_declare_it() {
    let (kinds, write) = (kinds(), std::env::var_os("TUNENET_DOCS_WRITE").is_some());
    let mut seen = BTreeSet::new();
    for page in PAGES {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../docs/{page}.md"));
        let text = std::fs::read_to_string(&path).unwrap();
        let generated: Vec<String> = text
            .lines()
            .map(|line| {
                let kind = listed(line, &kinds);
                seen.extend(kind.map(FindingKind::code));
                kind.map_or_else(|| line.to_owned(), row)
            })
            .collect();
        let generated = generated.join("\n") + "\n";
        if write {
            std::fs::write(&path, generated).unwrap();
        } else {
            let wrong = text.lines().zip(generated.lines()).find(|(found, expected)| found != expected);
            assert_eq!(wrong, None, "docs/{page}.md: (found, expected); TUNENET_DOCS_WRITE=1 writes it again");
        }
    }
    let missing: Vec<&str> = kinds.iter().map(|kind| kind.code()).filter(|code| !seen.contains(code)).collect();
    assert!(missing.is_empty(), "no page of docs/ lists {missing:?}");
}

#[test]
fn no_two_crates_declare_one_code() {
    let kinds = kinds();
    let codes: BTreeSet<&str> = kinds.iter().map(|kind| kind.code()).collect();
    assert_eq!(codes.len(), kinds.len());
    assert!(kinds.iter().all(|kind| !kind.meaning().is_empty() && !kind.remedy().is_empty()));
}
