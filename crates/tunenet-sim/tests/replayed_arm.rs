//! Replayed arms against logs of real ones.

use std::path::PathBuf;
use tunenet_core::observation::recording::{ReadOptions, read};
use tunenet_core::simulator::{Parameter, Simulator};
use tunenet_core::tune::{Settings, tune};
use tunenet_sim::arm::urdf;
use tunenet_sim::replayed_arm::{ReplayedArm, with_reference};

fn columns(per: &[(&str, &str, usize)]) -> Vec<(String, String)> {
    let mut all = vec![("t_s".to_owned(), "1".to_owned())];
    for (name, unit, first) in per {
        for j in 1..=6 {
            all.push((format!("{name}{j}_{unit}"), (first + j - 1).to_string()));
        }
    }
    all
}

#[test]
fn explore() {
    let Some(root) = std::env::var_os("TUNENET_MEASURED").map(PathBuf::from) else { return };
    let dir = root.join("ur10e-payload");
    let options = ReadOptions {
        columns: columns(&[("q", "rad", 2), ("i", "a", 14)]),
        skip_broken: true,
        ..ReadOptions::default()
    };
    let file = |name: &str| read(dir.join(name), &options).unwrap();
    for gains in [[10.0, 10.6956, 8.4566, 9.0029, 9.48, 10.1232], [14.87, 13.26, 11.13, 10.62, 11.03, 11.47]] {
        for reference in [true, false] {
            let mut gain = 1.0;
            for run in ["14harm", "15harm"] {
                let began = std::time::Instant::now();
                let seen = file(&format!("ur-20_02_19_{run}50secLoad.csv"));
                let bare = file(&format!("ur-20_02_19_{run}50sec.csv"));
                let (both, note) = with_reference(&seen.observation, &bare.observation).unwrap();
                if reference {
                    println!("{}", note.text);
                }
                let used = if reference { both } else { seen.observation.clone() };
                let model = urdf::read(&dir.join("ur10e.urdf")).unwrap();
                let mut model = model.chain_to("tool0").unwrap();
                model.notes.clear();
                let frame = model.frame("tool0").unwrap().clone();
                let fixed = |name: &str, unit: &str, value: f64, min: f64, max: f64, tune: bool| Parameter {
                    tune,
                    ..Parameter::new(name, unit, value, min, max).unwrap()
                };
                let mass_free = run == "15harm";
                let mut parameters = vec![
                    fixed("payload_mass", "kg", if mass_free { 1.0 } else { 2.805 }, 0.0, 20.0, mass_free),
                    fixed("payload_com_x", "m", 0.0, -0.5, 0.5, true),
                    fixed("payload_com_y", "m", 0.0, -0.5, 0.5, true),
                    fixed("payload_com_z", "m", 0.0, -0.5, 0.5, true),
                    fixed("torque_gain", "1", gain, 0.1, 10.0, !mass_free),
                ];
                let arm = ReplayedArm::new(model, frame, 9.81, parameters)
                    .unwrap()
                    .with_current_gain(gains.to_vec())
                    .unwrap();
                let arm = if reference { arm } else { arm };
                println!("read+build {:?}", began.elapsed());
                let friction =
                    arm.with_effects(if reference { &[] } else { &["viscous_friction", "coulomb_friction"] }).unwrap();
                let outcome = tune(&friction, &[used], None, &Settings::default()).unwrap();
                for p in &outcome.parameters[..5.min(outcome.parameters.len())] {
                    println!("  {} {:.4} {:?} {:?}", p.name, p.value, p.interval95, p.status);
                }
                println!(
                    "  {:?} gap {:?} rollouts {} {:?}",
                    outcome.verdict,
                    outcome.gap,
                    outcome.rollouts,
                    began.elapsed()
                );
                for n in &outcome.notes {
                    println!("  note {}", n.text);
                }
                if !mass_free {
                    gain = outcome.parameters.iter().find(|p| p.name == "torque_gain").unwrap().value;
                }
                let _ = arm.parameters();
            }
        }
    }
}
