//! Recordings of joints that are not what they seem.

use super::{commands, folder};
use crate::common::codes;

fn seen(of: impl Fn(f64) -> (f64, f64)) -> String {
    let rows = (0..400).map(|i| f64::from(i) / 100.0).map(|t| (t, of(t)));
    let rows = rows.map(|(t, (goal, q))| format!("{t},{goal},{q}\n"));
    std::iter::once("t_s,hinge_goal_rad,hinge_rad\n".to_owned()).chain(rows).collect()
}

/// On the grid of an encoder.
fn encoded(q: f64) -> f64 {
    (q / 0.0015).round() * 0.0015
}

fn goal(t: f64) -> f64 {
    0.8 * (2.0 * t).sin() + 0.3 * (5.0 * t).sin()
}

/// Commands that jump every half second.
fn jumping(t: f64) -> f64 {
    if (2.0 * t).floor() % 2.0 == 0.0 { 0.1 } else { 0.62 }
}

/// What tuning says of a recording.
fn said(text: String) -> Vec<String> {
    let folder = folder();
    folder.write("seen.csv", text);
    let answer = folder.run("tune --sim robot.toml seen.csv --json").json();
    codes(&answer).into_iter().map(str::to_owned).collect()
}

#[test]
fn what_is_odd_in_a_recording_is_named() {
    let late = |t: f64| encoded(0.95 * goal(t - 0.05));
    let all = [
        ("robot.units", seen(|t| (57.3 * 4.0 * goal(t), 4.0 * late(t)))),
        ("robot.steps", seen(|t| (0.9 * (goal(t + 0.01) - goal(t)), late(t)))),
        ("robot.leader", seen(|t| (encoded(goal(t)), encoded(goal(t))))),
        ("robot.leader", seen(|t| (jumping(t), encoded(jumping(t))))),
        ("robot.still", seen(|t| (goal(t), encoded(0.0 * t)))),
        ("robot.clock", seen(|t| (goal(t), encoded(0.95 * goal(t - 1.0))))),
        ("robot.jumps", seen(|t| (goal(t), if (t - 2.0).abs() < 1e-9 { 4.0 } else { late(t) }))),
        ("robot.one_setup", seen(|t| (goal(t), late(t)))),
    ];
    for (code, text) in all {
        let said = said(text);
        assert!(said.iter().any(|known| known == code), "{code}: {said:?}");
    }
}

#[test]
fn a_joint_or_a_number_that_the_file_lacks_is_refused_with_its_place() {
    let folder = folder();
    folder.write("seen.csv", commands(goal));
    let text = folder.text("robot.toml");
    for (from, to, wanted) in [
        ("[joints.hinge]", "[joints.elbow]", "hinge__stall_torque"),
        ("drive = \"position\"", "drive = \"servo\"", "\"position\" or \"velocity\""),
        ("command = \"hinge_goal_rad\"", "command = \"goal\"", "an input of the file"),
        ("gain_1_rad = 0.166", "n_v = 3.0", "no `n_v` for a position drive"),
        ("[parameters.hinge__zero]", "[parameters.hinge__offset]", "stall_torque, back_emf"),
        ("link = \"pendulum\"", "link = \"rod\"", "expected a link of the model"),
    ] {
        assert!(text.contains(from), "{from}");
        folder.write("wrong.toml", text.replace(from, to));
        let ran = folder.run("simulate --sim wrong.toml --inputs seen.csv --out s.csv");
        assert!(ran.stderr.contains(wanted), "{to}: {}", ran.stderr);
    }
}

#[test]
fn a_start_that_cannot_be_read_is_refused_instead_of_taken_for_0() {
    let folder = folder();
    let text = seen(|t| (goal(t), 0.3 + goal(t)));
    let broken = |(i, line): (usize, &str)| if i == 2 { format!("{line}x\n") } else { format!("{line}\n") };
    folder.write("seen.csv", text.lines().enumerate().map(broken).collect::<String>());
    let ran = folder.run("simulate --sim robot.toml --inputs seen.csv --out s.csv").ends(1);
    assert!(ran.stderr.contains("`hinge_rad`: expected a number"), "{}", ran.stderr);
    folder.write("seen.csv", text.replace("hinge_rad", "hinge_v"));
    let ran = folder.run("simulate --sim robot.toml --inputs seen.csv --out s.csv").ends(1);
    assert!(ran.stderr.contains("expected `hinge_rad` in rad, found the column in V"), "{}", ran.stderr);
    // Without positions, joints start at 0.
    folder.write("seen.csv", commands(goal));
    folder.run("simulate --sim robot.toml --inputs seen.csv --out s.csv").ends(0);
}
