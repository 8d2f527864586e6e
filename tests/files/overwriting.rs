//! What stands on the disk is never lost unasked: no input is written over, nor a file that tunenet did not write; and the
//! same command can be given again.

use crate::common::{DROP, Drop, Folder, refused};

fn folder() -> Folder {
    let folder = Folder::with_scene();
    folder.write("drop.toml", DROP);
    folder.write("drop.csv", Drop::default().csv());
    folder.write("other.csv", Drop { seed: 2, ..Drop::default() }.csv());
    folder.run("gen ball --sim drop.toml --pairs 20 --out pairs.mcap").ends(0);
    folder
}

/// Commands that write, without the name that they write to.
const WRITING: [(&str, &str); 9] = [
    ("init ball --out", "toml"),
    ("tune --sim scene.toml --observation drop.csv --out", "toml"),
    ("tune --sim scene.toml --observation drop.csv --report", "html"),
    ("diagnose --sim scene.toml --observation drop.csv other.csv --out", "toml"),
    ("diagnose --sim scene.toml --observation drop.csv other.csv --report", "html"),
    ("simulate --sim drop.toml --out", "csv"),
    ("simulate --sim drop.toml --out", "mcap"),
    ("gen ball --sim drop.toml --pairs 20 --out", "mcap"),
    ("train --data pairs.mcap --preset paper --out", "safetensors"),
];

/// Whoever finds a file goes by its name, and `-` is none.
#[test]
fn an_output_is_named_after_what_it_holds() {
    let folder = folder();
    let before = folder.names();
    for (line, ending) in WRITING {
        let flag = line.rsplit(' ').next().unwrap();
        for name in ["-", "a.txt", "a"] {
            let ran = folder.run(&format!("{line} {name}")).ends(2);
            let wanted = format!("`{flag}`: expected a name that ends in .");
            assert!(
                ran.stderr.contains(&wanted) && ran.stderr.contains(&format!(".{ending}")),
                "{line}: {}",
                ran.stderr
            );
            assert!(ran.stdout.is_empty(), "{}", ran.stdout);
            let stream = ran.stderr.contains("since the answer goes to standard output");
            assert_eq!(stream, name == "-", "{}", ran.stderr);
        }
    }
    assert_eq!(folder.names(), before);
    #[cfg(unix)]
    folder.run("tune --sim scene.toml drop.csv --report /dev/null").ends(0);
}

#[test]
fn a_file_of_a_person_is_replaced_only_where_it_is_asked_for() {
    let folder = folder();
    for (line, ending) in WRITING {
        let name = format!("mine.{ending}");
        folder.write(&name, "mine");
        let flag = line.rsplit(' ').next().unwrap();
        let wanted = [&format!("{name}: expected a new name"), "there already", flag, "--overwrite"];
        refused(&folder, &format!("{line} {name}"), &wanted);
        assert_eq!(folder.read(&name), b"mine", "{line}");
        folder.run(&format!("{line} {name} --overwrite")).ends(0);
        assert_ne!(folder.read(&name), b"mine", "{line}");
    }
}

/// A report is no simulation file, a recording no data set: each replaces its own kind alone.
#[test]
fn what_tunenet_wrote_is_replaced_by_the_same_kind() {
    let folder = folder();
    for (number, (line, ending)) in WRITING.into_iter().enumerate().skip(1) {
        let name = format!("{number}.{ending}");
        folder.run(&format!("{line} {name}")).ends(0);
        folder.run(&format!("{line} {name}")).ends(0);
    }
    folder.write("3.html", folder.read("1.toml"));
    folder.write("3.toml", folder.read("2.html"));
    refused(&folder, "tune --sim scene.toml --observation drop.csv --report 3.html", &["3.html", "a report"]);
    refused(&folder, "tune --sim scene.toml --observation drop.csv --out 3.toml", &["3.toml", "a simulation file"]);
    refused(&folder, "gen ball --sim drop.toml --pairs 20 --out 6.mcap", &["6.mcap", "a data set"]);
    // A recording bears no mark: only the very same is written again.
    refused(
        &folder,
        "simulate --sim drop.toml --set release.height_m=2 --out 5.csv",
        &["5.csv", "expected a new name"],
    );
    refused(&folder, "simulate --sim drop.toml --out drop.csv", &["drop.csv", "expected a new name"]);
    // An empty file has nothing to lose.
    folder.write("empty.toml", "");
    folder.run("tune --sim scene.toml --observation drop.csv --out empty.toml").ends(0);
}

#[test]
fn what_is_read_is_never_written_over() {
    let folder = folder();
    folder.run("tune --sim scene.toml --observation drop.csv --out tuned.toml").ends(0);
    folder.write(
        "objects.toml",
        "[[observation]]\nfile = \"drop.csv\"\n[[observation]]\nfile = \"other.csv\"\nobject = \"b\"\n",
    );
    std::fs::create_dir(folder.path("out")).unwrap();
    folder.write("out/ball.toml", DROP);
    for (line, name) in [
        ("tune --sim tuned.toml --observation drop.csv --out tuned.toml", "tuned.toml"),
        ("tune --sim tuned.toml --observation drop.csv --out ./tuned.toml", "tuned.toml"),
        ("tune --sim scene.toml --observation drop.csv --out drop.csv", "drop.csv"),
        ("tune --sim scene.toml --observation drop.csv --report drop.csv", "drop.csv"),
        ("diagnose --sim tuned.toml --observation drop.csv --out tuned.toml", "tuned.toml"),
        ("diagnose --sim scene.toml --observation drop.csv --held-out other.csv --report other.csv", "other.csv"),
        ("diagnose --sim out/ball.toml --manifest objects.toml --out out", "out/ball.toml"),
    ] {
        let before = folder.read(name);
        let wanted = ["read as an input", "choose another name for --"];
        refused(&folder, &format!("{line} --overwrite"), &wanted);
        assert!(folder.read(name) == before, "{line}");
    }
}

/// The same evidence twice would look like twice as much, and narrow the interval.
#[test]
fn a_recording_counts_once() {
    let folder = folder();
    folder.write("copy.csv", folder.read("drop.csv"));
    let tune = "tune --sim scene.toml --observation";
    refused(
        &folder,
        &format!("{tune} drop.csv drop.csv"),
        &["drop.csv: expected another recording, found the same as"],
    );
    refused(&folder, &format!("{tune} drop.csv other.csv copy.csv"), &["copy.csv", "the same as in drop.csv", "once"]);
    let diagnose = "diagnose --sim scene.toml --observation";
    refused(&folder, &format!("{diagnose} drop.csv ./drop.csv"), &["./drop.csv", "the same as in drop.csv"]);
    refused(&folder, &format!("{diagnose} drop.csv --held-out copy.csv"), &["copy.csv", "the same as in drop.csv"]);
    // One by one, nothing is counted twice.
    folder.run(&format!("{tune} drop.csv copy.csv --each")).ends(0);
}
