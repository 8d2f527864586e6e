//! Programs with recorded inputs, initial states and candidate effects: protocol 2, and what is wrong with either.

use std::fmt::Write as _;

use crate::common::{Folder, Noise, codes};
use crate::process::programs::{DRIVEN, DRIVEN_SCENE, MUJOCO_CART, MUJOCO_CART_SCENE, python};

/// The driven pendulum by the classical Runge–Kutta method, which its program does not use.
pub struct Driven {
    pub length_m: f64,
    pub damping_1_s: f64,
    pub friction_rad_s2: f64,
    pub start_rad: f64,
    pub seed: u64,
}

const RATE_HZ: f64 = 72.0;
const SAMPLES: usize = 216;
const MASS_KG: f64 = 0.5;

impl Driven {
    fn torque(&self, i: usize) -> f64 {
        let t = i as f64 / RATE_HZ;
        let (a, b) = (3.0 + self.seed as f64, 5.0 + 0.7 * self.seed as f64);
        0.4 * (a * t).sin() + 0.3 * (b * t + 1.0).sin()
    }

    fn slope(&self, [angle, rate]: [f64; 2], torque: f64) -> [f64; 2] {
        let free = torque / (MASS_KG * self.length_m * self.length_m)
            - 9.81 / self.length_m * angle.sin()
            - self.damping_1_s * rate;
        [rate, free - self.friction_rad_s2 * (rate / 1e-4).tanh()]
    }

    /// Columns `t_s`, `angle_rad` and the torque under this name.
    pub fn csv(&self, header: &str) -> String {
        const STEPS: u32 = 400;
        let mut noise = Noise(self.seed);
        let mut text = format!("{header}\n");
        let mut state = [self.start_rad, 0.0];
        for i in 0..SAMPLES {
            let t = i as f64 / RATE_HZ;
            writeln!(text, "{t},{},{}", state[0] + 2e-3 * noise.normal(), self.torque(i)).unwrap();
            let h = 1.0 / RATE_HZ / f64::from(STEPS);
            for _ in 0..STEPS {
                let at = |s: [f64; 2], k: [f64; 2], f: f64| [s[0] + f * k[0], s[1] + f * k[1]];
                let torque = self.torque(i);
                let k1 = self.slope(state, torque);
                let k2 = self.slope(at(state, k1, h / 2.0), torque);
                let k3 = self.slope(at(state, k2, h / 2.0), torque);
                let k4 = self.slope(at(state, k3, h), torque);
                for j in 0..2 {
                    state[j] += h / 6.0 * (k1[j] + 2.0 * k2[j] + 2.0 * k3[j] + k4[j]);
                }
            }
        }
        text
    }
}

const HEADER: &str = "t_s,angle_rad,torque_nm";

/// Four recordings with torques and starts of their own, and the manifest that holds the last one out.
fn recorded(friction_rad_s2: f64) -> Folder {
    let folder = Folder::new();
    folder.write("driven_pendulum.py", DRIVEN);
    folder.write("scene.toml", DRIVEN_SCENE);
    let mut manifest = String::new();
    for (seed, start_rad) in [(1, 0.5), (2, -0.4), (3, 0.2), (4, 0.8)] {
        let one = Driven { length_m: 0.62, damping_1_s: 0.24, friction_rad_s2, start_rad, seed };
        folder.write(&format!("rec{seed}.csv"), one.csv(HEADER));
        writeln!(manifest, "[[observation]]\nfile = \"rec{seed}.csv\"\nstart.angle_rad = {start_rad}").unwrap();
        writeln!(manifest, "held_out = {}\n", seed == 4).unwrap();
    }
    folder.write("runs.toml", manifest);
    folder
}

#[test]
fn a_driven_program_is_tuned_and_its_missing_effect_is_named_and_written() {
    if !python("json") {
        return;
    }
    let folder = recorded(0.35);
    let poor = folder.run("tune --sim scene.toml --allow-process --manifest runs.toml --json").ends(3).json();
    assert_eq!(poor["verdict"], "poor_fit");
    let line = "diagnose --sim scene.toml --allow-process --manifest runs.toml --out improved.toml --json";
    let json = folder.run(line).ends(0).json();
    assert_eq!((json["verdict"].as_str(), json["effects"][0]["name"].as_str()), (Some("named"), Some("dry_friction")));
    let found = json["effects"][0]["coefficients"]["rad_s2"]["value"].as_f64().unwrap();
    assert!((found - 0.35).abs() < 0.02, "{found}");
    let improved = folder.text("improved.toml");
    for wanted in ["[effects.dry_friction]\nrad_s2 = 0.3", "[candidates.dry_friction]", "[provenance"] {
        assert!(improved.contains(wanted), "no {wanted} in:\n{improved}");
    }
    // What was named is there: tuning with it leaves noise, and nothing is missing any more.
    let tuned = folder.run("tune --sim improved.toml --allow-process --manifest runs.toml --json").ends(0).json();
    assert_eq!(tuned["verdict"], "tuned", "{tuned:#}");
    let length = tuned["parameters"]["length"]["value"].as_f64().unwrap();
    assert!((length - 0.62).abs() < 2e-3, "{length}");
    let free =
        "tune --sim improved.toml --set effects.dry_friction.tune=true --allow-process --manifest runs.toml --json";
    let free = folder.run(free).ends(0).json();
    let again = free["parameters"]["dry_friction.rad_s2"]["value"].as_f64().unwrap();
    assert!((again - found).abs() < 1e-2, "{again}");
    let none = folder.run("diagnose --sim improved.toml --allow-process --manifest runs.toml --json").ends(0).json();
    assert_eq!(none["verdict"], "none");
}

/// What drove a recording is drawn below its channels, on the same axis.
#[test]
fn reports_draw_the_inputs_of_a_recording() {
    if !python("json") {
        return;
    }
    let folder = recorded(0.0);
    let command = |line: &str| format!("{line} --sim scene.toml --allow-process --report page.html");
    folder.run(&command("tune rec1.csv --quick")).ends(0);
    let page = folder.text("page.html");
    // Once for wide pages and once for narrow ones.
    assert_eq!(page.matches(">torque, N\u{b7}m</text>").count(), 2);
    assert!(page.contains("with residuals and inputs below") && page.contains("in steps where a value holds"));
    assert!(page.len() < 100_000, "{} bytes", page.len());
    folder.run(&command("diagnose --manifest runs.toml")).ends(0);
    let page = folder.text("page.html");
    assert_eq!(page.matches(">torque, N\u{b7}m</text>").count(), 4);
    assert!(page.contains("with inputs below") && page.contains("in steps where a value holds"));
    // A log of the input at 100 kHz makes no long page.
    let mut log = String::from("t_s,torque_nm\n");
    (0..300_000).for_each(|i| writeln!(log, "{},{}", f64::from(i) * 1e-5, i % 7).unwrap());
    folder.write("log.csv", log);
    folder.run(&command("tune rec1.csv --quick --set inputs.torque_nm.file=log.csv --force"));
    let page = folder.text("page.html");
    assert!(page.contains("at most 600 samples") && page.len() < 150_000, "{} bytes", page.len());
}

#[test]
fn what_is_simulated_with_inputs_can_be_tuned_to() {
    if !python("json") {
        return;
    }
    let folder = recorded(0.0);
    let simulate = "simulate --sim scene.toml --allow-process --set parameters.length.value=0.7";
    folder.run(&format!("{simulate} --inputs rec2.csv --out again.csv")).ends(0);
    assert!(folder.text("again.csv").starts_with("t_s,angle_rad,torque_nm\n0.0,0.5,"), "{}", folder.text("again.csv"));
    let json = folder.run("tune --sim scene.toml --allow-process again.csv --json").ends(0).json();
    assert!((json["parameters"]["length"]["value"].as_f64().unwrap() - 0.7).abs() < 1e-5, "{json}");
    folder.run(&format!("{simulate} --manifest runs.toml --out all")).ends(0);
    assert!(folder.text("all/rec2.csv").contains("\n0.0,-0.4,"));
    // Without a recording the default drives it; without a default nothing does.
    folder.run(&format!("{simulate} --out free.csv")).ends(0);
    folder.write("scene.toml", DRIVEN_SCENE.replace("default = 0.0", ""));
    crate::common::refused(
        &folder,
        &format!("{simulate} --out bare.csv"),
        &["`torque_nm`, found none", "--inputs FILE"],
    );
    let few = "--set record.frames=40 --set record.rate_hz=20 --pairs 12";
    for given in ["--inputs rec1.csv", "--manifest runs.toml"] {
        let line = format!("gen process --sim scene.toml --allow-process {few} {given} --out pairs.mcap --overwrite");
        folder.run(&line).ends(0);
    }
}

#[test]
fn inspect_tells_channels_inputs_and_starts_apart() {
    let folder = recorded(0.0);
    let json = folder.run("inspect rec1.csv --sim scene.toml --json").ends(0).json();
    assert_eq!(json["columns"][2]["read_as"], "torque_nm");
    assert_eq!(
        (json["channels"][0].as_str(), json["inputs"][0]["name"].as_str()),
        (Some("angle_rad"), Some("torque_nm"))
    );
    assert_eq!(
        (json["starts"][0]["value"].as_f64(), json["candidates"][0].as_str()),
        (Some(0.5), Some("dry_friction"))
    );
    let text = folder.run("inspect --sim scene.toml --manifest runs.toml").ends(0).stdout;
    for wanted in ["predicts", "torque_nm (default 0)", "angle_rad = -0.4, estimated with prior ±0.05"] {
        assert!(text.contains(wanted), "no `{wanted}` in:\n{text}");
    }
    folder.write("scene.toml", DRIVEN_SCENE.replace("default = 0.0", ""));
    folder.write("rec1.csv", folder.text("rec1.csv").replace("torque_nm", "current_a"));
    let ran = folder.run("inspect rec1.csv --sim scene.toml").ends(1);
    assert!(ran.stdout.contains("expected a column `torque_nm`"), "{}", ran.stdout);
}

#[test]
fn a_program_in_mujoco_is_driven() {
    if !python("mujoco") {
        return;
    }
    let folder = Folder::new();
    folder.write("mujoco_cart.py", MUJOCO_CART);
    folder.write("scene.toml", MUJOCO_CART_SCENE);
    // m x'' = F - d x' with a force of F0 sin(w t) held from sample to sample: the closed solution of each step.
    let (mass, damping, mut noise) = (1.7_f64, 2.3_f64, Noise(5));
    let (mut x, mut v, mut text) = (0.1_f64, 0.0_f64, String::from("t_s,x_m,force_n\n"));
    for i in 0..150 {
        let t = f64::from(i) / 50.0;
        let force = 5.0 * (4.0 * t).sin() + 2.0 * (9.0 * t).cos();
        writeln!(text, "{t},{},{force}", x + 1e-3 * noise.normal()).unwrap();
        let (end, decay) = (force / damping, (-damping / mass / 50.0).exp());
        x += end / 50.0 + (v - end) * mass / damping * (1.0 - decay);
        v = end + (v - end) * decay;
    }
    folder.write("cart.csv", text);
    let json = folder.run("tune --sim scene.toml --allow-process cart.csv --json").ends(0).json();
    assert_eq!(json["verdict"], "tuned", "{json:#}");
    for (name, truth) in [("mass", mass), ("damping", damping)] {
        let found = json["parameters"][name]["value"].as_f64().unwrap();
        assert!((found / truth - 1.0).abs() < 0.01, "{name}: {found}");
    }
}

/// Channels of different units have no common distance: each has a gap of its own.
#[test]
fn the_gap_of_each_channel_is_in_its_unit() {
    if !python("json") {
        return;
    }
    let folder = Folder::new();
    let program = r#"import json, sys
for line in sys.stdin:
    asked = json.loads(line)
    if "tunenet" in asked:
        print(json.dumps({"tunenet": 1}), flush=True)
        continue
    k = asked["parameters"]["rate"]
    print(json.dumps({"id": asked["id"], "values": [[k * t, 0.1 * k * t] for t in asked["times_s"]]}), flush=True)
"#;
    folder.write("ramp.py", program);
    folder.write(
        "scene.toml",
        "kind = \"process\"\nprocess.command = [\"python3\", \"ramp.py\"]\nprocess.channels = [\"x_m\", \"q_rad\"]\n\
         parameters.rate = { value = 1.0, min = 0.1, max = 5.0, unit = \"m/s\" }\n",
    );
    let (mut noise, mut text) = (Noise(3), String::from("t_s,x_m,q_rad\n"));
    for i in 0..200 {
        let t = f64::from(i) * 0.01;
        let (x, q) = (2.0 * t + 0.01 * noise.normal(), 0.2 * t + 0.001 * noise.normal());
        writeln!(text, "{t},{x},{q}").unwrap();
    }
    folder.write("a.csv", &text);
    let shown = folder.run("tune --sim scene.toml --allow-process a.csv --report page.html").ends(0).stdout;
    let row =
        |name: &str| shown.lines().find(|line| line.trim_start().starts_with(name)).unwrap_or_default().to_owned();
    assert!(row("x ").ends_with("mm") && row("q ").ends_with("rad"), "{shown}");
    assert!(folder.text("page.html").contains("<th scope=\"row\">q</th>"));
    let json = folder.run("tune --sim scene.toml --allow-process a.csv --json").ends(0).json();
    let gap = |i: usize, key: &str| json["gaps"][i][key].as_f64().unwrap();
    assert_eq!((json["gaps"][0]["unit"].as_str(), json["gaps"][1]["unit"].as_str()), (Some("m"), Some("rad")));
    assert!((gap(0, "after") / 0.01 - 1.0).abs() < 0.15 && (gap(1, "after") / 0.001 - 1.0).abs() < 0.15, "{json:#}");
    assert!(gap(0, "before") > 0.5, "{json:#}");
}

/// Each of these is one sentence with a hint.
#[test]
fn what_is_wrong_with_inputs_and_starts_is_said_in_one_sentence() {
    if !python("json") {
        return;
    }
    let folder = recorded(0.0);
    folder.write("scene.toml", DRIVEN_SCENE.replace("default = 0.0", ""));
    let tune = "tune --sim scene.toml --allow-process --manifest runs.toml";
    let third = folder.text("rec3.csv");
    folder.write("rec3.csv", third.replace("torque_nm", "current_a"));
    crate::common::refused(
        &folder,
        tune,
        &["rec3.csv:1", "expected a column `torque_nm`", "an input of the simulation"],
    );
    folder.write("rec3.csv", third.replace("torque_nm", "torque_mnm"));
    crate::common::refused(&folder, tune, &["rec3.csv:1", "expected `torque_nm` in N·m, found the column in mnm"]);
    folder.write("rec3.csv", &third);
    let set = |key: &str| format!("{tune} --set {key}");
    folder.write("late.csv", "t_s,torque_nm\n10,1\n11,1\n12,1\n");
    let late = set("inputs.torque_nm.file=late.csv");
    crate::common::refused(&folder, &late, &["that overlaps the recording", "from 10 to 12 s"]);
    folder.write("short.csv", "t_s,torque_nm\n0.5,0\n1,0\n2,0\n");
    let short = folder.run(&format!("{} --json", set("inputs.torque_nm.file=short.csv")));
    let json = short.json();
    let codes = codes(&json);
    assert!(codes.contains(&"inputs.short") && codes.contains(&"inputs.late"), "{codes:?}");

    // A program that knows protocol 1 alone, and one that refuses a state.
    let old = "import json, sys\nfor line in sys.stdin:\n    print(json.dumps({'tunenet': 1}), flush=True)\n";
    folder.write("driven_pendulum.py", old);
    let needs = "protocol 2 for the input `torque_nm` and state `angle_rad` and candidate `dry_friction`, found `{\"tunenet\":1}`";
    crate::common::refused(&folder, tune, &[needs, "docs/process.md"]);
    let strict = "import json, sys\nfor line in sys.stdin:\n    print(json.dumps({'error': 'no state angle_rad'}), flush=True)\n";
    folder.write("driven_pendulum.py", strict);
    crate::common::refused(&folder, tune, &["state `angle_rad`", "the error “no state angle_rad”"]);
}

/// What every copy of a program reads: each recording once, then rollouts of it, many in a line where they wait.
#[test]
fn a_recording_is_announced_once_to_every_copy_and_equal_requests_are_asked_once() {
    if !python("json") {
        return;
    }
    let folder = recorded(0.0);
    let noted = DRIVEN.replace(
        "    asked = json.loads(line)\n",
        "    asked = json.loads(line)\n    open(f'log{os.getpid()}', 'a').write(line)\n",
    );
    folder.write("driven_pendulum.py", noted.replace("import sys\n", "import os\nimport sys\n"));
    let line = "tune --sim scene.toml --set process.workers=1 --allow-process --manifest runs.toml --json";
    let mut command = folder.command();
    command.env("RAYON_NUM_THREADS", "4").args(line.split_whitespace());
    let json = crate::common::Ran::from(command.output().unwrap()).ends(0).json();
    let logs: Vec<String> = folder.names().into_iter().filter(|name| name.starts_with("log")).collect();
    assert_eq!(logs.len(), 1);
    let text = folder.text(&logs[0]);
    let lines: Vec<serde_json::Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!((lines[0]["tunenet"].as_u64(), lines[0]["states"][0].as_str()), (Some(2), Some("angle_rad")));
    assert_eq!(lines[0]["inputs"], serde_json::json!([{ "name": "torque_nm", "unit": "N·m", "hold": "previous" }]));
    let announced = lines.iter().filter(|line| line.get("inputs").is_some() && line.get("id").is_some()).count();
    assert_eq!(announced, 3);
    let batches: Vec<&serde_json::Value> = lines.iter().filter_map(|line| line.get("batch")).collect();
    assert!(!batches.is_empty());
    let single = lines.iter().filter(|line| line.get("times_s").is_some());
    let mut asked: Vec<String> = single
        .map(|one| {
            let mut one = one.clone();
            one.as_object_mut().unwrap().shift_remove("id");
            one.to_string()
        })
        .chain(batches.iter().flat_map(|batch| batch.as_array().unwrap()).map(ToString::to_string))
        .collect();
    let all = asked.len() as u64;
    asked.sort();
    asked.dedup();
    // What is asked again only holds the program against itself, and is counted apart.
    let rollouts = json["rollouts"].as_u64().unwrap();
    assert_eq!(asked.len() as u64, rollouts);
    assert_eq!(json["re_asks"].as_u64(), Some(all - rollouts));
    assert!(all > rollouts && all < rollouts + rollouts / 10, "{all} of {rollouts}");
    let shown = folder.run(&line.replace(" --json", "")).ends(0);
    assert!(shown.stderr.contains(&format!("{rollouts} rollouts, {} re-asked, ", all - rollouts)), "{}", shown.stderr);
    let json = folder.run("diagnose --sim scene.toml --allow-process --manifest runs.toml --json").json();
    assert!(json["re_asks"].as_u64().is_some_and(|count| count > 0), "{json}");
}

/// A copy keeps 128 recordings: it is asked to forget one before it gets another, and gets a forgotten one anew.
#[test]
fn a_program_forgets_recordings_beyond_128_and_gets_them_anew() {
    const KEPT: usize = 128;
    if !python("json") {
        return;
    }
    let folder = Folder::new();
    let noted = DRIVEN
        .replace("    asked = json.loads(line)\n", "    asked = json.loads(line)\n    open('log', 'a').write(line)\n");
    folder.write("driven_pendulum.py", noted);
    folder.write("scene.toml", DRIVEN_SCENE.replace("[process]\n", "[process]\nworkers = 1\n"));
    let mut manifest = String::new();
    for number in 0..=KEPT {
        let rows = format!("0,0,{number}\n0.01,0,0\n0.02,0,0\n");
        folder.write(&format!("rec{number}.csv"), format!("{HEADER}\n{rows}"));
        writeln!(manifest, "[[observation]]\nfile = \"rec{number}.csv\"").unwrap();
    }
    folder.write("runs.toml", manifest);
    // Pairs go through all recordings and begin again with the first one, several times: on any number of threads some recordings that
    // were forgotten come again.
    folder.run("gen process --sim scene.toml --allow-process --manifest runs.toml --pairs 520 --out a.mcap").ends(0);
    let (mut known, mut forgotten, mut anew) = (Vec::new(), Vec::new(), 0);
    for line in folder.text("log").lines().skip(1) {
        let line: serde_json::Value = serde_json::from_str(line).unwrap();
        if let Some(number) = line["forget"].as_u64() {
            known.retain(|other| *other != number);
            forgotten.push(number);
        } else if line.get("inputs").is_some() {
            let number = line["recording"].as_u64().unwrap();
            anew += usize::from(forgotten.contains(&number));
            known.push(number);
            assert!(known.len() <= KEPT, "{}", known.len());
        } else {
            let asked = line["batch"].as_array().map_or_else(|| vec![&line], |batch| batch.iter().collect());
            assert!(asked.iter().all(|one| known.contains(&one["recording"].as_u64().unwrap())), "{line}");
        }
    }
    assert!(known.len() == KEPT && forgotten.len() > 1 && anew > 0, "{anew} of {forgotten:?}");
}

/// A candidate that changes nothing is said to, and is not fitted; two that are the same are reported together.
#[test]
fn a_candidate_without_influence_is_said_and_twins_are_named_together() {
    if !python("json") {
        return;
    }
    let folder = recorded(0.35);
    let twin = |name: &str| {
        let of = DRIVEN_SCENE.split("[candidates.dry_friction]").nth(1).unwrap();
        format!("\n[candidates.{name}]{}", of.replace("candidates.dry_friction", &format!("candidates.{name}")))
    };
    folder.write("scene.toml", format!("{DRIVEN_SCENE}{}{}", twin("rubbing"), twin("nothing")));
    let both = DRIVEN.replace(
        "asked[\"effects\"][\"dry_friction\"][\"rad_s2\"]",
        "sum(asked[\"effects\"][name][\"rad_s2\"] for name in (\"dry_friction\", \"rubbing\"))",
    );
    assert_ne!(both, DRIVEN);
    folder.write("driven_pendulum.py", both);
    let json = folder.run("diagnose --sim scene.toml --allow-process --manifest runs.toml --json").ends(3).json();
    assert_eq!(json["verdict"], "one_of");
    let mut names: Vec<&str> =
        json["candidates"].as_array().unwrap().iter().map(|name| name.as_str().unwrap()).collect();
    names.sort_unstable();
    assert_eq!(names, ["dry_friction", "rubbing"]);
    let scores = json["scores"].as_array().unwrap();
    let nothing = scores.iter().find(|score| score["name"] == "nothing").unwrap();
    assert!(nothing["excluded"].as_str().is_some_and(|why| !why.is_empty()), "{nothing}");
}
