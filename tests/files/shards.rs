//! Work in shards: put together it has the bytes of one run, and what does not belong together is refused by name.

use std::path::Path;

use serde_json::Value;

use crate::common::{DROP, Drop, Folder, Ran, refused};

/// Status 2 and one sentence; nothing is written.
#[track_caller]
fn misused(folder: &Folder, line: &str, wanted: &str) {
    let before = folder.names();
    let ran = folder.run(line).ends(2);
    assert!(ran.stderr.contains(wanted), "{line}: no `{wanted}` in:\n{}", ran.stderr);
    assert_eq!(folder.names(), before, "{line}");
}

/// Runs a command once for each of `count` shards.
#[track_caller]
fn in_shards(folder: &Folder, line: &str, count: u32) {
    for index in 0..count {
        folder.run(&format!("{line} --shard {index}/{count}")).ends(0);
    }
}

/// Without what a clock decides.
fn timeless(mut value: Value) -> Value {
    match &mut value {
        Value::Object(object) => {
            object.retain(|key, _| !key.contains("seconds"));
            object.values_mut().for_each(|inner| *inner = timeless(inner.take()));
        }
        Value::Array(all) => all.iter_mut().for_each(|inner| *inner = timeless(inner.take())),
        _ => {}
    }
    value
}

#[test]
fn datasets_from_shards_have_the_bytes_of_one_run() {
    let folder = Folder::new();
    folder.write("drop.toml", DROP);
    for (kind, what) in [
        ("easy", "ball --sim drop.toml --pairs 100 --seed 3"),
        ("general", "ball --preset general --pairs 21"),
        ("video", "ball-video --preset wide --pairs 10 --seed 1"),
    ] {
        folder.run(&format!("gen {what} --out whole-{kind}.mcap")).ends(0);
        for count in [1, 3, 4] {
            in_shards(&folder, &format!("gen {what} --out {kind}.mcap"), count);
            folder.run(&format!("merge {kind}.shard-*-of-{count}.mcap --out {kind}.mcap")).ends(0);
            assert!(
                folder.read(&format!("{kind}.mcap")) == folder.read(&format!("whole-{kind}.mcap")),
                "{kind} {count}"
            );
        }
    }
    // More shards than pairs: some hold none.
    in_shards(&folder, "gen ball --sim drop.toml --pairs 2 --out few.mcap", 3);
    let merged =
        folder.run("merge few.shard-2-of-3.mcap few.shard-0-of-3.mcap few.shard-1-of-3.mcap --out few.mcap --json");
    let merged = merged.ends(0).json();
    assert_eq!((merged["schema"].as_str(), merged["pairs"].as_u64()), (Some("tunenet.merge/1"), Some(2)));
    // A shard is known for what it is, and no network learns from it alone.
    let seen = folder.run("inspect easy.shard-1-of-4.mcap").ends(1).stdout;
    assert!(seen.contains("shard 1/4") && seen.contains("25 of 100 pairs"), "{seen}");
    refused(
        &folder,
        "train --data easy.shard-1-of-4.mcap --out m.safetensors",
        &["found shard 1/4", "`tunenet merge`"],
    );
}

/// Most of a million shards of two pairs can have no work: each says so, and is a shard all the same.
#[test]
fn more_shards_than_work_are_told() {
    let folder = Folder::with_scene();
    folder.write("drop.toml", DROP);
    folder.write("drop.csv", Drop::default().csv());
    let each = "tune --sim scene.toml --observation drop.csv --each --out-dir answers";
    for (line, wanted) in [
        ("gen ball --sim drop.toml --pairs 2 --out p.mcap --shard 0/1000000", "1000000 shards of 2 pieces"),
        ("bench preflight --records 1 --out bench --shard 900/1000", "1000 shards of 28 pieces"),
        (&format!("{each} --shard 1/2"), "2 shards of 1 pieces"),
    ] {
        let ran = folder.run(&format!("{line} --json")).ends(0);
        assert!(ran.stderr.contains("warning[shards.many]") && ran.stderr.contains(wanted), "{line}: {}", ran.stderr);
        assert_eq!(ran.json()["warnings"][0]["code"], "shards.many", "{line}");
        if line.starts_with("bench") {
            assert_eq!(ran.json()["pieces"], 0, "{line}");
        }
    }
    let enough = folder.run(&format!("{each} --shard 0/1 --json")).ends(0);
    assert!(!enough.stderr.contains("shards.many"), "{}", enough.stderr);
}

#[test]
fn an_engine_says_which_shard() {
    let folder = Folder::new();
    folder.write("drop.toml", DROP);
    let with = |variables: &[(&str, &str)], shard: &str| -> Ran {
        let mut command = folder.command();
        for name in ["SLURM_ARRAY_TASK_ID", "JOB_COMPLETION_INDEX"] {
            command.env_remove(name);
        }
        command.envs(variables.iter().copied());
        let line = ["gen", "ball", "--sim", "drop.toml", "--pairs", "8", "--out", "p.mcap", "--shard", shard];
        command.args(line).output().expect("the binary starts").into()
    };
    let array = |task| {
        [
            ("SLURM_ARRAY_TASK_ID", task),
            ("SLURM_ARRAY_TASK_MIN", "1"),
            ("SLURM_ARRAY_TASK_MAX", "2"),
            ("SLURM_ARRAY_TASK_COUNT", "2"),
            ("SLURM_ARRAY_TASK_STEP", "1"),
        ]
    };
    with(&array("1"), "auto").ends(0);
    with(&array("2"), "auto").ends(0);
    with(&[("JOB_COMPLETION_INDEX", "7")], "auto/8").ends(0);
    assert_eq!(folder.names(), ["drop.toml", "p.shard-0-of-2.mcap", "p.shard-1-of-2.mcap", "p.shard-7-of-8.mcap"]);
    for (ran, wanted) in [
        (with(&[], "auto"), "found neither"),
        (with(&[("JOB_COMPLETION_INDEX", "8")], "auto/8"), "expected a shard from 0/8 to 7/8, found `8/8`"),
        (with(&[("JOB_COMPLETION_INDEX", "1")], "auto"), "expected `auto/N`"),
        (with(&[], "2/2"), "expected a shard from 0/2 to 1/2, found `2/2`"),
        (with(&[], "half"), "expected i/n"),
    ] {
        let ran = ran.ends(2);
        assert!(ran.stderr.contains(wanted), "no `{wanted}` in:\n{}", ran.stderr);
    }
}

#[test]
fn shards_that_do_not_belong_together_are_refused() {
    let folder = Folder::new();
    folder.write("drop.toml", DROP);
    let line = "gen ball --sim drop.toml --pairs 40 --out p.mcap";
    in_shards(&folder, line, 3);
    folder.run("gen ball --sim drop.toml --pairs 40 --seed 9 --out seed.mcap --shard 1/3").ends(0);
    folder.run("gen ball --sim drop.toml --pairs 40 --preset wide --out wide.mcap --shard 1/3").ends(0);
    folder.run("gen ball --sim drop.toml --pairs 41 --out more.mcap --shard 1/3").ends(0);
    folder.run("gen ball --sim drop.toml --set ball.mass_kg=0.1 --pairs 40 --out scene.mcap --shard 1/3").ends(0);
    folder.run("gen ball --sim drop.toml --pairs 40 --out whole.mcap").ends(0);
    let merge = |others: &str| format!("merge p.shard-0-of-3.mcap p.shard-2-of-3.mcap {others} --out merged.mcap");
    for (others, wanted) in [
        ("", "expected all 3 shards, found none that is 1/3"),
        (
            "seed.shard-1-of-3.mcap",
            "seed.shard-1-of-3.mcap: expected a shard of seed 0 as p.shard-0-of-3.mcap, found one of seed 9",
        ),
        (
            "wide.shard-1-of-3.mcap",
            "expected a shard of preset ball/easy as p.shard-0-of-3.mcap, found one of preset ball/wide",
        ),
        ("more.shard-1-of-3.mcap", "40 pairs as p.shard-0-of-3.mcap, found one of 41 pairs"),
        ("scene.shard-1-of-3.mcap", "found one of another scene"),
        ("p.shard-2-of-3.mcap", "expected every shard once, found 2/3 here and in p.shard-2-of-3.mcap"),
        ("whole.mcap", "expected a shard of a dataset, found a whole one"),
    ] {
        refused(&folder, &merge(others), &[wanted]);
    }
    refused(
        &folder,
        &merge("p.shard-1-of-3.mcap").replace("merged.mcap", "p.shard-0-of-3.mcap"),
        &["read as an input"],
    );
    misused(&folder, "merge 'none-*.mcap' --out merged.mcap", "which matches none");
    // Half a shard is told, and made again by its command; a whole one is kept.
    let whole = folder.read("p.shard-1-of-3.mcap");
    folder.write("p.shard-1-of-3.mcap", &whole[..whole.len() / 2]);
    let half = folder.run(&merge("p.shard-1-of-3.mcap")).ends(1).stderr;
    assert!(half.contains("p.shard-1-of-3.mcap: expected a complete MCAP file") && half.contains("again"), "{half}");
    assert!(!folder.path("merged.mcap").exists());
    for length in [100, 700, whole.len() / 2] {
        folder.write("p.shard-1-of-3.mcap", &whole[..length]);
        let again = folder.run(&format!("{line} --shard 1/3")).ends(0).stderr;
        assert!(again.contains("again") && again.contains("not whole"), "{length}: {again}");
        assert!(folder.read("p.shard-1-of-3.mcap") == whole, "{length}");
    }
    let kept = folder.run(&format!("{line} --shard 1/3")).ends(0).stderr;
    assert!(kept.contains("kept     p.shard-1-of-3.mcap is complete already"), "{kept}");
    folder.run(&merge("p.shard-1-of-3.mcap")).ends(0);
    assert!(folder.read("merged.mcap") == folder.read("whole.mcap"));
}

/// A limit on the length of files stands for a disk that is full: the system refuses in the middle of the writing.
#[cfg(unix)]
#[test]
fn a_full_disk_leaves_no_half_file_under_the_final_name() {
    let folder = Folder::new();
    folder.write("drop.toml", DROP);
    let line = "gen ball --sim drop.toml --pairs 800 --seed 3 --out p.mcap --shard 1/2";
    let full = |line: &str| folder.shell(&format!("trap '' XFSZ; ulimit -f 64; exec \"$TUNENET\" {line}")).ends(1);
    let ran = full(line);
    assert!(ran.stderr.contains("p.shard-1-of-2.mcap.partial: writing failed: File too large"), "{}", ran.stderr);
    assert!(ran.stderr.contains("free some space"), "{}", ran.stderr);
    assert!(!folder.path("p.shard-1-of-2.mcap").exists());
    // With room it goes on where it stopped, and so does a merge.
    in_shards(&folder, "gen ball --sim drop.toml --pairs 800 --seed 3 --out p.mcap", 2);
    let merge = "merge p.shard-0-of-2.mcap p.shard-1-of-2.mcap --out p.mcap";
    assert!(full(merge).stderr.contains("p.mcap.partial: writing failed: File too large"));
    assert!(!folder.path("p.mcap").exists());
    folder.run(merge).ends(0);
    folder.run("gen ball --sim drop.toml --pairs 800 --seed 3 --out whole.mcap").ends(0);
    assert!(folder.read("p.mcap") == folder.read("whole.mcap"));
    // The rollouts that do not fit into the memory of a training need room too.
    let train = "train --data p.mcap --preset paper --memory-mib 0 --out m.safetensors";
    let ran = full(train);
    assert!(ran.stderr.contains("temporary file of the training: writing failed: File too large"), "{}", ran.stderr);
    assert!(!folder.path("m.safetensors").exists());
}

#[test]
fn benches_from_shards_say_what_one_run_says() {
    let folder = Folder::new();
    for (line, count) in [
        ("bench diagnose --quick --only dropped --jobs 2", 3),
        ("bench intervals --drops 2", 2),
        ("bench regions --draws 2", 3),
        ("bench preflight --records 5", 2),
    ] {
        let whole = folder.run(&format!("{line} --out whole --json")).ends(0).json();
        in_shards(&folder, &format!("{line} --out out"), count);
        // Backwards, since the order in which they are named is nobody's business.
        let shards: Vec<String> = (0..count).rev().map(|i| format!("out.shard-{i}-of-{count}")).collect();
        let merged = folder.run(&format!("merge {} --out merged --json", shards.join(" "))).ends(0).json();
        assert_eq!(timeless(merged), timeless(whole), "{line}");
        for name in ["whole", "merged"].iter().map(ToString::to_string).chain(shards) {
            std::fs::remove_dir_all(folder.path(&name)).unwrap();
        }
    }
}

#[test]
fn shards_of_a_bench_that_do_not_belong_together_are_refused() {
    let folder = Folder::new();
    let line = "bench preflight --records 3";
    in_shards(&folder, &format!("{line} --out out"), 2);
    folder.run("bench preflight --records 3 --seed 5 --out seed --shard 1/2").ends(0);
    folder.run("bench regions --draws 1 --out other --shard 1/2").ends(0);
    let merge = |others: &str| format!("merge out.shard-0-of-2 {others} --out merged");
    for (others, wanted) in [
        ("", "out.shard-0-of-2: expected all 2 shards, found none that is 1/2"),
        (
            "seed.shard-1-of-2",
            "seed.shard-1-of-2: expected a shard of `--seed` 0 as out.shard-0-of-2, found one of `--seed` 5\n",
        ),
        (
            "other.shard-1-of-2",
            "expected a shard of `bench preflight` as out.shard-0-of-2, found one of `bench regions`\n",
        ),
        ("out.shard-0-of-2", "expected every shard once, found 0/2 here and in out.shard-0-of-2"),
    ] {
        refused(&folder, &merge(others), &[wanted]);
    }
    let mark = folder.read("out.shard-1-of-2/shard.json");
    let edited = |from: &str, to: &str| String::from_utf8(mark.clone()).unwrap().replacen(from, to, 1);
    folder.write("out.shard-1-of-2/shard.json", edited("\"version\": \"", "\"version\": \"9."));
    refused(&folder, &merge("out.shard-1-of-2"), &["found one by 9.", "merge with the version"]);
    folder.write("out.shard-1-of-2/shard.json", edited("\"program\": \"", "\"program\": \"0"));
    refused(&folder, &merge("out.shard-1-of-2"), &["found one of another build"]);
    folder.write("out.shard-1-of-2/shard.json", &mark[..mark.len() / 2]);
    refused(&folder, &merge("out.shard-1-of-2"), &["expected the mark of a shard"]);
    std::fs::remove_file(folder.path("out.shard-1-of-2/shard.json")).unwrap();
    refused(&folder, &merge("out.shard-1-of-2"), &["expected a finished shard, found a folder without `shard.json`"]);
    // What is damaged is told, and made again.
    folder.write("out.shard-1-of-2/shard.json", &mark);
    let piece = std::fs::read_dir(folder.path("out.shard-1-of-2/cells")).unwrap().next().unwrap().unwrap().path();
    let sound = std::fs::read_to_string(&piece).unwrap();
    std::fs::write(&piece, sound.replacen("true", "false", 1)).unwrap();
    refused(&folder, &merge("out.shard-1-of-2"), &["found other contents", "again"]);
    folder.run(&format!("{line} --out out --shard 1/2")).ends(0);
    assert_eq!(std::fs::read_to_string(&piece).unwrap(), sound);
    folder.run(&merge("out.shard-1-of-2")).ends(0);
    // A finished shard of another seed stays as it is.
    let finished = folder.read("out.shard-1-of-2/shard.json");
    refused(
        &folder,
        "bench preflight --records 3 --seed 5 --out out --shard 1/2",
        &[
            "out.shard-1-of-2: expected a new folder, or a shard with `--seed` 5, found a finished one with `--seed` 0",
            "--out",
        ],
    );
    assert!(folder.read("out.shard-1-of-2/shard.json") == finished);
    misused(&folder, "bench speed --shard 0/2", "has nothing to cut");
    misused(&folder, "bench grow --shard 0/2", "has nothing to cut");
}

/// Seven drops in two folders, one of which is none.
fn drops() -> Folder {
    let folder = Folder::with_scene();
    for sub in ["logs/a", "logs/b"] {
        std::fs::create_dir_all(folder.path(sub)).unwrap();
    }
    for seed in 0..6 {
        let drop = Drop { restitution: 0.5 + 0.05 * seed as f64, seed, ..Drop::default() };
        let sub = if seed % 2 == 0 { "a" } else { "b" };
        folder.write(&format!("logs/{sub}/drop{}.csv", seed / 2), drop.csv());
    }
    folder.write("logs/b/broken.csv", "t_s,z_m\n0,one\n");
    folder
}

#[test]
fn recordings_are_tuned_to_in_shards() {
    let folder = drops();
    let line = "tune --sim scene.toml --observation logs/*/*.csv --each";
    for tool in ["tune", "diagnose"] {
        let alone = format!("{tool} --sim scene.toml --observation logs/a/drop0.csv --shard 0/2");
        misused(&folder, &alone, "`--shard`: expected `--each`, since shards divide recordings");
    }
    let whole = folder.run(&format!("{line} --out-dir whole --jobs 2 --json")).ends(1);
    // In the order of their names, whichever was done first.
    let told: Vec<&str> = whole.stderr.lines().filter_map(|l| l.split_once(".csv:").map(|(name, _)| name)).collect();
    assert_eq!(told, ["a/drop0", "a/drop1", "a/drop2", "logs/b/broken", "b/drop0", "b/drop1", "b/drop2"]);
    let object = whole.json();
    assert_eq!(object["observations"].as_array().unwrap().len(), 7);
    let called: Vec<&str> =
        object["observations"].as_array().unwrap().iter().map(|one| one["file"].as_str().unwrap()).collect();
    assert_eq!((called[0], called[3], called[4]), ("a/drop0.csv", "broken.csv", "b/drop0.csv"));
    // What one run without files of its own answers is the same.
    let plain = folder.run(&format!("{line} --json")).ends(1).json();
    assert_eq!(timeless(plain), timeless(object.clone()));
    for index in 0..3 {
        let ran = folder.run(&format!("{line} --out-dir out --json --shard {index}/3"));
        let code = i32::from(index == 0);
        assert_eq!(ran.ends(code).json()["shard"], format!("{index}/3"));
    }
    let merged = folder.run("merge out.shard-*-of-3 --out out --json").ends(1).json();
    assert_eq!(timeless(merged), timeless(object));
    assert_eq!(files(&folder.path("out")), files(&folder.path("whole")));
    assert!(files(&folder.path("out")).contains(&"b/drop2.csv.json".to_owned()));
    // What is there is not done again, but for what was refused and what was asked otherwise.
    let again = folder.run(&format!("{line} --out-dir whole --json")).ends(1);
    assert_eq!(again.stderr.matches(": kept").count(), 6, "{}", again.stderr);
    let other = folder.run(&format!("{line} --out-dir whole --set ball.radius_m=0.021")).ends(1);
    assert_eq!(other.stdout.matches(": kept").count(), 0, "{}", other.stdout);
    // Shards of other questions do not go together.
    folder.run(&format!("{line} --out-dir other --seed 4 --shard 1/3")).ends(0);
    let merge = "merge out.shard-0-of-3 other.shard-1-of-3 out.shard-2-of-3 --out mixed";
    refused(&folder, merge, &["found one of another simulation, seed or setting"]);
    misused(&folder, &format!("{line} --shard 0/3"), "expected --out-dir with it");
    misused(&folder, &format!("{line} --out-dir out --report r.html"), "no `--report` with `--out-dir`");
    misused(&folder, "tune --sim scene.toml --observation logs/*/none.csv --each", "which matches none");
    misused(&folder, "tune --sim scene.toml --observation logs/a/drop0.csv --out-dir out", "--each");
}

#[test]
fn recordings_are_diagnosed_in_shards() {
    let folder = drops();
    std::fs::remove_file(folder.path("logs/b/broken.csv")).unwrap();
    let line = "diagnose --sim scene.toml --observation logs/?/drop[01].csv --each";
    let run = |rest: &str| {
        let ran = folder.run(&format!("{line} {rest}"));
        assert!(matches!(ran.code, Some(0 | 3)), "{}", ran.stderr);
        ran
    };
    let whole = run("--out-dir whole --jobs 2 --json").json();
    assert_eq!(whole["schema"], "tunenet.diagnose.each/1");
    assert_eq!(whole["observations"].as_array().unwrap().len(), 4);
    for index in 0..2 {
        run(&format!("--out-dir out --shard {index}/2"));
    }
    let merged = folder.run("merge out.shard-0-of-2 out.shard-1-of-2 --out out --json").json();
    assert_eq!(timeless(merged), timeless(whole));
    misused(&folder, &format!("{line} --out improved.toml"), "cannot be used with");
}

/// Every file below a folder.
/// What somebody else put there stays; tunenet's own answers and shards of the same command are made again as before.
#[test]
fn files_of_others_are_not_replaced() {
    let folder = drops();
    std::fs::create_dir(folder.path("mine")).unwrap();
    let line = "tune --sim scene.toml --observation logs/a/*.csv --each --out-dir mine";
    for name in ["each.json", "drop1.csv.json"] {
        folder.write(&format!("mine/{name}"), "{\"precious\":1}");
        refused(&folder, line, &[name, "--overwrite"]);
        assert_eq!(folder.read(&format!("mine/{name}")), b"{\"precious\":1}");
        std::fs::remove_file(folder.path(&format!("mine/{name}"))).unwrap();
    }
    // A shard of another seed may have taken long.
    folder.write("drop.toml", DROP);
    let made = |seed: u32| format!("gen ball --sim drop.toml --pairs 6 --seed {seed} --out p.mcap --shard 0/2");
    folder.run(&made(1)).ends(0);
    let kept = folder.read("p.shard-0-of-2.mcap");
    refused(&folder, &made(2), &["seed 2", "seed 1", "--overwrite"]);
    assert!(folder.read("p.shard-0-of-2.mcap") == kept);
    folder.run(&format!("{} --overwrite", made(2))).ends(0);
    assert!(folder.read("p.shard-0-of-2.mcap") != kept);
}

fn files(folder: &Path) -> Vec<String> {
    let (mut all, mut folders) = (Vec::new(), vec![folder.to_owned()]);
    while let Some(at) = folders.pop() {
        for entry in std::fs::read_dir(&at).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                all.push(path.strip_prefix(folder).unwrap().display().to_string());
            }
        }
    }
    all.sort();
    all
}

#[test]
fn the_page_shows_what_is_tested() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let page = std::fs::read_to_string(root.join("docs/grow.md")).unwrap();
    for name in ["array.sbatch", "merge.sbatch", "ray_shards.py", "indexed-job.yaml"] {
        let text = std::fs::read_to_string(root.join("assets/cluster").join(name)).unwrap();
        assert!(page.contains(text.trim_end()), "docs/grow.md does not hold assets/cluster/{name} as it is");
    }
    // Its figures have the form in which the command prints them.
    let folder = Folder::new();
    let line = "bench grow --pairs 20 --threads 2 --want 100000000 --nodes 16 --cores 32 --out out";
    let object = folder.run(&format!("{line} --json")).ends(0).json();
    assert_eq!(object["rows"][0]["pairs"], 20);
    assert_eq!(object["cluster"]["extrapolated"], true);
    assert_eq!(files(&folder.path("out")), ["grow.json", "grow.md"], "data sets go away");
    let printed = folder.text("out/grow.md");
    let shape = |text: &str| -> Vec<String> {
        let words = text.lines().filter(|l| l.starts_with('|') || l.starts_with("Extrapolated")).map(|line| {
            let plain: String = line.chars().filter(|c| !c.is_ascii_digit() && !".,".contains(*c)).collect();
            plain.replace("min", "s").replace(" h ", " s ").replace("GB", "MB").replace("TB", "MB")
        });
        let mut all: Vec<String> = words.collect();
        all.dedup();
        all
    };
    let held = page.split("<!-- grow: begin -->").nth(1).and_then(|rest| rest.split("<!-- grow: end -->").next());
    assert_eq!(shape(held.unwrap()), shape(&printed));
}
