//! What was measured, as one value: rates and their goals.

use std::collections::BTreeMap;

use serde::Serialize;
use tunenet_core::statistics::{median, quantile, wilson_interval};

use super::blind::EffectKind;
use super::trial::{Answer, BlindTrial, Mark};
use crate::args::DiagnoseRow;
use crate::goals;

/// One row of the bench.
#[derive(Debug, Clone, Serialize)]
pub struct DiagnoseTable {
    pub row: &'static str,
    pub title: &'static str,
    /// What the numbers of a line are; shares are in percent.
    pub columns: Vec<&'static str>,
    pub lines: Vec<DiagnoseLine>,
    pub goals: Vec<DiagnoseGoalResult>,
    /// Truth, answer, how often.
    pub confusion: Vec<(String, String, u64)>,
}

#[derive(Debug, Clone, Serialize)]
pub struct DiagnoseLine {
    pub label: String,
    pub numbers: Vec<f64>,
}

/// A goal and what became of it.
#[derive(Debug, Clone, Serialize)]
pub struct DiagnoseGoalResult {
    pub what: &'static str,
    /// `at least` or `at most`.
    pub relation: &'static str,
    pub limit: f64,
    pub measured: f64,
    pub met: bool,
}

/// Everything.
#[derive(Debug, Clone, Serialize)]
pub struct DiagnoseResults {
    pub schema: &'static str,
    pub command: String,
    pub version: &'static str,
    pub seed: u64,
    pub quick: bool,
    pub rows: Vec<DiagnoseTable>,
}

/// The table of a row.
pub fn table(row: DiagnoseRow, trials: &[BlindTrial]) -> DiagnoseTable {
    let answered: Vec<&BlindTrial> = trials.iter().filter(|t| t.answer.is_some()).collect();
    let (columns, lines, goals) = match row {
        DiagnoseRow::Many => many(&answered),
        DiagnoseRow::Cost => cost(&answered),
        DiagnoseRow::Experiment => experiment(&answered),
        row if row.is_clean() => clean(&answered),
        DiagnoseRow::Two => two(&answered),
        DiagnoseRow::Outside => outside(&answered),
        DiagnoseRow::Formulas => formulas(&answered),
        DiagnoseRow::Three | DiagnoseRow::WrongMass | DiagnoseRow::OddBall | DiagnoseRow::Scatter => {
            troubled(&answered)
        }
        DiagnoseRow::Plane => plane(&answered),
        row => single(row, &answered),
    };
    DiagnoseTable { row: row.name(), title: row.title(), columns, lines, goals, confusion: confusion(&answered) }
}

/// The table of all rows together: shares of the sets with Wilson's 95 % intervals.
pub fn summary(rows: &[(DiagnoseRow, Vec<BlindTrial>)]) -> DiagnoseTable {
    let of = |is: &dyn Fn(DiagnoseRow, &BlindTrial) -> bool| -> Vec<&BlindTrial> {
        let each = rows.iter().flat_map(|(row, trials)| trials.iter().map(|trial| (*row, trial)));
        each.filter(|(row, trial)| trial.answer.is_some() && is(*row, trial)).map(|(_, trial)| trial).collect()
    };
    let single = |row: DiagnoseRow, ratios: &[f64]| row.ratio().is_some_and(|ratio| ratios.contains(&ratio));
    let wrong = |trial: &BlindTrial| trial.mark() == Some(Mark::Wrong);
    let exact = |trial: &BlindTrial| trial.mark() == Some(Mark::Exact);
    let named = |trial: &BlindTrial| trial.answer.as_ref().is_some_and(Answer::names_something);
    let mut lines = Vec::new();
    let mut goals = Vec::new();
    let mut add = |label: &'static str, sets: &[&BlindTrial], is: &dyn Fn(&BlindTrial) -> bool| {
        let hits = sets.iter().filter(|trial| is(trial)).count();
        let (low, high) = wilson_interval(hits, sets.len());
        let measured = percent(sets, is);
        let numbers = [sets.len() as f64, hits as f64, measured.unwrap_or(0.0), 100.0 * low, 100.0 * high];
        lines.push(DiagnoseLine { label: label.into(), numbers: numbers.to_vec() });
        measured
    };
    let all = of(&|row, _| !matches!(row, DiagnoseRow::Experiment | DiagnoseRow::Cost));
    let label = "wrong lone name, all rows";
    goals.extend(at_most("wrong lone names of all sets, %", goals::WRONG_OF_ALL, add(label, &all, &wrong)));
    let many = of(&|row, trial| single(row, &[3.0, 10.0, 30.0]) && trial.drops >= 3);
    let label = "one effect named exactly, ratios 3, 10 and 30, 3 drops or more";
    goals.extend(at_least("one effect named exactly, %", goals::EXACT_ABOVE, add(label, &many, &exact)));
    let clean = of(&|row, _| row.is_clean());
    let label = "nothing hidden, and an effect named";
    goals.extend(at_most("nothing hidden, and an effect named, %", goals::FALSE_NAMES, add(label, &clean, &named)));
    let outside = of(&|row, _| row == DiagnoseRow::Outside);
    let label = "not in the catalogue, and a lone name given";
    goals.extend(at_most("not in the catalogue, a lone name, %", goals::WRONG_NAME, add(label, &outside, &wrong)));
    DiagnoseTable {
        row: "all",
        title: "all rows together, with 95 % intervals (Wilson 1927)",
        columns: vec!["sets", "cases", "%", "at least", "at most"],
        lines,
        goals,
        confusion: Vec::new(),
    }
}

type Parts = (Vec<&'static str>, Vec<DiagnoseLine>, Vec<DiagnoseGoalResult>);

fn at_least(what: &'static str, limit: f64, measured: Option<f64>) -> Option<DiagnoseGoalResult> {
    measured.map(|measured| DiagnoseGoalResult { what, relation: "at least", limit, measured, met: measured >= limit })
}

fn at_most(what: &'static str, limit: f64, measured: Option<f64>) -> Option<DiagnoseGoalResult> {
    measured.map(|measured| DiagnoseGoalResult { what, relation: "at most", limit, measured, met: measured <= limit })
}

/// How many of `trials` have one of these marks, in percent.
fn share(trials: &[&BlindTrial], marks: &[Mark]) -> Option<f64> {
    percent(trials, |t| t.mark().is_some_and(|m| marks.contains(&m)))
}

fn percent(trials: &[&BlindTrial], is: impl Fn(&BlindTrial) -> bool) -> Option<f64> {
    let hits = trials.iter().filter(|t| is(t)).count();
    (!trials.is_empty()).then(|| 100.0 * hits as f64 / trials.len() as f64)
}

fn with_drops<'a>(trials: &[&'a BlindTrial], drops: impl Fn(usize) -> bool) -> Vec<&'a BlindTrial> {
    trials.iter().filter(|t| drops(t.drops)).copied().collect()
}

/// One line for each number of drops.
fn by_drops(trials: &[&BlindTrial], numbers: impl Fn(&[&BlindTrial]) -> Vec<f64>) -> Vec<DiagnoseLine> {
    let mut drops: Vec<usize> = trials.iter().map(|t| t.drops).collect();
    drops.sort_unstable();
    drops.dedup();
    let line = |d: usize| {
        let those = with_drops(trials, |drops| drops == d);
        let label = if d == 1 { "1 drop".into() } else { format!("{d} drops") };
        DiagnoseLine { label, numbers: std::iter::once(those.len() as f64).chain(numbers(&those)).collect() }
    };
    drops.into_iter().map(line).collect()
}

const MARKS: [Mark; 7] =
    [Mark::Exact, Mark::Set, Mark::Part, Mark::Wrong, Mark::WrongSet, Mark::Unknown, Mark::Nothing];
const MARK_COLUMNS: [&str; 8] = ["sets", "exact", "in the set", "part", "wrong", "wrong set", "unknown", "none"];

fn marks(trials: &[&BlindTrial]) -> Vec<f64> {
    MARKS.iter().filter_map(|mark| share(trials, &[*mark])).collect()
}

fn clean(trials: &[&BlindTrial]) -> Parts {
    let verdict = |t: &BlindTrial, word: &str| t.answer.as_ref().is_some_and(|a| a.verdict == word);
    let named = |those: &[&BlindTrial]| percent(those, |t| t.answer.as_ref().is_some_and(Answer::names_something));
    let lines = by_drops(trials, |those| {
        let of = |word: &str| percent(those, |t| verdict(t, word));
        [of("none"), of("named"), of("one_of"), of("unknown"), of("insufficient")].into_iter().flatten().collect()
    });
    let goals = at_most("sets in which an effect was named, alone or in a set, %", goals::FALSE_NAMES, named(trials));
    (vec!["sets", "none", "named", "one_of", "unknown", "insufficient"], lines, goals.into_iter().collect())
}

fn single(row: DiagnoseRow, trials: &[&BlindTrial]) -> Parts {
    let many = with_drops(trials, |drops| drops >= 3);
    let mut lines = by_drops(trials, marks);
    let mut goals = Vec::new();
    let wrong = share(&many, &[Mark::Wrong]);
    if row == DiagnoseRow::Ratio3 {
        goals.extend(at_least("exact, 3 drops or more, %", goals::EXACT_AT_3, share(&many, &[Mark::Exact])));
        goals.extend(at_least(
            "exact or in the set, 3 drops or more, %",
            goals::IN_SET_AT_3,
            share(&many, &[Mark::Exact, Mark::Set]),
        ));
    } else if row != DiagnoseRow::Ratio1 {
        goals.extend(at_least("exact, 3 drops or more, %", goals::EXACT_ABOVE, share(&many, &[Mark::Exact])));
    }
    if row != DiagnoseRow::Ratio1 {
        goals.extend(at_most("wrong lone name, 3 drops or more, %", goals::WRONG_NAME, wrong));
        let twins = |t: &BlindTrial| !super::trial::twins(&t.truth).is_empty();
        let scales: Vec<&BlindTrial> = many.iter().filter(|t| twins(t)).copied().collect();
        goals.extend(at_least(
            "exact twins named together, 3 drops or more, %",
            goals::TWINS_TOGETHER,
            together(&scales),
        ));
        let (held_out, forecast) = (ratios(&many, |f| f.0, |a| a.held_out_m), ratios(&many, |f| f.1, |a| a.forecast_m));
        goals.extend(at_most(
            "held-out residual over the true model's, median",
            goals::HELD_OUT_MEDIAN,
            quantile(held_out.iter().copied(), 0.5),
        ));
        goals.extend(at_most(
            "held-out residual over the true model's, 90 %",
            goals::HELD_OUT_90,
            quantile(held_out.iter().copied(), 0.9),
        ));
        goals.extend(at_most(
            "forecast error over the true model's, median",
            goals::FORECAST_MEDIAN,
            quantile(forecast, 0.5),
        ));
    }
    let mut effects: Vec<&String> = many.iter().flat_map(|t| &t.truth).collect();
    effects.sort_unstable();
    effects.dedup();
    for effect in effects {
        let those: Vec<&BlindTrial> = many.iter().filter(|t| t.truth.contains(effect)).copied().collect();
        let numbers = std::iter::once(those.len() as f64).chain(marks(&those)).collect();
        lines.push(DiagnoseLine { label: format!("{effect}, 3 drops or more"), numbers });
    }
    (MARK_COLUMNS.to_vec(), lines, goals)
}

/// Among answers to an effect with twins that named something: how many named the twins together.
fn together(trials: &[&BlindTrial]) -> Option<f64> {
    let named: Vec<&BlindTrial> =
        trials.iter().filter(|t| t.answer.as_ref().is_some_and(Answer::names_something)).copied().collect();
    percent(&named, |t| {
        let Some(answer) = &t.answer else { return false };
        let offered = |twin: &str| answer.effects.iter().chain(&answer.candidates).any(|name| name == twin);
        answer.verdict == "one_of" && super::trial::twins(&t.truth).iter().all(|twin| offered(twin))
    })
}

/// What an answer leaves over what the true world leaves. Scatter at bounces is no model that predicts.
fn ratios(
    trials: &[&BlindTrial],
    floor: impl Fn((f64, f64)) -> f64,
    left: impl Fn(&Answer) -> Option<f64>,
) -> Vec<f64> {
    let predictable = trials.iter().filter(|t| !t.truth.iter().any(|name| name == "bounce_scatter"));
    let ratio = |t: &&BlindTrial| {
        let answer = t.answer.as_ref().filter(|a| a.names_something())?;
        Some(left(answer)? / floor(t.floor_m?))
    };
    predictable.filter_map(ratio).collect()
}

fn two(trials: &[&BlindTrial]) -> Parts {
    let goals = [
        at_least("both named, %", goals::BOTH_NAMED, share(trials, &[Mark::Exact])),
        at_most("a wrong name, %", goals::WRONG_OF_TWO, share(trials, &[Mark::Wrong])),
    ];
    (MARK_COLUMNS.to_vec(), by_drops(trials, marks), goals.into_iter().flatten().collect())
}

fn outside(trials: &[&BlindTrial]) -> Parts {
    let many = with_drops(trials, |drops| drops >= 3);
    let open = percent(&many, |t| t.answer.as_ref().is_some_and(|a| a.verdict == "unknown" || a.verdict == "one_of"));
    let goals = [
        at_least("unknown or one of a set, 3 drops or more, %", goals::OUTSIDE_OPEN, open),
        at_most("wrong lone name, 3 drops or more, %", goals::WRONG_NAME, share(&many, &[Mark::Wrong])),
    ];
    (MARK_COLUMNS.to_vec(), by_drops(trials, marks), goals.into_iter().flatten().collect())
}

/// A line for each formula that acts, and one for sets in which none does.
fn formulas(trials: &[&BlindTrial]) -> Parts {
    let (clean, acting): (Vec<&BlindTrial>, Vec<&BlindTrial>) = trials.iter().partition(|t| t.truth.is_empty());
    let named = percent(&clean, |t| t.answer.as_ref().is_some_and(Answer::names_something));
    let goals = [
        at_least("exact, %", goals::EXACT_ABOVE, share(&acting, &[Mark::Exact])),
        at_most("wrong lone name, %", goals::WRONG_NAME, share(trials, &[Mark::Wrong])),
        at_most("nothing hidden, and an effect named, %", goals::FALSE_NAMES, named),
    ];
    let mut truths: Vec<&[String]> = trials.iter().map(|t| t.truth.as_slice()).collect();
    truths.sort_unstable();
    truths.dedup();
    let line = |truth: &[String]| {
        let those: Vec<&BlindTrial> = trials.iter().filter(|t| t.truth == truth).copied().collect();
        let label = truth.first().cloned().unwrap_or_else(|| "nothing".into());
        DiagnoseLine { label, numbers: std::iter::once(those.len() as f64).chain(marks(&those)).collect() }
    };
    (MARK_COLUMNS.to_vec(), truths.into_iter().map(line).collect(), goals.into_iter().flatten().collect())
}

/// Sets with more against them than noise: what counts is that no wrong name is given.
fn troubled(trials: &[&BlindTrial]) -> Parts {
    let goal = at_most("wrong lone name, %", goals::WRONG_NAME, share(trials, &[Mark::Wrong]));
    (MARK_COLUMNS.to_vec(), by_drops(trials, marks), goal.into_iter().collect())
}

/// The same with a line for sets in which nothing is hidden, and one for the others.
fn plane(trials: &[&BlindTrial]) -> Parts {
    let (clean, acting): (Vec<&BlindTrial>, Vec<&BlindTrial>) = trials.iter().partition(|t| t.truth.is_empty());
    let line = |(label, those): (&str, &[&BlindTrial])| DiagnoseLine {
        label: label.into(),
        numbers: std::iter::once(those.len() as f64).chain(marks(those)).collect(),
    };
    let lines = [("nothing hidden", clean.as_slice()), ("one effect", acting.as_slice())].map(line);
    let (columns, _, goals) = troubled(trials);
    (columns, lines.to_vec(), goals)
}

/// Pairs of the truth and another candidate that is no twin of it, before the experiment and after.
fn experiment(trials: &[&BlindTrial]) -> Parts {
    let (mut pairs, mut separated, mut lost) = (0, 0, 0);
    for trial in trials {
        let Some(first) = &trial.answer else { continue };
        let [truth] = &trial.truth[..] else { continue };
        let offered =
            |answer: &Answer, name: &str| answer.effects.iter().chain(&answer.candidates).any(|other| other == name);
        if !offered(first, truth) {
            continue;
        }
        let twins = super::trial::twins(&trial.truth);
        let others = first.candidates.iter().filter(|c| *c != truth && !twins.contains(&c.as_str()));
        for other in others {
            pairs += 1;
            // Where nothing was asked for, nothing is separated.
            let Some(then) = &trial.then else { continue };
            separated += u32::from(!offered(then, other) && offered(then, truth));
            lost += u32::from(!offered(then, truth));
        }
    }
    let of = |count: u32| if pairs == 0 { 0.0 } else { 100.0 * f64::from(count) / f64::from(pairs) };
    let numbers = vec![trials.len() as f64, f64::from(pairs), of(separated), of(lost)];
    let goal = at_least(
        "separable pairs that the experiment separates, %",
        goals::SEPARATED,
        (pairs > 0).then(|| of(separated)),
    );
    let line = DiagnoseLine { label: "1 drop, then 1 more".into(), numbers };
    (vec!["sets", "pairs", "separated", "truth lost"], vec![line], goal.into_iter().collect())
}

fn cost(trials: &[&BlindTrial]) -> Parts {
    let of = |pick: &dyn Fn(&Answer) -> f64| -> Vec<f64> {
        trials.iter().filter_map(|t| t.answer.as_ref()).map(pick).collect()
    };
    let (rollouts, seconds) = (of(&|a| a.rollouts as f64), of(&|a| a.seconds));
    let goals = [
        at_most("rollouts, median", goals::ANSWER_ROLLOUTS, median(rollouts.iter().copied())),
        at_most("seconds, median", goals::ANSWER_S, median(seconds.iter().copied())),
    ];
    let greatest = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    let line = |label: &str, values: &[f64]| {
        let numbers = vec![values.len() as f64, median(values.iter().copied()).unwrap_or(0.0), greatest(values)];
        DiagnoseLine { label: label.into(), numbers }
    };
    let lines = vec![line("rollouts", &rollouts), line("seconds", &seconds)];
    (vec!["sets", "median", "greatest"], lines, goals.into_iter().flatten().collect())
}

fn many(trials: &[&BlindTrial]) -> Parts {
    let is_in = |trial: &BlindTrial| EffectKind::CATALOGUE.iter().any(|kind| trial.truth == [kind.name()]);
    let rollouts = |trials: &[&BlindTrial]| -> Vec<f64> {
        trials.iter().filter_map(|t| t.answer.as_ref()).map(|answer| answer.rollouts as f64).collect()
    };
    let greatest = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    let line = |label: &str, is: &dyn Fn(&BlindTrial) -> bool| {
        let own: Vec<&BlindTrial> = trials.iter().copied().filter(|trial| is(trial)).collect();
        let of = rollouts(&own);
        let shares = [Mark::Exact, Mark::Wrong].map(|mark| share(&own, &[mark]).unwrap_or(0.0));
        let numbers =
            [own.len() as f64, median(of.iter().copied()).unwrap_or(0.0), greatest(&of), shares[0], shares[1]];
        DiagnoseLine { label: label.into(), numbers: numbers.to_vec() }
    };
    let all = rollouts(trials);
    let goals = [
        at_most("rollouts, median", goals::MANY_ROLLOUTS, median(all.iter().copied())),
        at_most("rollouts, greatest", goals::MANY_ROLLOUTS, (!all.is_empty()).then(|| greatest(&all))),
        at_most("wrong lone name, %", goals::WRONG_NAME, share(trials, &[Mark::Wrong])),
    ];
    let columns = vec!["sets", "rollouts, median", "rollouts, greatest", "exact %", "wrong lone name %"];
    let lines = vec![
        line("nothing hidden", &|trial| trial.truth.is_empty()),
        line("in the catalogue", &is_in),
        line("not in the catalogue", &|trial| !trial.truth.is_empty() && !is_in(trial)),
    ];
    (columns, lines, goals.into_iter().flatten().collect())
}

fn confusion(trials: &[&BlindTrial]) -> Vec<(String, String, u64)> {
    let mut counts: BTreeMap<(String, String), u64> = BTreeMap::new();
    for trial in trials {
        let Some(answer) = &trial.answer else { continue };
        let truth = if trial.truth.is_empty() { "nothing".into() } else { trial.truth.join(" + ") };
        *counts.entry((format!("{truth}, {}", drops(trial.drops)), answer.words())).or_default() += 1;
    }
    counts.into_iter().map(|((truth, answer), count)| (truth, answer, count)).collect()
}

fn drops(count: usize) -> String {
    if count == 1 { "1 drop".into() } else { format!("{count} drops") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trial(truth: &str, verdict: &str, effect: &str, held_out_m: f64) -> BlindTrial {
        let answer = Answer {
            verdict: verdict.into(),
            effects: vec![effect.into()],
            candidates: vec![],
            held_out_m: Some(held_out_m),
            forecast_m: None,
            rollouts: 100,
            seconds: 1.0,
        };
        BlindTrial { truth: vec![truth.into()], drops: 3, answer: Some(answer), floor_m: Some((1.0, 1.0)), then: None }
    }

    #[test]
    fn rollouts_of_many_drops_are_compared_with_their_limit() {
        let mut trials = vec![trial("wind", "named", "wind", 1.01); 3];
        let Some(answer) = &mut trials[2].answer else { panic!("answered") };
        answer.rollouts = 30_000;
        trials.push(trial("vortex", "named", "wind", 1.5));
        let table = table(DiagnoseRow::Many, &trials);
        assert_eq!(table.lines[1].numbers, [3.0, 100.0, 30_000.0, 100.0, 0.0]);
        assert_eq!(table.lines[2].numbers, [1.0, 100.0, 100.0, 0.0, 100.0]);
        let goal = |what: &str| table.goals.iter().find(|g| g.what == what).unwrap();
        assert!(goal("rollouts, median").met && !goal("rollouts, greatest").met);
    }

    #[test]
    fn rates_are_held_against_their_goals() {
        let mut trials = vec![trial("wind", "named", "wind", 1.01); 19];
        trials.push(trial("wind", "named", "magnus", 1.5));
        let table = table(DiagnoseRow::Ratio10, &trials);
        let goal = |start: &str| table.goals.iter().find(|g| g.what.starts_with(start)).unwrap();
        assert!(goal("exact, 3").met && goal("exact, 3").measured == 95.0);
        assert!(!goal("wrong").met && goal("wrong").measured == 5.0);
        assert!(goal("held-out residual over the true model's, median").met);
        assert_eq!(table.confusion.len(), 2);
        let all = summary(&[(DiagnoseRow::Ratio10, trials)]);
        assert_eq!(all.lines[0].numbers[..3], [20.0, 1.0, 5.0]);
        assert!(all.lines[0].numbers[4] > 20.0 && all.goals.iter().filter(|goal| goal.met).count() == 1);
    }
}
