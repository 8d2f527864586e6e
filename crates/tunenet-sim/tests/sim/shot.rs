//! The bounce shot against closed forms and an integrator of its own.

use std::path::Path;

use crate::closed_form::{add, dot};
use crate::independent::World;
use tunenet_core::Result;
use tunenet_sim::SimulationFile;
use tunenet_sim::ball::{Contact, Forces, Scene, State};
use tunenet_sim::shot::reach::Anywhere;
use tunenet_sim::shot::{Belief, Pass, Reach, Rule, Settings, ShotScene, Task, plan};

const RADIUS_M: f64 = 0.03;
const G: f64 = 9.81;

fn task() -> Task {
    Task::parse(Path::new("shot.toml"), include_str!("../../../../assets/shot.toml")).unwrap()
}

fn scene() -> ShotScene {
    ShotScene::new(&task(), RADIUS_M).unwrap()
}

fn ball(restitution: f64) -> Scene {
    Scene { restitution, friction: 0.0, radius_m: RADIUS_M, ..Scene::default() }
}

fn file(more: &str) -> SimulationFile {
    let text = format!(
        "kind = \"ball\"\nball.radius_m = {RADIUS_M}\n[parameters.restitution]\nvalue = 0.7\nmin = 0.0\nmax = 1.0\n{more}"
    );
    SimulationFile::parse(Path::new("ball.toml"), &text).unwrap()
}

/// Velocity after a fall of `height` and a bounce on the plane of 30°, without friction.
fn thrown(e: f64, height: f64) -> (f64, f64) {
    let (speed, tilt) = ((2.0 * G * height).sqrt(), std::f64::consts::FRAC_PI_6);
    let into = speed * tilt.cos();
    ((1.0 + e) * into * tilt.sin(), -speed + (1.0 + e) * into * tilt.cos())
}

/// Where the parabola falls through the hoop's plane: (vx t) with vz t − g t²/2 = −0.3.
#[test]
fn a_parabola_crosses_the_hoop_where_the_formula_says() {
    for (e, height) in [(0.62, 0.7), (0.7, 0.5), (0.79, 0.42)] {
        let (vx, vz) = thrown(e, height);
        let t = (vz + (vz * vz + 2.0 * G * 0.3).sqrt()) / G;
        let flight = scene().fly(&ball(e), &State::at([0.0, 0.0, height])).unwrap();
        let pass = Pass::judge(&flight, &scene().hoop, RADIUS_M);
        assert!(pass.falls && (pass.miss_m - (vx * t - 0.8).abs()).abs() < 1e-9, "{e} {height}: {pass:?}");
        assert!((flight.bounce_s - (2.0 * height / G).sqrt()).abs() < 1e-12);
    }
}

/// The rim's nearest point by brute force over the parabola and the circle.
#[test]
fn the_clearance_is_the_least_distance_to_the_circle() {
    for (e, height) in [(0.7, 0.5), (0.7, 0.56), (0.8, 0.45)] {
        let (vx, vz) = thrown(e, height);
        let mut least = f64::INFINITY;
        for i in 0..200_000_i32 {
            let t = 1e-5 * f64::from(i);
            let (x, z) = (vx * t - 0.8, vz * t - 0.5 * G * t * t + 0.3);
            if z > -0.2 {
                least = least.min((x.abs() - 0.11).hypot(z));
            }
        }
        let flight = scene().fly(&ball(e), &State::at([0.0, 0.0, height])).unwrap();
        let found = Pass::judge(&flight, &scene().hoop, RADIUS_M).clearance_m;
        assert!((found - least).abs() < 1e-6, "{e} {height}: {found} {least}");
    }
}

/// Drag, friction, wind and a contact that lasts, by Runge–Kutta in steps of 1/20000 s and the impulse formulas.
#[test]
fn a_shot_with_drag_and_friction_is_the_independent_integrators() {
    let task = task();
    let tilted = Scene {
        surface_tilt_about_x_rad: task.plane.tilt_rad()[0],
        surface_tilt_about_y_rad: task.plane.tilt_rad()[1],
        ..Scene::default()
    };
    let height = -RADIUS_M / tilted.normal()[2];
    for (drag, friction, wind, duration) in
        [(0.1, 0.0, 0.0, 0.0), (0.06, 0.04, 0.0, 0.0), (0.02, 0.3, 0.4, 0.0), (0.02, 0.02, 0.0, 0.004)]
    {
        let flight = Forces { quadratic_drag_1_m: drag, wind_m_s2: [wind, -wind], ..Forces::default() };
        let contact = Contact { duration_s: duration, ..Contact::default() };
        let real = Scene { friction, flight, contact, ..ball(0.75) };
        let found = scene().fly(&real, &State::at([0.0, 0.0, 0.5])).unwrap();
        let truth = World {
            gravity: G,
            radius: RADIUS_M,
            height,
            restitution: 0.75,
            friction,
            x: [0.0, 0.0, 0.5],
            quadratic: drag,
            wind: [wind, -wind],
            tilt: task.plane.tilt_rad(),
            duration,
            ..World::default()
        };
        // The last states may lie below the plane, which acts once here and again there.
        let after = &found.states[found.bounce..];
        let clock: Vec<f64> = (0..after.len()).map(|k| found.bounce_s + k as f64 * found.step_s).collect();
        let clear = after.iter().position(|s| s.position_m[2] < -0.3).unwrap();
        let expected = truth.positions(&clock[..clear]);
        for (state, truth) in after.iter().zip(expected.chunks_exact(3)) {
            let off = add(state.position_m, -1.0, [truth[0], truth[1], truth[2]]);
            assert!(dot(off, off).sqrt() < 2e-7, "drag {drag}, friction {friction}: {off:?}");
        }
    }
}

/// Rapier's capsules stop exactly those balls whose path comes too near to the circle.
#[test]
fn a_ball_touches_the_capsules_where_its_clearance_is_less_than_its_radius() {
    let (scene, mut touched) = (scene(), 0);
    for i in 0..120 {
        let (height, aside) = (0.4 + 0.002 * f64::from(i), 0.015 * f64::from(i % 7) - 0.045);
        let ball = ball(0.72);
        let flight = scene.fly(&ball, &State::at([0.0, aside, height])).unwrap();
        let pass = Pass::judge(&flight, &scene.hoop, RADIUS_M);
        // The chords leave the circle by a tenth of a millimetre.
        if (pass.clearance_m - RADIUS_M).abs() < 2e-4 {
            continue;
        }
        let end = flight.step_s * (flight.states.len() - 2) as f64;
        let (path, touches) = scene.among_rim(&ball, &flight.states[flight.bounce], (0.0, flight.step_s, end)).unwrap();
        assert_eq!(touches, pass.clearance_m < RADIUS_M, "{height} {aside}: {pass:?}");
        assert_eq!(pass.goes_in(), !touches && pass.falls && pass.miss_m < scene.hoop.radius_m);
        assert!(touches || path[5] == flight.states[flight.bounce + 5]);
        touched += i32::from(touches);
    }
    assert!((20..100).contains(&touched), "{touched}");
}

fn planned(file: &SimulationFile, rule: Rule) -> tunenet_sim::shot::Plan {
    let (task, settings) = (task(), Settings { rule, ..Settings::default() });
    let belief = Belief::new(file, &task).unwrap();
    plan(&scene(), &belief, task.release.heights_m, &Anywhere, &settings).unwrap()
}

#[test]
fn the_nearest_height_is_that_of_the_formula() {
    let found = planned(&file(""), Rule::Nearest);
    let miss = |height: f64| {
        let (vx, vz) = thrown(0.7, height);
        (vx * (vz + (vz * vz + 2.0 * G * 0.3).sqrt()) / G - 0.8).abs()
    };
    let heights: Vec<f64> = (0..100).map(|i| 0.3 + 0.7 * f64::from(i) / 99.0).collect();
    let best = heights.into_iter().min_by(|a, b| miss(*a).total_cmp(&miss(*b))).unwrap();
    assert!((found.best().height_m - best).abs() < 1e-12 && found.reachable);
    assert!((found.best().pass.miss_m - miss(best)).abs() < 1e-9);
    assert_eq!(found.best().probability, Some(1.0));
}

/// How often an interval of the restitution goes in, by the window in which a shot of the chosen height does.
#[test]
fn the_probability_is_the_share_of_the_interval_that_goes_in() {
    let tuned = "\n[provenance]\nverdict = \"tuned\"\ninterval95 = { restitution = [0.6, 0.8] }\n";
    let found = planned(&file(tuned), Rule::Probability);
    let height = found.best().height_m;
    let goes_in = |e: f64| {
        let flight = scene().fly(&ball(e), &State::at([0.0, 0.0, height])).unwrap();
        Pass::judge(&flight, &scene().hoop, RADIUS_M).goes_in()
    };
    // The normal distribution's share, by a sum over its density.
    let sd = 0.1 / 1.959_964;
    let (mut inside, mut all) = (0.0, 0.0);
    for i in -400..=400_i32 {
        let z = 0.01 * f64::from(i);
        let weight = (-0.5 * z * z).exp();
        all += weight;
        inside += if goes_in(0.7 + sd * z) { weight } else { 0.0 };
    }
    let (expected, stated) = (inside / all, found.best().probability.unwrap());
    // 256 draws: a standard error of 0.03.
    assert!((0.3..0.95).contains(&expected) && (stated - expected).abs() < 0.09, "{stated} {expected}");
    let nearest = planned(&file(tuned), Rule::Nearest);
    assert!(stated >= nearest.best().probability.unwrap());
}

#[test]
fn every_alternative_has_its_weight() {
    let two = "\n[provenance]\nverdict = \"one_of\"\nalternatives = [\
        { name = \"quadratic_drag\", c_1_m = 0.0, restitution = 0.7, weight = 3.0 }, \
        { name = \"linear_drag\", b_1_s = 0.0, restitution = 0.2, weight = 1.0 }]\n";
    let found = planned(&file(two), Rule::Probability);
    assert_eq!(found.best().probability, Some(0.75));
    let alone = planned(&file("\n[provenance]\nverdict = \"one_of\"\n"), Rule::Probability);
    assert_eq!(alone.best().probability, Some(1.0));
    let belief = Belief::new(&file("\n[provenance]\nverdict = \"one_of\"\n"), &task()).unwrap();
    assert_eq!(belief.notes()[0].kind.code(), "plan.one_explanation");
    assert_eq!(Belief::new(&file(""), &task()).unwrap().notes()[0].kind.code(), "plan.untuned");
}

/// Of a file whose drag is open, every strength has its share; the file's own numbers stay what is drawn and what `nearest`
/// goes by, and a drag that the file holds closes the matter.
#[test]
fn a_drag_that_is_open_is_planned_for() {
    let open = "\n[provenance]\nverdict = \"tuned\"\nopen_drag = [\
        { c_1_m = 0.0, restitution = 0.7, weight = 0.75 }, { c_1_m = 9.0, restitution = 0.7, weight = 0.25 }]\n";
    let found = planned(&file(open), Rule::Probability);
    assert_eq!(found.best().probability, Some(0.75));
    let belief = Belief::new(&file(open), &task()).unwrap();
    assert_eq!(belief.notes()[0].kind.code(), "plan.open_drag");
    assert_eq!(belief.nominal(), Belief::new(&file(""), &task()).unwrap().nominal());
    // Of another value than was tuned, nothing is known of the drag beside it; what is not as it was written is told.
    let edited = open.replace("verdict", "interval95 = { restitution = [0.79, 0.81] }\nverdict");
    let edited = Belief::new(&file(&edited), &task()).unwrap();
    assert_eq!(edited.notes().iter().map(|n| n.kind.code()).collect::<Vec<_>>(), ["plan.changed"]);
    assert!(edited.draws(8, 0).iter().all(|d| d.ball.flight.quadratic_drag_1_m == 0.0));
    for (from, to) in
        [("c_1_m = 9.0", "c_1_m = \"9\""), ("c_1_m = 9.0", "c_1_m = 1e308"), ("0.25", "-0.25"), ("0.7,", "5.0,")]
    {
        let broken = Belief::new(&file(&open.replacen(from, to, 1)), &task()).unwrap();
        assert!(broken.notes()[0].text.contains("not in tunenet's form"), "{to}: {:?}", broken.notes());
        assert!(broken.draws(8, 0).iter().all(|d| d.ball.flight.quadratic_drag_1_m == 0.0), "{to}");
    }
    let closed = Belief::new(&file(&format!("[effects.quadratic_drag]\nc_1_m = 0.02\n{open}")), &task()).unwrap();
    assert!(closed.notes().is_empty(), "{:?}", closed.notes());
    // An interval beside a value is drawn from; one that does not hold it is not believed.
    let spread = |interval: &str| {
        let one = format!(
            "\n[provenance]\nverdict = \"tuned\"\nopen_drag = [{{ c_1_m = 0.0, restitution = 0.7, \
             restitution_interval95 = {interval}, weight = 1.0 }}]\n"
        );
        planned(&file(&one), Rule::Probability).best().probability.unwrap()
    };
    assert!(spread("[0.5, 0.9]") < 0.8 && spread("[0.1, 0.2]") == 1.0);
}

#[test]
fn what_scatters_lowers_the_chance() {
    let sure = planned(&file("[effects.bounce_scatter]\nsd_rad = 0.0\n"), Rule::Probability);
    let uneven = planned(&file("[effects.bounce_scatter]\nsd_rad = 0.1\n"), Rule::Probability);
    assert_eq!(sure.best().probability, Some(1.0));
    assert!((0.2..0.8).contains(&uneven.best().probability.unwrap()), "{:?}", uneven.best());
}

#[test]
fn a_hoop_out_of_reach_is_missed_by_as_much_as_is_said() {
    let mut far = task();
    far.hoop.centre_m = [4.0, 0.0, -0.3];
    let scene = ShotScene::new(&far, RADIUS_M).unwrap();
    let belief = Belief::new(&file(""), &far).unwrap();
    let found = plan(&scene, &belief, far.release.heights_m, &Anywhere, &Settings::default()).unwrap();
    assert!(!found.reachable && found.best().height_m == 1.0 && found.best().probability == Some(0.0));
    let (vx, vz) = thrown(0.7, 1.0);
    let lands = vx * (vz + (vz * vz + 2.0 * G * 0.3).sqrt()) / G;
    assert!((found.best().pass.miss_m - (4.0 - lands)).abs() < 1e-9);
}

/// A hand that shakes by more than the height: some balls start below the plane, and miss.
#[test]
fn a_release_below_the_plane_is_a_miss() {
    let mut shaky = task();
    shaky.release.position_sd_m = 0.4;
    let belief = Belief::new(&file(""), &shaky).unwrap();
    let found = plan(&scene(), &belief, shaky.release.heights_m, &Anywhere, &Settings::default()).unwrap();
    assert!((0.0..0.3).contains(&found.best().probability.unwrap()), "{:?}", found.best());
}

/// An arm that is 60 cm long.
struct Short;

impl Reach for Short {
    fn joints(&self, [_, _, z]: [f64; 3], _: Option<&[f64]>) -> Result<Option<Vec<f64>>> {
        Ok((z < 0.45).then(|| vec![z]))
    }
}

#[test]
fn only_heights_within_reach_are_chosen() {
    let belief = Belief::new(&file(""), &task()).unwrap();
    let found = plan(&scene(), &belief, task().release.heights_m, &Short, &Settings::default()).unwrap();
    assert!(found.best().height_m < 0.45 && found.best().joints_rad == Some(vec![found.best().height_m]));
    let none = plan(&scene(), &belief, (0.5, 1.0), &Short, &Settings::default()).unwrap_err();
    assert!(none.to_string().contains("the arm reaches none of the heights from 0.5 to 1 m"), "{none}");
}

#[test]
fn scenes_that_make_no_sense_are_refused() {
    let refused = |change: &dyn Fn(&mut Task), wanted: &str| {
        let mut task = task();
        change(&mut task);
        let found = ShotScene::new(&task, RADIUS_M).err().map(|e| e.message).unwrap_or_default();
        assert!(found.contains(wanted), "{found}");
    };
    refused(&|t| t.plane.tilt_about_y_rad = -0.5, "the plane faces away from the hoop");
    refused(&|t| t.plane.tilt_about_y_rad = 0.0, "the plane faces away from the hoop");
    refused(&|t| t.hoop.radius_m = 0.02, "a hoop that the ball fits through");
    refused(&|t| t.hoop.centre_m = [0.1, 0.0, 0.2], "the hoop stands in the way of the falling ball");
    let dead = "kind = \"ball\"\nball.radius_m = 0.03\n";
    let dead = SimulationFile::parse(Path::new("dead.toml"), dead).unwrap();
    let refusal = Belief::new(&dead, &task()).unwrap_err();
    assert!(refusal.to_string().contains("dead.toml: expected a restitution above 0, found none"), "{refusal}");
}

#[test]
fn equal_seeds_plan_equally() {
    let tuned = file("\n[provenance]\nverdict = \"tuned\"\ninterval95 = { restitution = [0.6, 0.8] }\n");
    assert_eq!(planned(&tuned, Rule::Probability), planned(&tuned, Rule::Probability));
}
