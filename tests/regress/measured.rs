//! Recordings of real things, where `TUNENET_MEASURED` names a folder that holds them.

use serde_json::Value;

use super::{answer, digest, each, line, of_each, pinned};
use crate::common::recorded::{
    FALLEN, fallen, fallen_entry, files, flights_diagnosed, flights_tuned, measured, metres, name,
    single_flights_diagnosed,
};
use crate::common::{Folder, ball};

const EACH: &str = "tune --sim scene.toml --each --observation";

#[test]
fn regress_table_tennis_flights_tuned() {
    let Some((flights, ran)) = flights_tuned() else { return };
    pinned::check("flights-tuned", &of_each(&ran.json(), &flights));
}

/// One flight in seventeen alone, then the first ones together.
#[test]
fn regress_table_tennis_flights_diagnosed() {
    let (Some(alone), Some(together)) = (single_flights_diagnosed(), flights_diagnosed(12)) else { return };
    let mut found: Vec<_> = alone.iter().map(|(flight, ran)| (name(flight), digest::answered(&ran.0))).collect();
    found.push(("together".into(), digest::answered(&together)));
    pinned::check("flights-diagnosed", &found);
}

#[test]
fn regress_bounces_heard() {
    let Some(from) = measured("bounce-acoustic") else { return };
    let mut found = each(&Folder::with_scene(), EACH, &files(&from, "", ".csv"));
    let here = Folder::new();
    here.write("ball.toml", ball(0.02, None));
    for start in ["pingpong_0", "blue"] {
        let words = "diagnose --sim ball.toml --observation";
        found.push((start.into(), answer(&here, &line(words, &files(&from, start, ".csv")))));
    }
    pinned::check("heard", &found);
}

#[test]
fn regress_cube_tosses_inspected() {
    let Some(from) = measured("cube-tosses") else { return };
    let all = files(&from, "toss_", ".csv");
    let inspected = answer(&Folder::new(), &line("inspect", &all));
    let files = inspected["files"].as_array().expect("one for each").clone();
    let mut found: Vec<(String, Value)> = all.iter().map(|path| name(path)).zip(files).collect();
    found.push(("together".into(), inspected["gravity"].clone()));
    pinned::check("cubes", &found);
}

#[test]
fn regress_three_balls() {
    let Some(from) = measured("three-balls") else { return };
    let here = Folder::new();
    let mut manifest = String::new();
    let mut found = Vec::new();
    for one in FALLEN {
        let (name, .., radius_m, mass_kg) = one;
        here.write(&format!("{name}.csv"), fallen(&from, one));
        here.write(&format!("{name}.toml"), ball(radius_m, Some(mass_kg)));
        manifest.push_str(&fallen_entry(one));
        let words = format!("diagnose --sim {name}.toml --observation {name}.csv");
        found.push((name.into(), answer(&here, &line(&words, &[]))));
    }
    here.write("m.toml", manifest);
    here.write("ball.toml", ball(0.02, None));
    found.push(("together".into(), answer(&here, &line("diagnose --sim ball.toml --manifest m.toml", &[]))));
    pinned::check("three-balls", &found);
}

#[test]
fn regress_pixels() {
    let (Some(throw), Some(serves)) = (measured("basketball-throw"), measured("pingpong-serve-px")) else {
        return;
    };
    let here = Folder::new();
    here.write("throw.csv", metres(&throw.join("OUTPUT.csv"), 60.0, 23.37 / 0.12, 1.0));
    here.write("basketball.toml", ball(0.747 / std::f64::consts::TAU, Some(0.5)));
    let mut launches = Vec::new();
    for file in files(&serves, "IMG", ".csv") {
        // From the mean apparent gravity of its README, 6200 px/s².
        launches.push(here.write(&name(&file), metres(&file, 240.0, 6200.0 / 9.81, -1.0)));
    }
    here.write("pingpong.toml", ball(0.02, Some(0.0027)));
    pinned::check(
        "pixels",
        &[
            ("throw inspected".into(), answer(&here, &line("inspect throw.csv", &[]))),
            ("throw".into(), answer(&here, &line("diagnose --sim basketball.toml --observation throw.csv", &[]))),
            ("serves".into(), answer(&here, &line("diagnose --sim pingpong.toml --observation", &launches))),
        ],
    );
}

/// A parameter of an arm.
fn free(name: &str, value: f64, min: f64, max: f64) -> String {
    format!("[parameters.{name}]\nvalue = {value:?}\nmin = {min:?}\nmax = {max:?}\n")
}

#[test]
fn regress_arm_with_a_payload() {
    let Some(data) = measured("ur10e-payload") else { return };
    let here = Folder::new();
    let centre: String = ["x", "y", "z"].map(|a| free(&format!("payload_com_{a}"), 0.0, -0.5, 0.5)).concat();
    let scene = |mass: &str, centre: &str, gain: &str| {
        format!(
            "kind = \"arm\"\n[arm]\nurdf = {:?}\npayload_link = \"tool0\"\n\
             current_gain_nm_a = [14.87, 13.26, 11.13, 10.62, 11.03, 11.47]\n[motion]\nkind = \"replay\"\n{mass}{centre}{gain}",
            data.join("ur10e.urdf"),
        )
    };
    let known = free("payload_mass", 2.805, 0.0, 20.0) + "tune = false\n";
    let gain = free("torque_gain", 1.0, 0.1, 10.0);
    here.write("ur10e.toml", scene(&known, &centre, &gain));
    let bare = free("payload_mass", 0.0, 0.0, 20.0) + "tune = false\n";
    here.write("bare.toml", scene(&bare, "", ""));
    let columns = "--columns t_s=1,q1..6_rad=2..7,i1..6_a=14..19";
    let run = |name: &str| data.join(format!("ur-20_02_19_{name}.csv"));
    let pair = |name: &str, words: &str| {
        let reference = run(&format!("{name}50sec")).display().to_string();
        let words = format!("tune {words} {columns} --reference {reference} --observation");
        answer(&here, &line(&words, &[run(&format!("{name}50secLoad"))]))
    };
    let calibrated = pair("14harm", "--sim ur10e.toml --out calibrated.toml");
    let other = "--set parameters.torque_gain.tune=false --set parameters.payload_mass.tune=true --skip-broken";
    let weighed = pair("15harm", &format!("--sim calibrated.toml {other}"));
    let words = format!("diagnose --sim bare.toml {columns} --observation");
    let diagnosed = answer(&here, &line(&words, &[run("14harm50sec")]));
    pinned::check(
        "payload",
        &[("calibrated".into(), calibrated), ("weighed".into(), weighed), ("diagnosed".into(), diagnosed)],
    );
}

#[test]
fn regress_pendulum() {
    let Some(data) = measured("pendulum-dfki") else { return };
    let here = Folder::new();
    let urdf = data.join("dfki_simple_pendulum.urdf");
    let scene =
        format!("kind = \"arm\"\n[arm]\nurdf = {urdf:?}\npayload_link = \"Link_1\"\n[motion]\nkind = \"replay\"\n");
    let mass = free("payload_mass", 0.0, 0.0, 5.0) + &free("payload_com_y", 0.5, -1.0, 1.0) + "tune = false\n";
    here.write("arm.toml", format!("{scene}{mass}"));
    let ask = |command: &str, run: &str| {
        let columns = "--columns t_s=time,q1_rad=position,dq1_rad_s=velocity,tau1_nm=torque";
        let words = format!("{command} --sim arm.toml {columns} --observation");
        let file = data.join(format!("control_method_{run}.csv"));
        (format!("{command} {run}"), answer(&here, &line(&words, &[file])))
    };
    let runs = [
        "ddp_data_measured",
        "energy_shaping_data_measured",
        "energy_shaping_data_measured_1kg",
        "gravity_compensation_data_measured",
        "ilqr_data_measured",
        "pd_system_identification_data_measured",
    ];
    let found: Vec<_> = runs.iter().flat_map(|run| [ask("tune", run), ask("diagnose", run)]).collect();
    pinned::check("pendulum", &found);
}
