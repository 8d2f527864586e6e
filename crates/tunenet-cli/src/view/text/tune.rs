//! The answer of `tunenet tune` for readers, and the notes with it.

use std::path::{Path, PathBuf};

use tunenet_core::tune::{Iteration, Outcome, Verdict, over_recordings};
use tunenet_sim::ChosenNetwork;

use super::{between, four_digits, in_words, list, note, rolled_out, rounded, stage, tally, verbose};
use crate::answers::tune::{Spent, Use, forced, is_written, reason};
use crate::files::names;
use crate::view::answer::Printout;

/// The verdict in one sentence.
pub fn sentence(outcome: &Outcome) -> String {
    let word = match outcome.verdict {
        Verdict::Tuned => "TUNED",
        Verdict::Rejected => "REJECTED",
        Verdict::PoorFit => "POOR FIT",
        Verdict::NotIdentifiable => "NOT IDENTIFIABLE",
    };
    let values: Vec<String> = outcome
        .parameters
        .iter()
        .map(|p| {
            let (low, high) = p.interval95;
            let half = (high - low) / 2.0;
            let unit = if p.unit == "1" { String::new() } else { format!(" {}", p.unit) };
            if p.identified {
                let range = between(&rounded(low, half), &rounded(high, half));
                let before = four_digits(p.before);
                format!("{} {}{unit} (95 %: {range}), was {before}", p.name, rounded(p.value, half))
            } else {
                format!("{} unknown", p.name)
            }
        })
        .collect();
    let reason = reason(outcome);
    let forced = if forced(outcome) { "FORCED, " } else { "" };
    match (values.is_empty(), reason) {
        (true, Some(note)) => format!("{word}  {}", note.text),
        (false, Some(note)) => format!("{forced}{word}  {}: {}", values.join(", "), note.text),
        _ => format!("{forced}{word}  {}", values.join(", ")),
    }
}

/// Which checks the recordings passed and which network was used, on standard error.
pub fn render_start(paths: &[PathBuf], outcome: &Outcome, chosen: &ChosenNetwork) {
    for (path, checks) in paths.iter().zip(&outcome.preflight).filter(|(_, checks)| !checks.is_empty()) {
        let which = if paths.len() > 1 { format!("{}: ", names::file_name(path)) } else { String::new() };
        stage("checked", &format!("{which}{}", tally(checks)));
    }
    stage("model", &chosen.text);
    note("");
}

/// The answer for readers; `names` are those of all recordings that were given.
pub fn printout(outcome: &Outcome, names: &[String]) -> Printout {
    let mut shown = Printout::default();
    shown.verdict(&sentence(outcome));
    let use_of = Use::of(outcome, names);
    if let Some(text) = use_of.sentence() {
        shown.line(&format!("  {text}"));
    }
    let rows = gaps(outcome);
    if !rows.is_empty() {
        shown.table(&rows);
        shown.line("");
    }
    for (name, own) in use_of.used.iter().zip(&outcome.nuisances).filter(|(_, own)| !own.is_empty()) {
        let each: Vec<String> = own.iter().map(|p| format!("{} {}", p.name, in_words(p.value, &p.unit))).collect();
        let which = if names.len() > 1 { format!(" of {name}") } else { String::new() };
        shown.line(&list(&format!("  also from the data{which}:"), &each));
    }
    if verbose() {
        shown.table(&iterations(outcome));
    }
    shown.warn_all(&outcome.notes);
    shown
}

/// The gap, in a line; a line for each channel where units differ or all details are asked for.
fn gaps(outcome: &Outcome) -> Vec<Vec<String>> {
    let Some(gap) = &outcome.gap else { return Vec::new() };
    let row = |name: String, unit: &str, all: [f64; 3]| {
        [name].into_iter().chain(all.map(|value| in_words(value, unit))).collect::<Vec<String>>()
    };
    let head = ["gap (RMS)", "before", "after", "noise floor"].map(String::from).to_vec();
    let channels = over_recordings(&outcome.gaps);
    let alike = channels.windows(2).all(|pair| pair[0].unit == pair[1].unit);
    let mut rows = vec![head];
    if alike {
        rows.push(row(String::new(), &gap.unit, [gap.before, gap.after, gap.noise_floor]));
    }
    if !alike || (verbose() && channels.len() > 1) {
        rows.extend(channels.iter().map(|c| row(c.channel.clone(), &c.unit, [c.before, c.after, c.noise_floor])));
    }
    rows
}

/// The parameters and the RMSE of every iteration.
fn iterations(outcome: &Outcome) -> Vec<Vec<String>> {
    let head = ["iteration".to_owned(), "RMSE".to_owned()].into_iter().chain(outcome.free.iter().cloned());
    let row = |i: &Iteration| {
        let values = i.parameters.iter().copied().map(four_digits);
        [i.k.to_string(), four_digits(i.rmse)].into_iter().chain(values).collect()
    };
    std::iter::once(head.collect()).chain(outcome.iterations.iter().map(row)).collect()
}

/// What was written, and what it cost, on standard error.
pub fn render_end(out: Option<&Path>, seed: u64, outcome: &Outcome, spent: Spent) {
    let wrote = match out {
        Some(out) if is_written(outcome) => format!("wrote {}, ", out.display()),
        Some(out) => format!("{} not written, since nothing was tuned; ", out.display()),
        None => String::new(),
    };
    let rollouts = rolled_out(outcome.rollouts, spent.re_asks);
    note(&format!("{wrote}{rollouts}, {:.1} s, seed {seed}", spent.seconds));
}
