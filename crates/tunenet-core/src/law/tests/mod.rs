//! Searches on a point that moves along a line: truths are closed forms, which share nothing with its integrator.

pub(super) mod line;

use line::{Line, observed};

use super::around::Around;
use super::colour::Colour;
use super::refit::Session;
use super::term::{Factor, Term};
use super::{Sample, Settings, Shape, Verdict, search};
use crate::estimate::RolloutLog;
use crate::observation::Observation;
use crate::simulator::{Preparation, Prepared, Simulator};

const NOISE_M: f64 = 1e-3;
const SECONDS: f64 = 1.5;
/// Initial speeds (m/s) of recordings to fit, and of held-out ones.
const SPEEDS: [f64; 3] = [-0.5, 2.0, -3.0];
const AHEAD: [f64; 2] = [1.0, -2.0];

/// Falls with quadratic resistance: v = −u tanh(g t/u + b), where tanh is replaced by tan while the point rises.
fn quadratic(g: f64, u: f64, v0: f64, t: f64) -> f64 {
    let falling = |v: f64, t: f64| {
        let b = (-v / u).atanh();
        -(u * u / g) * ((g * t / u + b).cosh() / b.cosh()).ln()
    };
    if v0 <= 0.0 {
        return falling(v0, t);
    }
    let b = (v0 / u).atan();
    let top = b * u / g;
    let risen = |t: f64| (u * u / g) * ((b - g * t / u).cos() / b.cos()).ln();
    if t < top { risen(t) } else { risen(top) + falling(0.0, t - top) }
}

fn prepared(host: &Line, seen: &[Observation]) -> Vec<Prepared> {
    let one = |seen: &Observation| match host.simulator().prepare(seen).unwrap() {
        Preparation::Usable(prepared) => *prepared,
        Preparation::Rejected(rejected) => panic!("{:?}", rejected.note),
    };
    seen.iter().map(one).collect()
}

fn recordings(speeds: &[f64], seed: u64, path: &dyn Fn(usize, f64, f64) -> f64) -> Vec<Observation> {
    let one = |(i, v0): (usize, &f64)| observed(SECONDS, NOISE_M, seed + i as u64, &|t| path(i, *v0, t));
    speeds.iter().enumerate().map(one).collect()
}

fn asked(path: &dyn Fn(usize, f64, f64) -> f64, seed: u64, settings: &Settings) -> super::Answer {
    let host = Line::new();
    let fitted = prepared(&host, &recordings(&SPEEDS, seed, path));
    let ahead = prepared(&host, &recordings(&AHEAD, seed + 100, path));
    search(&host, &fitted, &ahead, settings).unwrap()
}

#[test]
fn a_fall_without_resistance_has_no_law() {
    let answer = asked(&|_, v0, t| v0 * t - 0.5 * 9.8 * t * t, 3, &Settings::default());
    assert_eq!(answer.verdict, Verdict::None);
    assert!(answer.base_force_nats <= super::LIKELY_FORCE_NATS, "{}", answer.base_force_nats);
}

#[test]
fn quadratic_resistance_is_found_with_its_exponent_and_its_coefficient() {
    let u = 12.0;
    let answer = asked(&|_, v0, t| quadratic(9.8, u, v0, t), 5, &Settings::default());
    let best = &answer.members[0];
    assert!(matches!(answer.verdict, Verdict::Law | Verdict::OneOf), "{answer:?}");
    let is = |m: &super::Member| {
        m.terms.len() == 1
            && matches!(&m.terms[0].term.factors[..], [f] if f.shape == Shape::OddPower && f.variable == 1)
    };
    let found = answer
        .members
        .iter()
        .find(|m| is(m))
        .unwrap_or_else(|| panic!("{} {:?} {:?}", best.text(), best.gates, answer.refused));
    let (low, high) = match found.terms[0].rounded[0] {
        Some(rounded) => rounded.interval95,
        None => found.terms[0].numbers[1].interval95,
    };
    assert!(low <= 2.0 && 2.0 <= high, "{low} {high}");
    if found.terms[0].rounded[0].is_some() {
        let (low, high) = found.terms[0].numbers[0].interval95;
        let wanted = -9.8 / (u * u);
        assert!(low <= wanted && wanted <= high, "{low} {wanted} {high}");
    }
    assert!(answer.rollouts <= 10_000, "{}", answer.rollouts);
}

/// Along the speed both the law's band and what the recordings ask for in each range hold the true force; of 20 intervals of 95 % two may
/// miss it.
#[test]
fn the_course_of_a_law_and_its_recordings_hold_the_true_force() {
    let u = 12.0;
    let answer = asked(&|_, v0, t| quadratic(9.8, u, v0, t), 5, &Settings::default());
    let course = answer.members.iter().flat_map(|m| &m.courses).find(|c| c.variable == "v_m_s").unwrap();
    let holds = |s: &Sample| {
        let wanted = -9.8 / (u * u) * s.at * s.at.abs();
        s.interval95.0 <= wanted && wanted <= s.interval95.1
    };
    assert_eq!((course.unit.as_str(), course.held.is_none()), ("m/s²", true));
    assert!(course.bins.len() >= 4, "{course:?}");
    let missed = course.bins.iter().filter(|bin| !holds(&bin.estimate)).count();
    assert!(missed <= 2, "{course:?}");
    assert!(course.curve.iter().filter(|s| holds(s)).count() >= 70, "{course:?}");
    // Neighbouring ranges touch, and each holds its value.
    assert!(course.bins.windows(2).all(|pair| pair[0].range.1 == pair[1].range.0), "{course:?}");
    assert!(course.bins.iter().all(|b| b.range.0 <= b.estimate.at && b.estimate.at <= b.range.1), "{course:?}");
}

/// Differences of 120 values show a noise to 14 %: a third less is chance, less than half is another noise.
#[test]
fn recordings_share_their_noise_where_what_each_shows_of_it_differs_by_chance() {
    let host = Line::new();
    let with = |noise: f64, seconds: f64| {
        let seen = [observed(seconds, NOISE_M, 1, &|t| t)];
        Prepared { noise: Some(vec![noise]), ..prepared(&host, &seen).remove(0) }
    };
    let pooled = super::pooled(&[with(1.0, 1.19), with(1.1, 1.19)], &[with(0.65, 1.19)]);
    let mean = ((1.0 + 1.1 * 1.1 + 0.65 * 0.65) / 3.0_f64).sqrt();
    assert!(pooled.iter().all(|noise| (noise[0] - mean).abs() < 1e-12), "{pooled:?}");
    let other = super::pooled(&[with(1.0, 1.19), with(1.1, 1.19)], &[with(0.4, 1.19)]);
    assert_eq!(other, [[1.0], [1.1], [0.4]]);
}

/// A weight on a spring: three periods, of which the response about a free fall says nothing beyond the first.
#[test]
fn a_force_that_turns_the_motion_over_again_and_again_is_found_about_the_path() {
    let omega = 13.0;
    let path =
        |_: usize, v0: f64, t: f64| v0 / omega * (omega * t).sin() - 9.0 / (omega * omega) * (1.0 - (omega * t).cos());
    let answer = asked(&path, 11, &Settings::default());
    let found = answer.members.first().unwrap_or_else(|| panic!("{answer:?}"));
    let (low, high) = found.terms[0].numbers[0].interval95;
    let wanted = -omega * omega;
    assert!(found.text().contains("x_m") && low <= wanted && wanted <= high, "{} {low} {high}", found.text());
    assert!(answer.rollouts <= 10_000, "{}", answer.rollouts);
}

/// Pushed by A cos(ωt): a force of bumps in time follows the speed v₀ − g t + (A/ω) sin(ωt), of which a free fall knows nothing.
#[test]
fn a_path_follows_its_recording_where_the_base_model_does_not() {
    let (g, push, omega) = (9.8, 40.0, 6.0);
    let host = Line::new();
    let path =
        |_: usize, v0: f64, t: f64| v0 * t - 0.5 * g * t * t + push / (omega * omega) * (1.0 - (omega * t).cos());
    let (fitted, log) = (prepared(&host, &recordings(&SPEEDS, 3, &path)), RolloutLog::default());
    let noise = vec![vec![NOISE_M]; fitted.len()];
    let session = Session::new(&host, &fitted, (&noise, Colour::WHITE, None), &log, 10_000).unwrap();
    let base = Around::base(&session, &log).unwrap();
    let along = super::smoothed::along(&session, &base, 2).unwrap();
    let off = |around: &Around| {
        let each = around.response.parts.iter().zip(SPEEDS).flat_map(|(part, v0)| {
            part.visits.iter().map(move |visit| {
                let (speed, t) = (visit.variables[1], visit.variables[2]);
                (speed - (v0 - g * t + push / omega * (omega * t).sin())).abs()
            })
        });
        each.fold(0.0, f64::max)
    };
    assert!(off(&base) > 2.0 && off(&along) < 0.3, "{} {}", off(&base), off(&along));
}

/// A resistance that differs from recording to recording is no law.
#[test]
fn an_unmeasured_difference_between_recordings_is_never_a_law_alone() {
    let strength = [9.0, 14.0, 30.0];
    let answer = asked(&|i, v0, t| quadratic(9.8, strength[i], v0, t), 7, &Settings::default());
    assert_ne!(answer.verdict, Verdict::Law, "{answer:?}");
    assert!(answer.rollouts <= 10_000, "{}", answer.rollouts);
}

/// How a decaying force compares with one term fitted to these paths: by how much it surpasses the term by Akaike's criterion, and how much
/// more it gains than the term by that of Schwarz.
fn decay_surpasses(path: &dyn Fn(usize, f64, f64) -> f64, term: Term, numbers: Vec<f64>) -> (f64, f64) {
    let host = Line::new();
    let (fitted, log) = (prepared(&host, &recordings(&SPEEDS, 3, path)), RolloutLog::default());
    let noise = vec![vec![NOISE_M]; fitted.len()];
    let session = Session::new(&host, &fitted, (&noise, Colour::WHITE, None), &log, 10_000).unwrap();
    let base = Around::base(&session, &log).unwrap();
    let law = session.on(&base.response, &[term], &[numbers], session.base.point.clone()).unwrap();
    let law = session.finish(&base.response, &law).unwrap();
    let gain = super::decay::bic_gain(&session, &base, &law).unwrap();
    (super::decay::surpasses(&session, &base, &law).unwrap(), gain - law.bic)
}

/// A push A exp(-t/c) adds A c² (exp(-t/c) − 1 + t/c) to a fall; a resistance that is found with its exponent needs none.
#[test]
fn a_force_that_decays_in_each_recording_surpasses_a_law_of_the_height_and_no_true_law() {
    let c = 0.5_f64;
    let push = [2.0, 3.2, 4.5];
    let decays = |i: usize, v0: f64, t: f64| v0 * t - 4.9 * t * t + push[i] * c * c * ((-t / c).exp() - 1.0 + t / c);
    let bump = Term::new(0, 1, vec![Factor::new(Shape::Bump, 0)]);
    let (by, more) = decay_surpasses(&decays, bump, vec![3.0, 0.0, 2.0]);
    assert!(by > 0.0 && more > 0.0, "{by} {more}");
    let power = Term::new(0, 1, vec![Factor::new(Shape::OddPower, 1)]);
    let (by, more) = decay_surpasses(&|_, v0, t| quadratic(9.8, 12.0, v0, t), power, vec![-0.07, 2.0]);
    assert!(by < 0.0 && more < 0.0, "{by} {more}");
}

#[test]
fn without_held_out_recordings_no_law_stands_alone() {
    let host = Line::new();
    let path = |_: usize, v0: f64, t: f64| quadratic(9.8, 12.0, v0, t);
    let fitted = prepared(&host, &recordings(&SPEEDS, 9, &path));
    let answer = search(&host, &fitted, &[], &Settings::default()).unwrap();
    assert_ne!(answer.verdict, Verdict::Law);
}

#[test]
fn the_allowance_of_rollouts_ends_a_search() {
    let settings = Settings { rollouts: Some(600), ..Settings::default() };
    let answer = asked(&|_, v0, t| quadratic(9.8, 12.0, v0, t), 5, &settings);
    assert!(answer.rollouts <= 1_000, "{}", answer.rollouts);
}

/// The allowance ends a search at the same fit, however many run at a time.
#[test]
fn answers_do_not_depend_on_the_number_of_threads() {
    let settings = Settings { rollouts: Some(1_500), ..Settings::default() };
    let asked = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| asked(&|_, v0, t| quadratic(9.8, 12.0, v0, t), 5, &settings))
    };
    let (one, three) = (asked(1), asked(3));
    assert_eq!(serde_json::to_value(&one).unwrap(), serde_json::to_value(&three).unwrap());
    assert!(!one.members.is_empty() || !one.refused.is_empty() || one.reason.is_some(), "{one:?}");
}

/// About free falls: a session's fits of these terms.
fn fitted(terms: &[Term], numbers: &[Vec<f64>], of: &dyn Fn(&Line, &Around, super::refit::Law)) {
    let host = Line::new();
    let seen = prepared(&host, &recordings(&SPEEDS, 3, &|_, v0, t| v0 * t - 0.5 * 9.8 * t * t));
    let (noise, log) = (vec![vec![NOISE_M]; seen.len()], RolloutLog::default());
    let session = Session::new(&host, &seen, (&noise, Colour::WHITE, None), &log, 10_000).unwrap();
    let around = Around::base(&session, &log).unwrap();
    let law = session.on(&around.response, terms, numbers, session.base.point.clone()).unwrap();
    of(&host, &around, law);
}

/// A sign that fades with its variable, as tanh(v/c) exp(-((v - h)/w)²), is the decay exp(-(v/w)²) sign(v).
#[test]
fn a_sign_times_a_bump_of_its_variable_is_one_decay() {
    let factors = vec![Factor::new(Shape::Tanh, 1), Factor::new(Shape::Bump, 1)];
    let product = [Term::new(0, 1, factors)];
    fitted(&product, &[vec![-0.01, 0.1, 0.0, 2.0]], &|_, _, law| {
        let numbers = law.numbers();
        let (terms, merged) = super::simplify::merged(&law, 0, &numbers).unwrap();
        assert_eq!(terms[0].factors, [Factor::new(Shape::Stribeck, 1)]);
        assert_eq!(merged[0], [numbers[0][0], numbers[0][3]]);
    });
}

/// A second factor may mend what the first lacks: each factor's whole powers are tried without the other.
#[test]
fn a_product_is_compared_with_whole_powers_of_either_variable() {
    let product = [Term::new(0, 1, vec![Factor::new(Shape::Tanh, 1), Factor::new(Shape::Bump, 0)])];
    fitted(&product, &[vec![-0.01, 2.0, -5.0, 4.0]], &|host, around, law| {
        let search = super::linear::Search::fine(super::Host::space(host), &around.response);
        let kin = search.kin(&law.terms[0], &law.numbers()[0]);
        for variable in [0, 1] {
            let cube = [Factor { rounded: Some(3.0), ..Factor::new(Shape::OddPower, variable) }];
            assert!(kin.iter().any(|c| c.terms[0].factors == cube), "{variable}");
        }
    });
}

/// Friction a turns over at the top of a rise, t₁ = v/g: the path answers with −a t²/2 up to there, and from there on with
/// −a t₁²/2 − a t₁ (t − t₁) + a (t − t₁)²/2.
#[test]
fn a_response_follows_a_force_that_turns_over_within_a_piece() {
    let (g, v0, a) = (9.8, 5.03, 0.01);
    let host = Line::new();
    let seen = [observed(SECONDS, 0.0, 1, &|t| v0 * t - 0.5 * g * t * t)];
    let (fitted, noise, log) = (prepared(&host, &seen), [vec![NOISE_M]], RolloutLog::default());
    let session = Session::new(&host, &fitted, (&noise, Colour::WHITE, None), &log, 10_000).unwrap();
    let around = Around::base(&session, &log).unwrap();
    let friction = Term::new(0, 1, vec![Factor::new(Shape::Sign, 1)]);
    let answer = &around.response.answer(&friction, &[-a])[0];
    let top = v0 / g;
    for (k, found) in answer.iter().enumerate() {
        let t = k as f64 * 0.01;
        let after = (t - top).max(0.0);
        let wanted = -0.5 * a * (t - after).powi(2) - a * top * after + 0.5 * a * after * after;
        // The turn lies within a tenth of a piece, of which a recording has at most 40.
        let piece = SECONDS / 40.0;
        let off = 2.0 * a * 0.1 * piece * after + 0.5 * a * piece.powi(2);
        assert!((found * NOISE_M - wanted).abs() < off, "{t}: {} {wanted}", found * NOISE_M);
    }
}
