//! Orbits of several turns about a centre, whose initial velocities are unknown: their late motion has many local minima.

use std::fmt::Write as _;

use crate::common::{Folder, Noise};

const FILE: &str = "kind = \"equations\"\nstates.x_m = {}\nstates.y_m = {}\nstates.vx_m_s = {}\nstates.vy_m_s = {}\n\
outputs.x_m = \"x_m\"\noutputs.y_m = \"y_m\"\n\
start.x_m = { value = \"first\", sd = 0.3 }\nstart.y_m = { value = \"first\", sd = 0.3 }\n\
start.vx_m_s = { value = 0.0, sd = 5.0 }\nstart.vy_m_s = { value = 0.0, sd = 5.0 }\n\
derivatives.x_m = \"vx_m_s\"\nderivatives.y_m = \"vy_m_s\"\n\
derivatives.vx_m_s = \"-mu*x_m/(x_m^2 + y_m^2)^1.5\"\nderivatives.vy_m_s = \"-mu*y_m/(x_m^2 + y_m^2)^1.5\"\n\
parameters.mu = { value = 4.0, min = 1.0, max = 20.0, unit = \"m^3/s^2\" }\n";

const DRAG: &str = "candidates.drag.sentence = \"drag\"\ncandidates.drag.acts = \"flow\"\n\
candidates.drag.adds.vx_m_s = \"-c*sqrt(vx_m_s^2 + vy_m_s^2)*vx_m_s\"\n\
candidates.drag.adds.vy_m_s = \"-c*sqrt(vx_m_s^2 + vy_m_s^2)*vy_m_s\"\n\
candidates.drag.coefficients.c = { unit = \"1/m\", min = 0.0, max = 1.0, typical = 0.02 }\n";

type State = [f64; 4];

fn slope([x, y, vx, vy]: State, mu: f64, drag: f64) -> State {
    let (attraction, speed) = (mu * x.hypot(y).powi(-3), drag * vx.hypot(vy));
    [vx, vy, -attraction * x - speed * vx, -attraction * y - speed * vy]
}

/// 7 s at 20 Hz with noise of 10 mm, by classical Runge-Kutta steps of 0.5 ms.
fn orbit(number: u64, mut state: State, mu: f64, drag: f64) -> String {
    const STEP_S: f64 = 5e-4;
    let mut noise = Noise(number);
    let mut text = String::from("t_s,x_m,y_m\n");
    let moved = |state: State, by: f64, slope: State| -> State { std::array::from_fn(|i| state[i] + by * slope[i]) };
    for i in 0..140 {
        let mut seen = |value: f64| value + 0.01 * noise.normal();
        let (x, y) = (seen(state[0]), seen(state[1]));
        writeln!(text, "{:.2},{x:.7},{y:.7}", f64::from(i) * 0.05).unwrap();
        for _ in 0..100 {
            let first = slope(state, mu, drag);
            let second = slope(moved(state, 0.5 * STEP_S, first), mu, drag);
            let third = slope(moved(state, 0.5 * STEP_S, second), mu, drag);
            let last = slope(moved(state, STEP_S, third), mu, drag);
            state = std::array::from_fn(|i| {
                state[i] + STEP_S / 6.0 * (first[i] + 2.0 * second[i] + 2.0 * third[i] + last[i])
            });
        }
    }
    text
}

fn diagnosed(mu: f64, drag: f64, starts: [State; 3]) -> serde_json::Value {
    let folder = Folder::new();
    folder.write("orbit.toml", if drag > 0.0 { format!("{FILE}{DRAG}") } else { FILE.to_owned() });
    for (number, start) in (0..).zip(starts) {
        folder.write(&format!("{number}.csv"), orbit(number, start, mu, drag));
    }
    folder.run("diagnose --sim orbit.toml 0.csv 1.csv 2.csv --json").json()
}

#[test]
fn a_complete_model_of_several_turns_misses_nothing() {
    for (mu, starts) in [
        (3.71, [[1.15, 0.0, 0.0, 1.71], [0.0, 1.03, -1.58, 0.0], [0.0, -0.96, 1.74, 0.0]]),
        (4.63, [[0.0, -1.12, 1.59, 0.0], [0.85, 0.0, 0.0, 1.74], [0.0, 0.88, -1.84, 0.0]]),
        (3.9, [[-0.97, 0.0, 0.0, -2.19], [0.83, 0.0, 0.0, 1.95], [1.04, 0.0, 0.0, 1.99]]),
    ] {
        let json = diagnosed(mu, 0.0, starts);
        assert_eq!(json["verdict"], "none", "{json:#}");
        let found = json["parameters"][0]["value"].as_f64().unwrap();
        assert!((found - mu).abs() < 0.02, "{found} {mu}");
    }
}

#[test]
fn drag_of_several_turns_is_found_next_to_the_attraction() {
    let starts = [[1.15, 0.0, 0.0, 1.71], [0.0, 1.03, -1.58, 0.0], [0.0, -0.96, 1.74, 0.0]];
    let json = diagnosed(4.4, 0.04, starts);
    let effects = json["effects"].as_array().unwrap();
    assert!(effects.iter().any(|effect| effect["name"] == "drag"), "{json:#}");
    let found = json["parameters"][0]["value"].as_f64().unwrap();
    assert!((found - 4.4).abs() < 0.05, "{found}");
}
