//! The results as Markdown for users; the JSON is the value itself.

use std::fmt::Write as _;

use super::results::{Goal, JointResults, Line};
use super::trial::Mark;
use crate::goals::met;
use crate::output::percent;

const COLUMNS: &str = "sets | exact | in a set | wrong lone name | set without it | unknown | nothing | failed | surviving RMS | \
                       in standard deviations | rollouts | s |";

/// All tables. Writing to a string cannot fail, so its results are dropped.
pub fn markdown(results: &JointResults) -> String {
    let mut out = goals(results);
    let _ = writeln!(
        out,
        "\nNumbers of sets. *Surviving* is what tuning the motor's numbers leaves of the effect, in units of the noise; {} sets were \
         not drawn, since no physical size of their effect reaches the ratio.\n",
        results.unreachable
    );
    table(&mut out, "all effects", &results.ratios);
    if !results.hidden_by_tuning.is_empty() {
        out.push_str("\n## Hidden by tuning: less than 3 standard deviations survive\n\n");
        table(&mut out, "all effects", &results.hidden_by_tuning);
    }
    out.push_str("\n## By effect\n\n");
    table(&mut out, "", &results.effects);
    wrong(&mut out, results);
    out
}

fn table(out: &mut String, all: &str, lines: &[Line]) {
    let _ = writeln!(out, "| hidden | ratio | {COLUMNS}");
    let _ = writeln!(out, "|---|---:|{}", "---:|".repeat(12));
    for line in lines {
        let of = line.counts;
        let marks = [of.exact, of.in_set, of.wrong, of.wrong_set, of.unknown, of.nothing, of.failed];
        let marks = marks.map(|count| if count == 0 { String::new() } else { count.to_string() }).join(" | ");
        let number = |value: Option<f64>, digits: usize| value.map_or_else(String::new, |v| format!("{v:.digits$}"));
        let hidden = line.hidden.as_deref().unwrap_or(if line.ratio == 0.0 { "nothing" } else { all });
        let _ = writeln!(
            out,
            "| {hidden} | {} | {} | {marks} | {} | {} | {} | {} |",
            line.ratio,
            of.sets,
            number(line.surviving_rms, 2),
            number(line.surviving_sigma, 0),
            number(line.rollouts, 0),
            number(line.seconds, 1)
        );
    }
}

/// What is aimed at and what was measured.
pub fn goals(results: &JointResults) -> String {
    let mut out = format!("# Robot joints\n\n    {}\n\n", results.command);
    out.push_str("| what | aim | measured | 95 % | of | |\n|---|---|---:|---|---:|---|\n");
    for goal in &results.goals {
        let interval = goal
            .interval95
            .map_or_else(String::new, |(low, high)| format!("{:.1} to {:.1} %", 100.0 * low, 100.0 * high));
        let verdict = goal.met.map_or("", met);
        let _ =
            writeln!(out, "| {} | {} | {} | {interval} | {} | {verdict} |", goal.what, goal.aim, shown(goal), goal.of);
    }
    out
}

fn shown(goal: &Goal) -> String {
    match goal.measured {
        None => String::new(),
        Some(count) if count > 1.0 => format!("{count:.0}"),
        Some(value) => percent(value),
    }
}

/// Every answer that is wrong, and what failed.
fn wrong(out: &mut String, results: &JointResults) {
    for (mark, title) in [
        (Mark::Wrong, "Wrong lone names"),
        (Mark::WrongSet, "Sets without the truth"),
        (Mark::Unknown, "Unknown"),
        (Mark::Nothing, "Nothing"),
        (Mark::Failed, "Failed"),
    ] {
        let of_mark = |trial: &&super::trial::JointTrial| {
            let expected = trial.hidden.is_none() && mark == Mark::Nothing;
            !expected && trial.outcome.as_ref().is_some_and(|one| one.mark == mark)
        };
        if !results.trials.iter().any(|trial| of_mark(&trial)) {
            continue;
        }
        let _ = writeln!(out, "\n## {title}\n");
        for trial in results.trials.iter().filter(of_mark) {
            let Some(outcome) = &trial.outcome else { continue };
            let hidden = trial.hidden.as_deref().unwrap_or("nothing");
            let _ = writeln!(
                out,
                "- {hidden} at {}, set {} ({:.0} standard deviations survive): {}",
                trial.ratio, trial.number, outcome.surviving.sigma, outcome.words
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::results::tests::one;
    use super::*;

    #[test]
    fn tables_hold_goals_lines_and_wrong_answers() {
        let trials = vec![
            one(Some("dead_band"), 10.0, Mark::Exact, 50.0),
            one(Some("dead_band"), 10.0, Mark::Wrong, 30.0),
            one(Some("dead_band"), 3.0, Mark::Nothing, 1.0),
            one(None, 0.0, Mark::Nothing, 0.0),
        ];
        let text = markdown(&JointResults::new("tunenet bench joints --seed 1".into(), 1, true, trials));
        for wanted in [
            "# Robot joints\n\n    tunenet bench joints --seed 1\n",
            "| ratio 10: wrong lone name | at most 1 % | 50.0 % | 9.5 to 90.5 % | 2 | **missed** |",
            "| three runs: rollouts, median | at most 2000 | 1500 |  | 3 | met |",
            "| nothing | 0 | 1 |  |  |  |  |  | 1 |  | 0.00 | 0 | 1500 | 0.5 |",
            "## Hidden by tuning",
            "| dead_band | 10 | 2 | 1 |  | 1 |  |  |  |  | 5.00 | 50 | 1500 | 0.5 |",
            "## Wrong lone names\n\n- dead_band at 10, set 0 (30 standard deviations survive): backlash\n",
        ] {
            assert!(text.contains(wanted), "{wanted}\n{text}");
        }
    }
}
