//! Friction that grips: a ball whose slip ends within its first contact does not show how much more friction there is, nor whether a share
//! of the slip is taken instead.

use crate::common::{Folder, Noise};
use serde_json::Value;

const GRAVITY_M_S2: f64 = 9.81;
const RADIUS_M: f64 = 0.02;
const RESTITUTION: f64 = 0.75;
/// A solid sphere that does not spin leaves its first contact rolling, with so much of its speed along the surface.
const ROLLING: f64 = 5.0 / 7.0;
const NOISE_M: f64 = 0.004;

/// A throw at 100 Hz in closed form: parabolas from contact to contact.
fn throw(height_m: f64, [mut u, mut v]: [f64; 2], seed: u64) -> String {
    let mut noise = Noise(seed);
    let (mut begin_s, mut at, mut up_m_s, mut is_first) = (0.0, [0.0, 0.0, height_m], 0.0f64, true);
    let mut rows = vec!["t_s,x_m,y_m,z_m".to_owned()];
    for i in 0..160 {
        let t_s = f64::from(i) / 100.0;
        let falls_s = || {
            let drop_m = at[2] - RADIUS_M;
            (up_m_s + (up_m_s * up_m_s + 2.0 * GRAVITY_M_S2 * drop_m).sqrt()) / GRAVITY_M_S2
        };
        let lasts_s = falls_s();
        if t_s - begin_s > lasts_s {
            at = [at[0] + u * lasts_s, at[1] + v * lasts_s, RADIUS_M];
            up_m_s = RESTITUTION * (GRAVITY_M_S2 * lasts_s - up_m_s);
            begin_s += lasts_s;
            if is_first {
                (u, v, is_first) = (ROLLING * u, ROLLING * v, false);
            }
        }
        let dt_s = t_s - begin_s;
        let exact = [at[0] + u * dt_s, at[1] + v * dt_s, at[2] + up_m_s * dt_s - 0.5 * GRAVITY_M_S2 * dt_s * dt_s];
        let [x, y, z] = exact.map(|value| value + NOISE_M * noise.normal());
        rows.push(format!("{t_s},{x:.6},{y:.6},{z:.6}"));
    }
    rows.join("\n") + "\n"
}

#[test]
fn friction_that_grips_and_a_share_of_the_slip_stay_together() {
    for first in [1, 11, 21] {
        let folder = Folder::new();
        folder.write("ball.toml", "kind = \"ball\"\nball.radius_m = 0.02\n");
        for k in 0..4u64 {
            let (sin, cos) = (1.4 * k as f64).sin_cos();
            let speed_m_s = 0.5 + 0.15 * k as f64;
            let text = throw(0.8 + 0.1 * k as f64, [speed_m_s * cos, speed_m_s * sin], first + k);
            folder.write(&format!("{k}.csv"), text);
        }
        let line = "diagnose 0.csv 1.csv 2.csv --held-out 3.csv --sim ball.toml --json";
        let json = folder.run(line).ends(3).json();
        let left: Vec<&str> = json["candidates"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
        let both = ["bounce_friction", "tangential_restitution"].iter().all(|name| left.contains(name));
        assert!(json["verdict"] == "one_of" && both, "{first}: {} {left:?}", json["verdict"]);
    }
}
