//! The answer of `tunenet tune` for readers, and the notes with it.

use std::path::{Path, PathBuf};

use tunenet_core::observation::after_number;
use tunenet_core::tune::{Estimate, Iteration, Outcome, Stop, Verdict, over_recordings};
use tunenet_sim::ChosenNetwork;

use super::{between, four_digits, in_words, list, note, rolled_out, rounded, stage, tally, verbose};
use crate::answers::tune::{Spent, Use, forced, is_written, reason};
use crate::files::names;
use crate::view::answer::Printout;

/// The verdict in capitals.
fn verdict_word(outcome: &Outcome) -> String {
    let word = match outcome.verdict {
        Verdict::Tuned => "TUNED",
        Verdict::Rejected => "REJECTED",
        Verdict::PoorFit if outcome.stop == Stop::Limit => "NOT FINISHED",
        Verdict::PoorFit => "POOR FIT",
        Verdict::NotIdentifiable => "NOT IDENTIFIABLE",
    };
    if forced(outcome) { format!("FORCED, {word}") } else { word.into() }
}

/// The verdict in one sentence.
pub fn sentence(outcome: &Outcome) -> String {
    let values: Vec<String> = outcome
        .parameters
        .iter()
        .map(|p| {
            let [value, range, before] = figures(p);
            if p.identified {
                format!("{} {value} (95 %: {range}), was {before}", p.name)
            } else {
                format!("{} unknown", p.name)
            }
        })
        .collect();
    titled(outcome, &values.join(", "))
}

/// The verdict, what it is about, and the reason where it is not the best one.
fn titled(outcome: &Outcome, what: &str) -> String {
    let word = verdict_word(outcome);
    match (what, reason(outcome)) {
        ("", Some(note)) => format!("{word}  {}", note.text),
        (what, Some(note)) => format!("{word}  {what}: {}", note.text),
        (what, None) => format!("{word}  {what}"),
    }
}

/// Value, 95 % interval and value before, with the decimals that the interval warrants.
fn figures(p: &Estimate) -> [String; 3] {
    let (low, high) = p.interval95;
    let half = (high - low) / 2.0;
    let unit = after_number(&p.unit);
    let range = between(&rounded(low, half), &rounded(high, half));
    [format!("{}{unit}", rounded(p.value, half)), range, four_digits(p.before)]
}

/// A row for each of several parameters.
fn parameters(outcome: &Outcome) -> Vec<Vec<String>> {
    let head = ["parameter", "value", "95 %", "was"].map(String::from).to_vec();
    let row = |p: &Estimate| {
        let [value, range, before] = figures(p);
        let value = if p.identified { value } else { "unknown".into() };
        let range = if p.identified { range } else { String::new() };
        vec![p.name.clone(), value, range, before]
    };
    std::iter::once(head).chain(outcome.parameters.iter().map(row)).collect()
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
    match outcome.parameters.len() {
        0 | 1 => shown.verdict(&sentence(outcome)),
        several => {
            let unknown = outcome.parameters.iter().filter(|p| !p.identified).count();
            let of = if unknown == 0 { String::new() } else { format!("{unknown} of ") };
            shown.verdict(&titled(outcome, &format!("{of}{several} parameters")));
            shown.table(&parameters(outcome));
            shown.line("");
        }
    }
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
        Some(out) if outcome.parameters.iter().any(|one| one.identified) => {
            format!("{} not written, since the recordings do not determine every parameter; ", out.display())
        }
        Some(out) => format!("{} not written, since nothing was tuned; ", out.display()),
        None => String::new(),
    };
    let rollouts = rolled_out(outcome.rollouts, spent.re_asks);
    note(&format!("{wrote}{rollouts}, {:.1} s, seed {seed}", spent.seconds));
}
