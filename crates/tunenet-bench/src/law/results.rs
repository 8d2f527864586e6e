//! What the answers add up to, held against the goals.

use serde::Serialize;
use tunenet_core::statistics::{median, quantile, wilson_interval};

use super::laws::{DISCOVER, INSIDE};
use super::rows::LawRow;
use super::trial::{LawTrial, Mark, Outcome};
use crate::goals::{
    LAW_ALONE, LAW_ALONE_WRONG, LAW_ALONE_WRONG_AT_3, LAW_COVERAGE, LAW_DISCOVER_NMSE, LAW_FALSE, LAW_FASTER_90,
    LAW_HELD_OUT_90, LAW_HELD_OUT_MEDIAN, LAW_HIDDEN_STATE, LAW_IN_SET, LAW_IN_SET_AT_3, LAW_ROLLOUTS, LAW_SECONDS,
};

/// One line: one law in one row.
#[derive(Debug, Clone, Serialize)]
pub struct Line {
    pub row: String,
    pub law: String,
    pub sets: usize,
    /// How many of each mark.
    pub exact: usize,
    pub in_set: usize,
    pub wrong: usize,
    pub wrong_set: usize,
    pub refused: usize,
    pub nothing: usize,
    pub failed: usize,
    /// Of what is accepted.
    pub held_out_median: Option<f64>,
    pub faster_median: Option<f64>,
    /// Errors over those without the law, and over the variance of the motions.
    pub left_median: Option<f64>,
    pub nmse_median: Option<f64>,
    pub rollouts_median: Option<f64>,
    pub seconds_median: Option<f64>,
}

/// What is measured, held against its goal.
#[derive(Debug, Clone, Serialize)]
pub struct Goal {
    pub what: String,
    pub aim: String,
    /// A share, or a ratio, a number of rollouts, a time.
    pub measured: Option<f64>,
    pub unit: Unit,
    /// Of how many sets or constants, and Wilson's 95 % interval of a share.
    pub of: usize,
    pub interval95: Option<(f64, f64)>,
    /// `None` where it is only reported.
    pub met: Option<bool>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Unit {
    Share,
    Ratio,
    Rollouts,
    Seconds,
}

#[derive(Debug, Clone, Serialize)]
pub struct LawResults {
    pub schema: &'static str,
    pub command: String,
    pub version: &'static str,
    pub seed: u64,
    pub quick: bool,
    pub goals: Vec<Goal>,
    pub lines: Vec<Line>,
    pub trials: Vec<LawTrial>,
    pub warnings: Vec<()>,
}

impl LawResults {
    pub fn new(command: String, seed: u64, quick: bool, trials: Vec<LawTrial>) -> Self {
        // What no size makes visible says nothing.
        let trials: Vec<LawTrial> = trials.into_iter().filter(|trial| trial.outcome.is_some()).collect();
        Self {
            schema: "tunenet.bench.law/1",
            command,
            version: env!("CARGO_PKG_VERSION"),
            seed,
            quick,
            goals: goals(&trials),
            lines: lines(&trials),
            trials,
            warnings: vec![],
        }
    }
}

fn outcomes<'a>(trials: &'a [LawTrial], is: &dyn Fn(&LawTrial) -> bool) -> Vec<&'a Outcome> {
    trials.iter().filter(|trial| is(trial)).filter_map(|trial| trial.outcome.as_ref()).collect()
}

/// A share of sets; no goal where there are no sets.
fn share(what: &str, at_least: bool, limit: f64, of: &[&Outcome], is: &dyn Fn(&Outcome) -> bool) -> Option<Goal> {
    let hits = of.iter().filter(|one| is(one)).count();
    let measured = hits as f64 / of.len() as f64;
    let relation = if at_least { "at least" } else { "at most" };
    (!of.is_empty()).then(|| Goal {
        what: what.into(),
        aim: format!("{relation} {} %", 100.0 * limit),
        measured: Some(measured),
        unit: Unit::Share,
        of: of.len(),
        interval95: Some(wilson_interval(hits, of.len())),
        met: Some(if at_least { measured >= limit } else { measured <= limit }),
    })
}

/// A number that is to stay below a limit.
fn below(what: &str, limit: f64, unit: Unit, (of, measured): (usize, Option<f64>), judged: bool) -> Option<Goal> {
    let aim = match unit {
        Unit::Seconds => format!("at most {limit} s"),
        _ => format!("at most {limit}"),
    };
    let met = measured.filter(|_| judged).map(|value| value <= limit);
    measured.map(|_| Goal { what: what.into(), aim, measured, unit, of, interval95: None, met })
}

fn in_set(one: &Outcome) -> bool {
    matches!(one.mark, Mark::Exact | Mark::InSet)
}

fn wrong(one: &Outcome) -> bool {
    one.mark == Mark::Wrong
}

fn goals(trials: &[LawTrial]) -> Vec<Goal> {
    let of_row = |row: LawRow| {
        let name = row.name();
        outcomes(trials, &|trial| trial.row == name)
    };
    let rows = [LawRow::Ratio10, LawRow::Ratio30].map(LawRow::name);
    let large = outcomes(trials, &|trial| rows.contains(&trial.row.as_str()));
    let small = of_row(LawRow::Ratio3);
    let exact = |one: &Outcome| one.mark == Mark::Exact;
    let mut all = vec![
        share("ratio 10 and 30: the law is in the set", true, LAW_IN_SET, &large, &in_set),
        share("ratio 10 and 30: alone and right", true, LAW_ALONE, &large, &exact),
        share("ratio 10 and 30: alone and wrong", false, LAW_ALONE_WRONG, &large, &wrong),
        share("ratio 3: the law is in the set", true, LAW_IN_SET_AT_3, &small, &in_set),
        share("ratio 3: alone and wrong", false, LAW_ALONE_WRONG_AT_3, &small, &wrong),
    ];
    for (row, what) in [
        (LawRow::Clean, "nothing hidden: a law or a name alone"),
        (LawRow::Autocorrelated, "nothing hidden, autocorrelated noise: a law or a name alone"),
        (LawRow::Outliers, "nothing hidden, outliers: a law or a name alone"),
    ] {
        all.push(share(what, false, LAW_FALSE, &of_row(row), &wrong));
    }
    let hidden = of_row(LawRow::HiddenState);
    all.push(share("hidden state: a law or a name alone", false, LAW_HIDDEN_STATE, &hidden, &wrong));
    all.extend(predictions(&large));
    all.push(coverage(trials));
    all.extend(discover(trials));
    all.extend(cost(&of_row(LawRow::Ratio10)));
    all.into_iter().flatten().collect()
}

/// A quantile of what the accepted answers say, with their number.
fn of_accepted(those: &[&Outcome], share: f64, value: impl Fn(&Outcome) -> Option<f64>) -> (usize, Option<f64>) {
    let values: Vec<f64> = those.iter().filter(|one| one.accepted()).filter_map(|one| value(one)).collect();
    (values.len(), quantile(values, share))
}

fn predictions(large: &[&Outcome]) -> Vec<Option<Goal>> {
    let held_out = |share| of_accepted(large, share, |one| one.held_out);
    let faster = of_accepted(large, 0.9, |one| one.faster);
    vec![
        below("held-out error over the true law's, median", LAW_HELD_OUT_MEDIAN, Unit::Ratio, held_out(0.5), true),
        below("held-out error over the true law's, 90 %", LAW_HELD_OUT_90, Unit::Ratio, held_out(0.9), true),
        below("1.5 times faster: error over the true law's, 90 %", LAW_FASTER_90, Unit::Ratio, faster, true),
    ]
}

/// How often the intervals of constants hold the true values, at ratios 3 to 30.
fn coverage(trials: &[LawTrial]) -> Option<Goal> {
    let those = outcomes(trials, &|trial| trial.truth.is_some() && trial.ratio > 0.0);
    let (covered, constants) = those.iter().fold((0, 0), |sum, one| (sum.0 + one.covered, sum.1 + one.constants));
    let measured = covered as f64 / constants as f64;
    (constants > 0).then(|| Goal {
        what: "95 % intervals of the constants hold the truth".into(),
        aim: format!("{} to {} %", 100.0 * LAW_COVERAGE.0, 100.0 * LAW_COVERAGE.1),
        measured: Some(measured),
        unit: Unit::Share,
        of: constants,
        interval95: Some(wilson_interval(covered, constants)),
        met: Some((LAW_COVERAGE.0..=LAW_COVERAGE.1).contains(&measured)),
    })
}

fn discover(trials: &[LawTrial]) -> Vec<Option<Goal>> {
    let row = LawRow::Discover.name();
    let one = |name: &&str| {
        let those = outcomes(trials, &|trial| trial.row == row && trial.law == *name);
        let inside = trials.iter().any(|trial| trial.law == *name && trial.truth.is_some());
        if inside {
            return share(&format!("DiscoverPhysics, {name}: the law is in the set"), true, 1.0, &those, &in_set);
        }
        let what = format!("DiscoverPhysics, {name}: refused, or nMSE below {LAW_DISCOVER_NMSE}");
        let fair = |one: &Outcome| {
            one.mark == Mark::Refused || one.accepted() && one.nmse.is_some_and(|nmse| nmse < LAW_DISCOVER_NMSE)
        };
        share(&what, true, 1.0, &those, &fair)
    };
    DISCOVER.iter().map(one).collect()
}

/// Of an answer to three recordings at ratio 10.
fn cost(those: &[&Outcome]) -> Vec<Option<Goal>> {
    let answered: Vec<&&Outcome> = those.iter().filter(|one| one.mark != Mark::Failed).collect();
    let at = |share: f64, value: &dyn Fn(&Outcome) -> f64| {
        (answered.len(), quantile(answered.iter().map(|one| value(one)), share))
    };
    let rollouts = |one: &Outcome| one.rollouts as f64;
    let seconds = |one: &Outcome| one.seconds;
    vec![
        below("three recordings: rollouts, median", LAW_ROLLOUTS, Unit::Rollouts, at(0.5, &rollouts), true),
        below("three recordings: rollouts, 90 %", LAW_ROLLOUTS, Unit::Rollouts, at(0.9, &rollouts), true),
        below("three recordings: time on one thread, median", LAW_SECONDS, Unit::Seconds, at(0.5, &seconds), false),
        below("three recordings: time on one thread, 90 %", LAW_SECONDS, Unit::Seconds, at(0.9, &seconds), false),
    ]
}

fn lines(trials: &[LawTrial]) -> Vec<Line> {
    let mut keys: Vec<(&str, &str)> = Vec::new();
    for trial in trials {
        let key = (trial.row.as_str(), trial.law.as_str());
        if !keys.contains(&key) {
            keys.push(key);
        }
    }
    let line = |(row, law): (&str, &str)| {
        let those = outcomes(trials, &|trial| trial.row == row && trial.law == law);
        let count = |mark| those.iter().filter(|one| one.mark == mark).count();
        let middle = |value: &dyn Fn(&Outcome) -> Option<f64>| of_accepted(&those, 0.5, value).1;
        Line {
            row: row.into(),
            law: law.into(),
            sets: those.len(),
            exact: count(Mark::Exact),
            in_set: count(Mark::InSet),
            wrong: count(Mark::Wrong),
            wrong_set: count(Mark::WrongSet),
            refused: count(Mark::Refused),
            nothing: count(Mark::Nothing),
            failed: count(Mark::Failed),
            held_out_median: middle(&|one| one.held_out),
            faster_median: middle(&|one| one.faster),
            left_median: middle(&|one| one.left),
            nmse_median: middle(&|one| one.nmse),
            rollouts_median: median(those.iter().map(|one| one.rollouts as f64)),
            seconds_median: median(those.iter().map(|one| one.seconds)),
        }
    };
    keys.into_iter().map(line).collect()
}

/// How many of the laws inside the grammar a run holds.
pub fn laws_inside(lines: &[Line]) -> usize {
    INSIDE.iter().filter(|(name, _)| lines.iter().any(|line| line.law == *name)).count()
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use crate::law::laws::inside;
    use crate::law::set::stream;

    pub fn one(row: LawRow, law: &str, mark: Mark) -> LawTrial {
        let truth = INSIDE.iter().any(|(name, _)| *name == law).then(|| inside(law, &mut stream("test", 1, law, 0)));
        let ratio = if truth.is_some() { 10.0 } else { 0.0 };
        let accepted = matches!(mark, Mark::Exact | Mark::InSet | Mark::Wrong);
        let outcome = Outcome {
            mark,
            words: "k * speed_m_s^2 along v".into(),
            refused: vec![],
            held_out: accepted.then_some(1.002),
            faster: accepted.then_some(1.2),
            nmse: accepted.then_some(0.05),
            left: accepted.then_some(0.01),
            covered: 19,
            constants: 20,
            rollouts: 8000,
            seconds: 4.0,
        };
        LawTrial { row: row.name().into(), law: law.into(), ratio, number: 0, truth, outcome: Some(outcome) }
    }

    fn met(trials: Vec<LawTrial>, what: &str) -> Option<bool> {
        let results = LawResults::new("command".into(), 1, true, trials);
        results.goals.iter().find(|goal| goal.what.contains(what)).and_then(|goal| goal.met)
    }

    #[test]
    fn goals_are_held_against_what_was_measured() {
        let trials = vec![
            one(LawRow::Ratio10, "drag-2", Mark::Exact),
            one(LawRow::Ratio30, "drag-3", Mark::InSet),
            one(LawRow::Ratio3, "drag-2", Mark::Wrong),
            one(LawRow::Clean, "nothing, flight", Mark::Nothing),
            one(LawRow::HiddenState, "bouc-wen", Mark::Wrong),
            one(LawRow::Discover, "yukawa", Mark::Wrong),
        ];
        let of = |what: &str| met(trials.clone(), what);
        assert_eq!(of("ratio 10 and 30: the law is in the set"), Some(true));
        assert_eq!(of("ratio 10 and 30: alone and right"), Some(false));
        assert_eq!(of("ratio 3: alone and wrong"), Some(false));
        assert_eq!(of("nothing hidden: a law"), Some(true));
        assert_eq!(of("hidden state"), Some(false));
        assert_eq!(of("held-out error over the true law's, 90 %"), Some(true));
        assert_eq!(of("1.5 times faster"), Some(false));
        assert_eq!(of("intervals"), Some(true));
        assert_eq!(of("yukawa"), Some(true));
        assert_eq!(of("rollouts, median"), Some(true));
        // Times are reported only, and what was not measured has no line.
        assert_eq!(of("time on one thread, median"), None);
        assert_eq!(of("autocorrelated noise"), None);
    }

    #[test]
    fn what_could_not_be_drawn_is_left_out() {
        let mut trial = one(LawRow::Ratio10, "drag-2", Mark::Exact);
        trial.outcome = None;
        let results = LawResults::new("command".into(), 1, true, vec![trial]);
        assert!(results.trials.is_empty() && results.goals.is_empty() && laws_inside(&results.lines) == 0);
    }
}
