//! `tunenet diagnose` as a process: its JSON, its exit codes, the files that it writes, and what it refuses.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use crate::common::{Drop, Folder, Noise, Ran, table};
use serde_json::Value;

const SCENE: &str = "\
kind = \"ball\"
ball.radius_m = 0.02
ball.mass_kg = 0.0027
surface.height_m = 0.0

[parameters.restitution]
value = 0.5
min = 0.0
max = 1.0
";

fn light(number: usize) -> PathBuf {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/observations");
    assets.join(format!("light_{number}.csv"))
}

/// The scene, and the throws of a light ball from the assets as `1.csv` to `5.csv`.
fn with_throws() -> Folder {
    let folder = Folder::new();
    folder.write("scene.toml", SCENE);
    for number in 1..=5 {
        folder.write(&format!("{number}.csv"), std::fs::read(light(number)).expect("an asset"));
    }
    folder
}

fn list<'a>(json: &'a Value, key: &str) -> &'a Vec<Value> {
    json[key].as_array().unwrap_or_else(|| panic!("no list `{key}` in {json:#}"))
}

fn codes(json: &Value) -> Vec<&str> {
    list(json, "warnings").iter().filter_map(|w| w["code"].as_str()).collect()
}

#[test]
fn a_limit_on_rollouts_leaves_no_answer_and_a_quick_search_one() {
    let folder = with_throws();
    let line = "diagnose --sim scene.toml 1.csv 2.csv 3.csv 4.csv --held-out 5.csv --out-ranges ranges.json --json";
    let limited = folder.run(&format!("{line} --max-rollouts 100 --out improved.toml")).ends(3).json();
    assert_eq!((&limited["verdict"], &limited["rollouts"]), (&"insufficient".into(), &100.into()));
    assert!(codes(&limited).contains(&"rollouts.limit") && !folder.path("ranges.json").exists());
    assert!(!folder.path("improved.toml").exists());
    let ran = folder.run(&format!("{line} --quick")).ends(0);
    let quick = ran.json();
    assert_eq!((&quick["verdict"], &quick["effects"][0]["name"]), (&"named".into(), &"quadratic_drag".into()));
    assert!(codes(&quick).contains(&"fit.quick"));
    let written: Value = serde_json::from_str(&folder.text("ranges.json")).unwrap();
    let ranges = list(&written, "ranges");
    let of = |name: &str| ranges.iter().find(|one| one["name"] == name).unwrap_or_else(|| panic!("{written:#}"));
    let drag = of("effects.quadratic_drag.c_1_m");
    assert!(drag["low"].as_f64() < Some(0.1317) && drag["high"].as_f64() > Some(0.1317), "{drag}");
    assert_eq!((&of("restitution")["unit"], &written["verdict"]), (&"1".into(), &"named".into()));
    // What the recordings do not determine has no range.
    let open = list(&written, "undetermined");
    assert!(ranges.iter().all(|one| !open.contains(&one["name"])), "{written:#}");
    let said = |name: &Value| ran.stderr.contains(&format!("`{}`", name.as_str().unwrap_or_default()));
    assert!(open.iter().all(said), "{}", ran.stderr);
}

#[test]
fn a_missing_effect_is_named_and_written_and_proven() {
    let folder = with_throws();
    let line = "diagnose --sim scene.toml --observation 1.csv 2.csv 3.csv 4.csv --held-out 5.csv --out improved.toml";
    let ran = folder.run(&format!("{line} --json")).ends(0);
    let json = ran.json();
    for key in
        ["schema", "verdict", "effects", "candidates", "gap", "next_experiment", "rollouts", "seconds", "warnings"]
    {
        assert!(json.get(key).is_some(), "no `{key}` in {json:#}");
    }
    assert_eq!(json["verdict"], "named", "{json:#}");
    let [drag] = &list(&json, "effects")[..] else { panic!("{json:#}") };
    assert_eq!((&drag["name"], &drag["where"]["phase"]), (&"quadratic_drag".into(), &"flight".into()));
    let number = |value: &Value| value.as_f64().unwrap_or_else(|| panic!("no number in {json:#}"));
    let c = &drag["coefficients"]["c_1_m"];
    assert!((number(&c["value"]) - 0.1317).abs() < 0.01, "{c}");
    assert!(number(&c["interval95"][0]) < 0.1317 && 0.1317 < number(&c["interval95"][1]), "{c}");
    // 2 c m / (1.2 A)
    let expected = 2.0 * number(&c["value"]) * 0.0027 / (1.2 * std::f64::consts::PI * 4e-4);
    assert!((number(&drag["coefficients"]["drag_coefficient"]["value"]) - expected).abs() < 1e-9);
    assert!(number(&drag["evidence"]["bic_gain"]) > 6.0);
    let (gap, held_out) = (&json["gap"], &json["gap"]["held_out"]);
    assert!(number(&gap["after"]) < 0.5 * number(&gap["before"]), "{gap}");
    assert!(number(&held_out["after"]) < 0.5 * number(&held_out["before"]), "{held_out}");
    assert!(number(&gap["after"]) < 1.05 * number(&gap["noise_floor"]), "{gap}");

    // What was written is a simulation like any other, and it has the effect.
    let text = folder.text("improved.toml");
    for part in ["[effects.quadratic_drag]\nc_1_m = 0.1", "[provenance]", "command = \"diagnose\"", "held_out_after"] {
        assert!(text.contains(part), "no `{part}` in\n{text}");
    }
    folder.run("simulate --sim improved.toml --set release.height_m=1 --out again.csv").ends(0);
    let tuned = folder.run("tune --sim improved.toml --observation 5.csv --json").ends(0).json();
    assert!((number(&tuned["parameters"]["restitution"]["value"]) - 0.8).abs() < 5e-3, "{tuned:#}");
    // Equal runs write equal bytes, whatever the number of threads.
    let first = folder.read("improved.toml");
    folder.run(&format!("{line} --jobs 1")).ends(0);
    assert!(folder.read("improved.toml") == first);
}

/// Drag of a body of known mass comes first; it does not hide what explains the throw: friction 0.2, restitution 0.75, no air.
#[test]
fn what_explains_a_throw_comes_before_the_drag_that_has_to_be_there() {
    let folder = Folder::new();
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets");
    folder.write("ball.toml", std::fs::read(assets.join("ball.toml")).unwrap());
    folder.write("throw.csv", std::fs::read(assets.join("observations/throw.csv")).unwrap());
    let json = folder.run("diagnose --sim ball.toml throw.csv --json").ends(3).json();
    assert_eq!((&json["verdict"], &json["effects"][0]["name"]), (&"one_of".into(), &"bounce_friction".into()));
    let restitution = &json["parameters"][0];
    let mu = &json["effects"][0]["coefficients"]["mu"];
    for (found, truth) in [(restitution, 0.75), (mu, 0.2)] {
        let (low, high) = (found["interval95"][0].as_f64().unwrap(), found["interval95"][1].as_f64().unwrap());
        assert!(low < truth && truth < high && high - low < 0.05, "{truth}: {json:#}");
    }
    assert!(json["gap"]["after"].as_f64().unwrap() < 0.004, "{json:#}");
}

#[test]
fn the_answer_for_people_names_what_was_found() {
    let folder = with_throws();
    let ran = folder.run("diagnose --sim scene.toml --observation 1.csv 2.csv 3.csv --held-out 5.csv").ends(0);
    for part in ["NAMED  quadratic_drag in flight", "held out", "residual tests passed"] {
        assert!(ran.stdout.contains(part), "no `{part}` in\n{}", ran.stdout);
    }
    assert!(ran.stderr.contains("read     3 recordings, 1 held out, 864 samples"), "{}", ran.stderr);
}

/// What cannot be the answer is told to people with the reason, as the JSON has it.
#[test]
fn what_is_excluded_is_told() {
    let folder = with_throws();
    let line = "diagnose --sim scene.toml --observation 1.csv 2.csv 3.csv";
    let json = folder.run(&format!("{line} --json")).ends(0).json();
    let text = folder.run(line).ends(0).stdout;
    let told = text.split_once("  excluded: ").expect("a line of them").1;
    let told =
        told.split_once("  next best").expect("the next line").0.split_whitespace().collect::<Vec<_>>().join(" ");
    let mut count = 0;
    for score in list(&json, "scores").iter().filter(|score| score["excluded"].is_string()) {
        let [name, why] = ["name", "excluded"].map(|key| score[key].as_str().expect("text"));
        assert!(told.contains(name) && told.contains(&format!("({why})")), "{name}: {why} in:\n{told}");
        count += 1;
    }
    assert!(count > 0, "{json:#}");
}

#[test]
fn a_complete_simulation_lacks_nothing() {
    let folder = with_throws();
    folder.write("complete.toml", format!("{SCENE}\n[effects.quadratic_drag]\nc_1_m = 0.1317\n"));
    let json = folder.run("diagnose --sim complete.toml --observation 1.csv 2.csv 3.csv --json").ends(0).json();
    assert_eq!(json["verdict"], "none", "{json:#}");
    assert!(list(&json, "effects").is_empty());
}

#[test]
fn objects_of_a_manifest_get_a_file_each() {
    let folder = with_throws();
    let entry = |object: &str, file: &str, held_out: bool| {
        format!(
            "[[observation]]\nfile = \"{file}\"\nobject = \"{object}\"\nheld_out = {held_out}\nball.mass_kg = 0.0027\n"
        )
    };
    let all = [
        ("a", "1.csv", false),
        ("a", "2.csv", false),
        ("b", "3.csv", false),
        ("b", "4.csv", false),
        ("b", "5.csv", true),
    ];
    folder.write("m.toml", all.map(|(object, file, held_out)| entry(object, file, held_out)).concat());
    let json = folder.run("diagnose --sim scene.toml --manifest m.toml --out improved --json").ends(0).json();
    assert_eq!(json["effects"][0]["name"], "quadratic_drag", "{json:#}");
    let each = json["effects"][0]["coefficients"]["c_1_m"]["objects"].as_array().expect("one for each object");
    assert_eq!(each.iter().map(|o| o["object"].as_str().unwrap()).collect::<Vec<_>>(), ["a", "b"]);
    for name in ["improved/a.toml", "improved/b.toml"] {
        let text = folder.text(name);
        assert!(text.contains("[effects.quadratic_drag]"), "{text}");
    }
}

/// A light ball and a heavy one together: the air that the light one shows is told of both, and that the heavy one needs none
/// of it is told as well.
#[test]
fn each_object_of_a_manifest_has_a_verdict_of_its_own() {
    let folder = with_throws();
    let mut manifest = String::new();
    for (object, mass_kg, file, held_out) in [
        ("light", 0.0027, "1.csv", false),
        ("light", 0.0027, "2.csv", false),
        ("light", 0.0027, "5.csv", true),
        ("heavy", 0.25, "low.csv", false),
        ("heavy", 0.25, "high.csv", false),
    ] {
        let _ = write!(
            manifest,
            "[[observation]]\nfile = \"{file}\"\nobject = \"{object}\"\nheld_out = {held_out}\nball.mass_kg = {mass_kg}\n"
        );
    }
    folder.write("m.toml", manifest);
    for (name, height_m, seed) in [("low.csv", 0.8, 3), ("high.csv", 1.4, 4)] {
        folder.write(name, Drop { restitution: 0.7, height_m, noise_m: 0.002, seed, ..Drop::default() }.csv());
    }
    let line = "diagnose --sim scene.toml --manifest m.toml --report page.html --out improved --json";
    let ran = folder.run(line).ends(0);
    let json = ran.json();
    assert_eq!(
        (&json["verdict"], &json["effects"][0]["name"]),
        (&"named".into(), &"quadratic_drag".into()),
        "{json:#}"
    );
    let each = list(&json, "objects");
    let verdicts: Vec<(&str, &str)> =
        each.iter().map(|o| (o["object"].as_str().unwrap(), o["verdict"].as_str().unwrap())).collect();
    assert_eq!(verdicts, [("light", "named"), ("heavy", "none")], "{json:#}");
    let gain = |i: usize| each[i]["effects"][0]["bic_gain"].as_f64().expect("a gain");
    assert!(gain(0) > 1000.0 && gain(1) < 6.0, "{each:#?}");
    let page = folder.text("page.html");
    let left_out = "The recordings of heavy do not need quadratic drag; their files leave it out.";
    assert!(page.contains(left_out), "the page names it");
    assert!(page.contains("gap of"), "the page has a table of the gaps");
    assert_eq!((&each[0]["effects"][0]["needed"], &each[1]["effects"][0]["needed"]), (&true.into(), &false.into()));
    let [light, heavy] = ["improved/light.toml", "improved/heavy.toml"].map(|name| folder.text(name));
    assert!(light.contains("[effects.quadratic_drag]") && !light.contains("not_needed"), "{light}");
    assert!(!heavy.contains("[effects.quadratic_drag]"), "{heavy}");
    assert!(heavy.contains("not_needed = [\"quadratic_drag\"]"), "{heavy}");
    // Without it the heavy ball is tuned anew: to the restitution of its drops.
    let tuned = list(&json, "parameters").iter().find(|p| p["object"] == "heavy").expect("the heavy ball").clone();
    assert!((tuned["value"].as_f64().unwrap() - 0.7).abs() < 2e-3, "{tuned}");
    let gaps = list(&json, "gaps");
    let whole: Vec<_> = gaps.iter().filter(|gap| gap["channel"].is_null()).collect();
    assert_eq!(whole.iter().map(|gap| gap["object"].as_str().unwrap()).collect::<Vec<_>>(), ["light", "heavy"]);
    for gap in &whole {
        let [after, floor] = ["after", "noise_floor"].map(|key| gap[key].as_f64().expect("a number"));
        assert!(after < 1.2 * floor, "{gap}");
    }
    assert!(whole[0]["held_out"]["after"].is_number() && whole[1]["held_out"].is_null(), "{gaps:#?}");
    let text = folder.run("diagnose --sim scene.toml --manifest m.toml").ends(0).stdout;
    assert!(text.contains("quadratic_drag is not needed by the recordings of heavy"), "{text}");
    assert!(text.contains("gap of") && text.contains("noise floor"), "{text}");
    // Of a single object the verdict is that of the whole, and the list is empty.
    let one = folder.run("diagnose --sim scene.toml --observation 1.csv 2.csv 3.csv --json").ends(0).json();
    assert!(list(&one, "objects").is_empty(), "{one:#}");
}

/// A refusal: this status, these words on standard error, nothing on standard output.
#[track_caller]
fn refused(ran: Ran, code: i32, words: &[&str]) {
    let ran = ran.ends(code);
    assert!(ran.stdout.is_empty());
    for word in words {
        assert!(ran.stderr.contains(word), "no `{word}` in\n{}", ran.stderr);
    }
}

#[test]
fn recordings_of_two_kinds_are_refused() {
    let folder = with_throws();
    let times: Vec<String> = (0..6).map(|i| (0.4 * f64::from(i) + 0.3).to_string()).collect();
    folder.write("heard.csv", format!("bounce_time_s\n{}\n", times.join("\n")));
    let line = "diagnose --sim scene.toml --observation 1.csv heard.csv";
    refused(folder.run(line), 1, &["heard.csv", "positions", "bounce times"]);
    folder.write("joints.csv", "t_s,q1_rad,tau1_nm\n0,0,0\n0.1,0.1,0\n0.2,0.2,0\n0.3,0.1,0\n");
    let line = "diagnose --sim scene.toml --observation joints.csv";
    refused(folder.run(line), 1, &["joints.csv", "positions"]);
}

#[test]
fn a_wrong_manifest_is_refused_with_its_place() {
    let folder = with_throws();
    let tried = |text: &str, words: &[&str]| {
        folder.write("m.toml", text);
        refused(folder.run("diagnose --sim scene.toml --manifest m.toml"), 1, words);
    };
    tried("[[observation]]\nfile = \"1.csv\"\nball.radios_m = 1\n", &["m.toml", "ball.radios_m"]);
    tried("[[observation]]\nfile = \"1.csv\"\nreference = \"2.csv\"\n", &["reference"]);
    tried("[[observation]]\nfile = \"9.csv\"\n", &["9.csv"]);
    tried(
        "[[observation]]\nfile = \"1.csv\"\nparameters.restitution.max = 0.9\n[[observation]]\nfile = \"2.csv\"\n",
        &["1.csv: expected the same `parameters.restitution.max`", "2.csv"],
    );
    tried("[[observation]]\nfile = \"1.csv\"\nheld_out = true\n", &["m.toml", "at least one"]);
    refused(folder.run("diagnose --sim scene.toml"), 2, &["RECORDING"]);
    refused(folder.run("diagnose --sim scene.toml --observation 1.csv --jobs 0"), 2, &["--jobs"]);
}

/// Too short, resting, or in another unit: an honest no, and why.
#[test]
fn recordings_that_cannot_answer_get_an_honest_no() {
    let folder = with_throws();
    let drop = Drop { frames: 4, ..Drop::default() };
    folder.write("short.csv", drop.csv());
    let rest: Vec<(f64, [f64; 3])> = {
        let mut noise = Noise(3);
        (0..200).map(|i| (f64::from(i) / 120.0, [0.0, 0.0, 0.02 + 0.001 * noise.normal()])).collect()
    };
    folder.write("rest.csv", table(&rest));
    for name in ["short.csv", "rest.csv"] {
        let ran = folder.run(&format!("diagnose --sim scene.toml --observation {name} --out o.toml --json")).ends(3);
        let json = ran.json();
        assert_eq!(json["verdict"], "insufficient", "{name}: {json:#}");
        assert!(!codes(&json).is_empty() || list(&json, "recordings").iter().any(|r| r["used"] == false), "{json:#}");
        assert!(!folder.path("o.toml").exists() && ran.stderr.contains("o.toml not written"), "{}", ran.stderr);
    }
    // One file in millimetres that says metres.
    let frames: Vec<(f64, [f64; 3])> =
        Drop::default().frames().iter().map(|(t, x)| (*t, x.map(|v| v * 1000.0))).collect();
    folder.write("mm.csv", table(&frames));
    let ran = folder.run("diagnose --sim scene.toml --observation 1.csv 2.csv 3.csv mm.csv --json");
    let json = ran.json();
    assert!(json["verdict"] != "named" || list(&json, "recordings").iter().any(|r| r["used"] == false), "{json:#}");
}

/// Recordings at several rates are as good as any.
#[test]
fn rates_may_differ() {
    let folder = with_throws();
    let every = |name: &str, step: usize| {
        let text = folder.text(name);
        let mut lines = text.lines();
        let head = lines.next().expect("a header").to_owned();
        let rows: Vec<&str> = lines.step_by(step).collect();
        folder.write(name, format!("{head}\n{}\n", rows.join("\n")));
    };
    every("2.csv", 2);
    every("3.csv", 3);
    let json = folder.run("diagnose --sim scene.toml --observation 1.csv 2.csv 3.csv 4.csv --json").ends(0).json();
    assert_eq!(json["effects"][0]["name"], "quadratic_drag", "{json:#}");
}

/// The same throw again and again does not separate what varied throws do.
#[test]
fn one_throw_repeated_is_told_to_be_varied() {
    let folder = Folder::new();
    folder.write("scene.toml", SCENE);
    for seed in 1..=3 {
        folder.write(&format!("{seed}.csv"), Drop { noise_m: 0.002, seed, ..Drop::default() }.csv());
    }
    let json = folder.run("diagnose --sim scene.toml --observation 1.csv 2.csv 3.csv --json").json();
    assert!(["none", "insufficient"].contains(&json["verdict"].as_str().unwrap()), "{json:#}");
}

/// A ball that bounces on a smooth floor in a steady wind of 0.4 m/s² along x: its height is that of a drop, and along the
/// floor nothing but the wind acts, x = u t + 0.2 t².
fn in_the_wind(height_m: f64, along_m_s: [f64; 2], seed: u64) -> String {
    let (drop, mut noise) = (Drop { restitution: 0.8, height_m, noise_m: 0.0, ..Drop::default() }, Noise(seed));
    let frames: Vec<(f64, [f64; 3])> = drop
        .frames()
        .iter()
        .map(|(t, at)| {
            let [u, v] = along_m_s;
            (*t, [u * t + 0.2 * t * t, v * t, at[2]].map(|value| value + 0.002 * noise.normal()))
        })
        .collect();
    table(&frames)
}

/// Copies of one throw, alike up to noise or a person's hand, are one throw: what it cannot tell apart stays together, and
/// only one of it is written.
#[test]
fn a_throw_that_is_repeated_earns_no_lone_name() {
    let folder = Folder::new();
    folder.write("scene.toml", "kind = \"ball\"\nball.radius_m = 0.02\nsurface.height_m = 0.0\n");
    for hand in [0.0, 0.02] {
        for (i, name) in ["a", "b", "c", "d", "e"].iter().enumerate() {
            let off = hand * (i as f64 - 2.0);
            folder.write(&format!("{name}.csv"), in_the_wind(1.2 + 0.2 * off, [0.5 + off, 0.3 - off], 7 + i as u64));
        }
        let line =
            "diagnose --sim scene.toml --observation a.csv b.csv c.csv d.csv e.csv --out o.toml --overwrite --json";
        let json = folder.run(line).ends(3).json();
        assert_eq!(json["verdict"], "one_of", "{json:#}");
        let left: Vec<&str> = list(&json, "candidates").iter().filter_map(Value::as_str).collect();
        assert!(left.len() > 1 && left.contains(&"wind") && codes(&json).contains(&"recordings.alike"), "{json:#}");
        assert!(json["next_experiment"]["text"].as_str().is_some_and(|text| text.contains("throw")), "{json:#}");
        let text = folder.text("o.toml");
        assert_eq!(text.matches("[effects.").count(), 1, "{text}");
        assert!(text.contains("chosen = [\"wind\"]"), "{text}");
        // What was written explains them better than what was given.
        let gap = |file: &str| {
            let json = folder.run(&format!("tune --sim {file} --observation a.csv b.csv --json")).json();
            json["gap"]["after"].as_f64().expect("a gap")
        };
        assert!(gap("o.toml") < gap("scene.toml"));
    }
    // As many in other directions tell it from all else.
    for (i, name) in ["a", "b", "c", "d", "e"].iter().enumerate() {
        let (sin, cos) = (1.3 * i as f64).sin_cos();
        folder.write(&format!("{name}.csv"), in_the_wind(1.0 + 0.2 * i as f64, [cos, sin], 7 + i as u64));
    }
    let varied =
        folder.run("diagnose --sim scene.toml --observation a.csv b.csv c.csv d.csv e.csv --json").ends(0).json();
    assert!(varied["verdict"] == "named" && varied["effects"][0]["name"] == "wind", "{varied:#}");
}

/// One figure, wherever it is told: JSON, provenance, table and page.
#[test]
fn every_figure_has_one_value() {
    let folder = with_throws();
    let line =
        "diagnose --sim scene.toml --observation 1.csv 2.csv 3.csv --held-out 5.csv --out o.toml --report o.html";
    let json = folder.run(&format!("{line} --json")).ends(0).json();
    let shown = folder.run(line).ends(0).stdout;
    let evidence = &json["effects"][0]["evidence"];
    let score = |name: &str| list(&json, "scores").iter().find(|s| s["name"] == name).expect("a score").clone();
    let number = |value: &Value| value.as_f64().unwrap_or_else(|| panic!("no number in {json:#}"));
    let runner_up = score(evidence["runner_up"].as_str().expect("a runner-up"));
    assert_eq!(evidence["bic_gain"], score("quadratic_drag")["bic_gain"]);
    let gap = number(&evidence["runner_up_bic_gap"]);
    assert!((gap - number(&runner_up["behind_best"])).abs() < 1e-6 * gap.abs(), "{evidence} {runner_up}");
    let text = folder.text("o.toml");
    assert!(text.contains(&format!("bic_gain = {}", number(&evidence["bic_gain"]))), "{text}");
    assert!(text.contains("gap_of = \"recordings\"") && json["gap"]["of"] == "recordings");
    let page = folder.text("o.html");
    for figure in [number(&evidence["bic_gain"]), gap] {
        assert!(page.contains(&format!("{figure:.0}")) && shown.contains(&format!("{figure:.0}")), "{figure}");
    }
}

/// A throw seen in a picture of x and z: nothing is asked for along y.
#[test]
fn no_throw_is_asked_for_along_an_axis_that_is_not_measured() {
    let folder = Folder::new();
    folder.write("scene.toml", "kind = \"ball\"\nball.radius_m = 0.02\n");
    let text = in_the_wind(1.2, [0.5, 0.0], 3);
    let rows = text.lines().map(|line| {
        let cells: Vec<&str> = line.split(',').collect();
        format!("{},{},{}\n", cells[0], cells[1], cells[3])
    });
    folder.write("a.csv", rows.collect::<String>());
    let json = folder.run("diagnose --sim scene.toml --observation a.csv --json").ends(3).json();
    assert_eq!(json["verdict"], "one_of", "{json:#}");
    let next = &json["next_experiment"];
    assert!(next["settings"]["release.velocity_y"].as_f64().is_none_or(|v| v == 0.0), "{next}");
    assert!(next["text"].as_str().is_some_and(|text| !text.contains("along y")), "{next}");
}

/// What `tune` warns of, `diagnose` warns of.
#[test]
fn warnings_are_those_of_tune() {
    let folder = with_throws();
    let text = folder.text("1.csv");
    let gap: Vec<&str> = text.lines().enumerate().filter(|(i, _)| !(60..72).contains(i)).map(|(_, l)| l).collect();
    folder.write("1.csv", gap.join("\n"));
    let warned = |command: &str| -> Vec<String> {
        let json = folder.run(&format!("{command} --sim scene.toml --observation 1.csv --json")).json();
        codes(&json).into_iter().filter(|code| code.starts_with("clock.")).map(str::to_owned).collect()
    };
    let tuned = warned("tune");
    assert!(tuned.contains(&"clock.gaps".into()), "{tuned:?}");
    assert_eq!(warned("diagnose"), tuned);
}

/// A light ball that falls from rest through air, z = h − ln cosh(√(g c) t) / c, in a picture that shows x and z.
#[test]
fn an_axis_that_was_not_measured_carries_no_effect() {
    let (c, mut noise) = (0.9, Noise(5));
    let row = |i: i32| {
        let t = f64::from(i) / 40.0;
        let z = 1.5 - ((9.81f64 * c).sqrt() * t).cosh().ln() / c;
        format!("{t},{},{}\n", 0.0035 * noise.normal(), z + 0.0035 * noise.normal())
    };
    let folder = Folder::new();
    folder.write("fall.csv", format!("t_s,x_m,z_m\n{}", (0..24).map(row).collect::<String>()));
    folder.write("ball.toml", "kind = \"ball\"\nball.radius_m = 0.0155\nball.mass_kg = 0.0004\n");
    // Spin along a start velocity that nobody saw would explain the fall as well, and viscous drag nearly so.
    let json = folder.run("diagnose --sim ball.toml --observation fall.csv --json").ends(0).json();
    assert_eq!(json["verdict"], "named", "{json:#}");
    assert_eq!(json["effects"][0]["name"], "quadratic_drag", "{json:#}");
    assert!((json["effects"][0]["coefficients"]["c_1_m"]["value"].as_f64().unwrap() - c).abs() < 0.1, "{json:#}");
    // The nearest is far enough behind that nothing needs to be said of it.
    assert_eq!(json["effects"][0]["evidence"]["runner_up"], "linear_drag", "{json:#}");
    // In something that may be syrup, both are left.
    let other =
        folder.run("diagnose --sim ball.toml --set world.medium=other --observation fall.csv --json").ends(3).json();
    let left: Vec<&str> = list(&other, "candidates").iter().filter_map(Value::as_str).collect();
    assert!(left.contains(&"quadratic_drag") && left.contains(&"linear_drag"), "{other:#}");
}

#[test]
fn a_wrong_coefficient_in_the_file_is_tuned_anew() {
    let folder = with_throws();
    folder.write("wrong.toml", format!("{SCENE}\n[effects.quadratic_drag]\nc_1_m = 0.05 # a guess\n"));
    let line = "diagnose --sim wrong.toml --observation 1.csv 2.csv 3.csv --held-out 5.csv --out o.toml --json";
    let json = folder.run(line).ends(0).json();
    assert_eq!(json["verdict"], "none", "{json:#}");
    let tuned =
        list(&json, "parameters").iter().find(|p| p["name"] == "quadratic_drag.c_1_m").expect("the coefficient");
    assert!((tuned["value"].as_f64().unwrap() - 0.1317).abs() < 0.01 && tuned["given"] == 0.05, "{tuned}");
    let text = folder.text("o.toml");
    assert!(text.contains("c_1_m = 0.13") && text.contains("# a guess"), "{text}");
}

/// A restitution that rises from bounce to bounce, in one list: no constant one explains it, whoever is asked.
#[test]
fn a_list_of_bounces_gets_one_answer_from_tuning_and_from_diagnosis() {
    let (mut time, mut interval, mut noise) = (0.0, 0.5, Noise(2));
    let mut rows = String::from("bounce_time_s\n");
    for k in 0..15 {
        writeln!(rows, "{}", time + 2e-4 * noise.normal()).expect("text");
        time += interval;
        interval *= 0.86 + 0.006 * f64::from(k);
    }
    let folder = Folder::new();
    folder.write("heard.csv", rows);
    folder.write("ball.toml", "kind = \"ball\"\nball.radius_m = 0.02\n");
    let tuned = folder.run("tune --sim ball.toml --observation heard.csv --json").ends(3).json();
    assert_eq!(tuned["verdict"], "poor_fit", "{tuned:#}");
    let json = folder.run("diagnose --sim ball.toml --observation heard.csv --json").ends(3).json();
    assert!(["unknown", "one_of"].contains(&json["verdict"].as_str().unwrap()), "{json:#}");
}

#[test]
fn a_rejected_recording_is_said_before_anything_is_tuned() {
    let folder = with_throws();
    let frames = Drop::default().frames();
    folder.write("mm.csv", table(&frames.iter().map(|(t, x)| (*t, x.map(|v| v * 1000.0))).collect::<Vec<_>>()));
    let ran = folder.run("diagnose --sim scene.toml --observation 1.csv 2.csv 3.csv mm.csv");
    assert!(ran.stderr.contains("not used: mm.csv"), "{}", ran.stderr);
    assert!(ran.stdout.starts_with("tuned ") && !ran.stdout.contains("not used"), "{}", ran.stdout);
}
