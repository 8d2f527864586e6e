//! The words of the field: private words that had one are counted in sources and pages, and must not come back.

use std::path::Path;

use super::page::root;

/// Private words, as whole words and as parts of identifiers, in lower case. Words with an ordinary meaning of their own
/// (held, shown, reach, spread, chance, own, apart) are left out: no machine can judge them.
#[rustfmt::skip]
const PRIVATE: &[&str] = &[
    "film", "films", "filmed", "filming",           // video
    "pull", "pulls", "pulled",                      // prior; score of a likelihood
    "told", "tell", "tells", "untold",              // reported, rendered, printed
    "unseen",                                       // held out, validation
    "elsewhere",                                    // multistart, other starts
    "spoil", "spoils", "spoilt",                    // degraded, corrupted
    "kick", "kicks", "kicked",                      // per-contact random effect
    "wild",                                         // outlier
    "valley", "valleys",                            // local minimum
    "aloft", "lean",                                // flight segments; tilt
    "nameless", "mirrored",                         // unmodelled residual; sign-ambiguous
    "believed",                                     // plausible, physical bounds
    "reckon", "reckoned", "reckons",                // computed
    "beside",                                       // next to, with, in addition to
    "heard",                                        // visible in bounce times
    "coloured",                                     // autocorrelated
    "scout", "scouted", "bumped", "rehearse", "rehearsal", "rehearsed", // ball colour detection; camera motion; synthetic video
];

/// What keeps such a word: codes of findings, keys of JSON and of files, values and commands that others type.
#[rustfmt::skip]
const KEPT: &[&str] = &[
    "film.repeated", "film.dropped", "film.truncated", "camera.bumped", "samples.wild", "noise.coloured", "friction.unseen",
    "\"film\"", "`film`", "\"filmed\"", "\"spoilt\"", "`spoilt`", "_spoilt", "-spoilt", "\"coloured\"", "`coloured`",
    "long-film", "tunenet-video film",
    // An effect of a test simulator, and what a spring does.
    "`kick`", "\"kick\"", "kick.speed_m_s", "something pulls the joint",
    // A command of Git.
    "git lfs pull",
];

/// How many places may still hold one. It only ever falls.
const CEILING: usize = 1;

/// The words of a line, identifiers taken to pieces: `FilmRate` and `film_rate` are `film` and `rate`.
fn words(line: &str) -> Vec<String> {
    let mut found = vec![String::new()];
    let mut before = ' ';
    for c in line.chars() {
        if !c.is_ascii_alphabetic() || c.is_ascii_uppercase() && before.is_ascii_lowercase() {
            found.push(String::new());
        }
        if c.is_ascii_alphabetic() {
            found.last_mut().expect("one at least").push(c.to_ascii_lowercase());
        }
        before = c;
    }
    found
}

fn files(folder: &Path, endings: &[&str], found: &mut Vec<std::path::PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, endings, found);
        } else if path.extension().is_some_and(|e| endings.iter().any(|ending| e == *ending)) {
            found.push(path);
        }
    }
}

#[test]
fn private_words_do_not_come_back() {
    let root = root();
    let mut all = vec![root.join("README.md"), root.join("CONTRIBUTING.md")];
    files(&root.join("docs"), &["md"], &mut all);
    for entry in std::fs::read_dir(root.join("crates")).unwrap() {
        files(&entry.unwrap().path().join("src"), &["rs", "md", "css"], &mut all);
    }
    all.sort();
    let mut found = Vec::new();
    for path in &all {
        let name = path.strip_prefix(&root).unwrap().display();
        for (i, line) in std::fs::read_to_string(path).unwrap().lines().enumerate() {
            let line = KEPT.iter().fold(line.to_owned(), |line, kept| line.replace(kept, " "));
            let private = words(&line).into_iter().filter(|word| PRIVATE.contains(&word.as_str()));
            found.extend(private.map(|word| format!("{name}:{}:{word}", i + 1)));
        }
    }
    assert!(
        found.len() <= CEILING,
        "{} private words where {CEILING} are allowed; the field's word for each stands at the list in {}:\n{}",
        found.len(),
        file!(),
        found.join("\n")
    );
}

/// Words that have an ordinary meaning in other places, and none in the diagnosis: shared parameters, columns, candidates and steps of the
/// selection.
const PRIVATE_IN_DIAGNOSIS: [&str; 8] = ["global", "globals", "slot", "slots", "trial", "trials", "stage", "stages"];

#[test]
fn the_diagnosis_speaks_of_parameters_candidates_and_steps() {
    let mut all = Vec::new();
    files(&root().join("crates/tunenet-core/src/diagnose"), &["rs"], &mut all);
    assert!(all.len() > 40, "{} files", all.len());
    let of = |path: &std::path::PathBuf| {
        let text = std::fs::read_to_string(path).unwrap();
        let found = text
            .lines()
            .enumerate()
            .filter(|(_, line)| words(line).iter().any(|w| PRIVATE_IN_DIAGNOSIS.contains(&w.as_str())));
        found.map(|(i, line)| format!("{}:{}: {line}", path.display(), i + 1)).collect::<Vec<_>>()
    };
    let found: Vec<String> = all.iter().flat_map(of).collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn words_are_found_within_identifiers() {
    assert_eq!(
        words("FilmRate film_rate").join(" ").split_whitespace().collect::<Vec<_>>(),
        ["film", "rate", "film", "rate"]
    );
}
