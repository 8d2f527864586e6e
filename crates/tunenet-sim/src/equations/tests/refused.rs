//! What no rollout can follow, and what no file may say.

use super::super::{Misfit, System};
use super::{Given, system, tried};
use crate::scene::EquationsScene;

#[test]
fn what_cannot_be_followed_is_refused_with_state_and_time() {
    let of = |derivative: &str| {
        format!(
            "states.x_m = {{}}\nstates.y_m = {{}}\nstart.x_m.value = 1\nstart.y_m.value = 0\nderivatives.y_m = \"0*x_m*k\"\n\
                 derivatives.x_m = \"{derivative}\"\n"
        )
    };
    for (derivative, wanted) in [
        ("k*x_m*x_m", "`x_m`"),
        ("k*exp(x_m*k)", "`exp(x_m*k)` in `derivatives.x_m` grows beyond all bounds"),
        ("k*90*x_m", "`x_m` grows beyond all bounds at 0.7"),
        ("k*ln(0.5 - k*t_s)", "`ln(0.5 - k*t_s)` in `derivatives.x_m` grows beyond all bounds at 0.5"),
        ("-2*k*sqrt(x_m - 0.5*k)", "`sqrt(x_m - 0.5*k)` in `derivatives.x_m` has no real value at"),
        ("k*sqrt(0.5 - k*t_s)", "`sqrt(0.5 - k*t_s)` in `derivatives.x_m` has no real value at 0.5"),
        ("-k*1e9*(x_m - 1)", "`x_m` takes too many steps"),
        ("2 + k/y_m", "`k/y_m` in `derivatives.x_m` grows beyond all bounds at 0 s"),
        (
            "k*t_s + k*t_s*(x_m - x_m)/(y_m - y_m)",
            "`k*t_s*(x_m - x_m)/(y_m - y_m)` in `derivatives.x_m` has no real value at 0 s",
        ),
        ("2 + k/(0.5 - t_s)", "`k/(0.5 - t_s)` in `derivatives.x_m` grows beyond all bounds at 0.5"),
    ] {
        let system = system(&of(derivative), &["k"]);
        let given = Given { parameters: vec![1.0], start: vec![1.001, 0.0], ..Given::default() };
        let refused = tried(&system, &given, &[0.1, 2.0]).unwrap_err();
        assert!(refused.contains(wanted), "{derivative}: {refused}");
    }
}

/// At x = 0 the ball that falls from 1 m is given a speed that is none.
#[test]
fn what_an_event_cannot_give_is_refused_with_its_formula() {
    for (then, wanted) in [
        ("-v_m_s/(k - k)", "/(k - k)` in `events.bounce.then.v_m_s` grows beyond all bounds at 0.45"),
        ("v_m_s*sqrt(k*v_m_s)", "`sqrt(k*v_m_s)` in `events.bounce.then.v_m_s` has no real value at 0.45"),
    ] {
        let text = format!(
            "states.x_m = {{}}\nstates.v_m_s = {{}}\nstart.x_m.value = 1\nstart.v_m_s.value = 0\nderivatives.x_m = \"v_m_s\"\n\
             derivatives.v_m_s = \"-9.81*k\"\nevents.bounce.when = \"x_m\"\nevents.bounce.then.v_m_s = \"{then}\"\n"
        );
        let given = Given { parameters: vec![1.0], start: vec![1.0, 0.0], ..Given::default() };
        let refused = tried(&system(&text, &["k"]), &given, &[0.1, 2.0]).unwrap_err();
        assert!(refused.contains(wanted), "{then}: {refused}");
    }
}

/// 1/(x − 0.5) changes its sign where the ball passes 0.5 m, and is never zero.
#[test]
fn an_event_with_a_pole_is_refused() {
    let text = "states.x_m = {}\nstates.v_m_s = {}\nstart.x_m.value = 1\nstart.v_m_s.value = 0\nderivatives.x_m = \"v_m_s\"\n\
                derivatives.v_m_s = \"-9.81*k\"\nevents.bounce.when = \"1/(x_m - 0.5)\"\nevents.bounce.then.v_m_s = \"-v_m_s\"\n";
    let given = Given { parameters: vec![1.0], start: vec![1.0, 0.0], ..Given::default() };
    let refused = tried(&system(text, &["k"]), &given, &[0.1, 2.0]).unwrap_err();
    assert!(refused.contains("`events.bounce.when` changes its sign at 0.319"), "{refused}");
    // A floor at 0.6 m keeps the ball above it, in a step that would reach both.
    let floor = "events.floor.when = \"x_m - 0.6\"\nevents.floor.then.v_m_s = \"-v_m_s\"\n";
    let found = tried(&system(&format!("{text}{floor}"), &["k"]), &given, &[0.1, 2.0]).unwrap();
    assert!((0.6..=1.0).contains(&found[2]), "{found:?}");
}

const FILE: &str = "states.x_m = {}
states.v_m_s = {}
start.x_m.value = 0
start.v_m_s.value = 0
inputs.u_n = {}
derivatives.x_m = \"v_m_s\"
derivatives.v_m_s = \"-k*x_m + u_n/mass\"
outputs.x_m = \"x_m\"
events.stop.when = \"x_m\"
events.stop.then.v_m_s = \"0\"
constants.mass = 2
candidates.dry.sentence = \"it rubs\"
candidates.dry.acts = \"joint\"
candidates.dry.adds.v_m_s = \"-c*sign(v_m_s)\"
candidates.dry.coefficients.c = { min = 0, max = 1, typical = 0.1, unit = \"m/s²\" }
";

fn misfit(text: &str) -> Misfit {
    let scene: EquationsScene = toml_edit::de::from_str(text).unwrap();
    System::new(&scene, &[("k", Some("1/s²"))]).map(|_| ()).expect_err(text)
}

#[test]
fn what_contradicts_itself_is_refused_with_its_place() {
    for (from, to, path, at, wanted) in [
        (
            "\"v_m_s\"\n",
            "\"v_ms\"\n",
            "derivatives.x_m",
            Some(0),
            "expected one of x_m, v_m_s, t_s, u_n, k, mass, found `v_ms`",
        ),
        ("\"v_m_s\"\n", "\"2*x_m\"\n", "derivatives.x_m", Some(0), "expected a formula in m/s, found one in m"),
        (
            "-k*x_m +",
            "-k*x_m + x_m +",
            "derivatives.v_m_s",
            Some(9),
            "expected a value in m/s², as before it, found one in m",
        ),
        (
            "-k*x_m +",
            "-k*delay(x_m, 0.1) +",
            "derivatives.v_m_s",
            Some(9),
            "expected the name of an input, found what is no input: of inputs alone earlier values are known",
        ),
        ("u_n/mass", "delay(u_n, t_s)/mass", "derivatives.v_m_s", Some(20), "expected a delay of parameters"),
        ("u_n/mass", "c", "derivatives.v_m_s", Some(9), "found `c`"),
        ("derivatives.x_m = \"v_m_s\"\n", "derivatives.y_m = \"v_m_s\"\n", "derivatives", None, "found none of `x_m`"),
        (
            "states.v_m_s",
            "derivatives.w_m_s = \"1\"\nstates.v_m_s",
            "derivatives.w_m_s",
            None,
            "expected a state (`x_m`, `v_m_s`)",
        ),
        ("start.v_m_s.value = 0\n", "", "states.v_m_s", None, "expected [start.v_m_s]"),
        (
            "outputs.x_m = \"x_m\"",
            "outputs.x_m = \"v_m_s\"",
            "outputs.x_m",
            Some(0),
            "expected a formula in m, found one in m/s",
        ),
        (
            "outputs.x_m",
            "outputs.a_m = \"x_m\"\noutputs.b_m = \"a_m\"\noutputs.x_m",
            "outputs.b_m",
            Some(0),
            "found `a_m`",
        ),
        ("then.v_m_s = \"0\"", "then.v_m_s = \"x_m\"", "events.stop.then.v_m_s", Some(0), "expected a formula in m/s"),
        ("then.v_m_s", "then.w_m_s", "events.stop.then.w_m_s", None, "expected a state"),
        ("events.stop.then.v_m_s = \"0\"\n", "", "events.stop", None, "`then.STATE"),
        ("constants.mass", "constants.k", "constants.k", None, "found `k` under [parameters] too"),
        (
            "constants.mass = 2",
            "constants.mass = 2\nconstants.e = 3",
            "constants.e",
            None,
            "no constant of mathematics",
        ),
        ("constants.mass = 2", "constants.mass = 2\nconstants.t_s = 3", "constants.t_s", None, "which is the clock"),
        ("coefficients.c", "coefficients.mass", "candidates.dry.coefficients.mass", None, "under [constants] too"),
        ("adds.v_m_s", "adds.w_m_s", "candidates.dry.adds.w_m_s", None, "expected a state"),
        ("candidates.dry.adds.v_m_s = \"-c*sign(v_m_s)\"\n", "", "candidates.dry", None, "expected `adds.STATE"),
        ("-c*sign(v_m_s)", "-k*x_m*sign(v_m_s)", "candidates.dry.coefficients.c", None, "that uses `c`"),
        ("-c*sign(v_m_s)", "(c - k*x_m)*sign(v_m_s)", "candidates.dry.adds.v_m_s", None, "a formula that is 0 where"),
        ("-c*sign(v_m_s)", "-c*sign(v_m_s", "candidates.dry.adds.v_m_s", Some(13), "found the end"),
    ] {
        assert!(FILE.contains(from), "{from}");
        let refused = misfit(&FILE.replacen(from, to, 1));
        let said = format!("expected {}, found {}", refused.expected, refused.found);
        assert_eq!((refused.path.as_str(), refused.place.map(|place| place.start)), (path, at), "{to}: {said}");
        assert!(said.contains(wanted), "{to}: {said}");
    }
}
