//! The catalogue of effects against its page, and effects through the commands.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use tunenet_core::observation::Kind;
use tunenet_core::simulator::{Effect, measurement_effects};
use tunenet_sim::arm;
use tunenet_sim::ball::effects::{ALL, Body};

/// A ball of which only the size is known.
fn ball_effects() -> Vec<Effect> {
    let body = Body { radius_m: 0.02, mass_kg: None, gravity_m_s2: 9.81, in_air: true };
    ALL.iter().map(|e| e.entry(&body)).collect()
}

/// The rows that docs/effects.md must hold for these effects.
fn rows(effects: &[Effect]) -> String {
    let mut table = String::from(
        "| effect | acts | coefficients: allowed, physical bounds | what it is | mistaken for |\n|---|---|---|---|---|\n",
    );
    for effect in effects {
        let each = effect.coefficients.iter().zip(&effect.plausible).map(|(c, (low, high))| {
            let absent = if c.absent == 0.0 { String::new() } else { format!("; absent at {}", c.absent) };
            format!("`{}` ({}): {} to {}, {low} to {high}{absent}", c.key, c.unit, c.min, c.max)
        });
        let coefficients = each.collect::<Vec<_>>().join("<br>");
        let mistaken = effect.mistaken_for.iter().map(|m| format!("`{m}`")).collect::<Vec<_>>().join(", ");
        let sentence = effect.sentence.replace('|', "\\|");
        writeln!(
            table,
            "| `{}` | {} | {coefficients} | {sentence} | {mistaken} |",
            effect.name,
            tunenet_sim::phase::name(&effect.phase)
        )
        .unwrap();
    }
    table
}

#[test]
fn the_page_of_effects_is_the_catalogue() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/effects.md");
    let page = std::fs::read_to_string(path).unwrap();
    let arm: Vec<Effect> = arm::effects::ALL.iter().map(|e| e.entry(1)).collect();
    for (name, effects) in
        [("ball", ball_effects()), ("measurement", measurement_effects(Kind::Positions)), ("arm", arm)]
    {
        let (begin, end) = (format!("<!-- {name}: begin -->\n"), format!("<!-- {name}: end -->"));
        let found = page.split_once(&begin).and_then(|(_, rest)| rest.split_once(&end)).map(|(found, _)| found);
        let expected = rows(&effects);
        assert!(
            found == Some(&expected),
            "docs/effects.md should hold between its marks `{name}`:\n{expected}=== end of {name}"
        );
    }
}

#[test]
fn what_is_mistaken_is_mistaken_both_ways() {
    mistaken_both_ways(&ball_effects().into_iter().chain(measurement_effects(Kind::Positions)).collect::<Vec<_>>());
    mistaken_both_ways(&arm::effects::ALL.iter().map(|e| e.entry(1)).collect::<Vec<_>>());
}

fn mistaken_both_ways(all: &[Effect]) {
    for (i, effect) in all.iter().enumerate() {
        assert!(!all[..i].iter().any(|e| e.name == effect.name), "{} stands there twice", effect.name);
        assert!(!effect.mistaken_for.is_empty() && effect.sentence.len() < 110, "{}", effect.name);
        for other in &effect.mistaken_for {
            let back = all.iter().find(|e| e.name == *other).unwrap_or_else(|| panic!("{}: {other}?", effect.name));
            assert!(back.mistaken_for.contains(&effect.name), "{other} should name {}", effect.name);
        }
        for (c, (low, high)) in effect.coefficients.iter().zip(&effect.plausible) {
            assert!((c.min..=c.max).contains(&c.absent) && c.min <= *low && low < high && *high <= c.max);
            assert!(c.typical > 0.0 && c.absent + c.typical <= c.max, "{}.{}", effect.name, c.key);
        }
    }
}

fn tunenet(arguments: &[&str]) -> serde_json::Value {
    let output = Command::new(env!("CARGO_BIN_EXE_tunenet")).args(arguments).arg("--json").output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {said}");
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn a_file_with_effects_simulates_and_tunes_as_any_other() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let text = "kind = \"ball\"\nball.radius_m = 0.02\nball.mass_kg = 0.0027\nsurface.height_m = 0.0\n\
        record.rate_hz = 120.0\nrecord.frames = 240\n[parameters.restitution]\nvalue = 0.8\nmin = 0.0\nmax = 1.0\n\
        [effects.quadratic_drag]\nc_1_m = 0.13\n[effects.speed_dependent_restitution]\nexponent = 0.05\n\
        [effects.aspect_ratio]\nfactor = 0.95\n[effects.time_scale]\nfactor = 1.04\n";
    std::fs::write(at("ball.toml"), text).unwrap();
    let throw = ["--set", "release.position_m=[0,0,1.5]", "--set", "release.velocity_m_s=[0.8,0,1]"];
    let simulate = |out: &str, more: &[&str]| {
        let (sim, out) = (at("ball.toml"), at(out));
        let arguments = [&["simulate", "--sim", &sim, "--out", &out], &throw[..], more].concat();
        tunenet(&arguments);
        std::fs::read_to_string(out).unwrap()
    };
    let (seen, truth) = (simulate("seen.csv", &[]), simulate("truth.csv", &["--truth"]));
    let last =
        |text: &str| text.lines().nth(1).unwrap().split(',').map(|v| v.parse::<f64>().unwrap()).collect::<Vec<_>>();
    assert!((last(&seen)[3] - 0.95 * 1.5).abs() < 1e-12 && (last(&truth)[3] - 1.5).abs() < 1e-12);

    // With its effects the file explains what it wrote; without those of the measurement it does not.
    let (sim, out) = (at("ball.toml"), at("tuned.toml"));
    let start = "parameters.restitution.value=0.6";
    let seen = at("seen.csv");
    let tune = ["tune", "--sim", &sim, "--set", start, "--observation", &seen, "--out", &out];
    let answer = tunenet(&tune);
    assert_eq!(answer["verdict"], "tuned");
    let found = answer["parameters"]["restitution"]["value"].as_f64().unwrap();
    assert!((found - 0.8).abs() < 1e-6, "{found}");
    assert_eq!(answer["parameters"].as_object().unwrap().len(), 1, "effects are constants");
    let tuned = std::fs::read_to_string(&out).unwrap();
    assert!(tuned.contains("[effects.time_scale]\nfactor = 1.04"), "{tuned}");
    let truth = at("truth.csv");
    let other = Command::new(env!("CARGO_BIN_EXE_tunenet"))
        .args(["tune", "--sim", &sim, "--observation", &truth])
        .output()
        .unwrap();
    assert_eq!(other.status.code(), Some(3), "{}", String::from_utf8_lossy(&other.stderr));
}
