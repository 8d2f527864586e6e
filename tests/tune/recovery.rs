//! Drops from formulas alone, tuned to: the restitution comes back, and its interval keeps what it promises.

use crate::common::{Drop, Folder, Noise};
use crate::docs::page::root;
use rayon::prelude::*;
use tunenet_core::observation::{Kind, Observation};
use tunenet_core::tune::{Settings, Verdict, tune};
use tunenet_sim::{ObservedBall, SimulationFile};

const DROPS: u64 = 300;

fn drawn(seed: u64) -> Drop {
    let mut draw = Noise(seed.wrapping_mul(7919) + 1);
    let height_m = draw.between(0.3, 5.0);
    let mut drop = Drop {
        restitution: draw.between(0.05, 0.97),
        height_m,
        radius_m: draw.between(0.01, 0.5),
        floor_m: draw.between(-1.0, 1.0),
        rate_hz: draw.between(60.0, 240.0),
        frames: 0,
        held_s: draw.between(0.0, 0.3),
        noise_m: height_m * draw.between(0.0005, 0.003),
        seed: draw.next(),
    };
    let bounces = 2 + u32::try_from(draw.next() % 5).unwrap();
    // The record ends halfway through the flight after the last bounce.
    let end = f64::midpoint(drop.impact_s(bounces - 1), drop.impact_s(bounces));
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "seconds times a rate")]
    let frames = (end * drop.rate_hz) as usize + 1;
    drop.frames = frames;
    drop
}

/// What came of one drop.
struct Found {
    tuned: bool,
    covered: bool,
    story: String,
}

fn recover(seed: u64) -> Found {
    let drop = drawn(seed);
    let scene = format!(
        "kind = \"ball\"\n[ball]\nradius_m = {:?}\n[parameters.restitution]\nvalue = 0.5\nmin = 0.0\nmax = 1.0\n",
        drop.radius_m
    );
    let file = SimulationFile::parse("scene.toml".as_ref(), &scene).unwrap();
    let ball = ObservedBall::new(&file, Kind::Positions).unwrap();
    let (clock, rows): (Vec<f64>, Vec<[f64; 3]>) = drop.frames().into_iter().unzip();
    let seen = Observation::positions(clock, &rows).unwrap();
    let outcome = tune(&ball, &[seen], None, &Settings::default()).unwrap();
    let found = outcome.parameters.first();
    let (value, (low, high)) = found.map_or((f64::NAN, (f64::NAN, f64::NAN)), |p| (p.value, p.interval95));
    Found {
        tuned: outcome.verdict == Verdict::Tuned,
        covered: low <= drop.restitution && drop.restitution <= high,
        story: format!("{seed}: {:?} {value:.5} [{low:.5}, {high:.5}] {drop:?}", outcome.verdict),
    }
}

#[test]
fn drops_come_back_with_honest_intervals() {
    let all: Vec<Found> = (0..DROPS).into_par_iter().map(recover).collect();
    let share = |count: usize| count as f64 / all.len() as f64;
    let tuned = share(all.iter().filter(|f| f.tuned).count());
    let covered = share(all.iter().filter(|f| f.covered).count());
    eprintln!("{DROPS} drops: {tuned:.3} tuned, {covered:.3} covered");
    let stories = |wanted: fn(&Found) -> bool| {
        all.iter().filter(|f| wanted(f)).map(|f| f.story.as_str()).collect::<Vec<_>>().join("\n")
    };
    assert!(tuned >= 0.97, "{tuned} tuned, covered {covered}; not tuned:\n{}", stories(|f| !f.tuned));
    assert!(
        (0.90..=0.99).contains(&covered),
        "{covered} covered, tuned {tuned}; not covered:\n{}",
        stories(|f| !f.covered)
    );
}

/// The light ball of assets/ was thrown with a drag of 0.1317 1/m and bounces with 0.8, by an integrator of its own.
#[test]
fn an_effect_is_tuned_beside_the_parameters_and_alone() {
    const DRAG_1_M: f64 = 0.1317;
    let folder = Folder::new();
    let light = root().join("assets/observations/light_1.csv");
    folder.write("light.csv", std::fs::read(light).unwrap());
    let scene = |restitution: &str| {
        format!(
            "kind = \"ball\"\nball.radius_m = 0.02\n\n[effects.quadratic_drag]\nc_1_m = 0.05 # a guess\ntune = true\n\n\
             [parameters.restitution]\nmin = 0.0\nmax = 1.0\n{restitution}\n"
        )
    };
    for (name, text, count) in [("both", scene("value = 0.5"), 2), ("alone", scene("value = 0.8\ntune = false"), 1)] {
        folder.write(&format!("{name}.toml"), text);
        let json = folder.run(&format!("tune --sim {name}.toml light.csv --json -o {name}_tuned.toml")).ends(0).json();
        let found = json["parameters"].as_object().unwrap();
        assert_eq!((json["verdict"].as_str(), found.len()), (Some("tuned"), count), "{json}");
        let drag = &found["quadratic_drag.c_1_m"];
        let bound = |i: usize| drag["interval95"][i].as_f64().unwrap();
        assert!(bound(0) < DRAG_1_M && DRAG_1_M < bound(1) && bound(1) - bound(0) < 0.01, "{drag}");
        // The tuned file holds it, with its comment, and is the start of the next run.
        let tuned = folder.text(&format!("{name}_tuned.toml"));
        assert!(tuned.contains("c_1_m = 0.13") && tuned.contains("# a guess"), "{tuned}");
        let again = folder.run(&format!("tune --sim {name}_tuned.toml light.csv --json")).ends(0).json();
        let before = again["parameters"]["quadratic_drag.c_1_m"]["before"].as_f64().unwrap();
        assert!((before - drag["value"].as_f64().unwrap()).abs() < 1e-12);
    }
}
