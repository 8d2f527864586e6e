//! Throws through air, some over a slope before a camera that is level with it: one of them does not say what acts in flight, but
//! what contacts take of the speed along the surface shows.

use crate::common::{Folder, Noise};
use serde_json::Value;

const GRAVITY_M_S2: f64 = 9.81;
const RADIUS_M: f64 = 0.035;
const RESTITUTION: f64 = 0.72;
/// A solid sphere gives up so much of its slip.
const SHARE: f64 = 2.0 / 7.0;

/// Four flights at 30 Hz by steps of a fifth of a millisecond, seen with noise of .8 mm: drag of .15 1/m, a slope of so many rad,
/// and Coulomb's friction `mu` with spin.
fn throw(seed: u64, mu: f64, slope: f64) -> String {
    let mut random = Noise(seed);
    let mut between = |low: f64, high: f64| low + (high - low) * random.even();
    let (mut x, mut z, mut u, mut w) = (0.0, between(0.2, 0.6), between(0.8, 1.6), between(0.5, 2.2));
    let (mut skin, step) = (between(-0.4, 0.4), 2e-4);
    let (mut rows, mut next, mut bounces) = (vec!["t_s,x_m,z_m".to_owned()], 0usize, 0);
    let mut random = Noise(seed + 1000);
    for i in 0..20_000 {
        let t = f64::from(i) * step;
        if t >= next as f64 / 30.0 {
            let (seen_x, seen_z) = (x + 8e-4 * random.normal(), z + RADIUS_M + 8e-4 * random.normal());
            rows.push(format!("{t:.5},{seen_x:.6},{seen_z:.6}"));
            next += 1;
        }
        let speed = f64::hypot(u, w);
        u += step * (-0.15 * speed * u - GRAVITY_M_S2 * slope);
        w += step * (-0.15 * speed * w - GRAVITY_M_S2);
        x += step * u;
        z += step * w;
        if z < 0.0 && w < 0.0 {
            bounces += 1;
            if bounces == 4 {
                break;
            }
            let most = mu * (1.0 + RESTITUTION) * -w;
            let taken = (SHARE * (u - skin)).clamp(-most, most);
            u -= taken;
            skin += taken * (1.0 - SHARE) / SHARE;
            (z, w) = (0.0, -RESTITUTION * w);
        }
    }
    rows.join("\n") + "\n"
}

fn diagnosed(seed: u64, mu: f64, slope: f64) -> Value {
    let folder = Folder::new();
    let scene = "kind = \"ball\"\nball.radius_m = 0.035\n[parameters.restitution]\nvalue = 0.5\nmin = 0.0\nmax = 1.0\n";
    folder.write("ball.toml", scene);
    folder.write("throw.csv", throw(seed, mu, slope));
    let ran = folder.run("diagnose --sim ball.toml --observation throw.csv --json");
    assert!(matches!(ran.code, Some(0 | 3)), "{}", ran.stderr);
    ran.json()
}

/// What is left as an answer.
fn names(json: &Value) -> Vec<&str> {
    json["candidates"].as_array().into_iter().flatten().filter_map(Value::as_str).collect()
}

const RUBBING: [&str; 2] = ["tangential_restitution", "bounce_friction"];

fn told(found: &[Value]) -> Vec<String> {
    found.iter().map(|json| format!("{} {}", json["verdict"], json["candidates"])).collect()
}

#[test]
fn what_a_contact_takes_along_the_surface_is_in_the_answer() {
    let found: Vec<Value> = (1..=8).map(|seed| diagnosed(seed, 0.5, 0.0)).collect();
    let offered = found.iter().filter(|json| names(json).iter().any(|name| RUBBING.contains(name))).count();
    assert!(offered >= 7, "{offered} of 8: {:#?}", told(&found));
}

#[test]
fn where_contacts_take_nothing_they_are_not_blamed() {
    for seed in 11..=18 {
        let json = diagnosed(seed, 0.0, 0.03);
        let alone = json["warnings"].as_array().into_iter().flatten().any(|w| w["code"] == "contacts.alone");
        assert!(!alone, "{seed}: {} {}", json["verdict"], json["candidates"]);
    }
}
