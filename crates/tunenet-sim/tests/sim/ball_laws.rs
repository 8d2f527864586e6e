//! The simulated ball against formulas: drops, drag, oblique impacts, rolling, energy, and the shape of the error.
//!
//! Run with `--nocapture` to see how far each figure stays below its tolerance.

use crate::closed_form::{Three, add, dot};
use tunenet_sim::ball::{Forces, Scene, State, World, impact_times, positions};

const G: f64 = 9.81;
const FRAMES: usize = 400;

/// The two settings of the drops: radius (m), heights of fall (m), frames a second.
const SETTINGS: [(f64, [f64; 5], f64); 2] =
    [(0.5, [4.0, 4.25, 4.5, 4.77, 5.0], 60.0), (0.02, [1.0, 1.0, 1.0, 1.0, 1.0], 240.0)];

fn scene(radius_m: f64, restitution: f64) -> Scene {
    Scene { radius_m, restitution, gravity_m_s2: G, ..Scene::default() }
}

fn clock(rate_hz: f64, frames: usize) -> Vec<f64> {
    (0..frames).map(|i| i as f64 / rate_hz).collect()
}

/// Heights of the centre (m).
fn heights(scene: &Scene, start: &State, clock: &[f64]) -> Vec<f64> {
    let mut out = vec![f64::NAN; 3 * clock.len()];
    positions(scene, start, 0.0, clock, &mut out).unwrap();
    out.chunks(3).map(|row| row[2]).collect()
}

fn tenths() -> impl Iterator<Item = f64> {
    (0..=10).map(|i| f64::from(i) / 10.0)
}

fn rms(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    (a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>() / a.len() as f64).sqrt()
}

#[test]
fn rebound_over_approach_is_the_restitution() {
    let (mut worst, mut count) = (0.0_f64, 0);
    for (radius, falls, _) in SETTINGS {
        for (e, fall) in tenths().flat_map(|e| falls.map(|fall| (e, fall))) {
            let (scene, start) = (scene(radius, e), State::at([0.0, 0.0, fall + radius]));
            let times = impact_times(&scene, &start, 0.0, 40).unwrap();
            let mut world = World::new(&scene, &start, 0.0).unwrap();
            for (k, time) in times.iter().enumerate() {
                world.advance_to(*time).unwrap();
                let impact = world.impacts()[k];
                assert_eq!(impact.time_s, *time);
                if k == 0 {
                    assert!((impact.approach_m_s - (2.0 * G * fall).sqrt()).abs() < 1e-12);
                    assert!((time - (2.0 * fall / G).sqrt()).abs() < 1e-13);
                }
                let rebound = world.state().velocity_m_s[2];
                // The slowest rebounds are cut off.
                if e * impact.approach_m_s > 1.1e-4 || e == 0.0 {
                    worst = worst.max((rebound / impact.approach_m_s - e).abs());
                    count += 1;
                }
            }
        }
    }
    eprintln!("restitution: {worst:e} over {count} impacts");
    assert!(count > 500 && worst <= 1e-9, "{worst:e} over {count} impacts");
}

#[test]
fn drops_follow_the_closed_form() {
    let mut worst = 0.0_f64;
    for (radius, falls, rate) in SETTINGS {
        let clock = clock(rate, FRAMES);
        for (e, fall) in tenths().flat_map(|e| falls.map(|fall| (e, fall))) {
            let seen = heights(&scene(radius, e), &State::at([0.0, 0.0, fall + radius]), &clock);
            let truth: Vec<_> = clock.iter().map(|t| crate::closed_form::drop(fall, G, e, *t) + radius).collect();
            worst = worst.max(rms(&seen, &truth));
        }
    }
    eprintln!("drop: RMS {worst:e} m");
    assert!(worst <= 1e-6, "{worst:e}");
}

#[test]
fn drag_follows_tanh_and_ln_cosh_arcs() {
    let (fall, radius, clock) = (5.0, 0.03, clock(60.0, FRAMES));
    let (mut worst, mut effect) = (0.0_f64, 0.0_f64);
    for (c, e) in [0.005, 0.0245, 0.1, 0.5, 2.0].into_iter().flat_map(|c| [0.5, 0.8, 0.9, 1.0].map(|e| (c, e))) {
        let flight = Forces { quadratic_drag_1_m: c, ..Forces::default() };
        let start = State::at([0.0, 0.0, fall + radius]);
        let scene = Scene { flight, ..scene(radius, e) };
        assert!(impact_times(&scene, &start, 0.0, 3).unwrap()[2] < 6.0, "several bounces lie within the clock");
        let seen = heights(&scene, &start, &clock);
        for (t, z) in clock.iter().zip(&seen) {
            worst = worst.max((z - radius - crate::closed_form::drop_with_drag(fall, G, e, c, *t)).abs());
        }
        let without: Vec<_> = clock.iter().map(|t| crate::closed_form::drop(fall, G, e, *t) + radius).collect();
        effect = effect.max(rms(&seen, &without));
    }
    eprintln!("drag: at most {worst:e} m, of an effect of {effect} m");
    assert!(effect > 0.2 && worst <= 1e-6, "{worst:e}");
}

/// Lets a ball that touches the surface strike it with this velocity and spin, and reads what comes out.
fn strike(scene: &Scene, velocity_m_s: Three, spin_rad_s: Three) -> (Three, Three) {
    let position_m = add([0.0, 0.0, scene.surface_height_m], scene.radius_m, scene.normal());
    let state = State { position_m, velocity_m_s, spin_rad_s };
    let mut world = World::new(scene, &state, 0.0).unwrap();
    // The touch is found at once; not later than rounding of the place needs.
    world.advance_to(1e-15).unwrap();
    assert_eq!(world.impacts().len(), 1);
    let after = world.state();
    (after.velocity_m_s, after.spin_rad_s)
}

#[test]
fn oblique_impacts_obey_coulomb() {
    let (mut worst, mut slipping, mut count) = (0.0_f64, 0, 0);
    for (tilt_x, tilt_y) in [(0.0, 0.0), (0.3, 0.0), (-0.2, 0.5)] {
        for (e, mu) in [0.1, 0.5, 0.7, 0.95].into_iter().flat_map(|e| [0.0, 0.1, 0.2, 0.3, 0.5].map(|mu| (e, mu))) {
            let scene = Scene {
                friction: mu,
                surface_tilt_about_x_rad: tilt_x,
                surface_tilt_about_y_rad: tilt_y,
                surface_height_m: 0.4,
                ..scene(0.02, e)
            };
            let n = scene.normal();
            for spin in
                [[0.0; 3], [0.0, 50.0, 0.0], [-300.0, 400.0, 100.0], [2000.0, 0.0, 0.0], [800.0, -1100.0, 1466.0]]
            {
                // 4 m/s, half a radian off the normal, in two directions.
                for across in [[1.0, 0.0, 0.0], [-0.6, 0.8, 0.0]] {
                    let flat = add(across, -dot(across, n), n);
                    let v = add([0.0; 3], -4.0 * 0.5_f64.cos(), n);
                    let v = add(v, 4.0 * 0.5_f64.sin() / dot(flat, flat).sqrt(), flat);
                    let (seen_v, seen_w) = strike(&scene, v, spin);
                    let (true_v, true_w) = crate::closed_form::impact(n, 0.02, e, mu, v, spin);
                    for axis in 0..3 {
                        worst = worst.max((seen_v[axis] - true_v[axis]).abs());
                        worst = worst.max((seen_w[axis] - true_w[axis]).abs());
                    }
                    let (_, stuck) = crate::closed_form::impact(n, 0.02, e, f64::INFINITY, v, spin);
                    slipping += usize::from(mu > 0.0 && stuck != true_w);
                    count += 1;
                }
            }
        }
    }
    eprintln!("oblique: {worst:e} m/s or rad/s over {count} impacts, {slipping} slip throughout");
    assert!(slipping > 100 && slipping < count - 100, "both sorts of friction are tried: {slipping} of {count}");
    assert!(worst <= 1e-8, "{worst:e}");
}

#[test]
fn a_ball_rolls_down_an_incline_with_five_sevenths() {
    let mut worst = 0.0_f64;
    // The least friction that holds is 2/7·tan(tilt); the last ones slide.
    for (tilt, mu, share) in
        [(0.1, 0.3, true), (0.5, 0.2, true), (1.2, 0.8, true), (0.5, 0.1, false), (0.5, 0.0, false)]
    {
        let scene = Scene { surface_tilt_about_y_rad: tilt, friction: mu, ..scene(0.03, 0.6) };
        let start = State::at(add([0.0; 3], 0.03, scene.normal()));
        let pull = if share { 5.0 / 7.0 * G * tilt.sin() } else { G * (tilt.sin() - mu * tilt.cos()) };
        for clock in [clock(60.0, 200), clock(7.0, 30)] {
            let mut out = vec![0.0; 3 * clock.len()];
            positions(&scene, &start, 0.0, &clock, &mut out).unwrap();
            for (t, row) in clock.iter().zip(out.chunks(3)).skip(1) {
                let moved = add([row[0], row[1], row[2]], -1.0, start.position_m);
                assert!(moved[0] > 0.0 && dot(moved, scene.normal()).abs() < 1e-9);
                worst = worst.max((dot(moved, moved).sqrt() / (0.5 * pull * t * t) - 1.0).abs());
            }
        }
    }
    eprintln!("incline: {worst:e} of the distance");
    assert!(worst <= 1e-4, "{worst:e}");
}

#[test]
fn a_sliding_ball_ends_up_rolling() {
    // Sliding with −μ·g lasts 2·v/(7·μ·g); then 5/7 of the speed is left for good.
    let (v, mu) = (2.0, 0.2);
    let scene = Scene { friction: mu, ..scene(0.03, 0.5) };
    let start = State { velocity_m_s: [v, 0.0, 0.0], ..State::at([0.0, 0.0, 0.03]) };
    let mut world = World::new(&scene, &start, 0.0).unwrap();
    world.advance_to(3.0).unwrap();
    let turn = 2.0 * v / (7.0 * mu * G);
    let truth = v * turn - 0.5 * mu * G * turn * turn + 5.0 / 7.0 * v * (3.0 - turn);
    let (seen, speed) = (world.state().position_m[0], world.state().velocity_m_s[0]);
    eprintln!("slide to roll: {:e} m, {:e} m/s", seen - truth, speed - 5.0 / 7.0 * v);
    assert!((seen - truth).abs() < 1e-4 && (speed - 5.0 / 7.0 * v).abs() < 1e-9);
    assert!((world.state().spin_rad_s[1] * 0.03 - speed).abs() < 1e-9);
}

#[test]
fn full_restitution_gains_no_energy() {
    let (mut gain, mut loss) = (f64::MIN, f64::MAX);
    for (radius, fall, rate) in [(0.5, 5.0, 60.0), (0.02, 1.0, 240.0)] {
        let start = State { velocity_m_s: [0.3, 0.0, 0.0], ..State::at([0.0, 0.0, fall + radius]) };
        let scene = Scene { friction: 0.0, ..scene(radius, 1.0) };
        let mut world = World::new(&scene, &start, 0.0).unwrap();
        let energy = |state: State| 0.5 * dot(state.velocity_m_s, state.velocity_m_s) + G * state.position_m[2];
        let first = energy(start);
        for time in clock(rate, 6000) {
            world.advance_to(time).unwrap();
            let change = energy(world.state()) / first - 1.0;
            (gain, loss) = (gain.max(change), loss.min(change));
        }
        assert!(world.impacts().len() > 20);
    }
    eprintln!("energy: +{gain:e}, {loss:e}");
    assert!(gain <= 1e-12 && loss >= -1e-10, "+{gain:e}, {loss:e}");
}

/// A tuner that walks downhill finds the one minimum. Fixed steps of 1/60 s in the same engine give 3, 6, 24 and 36 minima
/// on this grid instead, because the phase of the step decides how deep each contact starts.
#[test]
fn the_error_over_restitution_has_one_minimum() {
    let clock = clock(60.0, FRAMES);
    let start = State::at([0.0, 0.0, 5.0]);
    let roll = |e: f64| heights(&scene(0.5, e), &start, &clock);
    let grid: Vec<_> = (0..=400).map(|i| roll(f64::from(i) / 400.0)).collect();
    for (target, place) in [(0.3, 120), (0.5, 200), (0.7, 280), (0.9, 360)] {
        let truth: Vec<_> = clock.iter().map(|t| crate::closed_form::drop(4.5, G, target, *t) + 0.5).collect();
        let mut error: Vec<_> = grid.iter().map(|seen| rms(seen, &truth).powi(2)).enumerate().collect();
        // Bounces that begin and end between two frames leave no trace: next to e = 0 equal bits make one level stretch.
        error.dedup_by(|next, kept| next.1 == kept.1);
        let below = |i: usize, j: usize| error.get(j).is_none_or(|other| error[i].1 < other.1);
        let minima: Vec<_> =
            (0..error.len()).filter(|i| below(*i, i.wrapping_sub(1)) && below(*i, i + 1)).map(|i| error[i].0).collect();
        eprintln!("minima for {target}: {minima:?}");
        assert_eq!(minima, [place]);
    }
}

#[test]
fn reruns_are_equal_to_the_bit() {
    let roll = || {
        let flight = Forces { quadratic_drag_1_m: 0.02, magnus_1_s: [0.1, -0.2, 0.3], ..Forces::default() };
        let tilted = Scene { surface_tilt_about_x_rad: 0.05, flight, ..scene(0.03, 0.8) };
        let start =
            State { spin_rad_s: [30.0, 5.0, -80.0], velocity_m_s: [1.0, 2.0, 0.0], ..State::at([0.0, 0.0, 2.0]) };
        let clock = clock(60.0, 600);
        let mut out = vec![0.0; 3 * clock.len()];
        positions(&tilted, &start, 0.0, &clock, &mut out).unwrap();
        positions(&scene(0.5, 0.7), &State::at([0.0, 0.0, 5.0]), 0.0, &clock, &mut out[..])
            .map(|()| out.clone())
            .unwrap();
        let mut both = out.clone();
        positions(&tilted, &start, 0.0, &clock, &mut out).unwrap();
        both.extend(out);
        both.into_iter().map(f64::to_bits).collect::<Vec<_>>()
    };
    let first = roll();
    let others: Vec<_> = (0..4).map(|_| std::thread::spawn(move || (roll(), roll()))).collect();
    for other in others {
        let (one, two) = other.join().unwrap();
        assert!(one == first && two == first);
    }
}
