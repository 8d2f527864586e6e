//! Every physical effect of the catalogue against an integrator of its own: Runge–Kutta flight in tiny steps, root-found
//! impacts and impulse formulas. Nothing there uses the code under test.

use std::path::Path;

use crate::independent::World;
use tunenet_core::observation::{Kind, Observation};
use tunenet_core::simulator::{Preparation, Simulator, rollout};
use tunenet_sim::simulation_file::LeftOpen;
use tunenet_sim::{Session, SimulationFile, simulator};

const BALL: &str = "kind = \"ball\"\nworld.gravity_m_s2 = 9.81\nball.radius_m = 0.02\nsurface.height_m = 0.1\n\
    release.position_m = [0.1, -0.2, 1.6]\nrelease.velocity_m_s = [1.1, -0.7, 0.9]\nrelease.spin_rad_s = [-150, 120, 30]\n\
    release.time_s = 0\n[parameters.restitution]\nvalue = 0.75\nmin = 0.0\nmax = 1.0\n\
    [parameters.friction]\nvalue = 0.05\nmin = 0.0\nmax = 1.0\ntune = false\n";

fn file() -> SimulationFile {
    SimulationFile::parse(Path::new("ball.toml"), BALL).unwrap()
}

/// The same throw for the independent integrator.
fn world() -> World {
    World {
        gravity: 9.81,
        radius: 0.02,
        height: 0.1,
        restitution: 0.75,
        friction: 0.05,
        x: [0.1, -0.2, 1.6],
        v: [1.1, -0.7, 0.9],
        w: [-150.0, 120.0, 30.0],
        ..World::default()
    }
}

fn clock() -> Vec<f64> {
    (0..216).map(|i| f64::from(i) / 120.0).collect()
}

/// What the simulator says with this effect in its file, and with it as parameters; both have to be the same.
fn simulated(file: &SimulationFile, name: &str, values: &[f64], clock: &[f64]) -> Vec<f64> {
    let base = simulator(file, Kind::Positions, &Session::default()).unwrap();
    let entry = base.effects().into_iter().find(|e| e.name == name).unwrap();
    let free = base.with_effects(&[name]).unwrap();
    let mut parameters: Vec<f64> = free.parameters().iter().map(|p| p.value).collect();
    let at = parameters.len() - values.len();
    parameters[at..].copy_from_slice(values);
    let seen = rollout(&*free, &parameters, &[], clock).unwrap();

    let mut file = file.clone();
    let pairs: Vec<_> = entry.coefficients.iter().map(|c| c.key.as_ref()).zip(values.iter().copied()).collect();
    file.add_effect(name, &pairs).unwrap();
    let fixed = simulator(&file, Kind::Positions, &Session::default()).unwrap();
    assert_eq!(fixed.parameters().len(), 2);
    assert_eq!(rollout(&*fixed, &parameters[..2], &[], clock).unwrap(), seen, "a file and a parameter mean the same");
    seen
}

/// Holds an effect against the independent world, and asks that it matters.
fn agrees(name: &str, values: &[f64], truth: &World, tolerance_m: f64) {
    let clock = clock();
    let seen = simulated(&file(), name, values, &clock);
    let base = simulator(&file(), Kind::Positions, &Session::default()).unwrap();
    let without = rollout(&*base, &[0.75, 0.05], &[], &clock).unwrap();
    let truth = truth.positions(&clock);
    let worst = seen.iter().zip(&truth).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let size = seen.iter().zip(&without).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    eprintln!("{name}: {worst:e} m of an effect of {size} m");
    assert!(size > 5e-3, "{name} changes {size} m");
    assert!(worst < tolerance_m, "{name}: {worst:e} m");
}

#[test]
fn the_independent_world_is_the_base_model() {
    let base = simulator(&file(), Kind::Positions, &Session::default()).unwrap();
    let seen = rollout(&*base, &[0.75, 0.05], &[], &clock()).unwrap();
    let worst = seen.iter().zip(world().positions(&clock())).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-9, "{worst:e}");
}

#[test]
fn forces_of_flight_follow_their_equations() {
    agrees("quadratic_drag", &[0.13], &World { quadratic: 0.13, ..world() }, 1e-6);
    agrees("linear_drag", &[0.3], &World { linear: 0.3, ..world() }, 1e-6);
    agrees("wind", &[0.4, -0.25], &World { wind: [0.4, -0.25], ..world() }, 1e-9);
    agrees("magnus", &[0.3, -0.2, 0.5], &World { magnus: [0.3, -0.2, 0.5], ..world() }, 1e-6);
    agrees("effective_gravity", &[-0.6], &World { gravity: 9.21, ..world() }, 1e-9);
}

#[test]
fn laws_of_contact_follow_their_formulas() {
    agrees("speed_dependent_restitution", &[0.12], &World { exponent: 0.12, ..world() }, 1e-8);
    agrees("surface_tilt", &[0.05, -0.08], &World { tilt: [0.05, -0.08], ..world() }, 1e-8);
    agrees("bounce_friction", &[0.15], &World { friction: 0.2, ..world() }, 1e-8);
    agrees("tangential_restitution", &[0.35], &World { loss: 0.35, ..world() }, 1e-8);
    agrees("contact_time", &[0.012], &World { duration: 0.012, ..world() }, 1e-7);
}

#[test]
fn a_rolling_ball_slows_down_evenly_and_stops() {
    // On the floor, rolling already: v²/(2 c g) is the way to rest.
    let mut file = file();
    for set in [
        "release.position_m=[0,0,0.12]",
        "release.velocity_m_s=[0.6,0.8,0]",
        "release.spin_rad_s=[-40,30,0]",
        "parameters.friction.value=0.4",
    ] {
        file.set(set).unwrap();
    }
    let clock: Vec<f64> = (0..100).map(|i| f64::from(i) / 20.0).collect();
    let seen = simulated(&file, "rolling_resistance", &[0.05], &clock);
    let brake = 0.05 * 9.81;
    for (t, row) in clock.iter().zip(seen.chunks(3)) {
        let t = t.min(1.0 / brake);
        let way = t - 0.5 * brake * t * t;
        assert!((row[0] - 0.6 * way).abs() < 1e-9 && (row[1] - 0.8 * way).abs() < 1e-9, "{t}: {row:?}, {way}");
    }
    // On a slope it rolls with what is left of 5/7, or stays where it is.
    let tilt = 0.1_f64;
    file.set("surface.tilt_about_y_rad=0.1").unwrap();
    let (x, z) = (0.02 * tilt.sin(), 0.1 + 0.02 * tilt.cos());
    file.set(&format!("release.position_m=[{x},0,{z}]")).unwrap();
    for set in ["release.velocity_m_s=[0,0,0]", "release.spin_rad_s=[0,0,0]"] {
        file.set(set).unwrap();
    }
    for (c, pull) in [(0.02, (5.0 / 7.0 * tilt.sin() - 0.02 * tilt.cos()) * 9.81), (0.2, 0.0)] {
        let seen = simulated(&file, "rolling_resistance", &[c], &clock);
        for (t, row) in clock.iter().zip(seen.chunks(3)) {
            let way = 0.5 * pull * t * t;
            assert!((row[0] - x - way * tilt.cos()).abs() < 1e-8, "{c} {t}: {row:?}");
        }
    }
    // Across a slope the way bends; the independent integrator follows it in tiny steps.
    for set in ["release.velocity_m_s=[0,0.5,0]", "release.spin_rad_s=[-24.87510413,0,2.49584]"] {
        file.set(set).unwrap();
    }
    let seen = simulated(&file, "rolling_resistance", &[0.06], &clock);
    let truth =
        crate::independent::roll([tilt.sin() * 9.81 * 5.0 / 7.0, 0.0], [0.0, 0.5], 0.06 * 9.81 * tilt.cos(), &clock);
    for (row, down) in seen.chunks(3).zip(truth) {
        assert!(
            (row[0] - x - down[0] * tilt.cos()).abs() < 1e-5 && (row[1] - down[1]).abs() < 1e-5,
            "{row:?} {down:?}"
        );
    }
}

#[test]
fn bounce_times_hear_what_changes_them() {
    let mut file = file();
    file.leave_open(&[LeftOpen::ReleasePosition, LeftOpen::ReleaseVelocity, LeftOpen::ReleaseSpin]);
    let base = simulator(&file, Kind::EventTimes, &Session::default()).unwrap();
    let index: Vec<f64> = (0..6).map(f64::from).collect();
    let fall = 1.3;
    let heard = |name: &str, value: f64| {
        let free = base.with_effects(&[name]).unwrap();
        rollout(&*free, &[0.75, 0.0, value], &[fall, 0.2], &index).unwrap()
    };
    let first = (2.0 * fall / 9.81_f64).sqrt();
    // A bounce with speed v keeps the ball away for 2 v/g, and in contact for a while.
    let (mut time, mut hop) = (0.2 + first, 2.0 * first);
    for seen in heard("contact_time", 0.01) {
        assert!((seen - time).abs() < 1e-12, "{seen} {time}");
        hop *= 0.75;
        time += hop + 0.01;
    }
    let (mut time, mut speed) = (0.2 + first, 9.81 * first);
    for seen in heard("speed_dependent_restitution", 0.1) {
        assert!((seen - time).abs() < 1e-12, "{seen} {time}");
        speed *= 0.75 * (speed / 3.0).powf(-0.1);
        time += 2.0 * speed / 9.81;
    }
    // As a clock that runs 2 % fast and is 0.3 s late tells it.
    let truth = rollout(&*base, &[0.75, 0.0], &[fall, 0.2], &index).unwrap();
    file.add_effect("time_scale", &[("factor", 1.02)]).unwrap();
    file.add_effect("time_offset", &[("offset_s", 0.3)]).unwrap();
    file.add_effect("camera_tilt", &[("about_x_rad", 0.1)]).unwrap();
    let clocked = simulator(&file, Kind::EventTimes, &Session::default()).unwrap();
    let seen = rollout(&*clocked, &[0.75, 0.0], &[fall, 0.2], &index).unwrap();
    assert!(seen.iter().zip(&truth).all(|(seen, t)| (seen - 1.02 * t - 0.3).abs() < 1e-14));
}

#[test]
fn a_scattered_bounce_meets_a_turned_normal() {
    let clock = clock();
    let seen = Observation::new(
        Kind::Positions,
        tunenet_core::observation::Channel::positions(),
        clock.clone(),
        world().positions(&clock),
    )
    .unwrap();
    let free =
        simulator(&file(), Kind::Positions, &Session::default()).unwrap().with_effects(&["bounce_scatter"]).unwrap();
    assert!(!free.parameters()[2].tune, "chance has no rollout");
    let Preparation::Usable(prepared) = free.prepare(&seen).unwrap() else { panic!("a plain throw") };
    let names: Vec<&str> = prepared.nuisances.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names[..3], ["bounce.1.tilt_about_x", "bounce.1.tilt_about_y", "bounce.2.tilt_about_x"]);
    let mut own = prepared.nuisance_values();
    let parameters = [0.75, 0.05, 0.0];
    let plain = simulator(&file(), Kind::Positions, &Session::default()).unwrap();
    assert_eq!(
        rollout(&*free, &parameters, &own, &clock).unwrap(),
        rollout(&*plain, &parameters[..2], &[], &clock).unwrap()
    );
    own[..4].copy_from_slice(&[0.03, -0.02, 0.01, 0.04]);
    let truth = World { kicks: vec![[0.03, -0.02], [0.01, 0.04]], ..world() }.positions(&clock);
    let kicked = rollout(&*free, &parameters, &own, &clock).unwrap();
    let worst = kicked.iter().zip(&truth).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-8, "{worst:e}");
}

#[test]
fn absent_effects_change_no_bit() {
    let (base, clock) = (simulator(&file(), Kind::Positions, &Session::default()).unwrap(), clock());
    let plain = rollout(&*base, &[0.75, 0.05], &[], &clock).unwrap();
    let known = base.effects();
    let all: Vec<&str> = known.iter().map(|e| e.name.as_ref()).collect();
    assert_eq!(all.len(), 12);
    let free = base.with_effects(&all).unwrap();
    let absent: Vec<f64> = free.parameters().iter().map(|p| p.value).collect();
    assert_eq!(rollout(&*free, &absent, &[], &clock).unwrap(), plain);
    assert!(free.effects().is_empty());

    let base = simulator(&file(), Kind::EventTimes, &Session::default()).unwrap();
    let known = base.effects();
    let all: Vec<&str> = known.iter().map(|e| e.name.as_ref()).collect();
    let expected =
        ["quadratic_drag", "linear_drag", "effective_gravity", "speed_dependent_restitution", "contact_time"];
    assert_eq!(all, expected);
    let free = base.with_effects(&all).unwrap();
    let absent: Vec<f64> = free.parameters().iter().map(|p| p.value).collect();
    let index = [0.0, 1.0, 2.0, 3.0];
    let own = [1.4, 0.0];
    assert_eq!(rollout(&*free, &absent, &own, &index).unwrap(), rollout(&*base, &absent[..2], &own, &index).unwrap());
}

/// A fit walks along forward differences: at steps of a thousandth and a ten-thousandth of the typical value, and at the
/// absent value, they have to agree.
#[test]
fn derivatives_are_smooth() {
    let (base, clock) = (simulator(&file(), Kind::Positions, &Session::default()).unwrap(), clock());
    for effect in base.effects().iter().filter(|e| !["bounce_scatter", "rolling_resistance"].contains(&e.name.as_ref()))
    {
        let free = base.with_effects(&[&effect.name]).unwrap();
        let absent: Vec<f64> = free.parameters().iter().map(|p| p.value).collect();
        for (i, coefficient) in effect.coefficients.iter().enumerate() {
            for away in [0.0, 1.0] {
                let mut point = absent.clone();
                point[2 + i] += away * coefficient.typical;
                let from = rollout(&*free, &point, &[], &clock).unwrap();
                let slope = |share: f64| -> Vec<f64> {
                    let step = share * coefficient.typical;
                    let mut moved = point.clone();
                    moved[2 + i] += step;
                    let to = rollout(&*free, &moved, &[], &clock).unwrap();
                    to.iter().zip(&from).map(|(a, b)| (a - b) / step).collect()
                };
                let (coarse, fine) = (slope(1e-3), slope(1e-5));
                let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
                let apart: Vec<f64> = coarse.iter().zip(&fine).map(|(a, b)| a - b).collect();
                let share = norm(&apart) / norm(&fine);
                eprintln!("{}.{} at {away}: {share:e}", effect.name, coefficient.key);
                // A sample that lies in a contact of 5 µs and 50 ns sees the kink that a contact is.
                assert!(share < 0.02, "{}.{} at {away}: {share:e}", effect.name, coefficient.key);
            }
        }
    }
}

#[test]
fn what_is_out_of_range_is_refused_with_a_sentence() {
    let text = format!("{BALL}\n[effects.quadratic_drag]\nc_1_m = -0.1\n");
    let said = SimulationFile::parse(Path::new("ball.toml"), &text).unwrap_err().to_string();
    assert!(said.contains("`effects.quadratic_drag.c_1_m`: expected a number from 0 to 10, found -0.1"), "{said}");

    let text = format!("{BALL}\n[effects.quadratic_drg]\nc_1_m = 0.1\n");
    let said = SimulationFile::parse(Path::new("ball.toml"), &text).unwrap_err().to_string();
    assert!(said.contains("built-in effect (`quadratic_drag`,"), "{said}");

    let mut file = file();
    let before = file.text();
    let said = file.add_effect("wind", &[("ax_m_s2", 0.1), ("az_m_s2", 0.1)]).unwrap_err().to_string();
    assert!(said.contains("effects.wind.ay_m_s2") && said.contains("az_m_s2"), "{said}");
    assert!(file.add_effect("tide", &[("height_m", 0.1)]).is_err());
    assert!(file.add_effect("contact_time", &[("duration_s", f64::NAN)]).is_err());
    assert_eq!(file.text(), before);

    let base = simulator(&file, Kind::Positions, &Session::default()).unwrap();
    let said = base.with_effects(&["tide"]).map(|_| ()).unwrap_err().to_string();
    assert!(said.contains("quadratic_drag") && said.contains("`tide`"), "{said}");
    assert!(base.with_effects(&["wind", "wind"]).is_err());
    let free = base.with_effects(&["tangential_restitution"]).unwrap();
    let said = rollout(&*free, &[0.75, 0.05, 2.5], &[], &clock()).unwrap_err().to_string();
    assert!(said.contains("tangential_loss") && said.contains("2.5"), "{said}");
}

#[test]
fn effects_of_a_file_are_constants_until_they_are_freed() {
    let mut file = file();
    file.add_effect("quadratic_drag", &[("c_1_m", 0.1)]).unwrap();
    file.add_effect("length_scale", &[("factor", 1.1)]).unwrap();
    file.add_effect("quadratic_drag", &[("c_1_m", 0.13)]).unwrap();
    let base = simulator(&file, Kind::Positions, &Session::default()).unwrap();
    assert!(base.effects().iter().all(|e| e.name != "quadratic_drag") && base.parameters().len() == 2);
    let free = base.with_effects(&["length_scale", "quadratic_drag"]).unwrap();
    let values: Vec<f64> = free.parameters().iter().map(|p| p.value).collect();
    assert_eq!(values, [0.75, 0.05, 0.13, 1.1]);
    let clock = clock();
    let seen = rollout(&*base, &values[..2], &[], &clock).unwrap();
    assert_eq!(rollout(&*free, &values, &[], &clock).unwrap(), seen);
    let truth = World { quadratic: 0.13, ..world() }.positions(&clock);
    assert!(seen.iter().zip(&truth).all(|(a, b)| (a - 1.1 * b).abs() < 1e-6));
}

#[test]
fn mass_and_size_bound_what_is_plausible() {
    let plausible = |file: &SimulationFile, name: &str| {
        let base = simulator(file, Kind::Positions, &Session::default()).unwrap();
        base.effects().into_iter().find(|e| e.name == name).unwrap().plausible[0]
    };
    let mut file = file();
    assert_eq!(plausible(&file, "effective_gravity"), (-2.0, 2.0));
    file.set("ball.mass_kg=0.0027").unwrap();
    // ρ π r² / (2 m) = 1.2 · 1.2566e-3 / 5.4e-3 for a drag coefficient of 1.
    let (low, high) = plausible(&file, "quadratic_drag");
    assert!((low - 0.1 * 0.279_25).abs() < 1e-5 && (high - 1.5 * 0.279_25).abs() < 1e-4, "{low} {high}");
    // 40 mg of air against 2.7 g of ball: 1.5 % of g, and half of that again for the air moved along.
    let (low, high) = plausible(&file, "effective_gravity");
    assert!((low + 1.5 * 0.014_893 * 9.81 + 0.05).abs() < 1e-4 && high == 0.05, "{low} {high}");
}

/// The same drag by its name and by a formula: one world, although the steps are chosen in other ways.
#[test]
fn a_formula_does_what_the_effect_of_the_catalogue_does() {
    let drag = format!(
        "{BALL}[candidates.air]\nsentence = \"the air brakes\"\nacts = \"flight\"\nalong = [\"v\"]\n\
         formula = \"-c * speed_m_s^2\"\ncoefficients.c = {{ unit = \"1/m\", absent = 0.0, min = 0.0, max = 2.0 }}\n"
    );
    let by_formula = SimulationFile::parse(Path::new("ball.toml"), &drag).unwrap();
    let named = simulated(&file(), "quadratic_drag", &[0.13], &clock());
    let found = simulated(&by_formula, "air", &[0.13], &clock());
    let worst = named.iter().zip(&found).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(worst < 2e-6, "{worst} m");
    let still = simulated(&by_formula, "air", &[0.0], &clock());
    assert!(named.iter().zip(&still).any(|(a, b)| (a - b).abs() > 1e-3), "drag has to matter");
}

/// A force that depends on place and time, integrated here in tiny steps; no closed form is needed without a bounce.
#[test]
fn a_formula_of_place_and_time_agrees_with_an_integration_of_its_own() {
    let text = format!(
        "{BALL}[candidates.fan]\nsentence = \"a fan blows at a height\"\nacts = \"flight\"\nalong = [\"x\", \"y\"]\n\
         formula = \"a * exp(-((z_m - h) / w)^2) * (1 + 0.5*sin(20*t_s))\"\nper_direction = [\"a\"]\n\
         coefficients.a = {{ unit = \"m/s²\", absent = 0.0, min = -9.0, max = 9.0 }}\n\
         coefficients.h = {{ unit = \"m\", min = 0.0, max = 3.0 }}\ncoefficients.w = {{ unit = \"m\", min = 0.02, max = 3.0 }}\n\
         [effects.fan]\na = [2.5, -1.5]\nh = 1.2\nw = 0.4\n"
    );
    let file = SimulationFile::parse(Path::new("ball.toml"), &text).unwrap();
    let fixed = simulator(&file, Kind::Positions, &Session::default()).unwrap();
    let clock: Vec<f64> = (0..60).map(|i| f64::from(i) / 120.0).collect();
    let seen = rollout(&*fixed, &[0.75, 0.05], &[], &clock).unwrap();
    let acceleration = |t: f64, x: [f64; 3]| {
        let blown = (-((x[2] - 1.2) / 0.4_f64).powi(2)).exp() * (1.0 + 0.5 * (20.0 * t).sin());
        [2.5 * blown, -1.5 * blown, -9.81]
    };
    // The midpoint rule in steps of 4 µs.
    let (mut x, mut v, mut t) = ([0.1, -0.2, 1.6], [1.1, -0.7, 0.9], 0.0);
    let h = 1.0 / 120.0 / 2000.0;
    for (i, (row, until)) in seen.chunks_exact(3).zip(&clock).enumerate() {
        for _ in 0..if i == 0 { 0 } else { 2000 } {
            let middle: [f64; 3] = std::array::from_fn(|i| x[i] + 0.5 * h * v[i]);
            let a = acceleration(t + 0.5 * h, middle);
            (0..3).for_each(|i| x[i] += h * (v[i] + 0.5 * h * a[i]));
            (0..3).for_each(|i| v[i] += h * a[i]);
            t += h;
        }
        assert!(row.iter().zip(x).all(|(a, b)| (a - b).abs() < 1e-7), "{until}: {row:?} {x:?}");
    }
}

/// Fast bounces return less by a formula: successive heights of a drop follow from it in closed form.
#[test]
fn a_formula_at_contacts_changes_the_restitution() {
    let text = BALL.replace("release.position_m = [0.1, -0.2, 1.6]\nrelease.velocity_m_s = [1.1, -0.7, 0.9]\nrelease.spin_rad_s = [-150, 120, 30]\n",
        "release.position_m = [0, 0, 1.12]\nrelease.velocity_m_s = [0, 0, 0]\n");
    let text = format!(
        "{text}[candidates.loss]\nsentence = \"fast bounces return less\"\nacts = \"contact\"\nformula = \"-k*vn_m_s\"\n\
         coefficients.k = {{ unit = \"s/m\", absent = 0.0, min = 0.0, max = 0.1 }}\n[effects.loss]\nk = 0.03\n"
    );
    let file = SimulationFile::parse(Path::new("ball.toml"), &text).unwrap();
    let fixed = simulator(&file, Kind::Positions, &Session::default()).unwrap();
    let (g, mut speed) = (9.81_f64, (2.0 * 9.81_f64).sqrt());
    let (mut t, mut apexes) = (speed / g, Vec::new());
    for _ in 0..3 {
        speed *= 0.75 - 0.03 * speed;
        apexes.push((t + speed / g, 0.12 + speed * speed / (2.0 * g)));
        t += 2.0 * speed / g;
    }
    let clock: Vec<f64> = apexes.iter().map(|(t, _)| *t).collect();
    let seen = rollout(&*fixed, &[0.75, 0.05], &[], &clock).unwrap();
    for (row, (_, z)) in seen.chunks_exact(3).zip(&apexes) {
        assert!((row[2] - z).abs() < 1e-9, "{} {z}", row[2]);
    }
}
