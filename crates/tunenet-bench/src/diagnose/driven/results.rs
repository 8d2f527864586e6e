//! What the answers add up to, held against the goals.

use std::fmt::Write as _;

use serde::Serialize;
use tunenet_core::statistics::{median, wilson_interval};

use super::trial::DrivenTrial;
use crate::goals::{DRIVEN_EXACT, DRIVEN_FALSE_NAMES, DRIVEN_OPEN, DRIVEN_ROLLOUTS, DRIVEN_WRONG_NAME, met};
use crate::output::{percent, share};

/// One line: a mechanism with one thing hidden, at one ratio.
#[derive(Debug, Clone, Serialize)]
struct Line {
    plant: String,
    hidden: String,
    ratio: f64,
    sets: usize,
    exact: f64,
    in_set: f64,
    wrong_lone_name: f64,
    open: f64,
    unknown: f64,
    rollouts: f64,
}

/// A share held against its goal.
#[derive(Debug, Clone, Serialize)]
struct Goal {
    what: &'static str,
    relation: &'static str,
    limit: f64,
    measured: f64,
    /// Of how many sets, and Wilson's 95 % interval; of the median there is none.
    sets: usize,
    interval95: Option<(f64, f64)>,
    met: bool,
}

#[derive(Debug, Clone, Serialize)]
pub struct DrivenResults {
    schema: &'static str,
    command: String,
    version: &'static str,
    seed: u64,
    quick: bool,
    goals: Vec<Goal>,
    lines: Vec<Line>,
    trials: Vec<DrivenTrial>,
}

impl DrivenResults {
    pub fn new(command: String, seed: u64, quick: bool, trials: Vec<DrivenTrial>) -> Self {
        // What no size makes visible says nothing.
        let trials: Vec<DrivenTrial> = trials.into_iter().filter(|trial| trial.answer.is_some()).collect();
        Self {
            schema: "tunenet.bench.diagnose.driven/1",
            command,
            version: env!("CARGO_PKG_VERSION"),
            seed,
            quick,
            goals: goals(&trials),
            lines: lines(&trials),
            trials,
        }
    }

    /// Both tables. Writing to a string cannot fail, so its results are dropped.
    pub fn markdown(&self) -> String {
        let mut out = self.goals();
        out.push_str(
            "\n| mechanism | hidden | ratio | sets | exact | in the set | wrong lone name | left open | unknown | rollouts |\n",
        );
        out.push_str("|---|---|---:|---:|---:|---:|---:|---:|---:|---:|\n");
        for line in &self.lines {
            let whole = |share: f64| format!("{:.0} %", 100.0 * share);
            let _ = writeln!(
                out,
                "| {} | {} | {} | {} | {} | {} | {} | {} | {} | {:.0} |",
                line.plant,
                line.hidden,
                line.ratio,
                line.sets,
                whole(line.exact),
                whole(line.in_set),
                whole(line.wrong_lone_name),
                whole(line.open),
                whole(line.unknown),
                line.rollouts
            );
        }
        out
    }

    /// What is aimed at and what was measured.
    pub fn goals(&self) -> String {
        let mut out = format!("# Diagnosis of driven mechanisms\n\n    {}\n\n", self.command);
        out.push_str("| what | aim | measured | 95 % | of | |\n|---|---|---:|---|---:|---|\n");
        for goal in &self.goals {
            let shown = |v: f64| if v > 1.0 { format!("{v:.0}") } else { percent(v) };
            let interval = goal
                .interval95
                .map_or_else(String::new, |(low, high)| format!("{:.1} to {:.1} %", 100.0 * low, 100.0 * high));
            let (what, relation, limit, measured) = (goal.what, goal.relation, shown(goal.limit), shown(goal.measured));
            let _ = writeln!(
                out,
                "| {what} | {relation} {limit} | {measured} | {interval} | {} | {} |",
                goal.sets,
                met(goal.met)
            );
        }
        out
    }
}

fn rollouts(trials: &[&DrivenTrial]) -> f64 {
    let counts = trials.iter().filter_map(|t| t.answer.as_ref()).map(|a| a.rollouts as f64);
    median(counts).unwrap_or(f64::NAN)
}

fn goals(trials: &[DrivenTrial]) -> Vec<Goal> {
    let those = |is: &dyn Fn(&DrivenTrial) -> bool| trials.iter().filter(|t| is(t)).collect::<Vec<_>>();
    let goal = |what, at_least: bool, limit: f64, of: &[&DrivenTrial], is: &dyn Fn(&DrivenTrial) -> bool| {
        let measured = share(of, |t| is(t));
        let hits = of.iter().filter(|t| is(t)).count();
        let met = if at_least { measured >= limit } else { measured <= limit };
        let relation = if at_least { "at least" } else { "at most" };
        Goal { what, relation, limit, measured, sets: of.len(), interval95: Some(wilson_interval(hits, of.len())), met }
    };
    let all: Vec<&DrivenTrial> = trials.iter().collect();
    let (clean, outside) = (those(&DrivenTrial::clean), those(&|t| !t.declared));
    let (at_10, in_catalogue) = (those(&|t| t.declared && t.ratio == 10.0), those(&|t| t.declared && !t.clean()));
    let cost = rollouts(&in_catalogue);
    vec![
        goal("exact at 10 times the noise", true, DRIVEN_EXACT, &at_10, &DrivenTrial::exact),
        goal("wrong lone names, all sets", false, DRIVEN_WRONG_NAME, &all, &DrivenTrial::wrong_lone_name),
        goal("nothing hidden, a name given", false, DRIVEN_FALSE_NAMES, &clean, &DrivenTrial::named),
        goal("undeclared: unknown, or one of a set with the doubt", true, DRIVEN_OPEN, &outside, &DrivenTrial::open),
        goal("undeclared: a wrong lone name", false, DRIVEN_WRONG_NAME, &outside, &DrivenTrial::wrong_lone_name),
        Goal {
            what: "rollouts of an answer where a candidate is hidden, median",
            relation: "at most",
            limit: DRIVEN_ROLLOUTS,
            measured: cost,
            sets: in_catalogue.len(),
            interval95: None,
            met: cost <= DRIVEN_ROLLOUTS,
        },
    ]
}

fn lines(trials: &[DrivenTrial]) -> Vec<Line> {
    let mut keys: Vec<(&str, &str, f64)> = Vec::new();
    for trial in trials {
        let key = (trial.plant.as_str(), trial.truth.as_str(), trial.ratio);
        if !keys.contains(&key) {
            keys.push(key);
        }
    }
    let line = |(plant, hidden, ratio): (&str, &str, f64)| {
        let of = |t: &&DrivenTrial| t.plant == plant && t.truth == hidden && t.ratio == ratio;
        let those: Vec<&DrivenTrial> = trials.iter().filter(of).collect();
        Line {
            plant: plant.into(),
            hidden: hidden.into(),
            ratio,
            sets: those.len(),
            exact: share(&those, |t| t.exact()),
            in_set: share(&those, |t| t.in_set()),
            wrong_lone_name: share(&those, |t| t.wrong_lone_name()),
            open: share(&those, |t| t.open()),
            unknown: share(&those, |t| t.unknown()),
            rollouts: rollouts(&those),
        }
    };
    keys.into_iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::super::trial::Answer;
    use super::*;
    use tunenet_core::diagnose::Verdict;

    fn one(truth: &str, ratio: f64, declared: bool, verdict: Verdict, names: &[&str]) -> DrivenTrial {
        let names = names.iter().map(ToString::to_string).collect();
        let answer = Some(Answer { verdict, names, doubt: false, rollouts: 700 });
        DrivenTrial { plant: "cart".into(), truth: truth.into(), ratio, declared, recordings: 4, answer }
    }

    #[test]
    fn a_wrong_lone_name_and_a_name_for_nothing_miss_their_goals() {
        let trials = vec![
            one("delay", 10.0, true, Verdict::Named, &["delay"]),
            one("ripple", 10.0, false, Verdict::Named, &["delay"]),
            one("nothing", 0.0, true, Verdict::OneOf, &["delay", "gain"]),
        ];
        let results = DrivenResults::new("command".into(), 1, true, trials);
        let met: Vec<bool> = results.goals.iter().map(|goal| goal.met).collect();
        assert_eq!(met, [true, false, false, false, false, true]);
        let text = results.markdown();
        assert!(text.contains("| cart | ripple | 10 | 1 | 0 % | 0 % | 100 % | 0 % | 0 % | 700 |"), "{text}");
    }
}
