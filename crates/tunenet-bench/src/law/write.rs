//! The results as Markdown for users; the JSON is the value itself.

use std::fmt::Write as _;

use super::results::{Goal, LawResults, Unit, laws_inside};
use super::trial::Mark;
use crate::goals::met;
use crate::output::percent;

/// All tables. Writing to a string cannot fail, so its results are dropped.
pub fn markdown(results: &LawResults) -> String {
    let mut out = goals(results);
    let _ = writeln!(out, "\n{} of 26 laws inside the grammar. Numbers of sets:\n", laws_inside(&results.lines));
    out.push_str(
        "| row | hidden | sets | alone and right | in a set | alone and wrong | set without it | refused | nothing | failed \
         | held out | faster | left | nMSE | rollouts | s |\n|---|---|",
    );
    out.push_str(&"---:|".repeat(14));
    out.push('\n');
    for line in &results.lines {
        let marks = [line.exact, line.in_set, line.wrong, line.wrong_set, line.refused, line.nothing, line.failed];
        let marks = marks.map(|count| if count == 0 { String::new() } else { count.to_string() }).join(" | ");
        let ratios = [line.held_out_median, line.faster_median, line.left_median, line.nmse_median].map(shown_ratio);
        let rollouts = line.rollouts_median.map_or_else(String::new, |v| format!("{v:.0}"));
        let seconds = line.seconds_median.map_or_else(String::new, |v| format!("{v:.1}"));
        let _ = writeln!(
            out,
            "| {} | {} | {} | {marks} | {} | {rollouts} | {seconds} |",
            line.row,
            line.law,
            line.sets,
            ratios.join(" | ")
        );
    }
    out.push_str(
        "\n*Held out* and *faster* are medians of the error over the true law's, *left* is the error over that without the law, \
         from true starts.\n",
    );
    wrong(&mut out, results);
    out
}

/// What is aimed at and what was measured.
pub fn goals(results: &LawResults) -> String {
    let mut out = format!("# Laws\n\n    {}\n\n", results.command);
    out.push_str("| what | aim | measured | 95 % | of | |\n|---|---|---:|---|---:|---|\n");
    for goal in &results.goals {
        let interval = goal
            .interval95
            .map_or_else(String::new, |(low, high)| format!("{:.1} to {:.1} %", 100.0 * low, 100.0 * high));
        let verdict = goal.met.map_or("reported", met);
        let (what, aim, of) = (&goal.what, &goal.aim, goal.of);
        let _ = writeln!(out, "| {what} | {aim} | {} | {interval} | {of} | {verdict} |", shown(goal));
    }
    out
}

fn shown(goal: &Goal) -> String {
    let Some(value) = goal.measured else { return String::new() };
    match goal.unit {
        Unit::Share => percent(value),
        Unit::Ratio => shown_ratio(Some(value)),
        Unit::Rollouts => format!("{value:.0}"),
        Unit::Seconds => format!("{value:.1} s"),
    }
}

fn shown_ratio(value: Option<f64>) -> String {
    match value {
        None => String::new(),
        Some(value) if value < 1e-3 => format!("{value:.0e}"),
        Some(value) if value < 100.0 => format!("{value:.3}"),
        Some(value) if value < 1e6 => format!("{value:.0}"),
        Some(_) => "fails".into(),
    }
}

/// Every wrong answer, and what failed.
fn wrong(out: &mut String, results: &LawResults) {
    for (mark, title) in [
        (Mark::Wrong, "Alone and wrong"),
        (Mark::WrongSet, "Sets without the law"),
        (Mark::Refused, "Refused"),
        (Mark::Failed, "Failed"),
    ] {
        let is = |trial: &&super::trial::LawTrial| trial.outcome.as_ref().is_some_and(|one| one.mark == mark);
        if !results.trials.iter().any(|trial| is(&trial)) {
            continue;
        }
        let _ = writeln!(out, "\n## {title}\n");
        for trial in results.trials.iter().filter(is) {
            let Some(outcome) = &trial.outcome else { continue };
            let _ = write!(out, "- {} {} {}: {}", trial.row, trial.law, trial.number, outcome.words);
            if !outcome.refused.is_empty() {
                let _ = write!(out, "; {}", outcome.refused.join("; "));
            }
            out.push('\n');
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::results::tests::one;
    use super::super::rows::LawRow;
    use super::*;

    #[test]
    fn tables_hold_goals_lines_and_wrong_answers() {
        let trials = vec![
            one(LawRow::Ratio10, "drag-2", Mark::Exact),
            one(LawRow::Ratio10, "drag-3", Mark::Wrong),
            one(LawRow::Clean, "nothing, plane", Mark::Nothing),
        ];
        let text = markdown(&LawResults::new("tunenet bench law --seed 1".into(), 1, true, trials));
        for wanted in [
            "# Laws\n\n    tunenet bench law --seed 1\n",
            "| ratio 10 and 30: alone and wrong | at most 1 % | 50.0 % | 9.5 to 90.5 % | 2 | **missed** |",
            "| ratio-10 | drag-2 | 1 | 1 |  |  |  |  |  |  | 1.002 | 1.200 | 0.010 | 0.050 | 8000 | 4.0 |",
            "## Alone and wrong\n\n- ratio-10 drag-3 0: k * speed_m_s^2 along v\n",
            "2 of 26 laws",
        ] {
            assert!(text.contains(wanted), "{wanted}\n{text}");
        }
    }
}
