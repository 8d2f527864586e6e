//! Verdicts on a simulator of the tests' own, judged by truth in closed form.

mod constant_input;
mod glider;
pub(in crate::diagnose) mod zoo;

use super::*;
use crate::diagnose::tests::zoo::{LEVER_FRICTION, NOISE_NM};
use crate::findings;
use crate::observation::Observation;
use crate::testing::Levers;
use glider::{Glider, Truth, glides};

fn ask(seen: &[&[Observation]], settings: &Settings) -> Diagnosis {
    let gliders: Vec<Glider> = seen.iter().map(|_| Glider::new()).collect();
    let subjects: Vec<Subject> =
        gliders.iter().enumerate().map(|(i, g)| Subject { name: format!("glider {i}"), simulator: g }).collect();
    let recordings: Vec<Recording> = seen
        .iter()
        .enumerate()
        .flat_map(|(object, all)| {
            all.iter().enumerate().map(move |(i, seen)| Recording {
                name: format!("glide {object}.{i}"),
                object,
                held_out: false,
                seen,
            })
        })
        .collect();
    diagnose(&subjects, &recordings, settings, &|_| {}).unwrap()
}

fn verdict_of(truth: Truth, count: usize, seed: u64) -> Diagnosis {
    ask(&[&glides(truth, count, 180, seed)], &Settings::default())
}

#[test]
fn a_glider_without_anything_missing_gets_none() {
    for seed in 0..20 {
        let found = verdict_of(Truth { push: 0.4, ..Truth::default() }, 3, seed);
        assert_eq!(found.verdict(), Verdict::None, "seed {seed}: {:?} {:?}", found.names(), found.adequacy);
        assert!((found.parameters[0].value - 0.4).abs() < 0.02, "{:?}", found.parameters);
    }
}

#[test]
fn a_name_in_doubt_stays_with_its_effect_and_no_other_verdict_changes() {
    let found = verdict_of(Truth { push: 0.3, drag: 0.15, ..Truth::default() }, 5, 1).doubted(Doubt::Unconfirmed);
    assert_eq!((found.verdict(), found.names(), found.effects().len()), (Verdict::OneOf, vec!["linear_drag"], 1));
    assert_eq!(found.conclusion.doubt(), Some(&Doubt::Unconfirmed));
    assert!(found.objects.iter().all(|object| object.verdict == Verdict::OneOf), "{:?}", found.objects);
    let nothing = verdict_of(Truth { push: 0.4, ..Truth::default() }, 3, 0).doubted(Doubt::Unconfirmed);
    assert_eq!(nothing.verdict(), Verdict::None);
    let reopened = nothing.reopened("a force is left".into());
    assert_eq!((reopened.verdict(), reopened.conclusion.description()), (Verdict::Unknown, Some("a force is left")));
    assert_eq!(found.clone().reopened(String::new()).verdict(), Verdict::OneOf);
}

#[test]
fn drag_is_named_with_its_size_and_proven_on_a_glide_set_aside() {
    let truth = Truth { push: 0.3, drag: 0.15, ..Truth::default() };
    let found = verdict_of(truth, 5, 1);
    assert_eq!((found.verdict(), found.names().as_slice()), (Verdict::Named, ["linear_drag"].as_slice()));
    let value = &found.effects()[0].coefficients[0].values[0];
    let half = 0.5 * (value.interval95.1 - value.interval95.0);
    assert!((value.value - 0.15).abs() < 2.0 * half && half < 0.02, "{value:?}");
    let gap = found.gap.unwrap();
    let held_out = gap.held_out.unwrap();
    assert_eq!(found.uses.iter().filter(|u| u.held_out).count(), 1);
    assert!(held_out.after < 0.8 * held_out.before && held_out.after < 1.15 * gap.noise_floor, "{gap:?}");
    assert!(gap.control.as_ref().unwrap().1 > held_out.after, "a wrong effect does not reach it: {gap:?}");
}

#[test]
fn what_no_glide_separates_is_reported_together_with_what_would() {
    let found = verdict_of(Truth { more_gravity: 0.3, ..Truth::default() }, 3, 2);
    assert_eq!(found.verdict(), Verdict::OneOf);
    for twin in ["effective_gravity", "length_scale", "time_scale"] {
        assert!(found.names().contains(&twin), "{twin} in {:?}", found.names());
    }
    let text = found.next_experiment.unwrap().text;
    assert!(text.starts_with("no motion distinguishes") && text.contains("known length"), "{text}");
}

#[test]
fn what_is_in_no_catalogue_is_unknown_and_described() {
    let found = verdict_of(Truth { sway_m: 0.02, ..Truth::default() }, 3, 3);
    assert_eq!(found.verdict(), Verdict::Unknown, "{:?}", found.names());
    assert!(found.effects().is_empty() && found.adequacy.iter().any(|t| !t.passed));
    assert!(found.conclusion.description().unwrap().contains("along z"));
}

#[test]
fn a_single_glide_earns_no_lone_name() {
    let found = verdict_of(Truth { drag: 0.01, ..Truth::default() }, 1, 4);
    assert!(matches!(found.verdict(), Verdict::OneOf | Verdict::None), "{:?} {:?}", found.verdict(), found.names());
    let found = verdict_of(Truth { drag: 0.02, ..Truth::default() }, 1, 5);
    assert_eq!(found.verdict(), Verdict::OneOf);
    assert!(found.names().len() > 1 && found.names().contains(&"linear_drag"), "{:?}", found.names());
}

#[test]
fn a_handful_of_samples_is_insufficient() {
    let found = ask(&[&glides(Truth::default(), 1, 6, 6)], &Settings::default());
    assert_eq!(found.verdict(), Verdict::Insufficient);
    assert!(found.notes.iter().any(|n| n.kind == findings::RECORDINGS_SHORT));
    assert_eq!(ask(&[&[]], &Settings::default()).verdict(), Verdict::Insufficient);
}

#[test]
fn each_object_has_its_own_size_of_a_shared_effect() {
    let (light, heavy) = (Truth { drag: 0.3, ..Truth::default() }, Truth { drag: 0.05, push: 1.0, ..Truth::default() });
    let found = ask(&[&glides(light, 3, 180, 7), &glides(heavy, 3, 180, 8)], &Settings::default());
    assert_eq!((found.verdict(), found.names().as_slice()), (Verdict::Named, ["linear_drag"].as_slice()));
    let values = &found.effects()[0].coefficients[0].values;
    assert!((values[0].value - 0.3).abs() < 0.03 && (values[1].value - 0.05).abs() < 0.03, "{values:?}");
    assert!((found.parameters[1].value - 1.0).abs() < 0.05 && found.parameters[1].object == 1);
}

/// The drag of a glider that has none is not needed: its push is fitted anew, and its gap is its noise.
#[test]
fn an_object_that_does_not_show_an_effect_is_fitted_without_it() {
    let (light, heavy) = (Truth { drag: 0.3, ..Truth::default() }, Truth { push: 1.0, ..Truth::default() });
    let found = ask(&[&glides(light, 3, 180, 7), &glides(heavy, 3, 180, 8)], &Settings::default());
    assert_eq!((found.verdict(), found.names().as_slice()), (Verdict::Named, ["linear_drag"].as_slice()));
    let own: Vec<_> = found.objects.iter().map(|one| (one.effects[0].shown, one.effects[0].needed)).collect();
    assert_eq!(own, [(true, true), (false, false)]);
    assert_eq!(found.objects[1].verdict, Verdict::None);
    let alone = ask(&[&glides(heavy, 3, 180, 8)], &Settings::default());
    let (both, one) = (&found.parameters[1], &alone.parameters[0]);
    assert!((both.value - one.value).abs() < 1e-6, "{both:?} {one:?}");
    let whole: Vec<_> = found.gaps.iter().filter(|gap| gap.channel.is_none()).collect();
    assert!(whole.len() == 2 && whole.iter().all(|gap| gap.after < 1.2 * gap.noise_floor), "{whole:?}");
    assert!(whole[0].before > 2.0 * whole[0].after && whole[1].before < 1.05 * whole[1].after);
}

/// What lacks nothing is tuned: parameters and intervals are those of tuning the same recordings.
#[test]
fn a_diagnosis_of_nothing_states_the_intervals_of_tuning() {
    let seen = glides(Truth { push: 0.4, ..Truth::default() }, 2, 180, 12);
    let found = ask(&[&seen], &Settings { set_aside: false, ..Settings::default() });
    assert_eq!(found.verdict(), Verdict::None);
    let tuned = crate::tune::tune(&Glider::new(), &seen, None, &crate::tune::Settings::default()).unwrap();
    let (ours, theirs) = (&found.parameters[0], &tuned.parameters[0]);
    let half = 0.5 * (theirs.interval95.1 - theirs.interval95.0);
    for (a, b) in
        [(ours.value, theirs.value), (ours.interval95.0, theirs.interval95.0), (ours.interval95.1, theirs.interval95.1)]
    {
        assert!((a - b).abs() < 0.01 * half, "{ours:?} {theirs:?}");
    }
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let seen = glides(Truth { drag: 0.15, ..Truth::default() }, 3, 180, 9);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| format!("{:?}", ask(&[&seen], &Settings::default())))
    };
    assert_eq!(with(1), with(4));
}

/// A limit holds on any number of threads and leaves no answer; one that suffices does not change the answer.
#[test]
fn a_limit_on_rollouts_is_kept() {
    let seen = glides(Truth { drag: 0.15, ..Truth::default() }, 3, 180, 9);
    let limited = |most: Option<usize>, threads: usize| {
        let settings = Settings { max_rollouts: most, ..Settings::default() };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| ask(&[&seen], &settings))
    };
    let whole = limited(None, 2);
    for most in [1, 60, whole.rollouts / 2] {
        let short = limited(Some(most), 1);
        assert_eq!((short.verdict(), short.rollouts), (Verdict::Insufficient, most));
        assert!(short.notes.iter().any(|note| note.kind == crate::findings::ROLLOUTS_LIMIT), "{:?}", short.notes);
        assert_eq!(format!("{short:?}"), format!("{:?}", limited(Some(most), 4)));
    }
    assert_eq!(format!("{whole:?}"), format!("{:?}", limited(Some(whole.rollouts), 2)));
}

#[test]
fn a_quick_diagnosis_takes_fewer_rollouts_and_names_the_same() {
    let seen = glides(Truth { drag: 0.15, ..Truth::default() }, 1, 180, 9);
    let [whole, quick] = [false, true].map(|quick| ask(&[&seen], &Settings { quick, ..Settings::default() }));
    assert!(whole.next_experiment.is_some() && quick.next_experiment.is_none());
    assert_eq!((whole.verdict(), whole.names()), (quick.verdict(), quick.names()));
    assert!(quick.rollouts < whole.rollouts, "{} {}", quick.rollouts, whole.rollouts);
}

#[test]
fn settings_out_of_range_are_refused() {
    let glider = Glider::new();
    let subjects = [Subject { name: "glider".into(), simulator: &glider }];
    let settings = Settings { margin: f64::NAN, ..Settings::default() };
    assert!(diagnose(&subjects, &[], &settings, &|_| {}).is_err());
    let seen = &glides(Truth::default(), 1, 60, 1)[0];
    let lost = [Recording { name: "a".into(), object: 3, held_out: false, seen }];
    assert!(diagnose(&subjects, &lost, &Settings::default(), &|_| {}).is_err());
}

/// A driven recording needs no second one: its end is held out, and a joint in which the effect cannot be seen says so.
#[test]
fn a_single_driven_recording_names_an_effect_in_the_joint_that_shows_it() {
    let levers = Levers::new().unwrap();
    let seen = levers.observe(&[("inertia", 1.4), (LEVER_FRICTION, 0.5)], NOISE_NM, 3).unwrap();
    let subjects = [Subject { name: "levers".into(), simulator: &levers }];
    let recordings = [Recording { name: "run".into(), object: 0, held_out: false, seen: &seen }];
    let found = diagnose(&subjects, &recordings, &Settings::default(), &|_| {}).unwrap();
    assert_eq!((found.verdict(), found.names().as_slice()), (Verdict::Named, ["viscous_friction"].as_slice()));
    let values: Vec<_> =
        found.effects()[0].coefficients.iter().map(|c| (c.values[0].value, c.values[0].interval95)).collect();
    assert!((values[0].0 - 0.5).abs() < 0.01 && values[0].1.0 < 0.5 && 0.5 < values[0].1.1, "{values:?}");
    assert_eq!(values[1], (0.0, (0.0, 20.0)), "the second lever is held");
    assert!(found.gap.unwrap().held_out.is_some_and(|gap| gap.after < 1.2 * NOISE_NM * 2.0f64.sqrt()));
}
