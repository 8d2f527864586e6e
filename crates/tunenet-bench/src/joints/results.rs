//! What the answers add up to, held against the goals.

use serde::Serialize;
use tunenet_core::statistics::{median, wilson_interval};

use super::rows::RATIOS;
use super::servo::SECRETS;
use super::trial::{JointTrial, Mark, Outcome};
use crate::goals::{JOINTS_FALSE_NAMES, JOINTS_IN_SET, JOINTS_IN_SET_AT_3, JOINTS_ROLLOUTS, JOINTS_WRONG_NAME};

/// A hidden effect of which tuning leaves less than this, in standard deviations of the best test, cannot be seen.
pub const SEEN_SIGMA: f64 = 3.0;
/// A root mean square of what survives that is clearly visible, in units of the noise.
pub const CLEAR_RMS: f64 = 3.0;

/// How many sets got each mark.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    pub sets: usize,
    pub exact: usize,
    pub in_set: usize,
    pub wrong: usize,
    pub wrong_set: usize,
    pub unknown: usize,
    pub nothing: usize,
    pub failed: usize,
}

impl Counts {
    fn of(those: &[&Outcome]) -> Self {
        let count = |mark| those.iter().filter(|one| one.mark == mark).count();
        Self {
            sets: those.len(),
            exact: count(Mark::Exact),
            in_set: count(Mark::InSet),
            wrong: count(Mark::Wrong),
            wrong_set: count(Mark::WrongSet),
            unknown: count(Mark::Unknown),
            nothing: count(Mark::Nothing),
            failed: count(Mark::Failed),
        }
    }
}

/// One line: one effect, or all, at one ratio.
#[derive(Debug, Clone, Serialize)]
pub struct Line {
    /// `None`: all of them together.
    pub hidden: Option<String>,
    pub ratio: f64,
    pub counts: Counts,
    pub surviving_rms: Option<f64>,
    pub surviving_sigma: Option<f64>,
    pub rollouts: Option<f64>,
    pub seconds: Option<f64>,
}

/// What is measured, held against its goal.
#[derive(Debug, Clone, Serialize)]
pub struct Goal {
    pub what: String,
    pub aim: String,
    /// A share, or a number of rollouts.
    pub measured: Option<f64>,
    pub of: usize,
    /// Wilson's 95 % interval of a share.
    pub interval95: Option<(f64, f64)>,
    /// `None` where it is only reported.
    pub met: Option<bool>,
}

#[derive(Debug, Clone, Serialize)]
pub struct JointResults {
    pub schema: &'static str,
    pub command: String,
    pub version: &'static str,
    pub seed: u64,
    pub quick: bool,
    pub goals: Vec<Goal>,
    /// Of all effects together, those that tuning hides apart.
    pub ratios: Vec<Line>,
    pub hidden_by_tuning: Vec<Line>,
    pub effects: Vec<Line>,
    /// Sets that no physical size of the effect reaches.
    pub unreachable: usize,
    pub trials: Vec<JointTrial>,
    pub warnings: Vec<()>,
}

impl JointResults {
    pub fn new(command: String, seed: u64, quick: bool, trials: Vec<JointTrial>) -> Self {
        let drawn = trials.len();
        let trials: Vec<JointTrial> = trials.into_iter().filter(|trial| trial.outcome.is_some()).collect();
        let at = |ratio: f64, is: &dyn Fn(&JointTrial, &Outcome) -> bool| line(&trials, None, ratio, is);
        let ratios = [0.0].into_iter().chain(RATIOS);
        Self {
            schema: "tunenet.bench.joints/1",
            command,
            version: env!("CARGO_PKG_VERSION"),
            seed,
            quick,
            goals: goals(&trials),
            ratios: ratios.filter_map(|ratio| at(ratio, &|trial, one| is_seen(trial, one))).collect(),
            hidden_by_tuning: RATIOS.iter().filter_map(|r| at(*r, &|trial, one| !is_seen(trial, one))).collect(),
            effects: effects(&trials),
            unreachable: drawn - trials.len(),
            trials,
            warnings: Vec::new(),
        }
    }
}

/// Whether what is hidden could be seen; nothing counts as seen.
fn is_seen(trial: &JointTrial, one: &Outcome) -> bool {
    trial.hidden.is_none() || one.surviving.sigma >= SEEN_SIGMA
}

fn outcomes<'a>(trials: &'a [JointTrial], is: &dyn Fn(&JointTrial, &Outcome) -> bool) -> Vec<&'a Outcome> {
    let all = trials.iter().filter_map(|trial| Some((trial, trial.outcome.as_ref()?)));
    all.filter(|(trial, one)| is(trial, one)).map(|(_, one)| one).collect()
}

fn line(
    trials: &[JointTrial],
    hidden: Option<&str>,
    ratio: f64,
    is: &dyn Fn(&JointTrial, &Outcome) -> bool,
) -> Option<Line> {
    let those = outcomes(trials, &|trial, one| trial.ratio == ratio && is(trial, one));
    let middle = |value: &dyn Fn(&Outcome) -> f64| median(those.iter().map(|one| value(one)));
    (!those.is_empty()).then(|| Line {
        hidden: hidden.map(str::to_owned),
        ratio,
        counts: Counts::of(&those),
        surviving_rms: middle(&|one| one.surviving.rms),
        surviving_sigma: middle(&|one| one.surviving.sigma),
        rollouts: middle(&|one| one.rollouts as f64),
        seconds: middle(&|one| one.seconds),
    })
}

fn effects(trials: &[JointTrial]) -> Vec<Line> {
    let each = SECRETS.iter().flat_map(|secret| RATIOS.map(|ratio| (secret.name, ratio)));
    each.filter_map(|(name, ratio)| line(trials, Some(name), ratio, &|trial, _| trial.hidden.as_deref() == Some(name)))
        .collect()
}

fn goals(trials: &[JointTrial]) -> Vec<Goal> {
    let seen = |ratio: f64| {
        outcomes(trials, &|trial, one| trial.ratio == ratio && trial.hidden.is_some() && is_seen(trial, one))
    };
    let clear = |ratio: f64| outcomes(trials, &|trial, one| trial.ratio == ratio && one.surviving.rms >= CLEAR_RMS);
    let right = |one: &Outcome| matches!(one.mark, Mark::Exact | Mark::InSet);
    let wrong = |one: &Outcome| one.mark == Mark::Wrong;
    let named = |one: &Outcome| right(one) || matches!(one.mark, Mark::Wrong | Mark::WrongSet);
    let (clean, hidden) = (outcomes(trials, &|t, _| t.hidden.is_none()), outcomes(trials, &|t, _| t.hidden.is_some()));
    let rollouts = median(hidden.iter().map(|one| one.rollouts as f64));
    vec![
        share("ratio 10: exact or in the set", Some((true, JOINTS_IN_SET)), &seen(10.0), &right),
        share("ratio 3: exact or in the set", Some((true, JOINTS_IN_SET_AT_3)), &seen(3.0), &right),
        share("ratio 30: exact or in the set", None, &seen(30.0), &right),
        share("ratio 10, clear after tuning: exact or in the set", None, &clear(10.0), &right),
        share("ratio 10: exact", None, &seen(10.0), &|one| one.mark == Mark::Exact),
        share("ratio 3: exact", None, &seen(3.0), &|one| one.mark == Mark::Exact),
        share("ratio 10: wrong lone name", Some((false, JOINTS_WRONG_NAME)), &seen(10.0), &wrong),
        share("ratio 3: wrong lone name", Some((false, JOINTS_WRONG_NAME)), &seen(3.0), &wrong),
        share("all ratios: wrong lone name", Some((false, JOINTS_WRONG_NAME)), &hidden, &wrong),
        share("nothing hidden: a name given", Some((false, JOINTS_FALSE_NAMES)), &clean, &named),
        Goal {
            what: "three runs: rollouts, median".into(),
            aim: format!("at most {JOINTS_ROLLOUTS:.0}"),
            measured: rollouts,
            of: hidden.len(),
            interval95: None,
            met: rollouts.map(|count| count <= JOINTS_ROLLOUTS),
        },
    ]
}

/// A share; `aim` is whether it has to reach a limit, or may not pass it.
fn share(what: &str, aim: Option<(bool, f64)>, those: &[&Outcome], is: &dyn Fn(&Outcome) -> bool) -> Goal {
    let hits = those.iter().filter(|one| is(one)).count();
    let measured = (!those.is_empty()).then(|| hits as f64 / those.len() as f64);
    let shown =
        |(least, limit): (bool, f64)| format!("{} {:.0} %", if least { "at least" } else { "at most" }, 100.0 * limit);
    let met = aim.zip(measured).map(|((least, limit), is)| if least { is >= limit } else { is <= limit });
    Goal {
        what: what.into(),
        aim: aim.map_or_else(|| "reported".into(), shown),
        measured,
        of: those.len(),
        interval95: measured.map(|_| wilson_interval(hits, those.len())),
        met,
    }
}

#[cfg(test)]
pub mod tests {
    use super::super::set::Surviving;
    use super::*;

    pub fn one(hidden: Option<&str>, ratio: f64, mark: Mark, sigma: f64) -> JointTrial {
        let surviving = Surviving { rms: sigma / 10.0, sigma };
        let outcome = Some(Outcome { mark, words: "backlash".into(), surviving, rollouts: 1500, seconds: 0.5 });
        JointTrial { hidden: hidden.map(str::to_owned), ratio, number: 0, outcome }
    }

    #[test]
    fn goals_are_held_against_what_was_measured() {
        let trials = vec![
            one(Some("dead_band"), 10.0, Mark::Exact, 50.0),
            one(Some("dead_band"), 10.0, Mark::Wrong, 50.0),
            one(Some("dead_band"), 3.0, Mark::InSet, 20.0),
            // Hidden by the tuning, so that it counts against no goal but that of wrong names.
            one(Some("dead_band"), 3.0, Mark::Nothing, 1.0),
            one(None, 0.0, Mark::Nothing, 0.0),
        ];
        let results = JointResults::new("command".into(), 1, true, trials);
        let met = |what: &str| results.goals.iter().find(|goal| goal.what == what).unwrap().met;
        assert_eq!(met("ratio 10: exact or in the set"), Some(false));
        assert_eq!(met("ratio 3: exact or in the set"), Some(true));
        assert_eq!(met("all ratios: wrong lone name"), Some(false));
        assert_eq!(met("nothing hidden: a name given"), Some(true));
        assert_eq!(met("ratio 30: exact or in the set"), None);
        assert_eq!(met("three runs: rollouts, median"), Some(true));
        assert_eq!((results.ratios.len(), results.hidden_by_tuning.len()), (3, 1));
        assert_eq!(results.effects.iter().map(|line| line.counts.sets).collect::<Vec<_>>(), [2, 2]);
    }

    #[test]
    fn what_no_size_reaches_is_counted_apart() {
        let mut trial = one(Some("dead_band"), 30.0, Mark::Exact, 50.0);
        trial.outcome = None;
        let results = JointResults::new("command".into(), 1, true, vec![trial]);
        assert!(results.unreachable == 1 && results.trials.is_empty() && results.effects.is_empty());
    }
}
