//! The same command with the same seed writes the same bytes: run again, and on one, two and four threads. Only how long it took
//! may differ.

use crate::common::{DROP, Drop, Folder, timeless};

/// Threads of each run; the first is run twice.
const THREADS: [&str; 4] = ["1", "1", "2", "4"];

/// Where a line on standard error begins that long work writes from time to time.
const PROGRESS: &str = "sets: ";

/// Everything that `line` prints and writes: its standard output and error without seconds and progress, and every new file.
fn written(folder: &Folder, line: &str, threads: &str) -> Vec<(String, Vec<u8>)> {
    let before = folder.names();
    let ran = folder.command().env("RAYON_NUM_THREADS", threads).args(line.split_whitespace()).output().unwrap();
    assert!(matches!(ran.status.code(), Some(0 | 3)), "{line}: {}", String::from_utf8_lossy(&ran.stderr));
    let text = |bytes: Vec<u8>| -> Vec<u8> {
        let lines = String::from_utf8(bytes).unwrap();
        let kept = lines.lines().filter(|line| !line.starts_with(PROGRESS));
        kept.flat_map(|line| (untimed(line) + "\n").into_bytes()).collect()
    };
    let printed = if ran.stdout.starts_with(b"{") { timeless(&ran.stdout) } else { text(ran.stdout) };
    let mut all = vec![("standard output".to_owned(), printed), ("standard error".into(), text(ran.stderr))];
    for name in folder.names().into_iter().filter(|name| !before.contains(name) && name != "cache") {
        let path = folder.path(&name);
        if path.is_dir() {
            for entry in std::fs::read_dir(&path).unwrap().map(Result::unwrap).filter(|e| e.path().is_file()) {
                let bytes = folder.read(&format!("{name}/{}", entry.file_name().display()));
                all.push((entry.file_name().display().to_string(), bytes));
            }
            std::fs::remove_dir_all(path).unwrap();
        } else {
            let bytes = folder.read(&name);
            all.push((name, bytes));
            std::fs::remove_file(path).unwrap();
        }
    }
    all.sort();
    all
}

/// A line in which seconds stand as `#`.
fn untimed(line: &str) -> String {
    let words: Vec<&str> = line.split(' ').collect();
    let second = |i: usize| words.get(i + 1).is_some_and(|unit| unit.trim_end_matches([',', '.', ':']) == "s");
    let number = |word: &str| word.parse::<f64>().is_ok();
    let kept = words.iter().enumerate().map(|(i, w)| if number(w) && second(i) { "#" } else { w });
    kept.collect::<Vec<_>>().join(" ")
}

#[test]
fn threads_and_repetition_change_no_byte() {
    let folder = Folder::with_scene();
    folder.write("drop.toml", DROP);
    let slow = Drop { frames: 300, ..Drop::default() };
    folder.write("a.csv", slow.csv());
    folder.write("b.csv", Drop { seed: 2, height_m: 0.8, ..slow }.csv());
    folder.write("c.csv", Drop { seed: 3, height_m: 1.3, ..slow }.csv());
    folder.run("gen ball --sim drop.toml --pairs 200 --seed 5 --out learn.mcap").ends(0);
    for line in [
        "simulate --sim drop.toml --out s.mcap --json",
        "gen ball --sim drop.toml --pairs 200 --seed 5 --out pairs.mcap --json",
        "gen ball --preset general --pairs 20 --seed 5 --out pairs.mcap",
        "train --data learn.mcap --preset paper --seed 5 --out m.safetensors",
        "tune --sim scene.toml --observation a.csv b.csv --seed 5 --out t.toml --report t.html",
        "tune --sim scene.toml --observation a.csv --seed 5 --json",
        "diagnose --sim scene.toml --observation a.csv b.csv c.csv --seed 5 --out d.toml --report d.html",
        "diagnose --sim scene.toml --observation a.csv b.csv c.csv --seed 5 --json",
        "bench diagnose --quick --only clean --seed 5 --out b",
    ] {
        let first = written(&folder, line, THREADS[0]);
        assert!(first.iter().any(|(_, bytes)| bytes.len() > 50), "{line} writes nothing");
        for threads in &THREADS[1..] {
            let again = written(&folder, line, threads);
            let names = |all: &[(String, Vec<u8>)]| all.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
            assert_eq!(names(&first), names(&again), "{line}");
            for ((name, a), (_, b)) in first.iter().zip(&again) {
                let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
                assert!(a == b, "{line}: {name} differs on {threads} threads:\n{}\n---\n{}", text(a), text(b));
            }
        }
    }
}
