//! A motor that acts late, declared as a candidate of equations: absent it adds nothing, and it is named, with late readings, where it was there.

use std::fmt::Write as _;

use crate::common::{Folder, Noise};

const FILE: &str = "kind = \"equations\"\n[states.x_m]\n[states.v_m_s]\n[derivatives]\nx_m = \"v_m_s\"\n\
v_m_s = \"(u_n - stiffness*x_m - damping*v_m_s)/mass_kg\"\n[outputs]\nx_m = \"x_m\"\n[constants]\nmass_kg = 1.0\n\
[inputs.u_n]\nhold = \"linear\"\n[start.x_m]\nvalue = \"first\"\nsd = 0.01\n[start.v_m_s]\nvalue = 0.0\n\
[parameters.stiffness]\nvalue = 10.0\nmin = 1.0\nmax = 100.0\nunit = \"N/m\"\n\
[parameters.damping]\nvalue = 0.5\nmin = 0.0\nmax = 5.0\nunit = \"N·s/m\"\n\
[candidates.quadratic]\nsentence = \"the slider drags the air\"\nacts = \"body\"\nadds.v_m_s = \"-c*v_m_s*abs(v_m_s)\"\n\
coefficients.c = { unit = \"1/m\", absent = 0.0, min = 0.0, max = 10.0, typical = 0.1 }\n\
[candidates.motor_delay]\nsentence = \"the motor acts late\"\nacts = \"actuator\"\n\
adds.v_m_s = \"(delay(u_n, late) - u_n)/mass_kg\"\n\
coefficients.late = { unit = \"s\", absent = 0.0, min = 0.0, max = 0.2, typical = 0.02 }\n";
const LATE_S: f64 = 0.04;

/// 4 s at 100 Hz from rest under a force that begins after 0.3 s, by the midpoint rule in short steps; noise of 1 mm.
fn run(number: u64) -> String {
    let mut noise = Noise(number);
    let rate = noise.between(3.0, 6.0);
    let force = |t: f64| if t < 0.3 { 0.0 } else { 4.0 * (rate * (t - 0.3)).sin() };
    let (mut x, mut v) = (0.0, 0.0);
    let mut text = String::from("t_s,u_n,x_m\n");
    let h = 1e-4;
    for i in 0..400 {
        let t = f64::from(i) * 0.01;
        writeln!(text, "{t},{},{:.6}", force(t), x + 0.001 * noise.normal()).unwrap();
        for k in 0..100 {
            let t = t + f64::from(k) * h;
            let a = |t: f64, x: f64, v: f64| force(t - LATE_S) - 20.0 * x - 0.8 * v;
            let (at, middle) = (x + 0.5 * h * v, v + 0.5 * h * a(t, x, v));
            let a = a(t + 0.5 * h, at, middle);
            x += h * (v + 0.5 * h * a);
            v += h * a;
        }
    }
    text
}

#[test]
fn a_late_motor_is_named_with_late_readings() {
    let folder = Folder::new();
    folder.write("slider.toml", FILE);
    for i in 0..4 {
        folder.write(&format!("{i}.csv"), run(i + 1));
    }
    let json = folder.run("diagnose --sim slider.toml 0.csv 1.csv 2.csv --held-out 3.csv --json").json();
    // From rest, late readings look the same.
    let effect = &json["effects"][0];
    let alternatives = effect["alternatives"].as_array().unwrap();
    let both = ["motor_delay", "time_offset"].map(|name| effect["name"] == name || alternatives.contains(&name.into()));
    assert_eq!((json["verdict"].as_str(), both), (Some("one_of"), [true; 2]), "{json:#}");
    assert_eq!(json["effects"].as_array().map(Vec::len), Some(1), "{json:#}");
}
