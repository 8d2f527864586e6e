//! The ball at the edges of what can be asked: extreme numbers, odd clocks, long rollouts, grooves.

use std::time::Instant;

use rapier3d::math::{Pose, Vector};
use rapier3d::parry::shape::SharedShape;
use tunenet_sim::ball::impact::Obstacle;
use tunenet_sim::ball::{Forces, Scene, State, World, impact_times, positions};

fn scene(restitution: f64) -> Scene {
    Scene { restitution, ..Scene::default() }
}

fn roll(scene: &Scene, start: &State, clock: &[f64]) -> Result<Vec<f64>, String> {
    let mut out = vec![0.0; 3 * clock.len()];
    positions(scene, start, 0.0, clock, &mut out).map(|()| out)
}

#[test]
fn what_is_no_number_is_refused_by_name() {
    let start = State::at([0.0, 0.0, 1.0]);
    let clock = [0.0, 0.1];
    let bad = |scene: Scene, name: &str| {
        let message = roll(&scene, &start, &clock).unwrap_err();
        assert!(message.contains(name), "{message}");
    };
    for value in [f64::NAN, f64::INFINITY, -1.0, 1.5] {
        bad(scene(value), "restitution");
    }
    bad(Scene { radius_m: 0.0, ..scene(0.5) }, "radius_m");
    bad(Scene { surface_tilt_about_x_rad: 2.0, ..scene(0.5) }, "surface_tilt_about_x_rad");
    bad(Scene { flight: Forces { linear_drag_1_s: -1.0, ..Forces::default() }, ..scene(0.5) }, "linear_drag_1_s");
    let nan = State { spin_rad_s: [0.0, f64::NAN, 0.0], ..start };
    assert!(roll(&scene(0.5), &nan, &clock).unwrap_err().contains("spin_rad_s"));
    assert!(roll(&scene(0.5), &State::at([0.0; 3]), &clock).unwrap_err().contains("inside"));
    assert!(roll(&scene(0.5), &start, &[0.1, 0.0]).unwrap_err().contains("clock"));
    assert!(roll(&scene(0.5), &start, &[0.1, f64::NAN]).unwrap_err().contains("clock"));
    assert!(positions(&scene(0.5), &start, 0.0, &clock, &mut [0.0; 5]).is_err());
}

#[test]
fn extreme_numbers_end_with_an_answer() {
    let long: Vec<_> = (0..600).map(|i| f64::from(i) / 10.0).collect();
    let begin = Instant::now();
    for value in [0.0, 1e-300, 1e-9, 1.0, 1e9] {
        for c in 0..5 {
            let mut forces = Forces::default();
            let (mut scene, mut start) = (scene(0.9), State::at([0.0, 0.0, 10.0]));
            match c {
                0 => forces.quadratic_drag_1_m = value,
                1 => forces.magnus_1_s = [value, 0.0, -value],
                2 => start.spin_rad_s = [value, -value, value],
                3 => start.velocity_m_s = [value, 0.0, value],
                _ => scene.gravity_m_s2 = value,
            }
            scene.flight = forces;
            match roll(&scene, &start, &long) {
                Ok(out) => assert!(out.iter().all(|x| x.is_finite())),
                Err(message) => eprintln!("{value} in place {c}: {message}"),
            }
        }
    }
    eprintln!("extremes took {:?}", begin.elapsed());
}

#[test]
fn lively_balls_are_followed_for_a_minute() {
    let clock: Vec<_> = (0..3600).map(|i| f64::from(i) / 60.0).collect();
    for e in [0.999, 1.0] {
        let out = roll(&scene(e), &State::at([0.0, 0.0, 10.02]), &clock).unwrap();
        assert!(out.chunks(3).all(|row| (0.02 - 1e-12..=10.02).contains(&row[2])));
        assert!(out[3 * 3500..].chunks(3).any(|row| row[2] > 5.0));
    }
}

#[test]
fn too_many_bounces_are_an_error_and_no_endless_loop() {
    let start = State::at([0.0, 0.0, 0.02 + 1e-9]);
    let message = roll(&scene(1.0), &start, &[0.0, 1e6]).unwrap_err();
    assert!(message.contains("too often"), "{message}");
}

#[test]
fn no_restitution_rests_at_once_and_rest_costs_nothing() {
    let start = State::at([0.0, 0.0, 1.02]);
    assert_eq!(impact_times(&scene(0.0), &start, 0.0, 9).unwrap().len(), 1);
    let clock: Vec<_> = (0..2_000_000).map(|i| f64::from(i) / 60.0).collect();
    let begin = Instant::now();
    let out = roll(&scene(0.0), &start, &clock).unwrap();
    assert!(out[3 * 60..].chunks(3).all(|row| row[0] == 0.0 && (row[2] - 0.02).abs() < 1e-15));
    let each = begin.elapsed().as_secs_f64() / clock.len() as f64;
    eprintln!("a frame at rest takes {:.1} ns", each * 1e9);
    assert!(each < 1e-6);
}

#[test]
fn the_clock_only_looks_and_never_acts() {
    let flight = Forces { quadratic_drag_1_m: 0.05, ..Forces::default() };
    let start = State { velocity_m_s: [0.4, 0.0, 0.0], ..State::at([0.0, 0.0, 1.0]) };
    let scene = Scene { flight, ..scene(0.6) };
    let fine: Vec<_> = (0..4000).map(|i| f64::from(i) / 1000.0).collect();
    let all = roll(&scene, &start, &fine).unwrap();
    let few: Vec<usize> = vec![0, 1, 2, 450, 451, 1333, 2000, 2000, 3999];
    let odd = roll(&scene, &start, &few.iter().map(|i| fine[*i]).collect::<Vec<_>>()).unwrap();
    for (row, i) in odd.chunks(3).zip(few) {
        assert_eq!(row, &all[3 * i..3 * i + 3]);
    }
}

#[test]
fn the_ball_is_held_until_its_release() {
    let (start, clock) = (State::at([1.0, 2.0, 3.0]), [-5.0, 0.9, 1.0, 1.1]);
    let mut out = [0.0; 12];
    positions(&scene(0.5), &start, 1.0, &clock, &mut out).unwrap();
    assert!(out[..9].chunks(3).all(|row| row == [1.0, 2.0, 3.0]));
    assert!((out[11] - (3.0 - 0.5 * 9.81 * 0.01)).abs() < 1e-14);
}

#[test]
fn without_a_pull_to_the_surface_a_ball_leaves() {
    let flight = Forces { effective_gravity_m_s2: -10.81, ..Forces::default() };
    let out = roll(&Scene { flight, ..scene(0.5) }, &State::at([0.0, 0.0, 0.02]), &[2.0]).unwrap();
    assert!((out[2] - 2.02).abs() < 1e-12);
    assert!(impact_times(&Scene { flight, ..scene(0.5) }, &State::at([0.0, 0.0, 0.02]), 0.0, 1).unwrap().is_empty());
}

/// Two planes at right angles, 45° each.
fn groove(restitution: f64, start: &State) -> World {
    let (up, out) = (std::f64::consts::FRAC_1_SQRT_2, std::f64::consts::FRAC_1_SQRT_2);
    let planes = [out, -out].map(|x| Obstacle::half_space(Vector::ZERO, Vector::new(x, 0.0, up)));
    let scene = Scene { friction: 0.0, ..scene(restitution) };
    World::among(&scene, planes.to_vec(), start, 0.0).unwrap()
}

#[test]
fn a_groove_hit_on_both_sides_at_once_gains_no_energy() {
    // Straight down the middle: both planes are touched at the same instant.
    let start = State::at([0.0, 0.0, 1.0]);
    let mut world = groove(1.0, &start);
    let first = 9.81 * start.position_m[2];
    let mut gain = f64::MIN;
    for i in 0..3000 {
        world.advance_to(f64::from(i) / 60.0).unwrap();
        let State { position_m: x, velocity_m_s: v, .. } = world.state();
        let energy = 0.5 * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) + 9.81 * x[2];
        gain = gain.max(energy / first - 1.0);
    }
    eprintln!("groove: {gain:e} after {} impacts", world.impacts().len());
    assert!(gain < 1e-10 && world.impacts().len() > 50);
}

#[test]
fn a_groove_holds_a_ball_that_has_come_to_rest() {
    let start = State { velocity_m_s: [0.2, 0.0, 0.0], ..State::at([0.05, 0.0, 0.5]) };
    let mut world = groove(0.5, &start);
    world.advance_to(100.0).unwrap();
    let x = world.state().position_m;
    assert!(world.is_supported());
    assert!(x[0].abs() < 1e-9 && (x[2] - 0.02 * std::f64::consts::SQRT_2).abs() < 1e-9, "{x:?}");
}

#[test]
fn a_ball_rolls_off_an_edge_and_falls() {
    let table = Obstacle::new(SharedShape::cuboid(0.5, 0.5, 0.1), Pose::from_translation(Vector::Z * -0.1)).unwrap();
    let floor = Obstacle::half_space(Vector::Z * -1.0, Vector::Z);
    let spin_rad_s = [0.0, 1.0 / 0.02, 0.0];
    let start = State { velocity_m_s: [1.0, 0.0, 0.0], spin_rad_s, ..State::at([0.0, 0.0, 0.02]) };
    let mut world = World::among(&scene(0.5), vec![table, floor], &start, 0.0).unwrap();
    world.advance_to(0.49).unwrap();
    assert!((world.state().position_m[2] - 0.02).abs() < 1e-8 && world.impacts().is_empty());
    world.advance_to_impact(1).unwrap();
    let fall = world.impacts()[0].time_s - 0.5;
    // The ball tips over the edge for a moment before it falls 1 m.
    assert!(fall > (2.0_f64 / 9.81).sqrt() - 1e-3 && fall < 0.55, "{fall}");
}
