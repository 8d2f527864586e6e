//! Recordings that lack a channel: gaps are those of the channels that were measured, and nothing is said of the others.

use crate::common::{Drop, Folder, Noise};

const NOISE_M: f64 = 0.004;

/// Drops at these heights with a steady speed along x, of which only these columns are recorded.
fn folder_of(columns: &str) -> Folder {
    let folder = Folder::new();
    folder.write("ball.toml", "kind = \"ball\"\nball.radius_m = 0.02\n");
    for (k, height_m) in (0u64..).zip([0.8, 1.0, 1.2, 0.9]) {
        let (drop, mut noise) = (Drop { height_m, noise_m: 0.0, ..Drop::default() }, Noise(50 + k));
        let mut text = format!("{columns}\n");
        for (t, [x, _, z]) in drop.frames() {
            let along = x + (0.3 - 0.2 * k as f64) * t;
            let seen = [("x_m", along), ("z_m", z)].map(|(name, value)| (name, value + NOISE_M * noise.normal()));
            let kept = seen.iter().filter(|(name, _)| columns.contains(name)).map(|(_, value)| format!(",{value:.6}"));
            text += &[t.to_string(), kept.collect(), "\n".into()].concat();
        }
        folder.write(&format!("{k}.csv"), text);
    }
    folder
}

/// Of one channel the noise floor is its noise, of two the root of twice its square.
#[test]
fn gaps_count_the_channels_that_were_measured() {
    for (columns, channels) in [("t_s,z_m", 1.0f64), ("t_s,x_m,z_m", 2.0)] {
        let folder = folder_of(columns);
        let json = folder.run("diagnose 0.csv 1.csv 2.csv --held-out 3.csv --sim ball.toml --json").ends(0).json();
        assert_eq!(json["verdict"], "none", "{columns}: {json:#}");
        let noise_m = channels.sqrt() * NOISE_M;
        for key in ["noise_floor", "after"] {
            let found = json["gap"][key].as_f64().unwrap();
            assert!((found / noise_m - 1.0).abs() < 0.15, "{columns}: {key} {found}, noise {noise_m}");
        }
        let tuned = folder.run("tune 0.csv 1.csv 2.csv --sim ball.toml --json").ends(0).json();
        let (one, other) = (&tuned["gap"]["noise_floor"], &json["gap"]["noise_floor"]);
        let ratio = one.as_f64().unwrap() / other.as_f64().unwrap();
        assert!((ratio - 1.0).abs() < 0.1, "{columns}: {one} {other}");
    }
}

/// A force that acts along x only: what is left is described there.
#[test]
fn no_residual_is_described_along_a_channel_without_values() {
    let folder = folder_of("t_s,x_m,z_m");
    for k in 0..4 {
        let name = format!("{k}.csv");
        let text = folder.text(&name);
        let pushed = text.lines().map(|line| {
            let cells: Vec<f64> = line.split(',').filter_map(|cell| cell.parse().ok()).collect();
            let [t, x, z] = cells[..] else { return format!("{line}\n") };
            format!("{t},{},{z}\n", x + 0.05 * (9.0 * t).sin())
        });
        folder.write(&name, pushed.collect::<String>());
    }
    let json = folder.run("diagnose 0.csv 1.csv 2.csv --held-out 3.csv --sim ball.toml --json").ends(3).json();
    let text = json["description"].as_str().unwrap_or_else(|| panic!("{json:#}"));
    assert!(text.contains("along x"), "{text}");
}
