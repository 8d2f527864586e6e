//! The answer for readers, and the notes with it.

use std::cmp::Ordering;
use std::path::Path;

use indicatif::ProgressBar;
use tunenet_core::diagnose::{
    Candidate, Change, Conclusion, Diagnosis, Doubt, NamedEffect, PartGap, Progress, Verdict,
};
use tunenet_core::observation::{Note, with_decimals};
use tunenet_sim::phase;

use super::fitted::{gap_line, parameter, ranged};
use super::{in_words, list, note, rolled_out, stage, verbose};
use crate::answers::diagnose::{Answer, Loaded, NOT_IN_CATALOGUE, why_insufficient};
use crate::answers::improved::Written;
use crate::view::answer::Printout;

/// Candidates that are shown without `--verbose`; the JSON has all of them.
const SHOWN: usize = 6;
/// Warnings of one kind that are shown in full.
const MOST_ALIKE: usize = 3;

/// Says what was read.
pub fn read(loaded: &Loaded) {
    let held_out = loaded.recorded.iter().filter(|r| r.held_out).count();
    let count = loaded.recorded.len() - held_out;
    let samples: usize = loaded.recorded.iter().map(|r| r.seen.len()).sum();
    let mut text = format!("{count} recording{}", if count == 1 { "" } else { "s" });
    if loaded.objects.len() > 1 {
        text = format!("{text} of {} objects", loaded.objects.len());
    }
    if held_out > 0 {
        text = format!("{text}, {held_out} held out");
    }
    stage("read", &format!("{text}, {samples} samples"));
}

/// Shows what is being done.
pub fn progress(working: &ProgressBar, at: Progress) {
    working.set_message(match at {
        Progress::NotUsed { name, why } => {
            working.suspend(|| note(&format!("not used: {name} ({})", why.text)));
            return;
        }
        Progress::Noticed(noticed) => {
            working.suspend(|| note(&format!("noticed: {}", noticed.text)));
            return;
        }
        Progress::Tuning => "tuning".to_owned(),
        Progress::Scoring { candidates, effects, rollouts, left } => {
            let addition = if effects == 0 { String::new() } else { format!(" in addition to {effects}") };
            let left = with_decimals(left, 1);
            format!("scoring {candidates} effects{addition} after {rollouts} rollouts, {left} times the noise left")
        }
        Progress::Fitting(name) => format!("fitting {name}"),
        Progress::Judging => "testing residuals".to_owned(),
    });
}

/// The whole answer.
pub fn answer(answer: &Answer) -> Printout {
    let (diagnosis, mut shown) = (answer.diagnosis, Printout::default());
    if let Some(gap) = &diagnosis.gap {
        let words = |value: f64| in_words(value, &gap.unit);
        let remains = if diagnosis.verdict() == Verdict::None { "nothing remains" } else { "structure remains" };
        shown.row("tuned", &format!("gap {}, noise floor {}: {remains}", words(gap.before), words(gap.noise_floor)));
    }
    shown.line("");
    shown.verdict(&sentence(answer));
    if let Some(text) = used(diagnosis) {
        shown.line(&format!("  {text}"));
    }
    let decides = answer.found().is_some();
    if let Some(law) = answer.law.filter(|_| decides) {
        super::law::lines(&mut shown, answer, law);
        let less = match (answer.rivals().is_empty(), diagnosis.effects().is_empty()) {
            (false, _) => ", effects of the catalogue explain as much",
            (true, false) => ", effects of the catalogue explain less",
            (true, true) => "",
        };
        shown.line(&format!("  without a law{less}:"));
    }
    let indent = if decides { "    " } else { "  " };
    for line in details(answer) {
        shown.line(&format!("{indent}{line}"));
    }
    let gaps = gaps(answer);
    if !gaps.is_empty() {
        shown.table(&gaps);
    }
    if !diagnosis.candidates.is_empty() {
        shown.table(&candidates(diagnosis));
    }
    let excluded = excluded(diagnosis);
    if !excluded.is_empty() {
        shown.line(&list("  excluded:", &excluded));
    }
    if let Some(line) = margins(diagnosis) {
        let without = if decides { "without a law, " } else { "" };
        shown.line(&format!("  {without}{line}"));
    }
    let aside: Vec<&str> = diagnosis
        .uses
        .iter()
        .filter(|u| u.used && u.held_out && !given_as_held_out(answer, &u.name))
        .map(|u| u.name.as_str())
        .collect();
    if !aside.is_empty() {
        shown.line(&format!("  held out for validation: {}", aside.join(", ")));
    }
    if let Some(law) = answer.law.filter(|_| !decides) {
        super::law::lines(&mut shown, answer, law);
    }
    // What distinguishes effects of the catalogue is no longer the question where a law explains more than they do.
    if let Some(next) = diagnosis.next_experiment.as_ref().filter(|_| !decides) {
        shown.line(&format!("  next: {}", next.text));
    }
    warnings(&mut shown, &answer.notes());
    shown
}

/// What was written, and what it cost, on standard error.
pub fn end(out: Option<&Path>, seed: u64, answer: &Answer, written: &Written) {
    let diagnosis = answer.diagnosis;
    let wrote = match written {
        Written::NotAsked => String::new(),
        Written::Files(files) => {
            let paths: Vec<String> = files.iter().map(|path| path.display().to_string()).collect();
            let several = diagnosis.verdict() == Verdict::OneOf;
            let with = if let Some((_, law)) = answer.found() {
                format!(" with {}", law.text())
            } else if several {
                format!(" with {}, the best of them", answer.chosen().join(" and "))
            } else {
                String::new()
            };
            format!("wrote {}{with}; ", paths.join(", "))
        }
        Written::Not(why) => {
            let out = out.map(|out| out.display().to_string()).unwrap_or_default();
            format!("{out} not written: {why}; ")
        }
    };
    let mut rollouts = rolled_out(answer.rollouts(), answer.re_asks);
    let for_law = answer.rollouts_for_law();
    if for_law > 0 {
        rollouts += &[" (", &for_law.to_string(), " of them in the search for a formula)"].concat();
    }
    note(&format!("{wrote}{rollouts}, {:.1} s, seed {seed}", answer.all_seconds()));
}

/// Of many recordings with the same to say, the first few.
fn warnings(shown: &mut Printout, notes: &[Note]) {
    for (i, note) in notes.iter().enumerate() {
        let before = notes[..i].iter().filter(|other| other.kind == note.kind).count();
        match before.cmp(&MOST_ALIKE) {
            Ordering::Less => shown.warn(note),
            Ordering::Equal => {
                let more = notes[i..].iter().filter(|other| other.kind == note.kind).count();
                let text = format!("{more} more of this kind; `--json` has all");
                shown.warn(&Note::new(note.kind, text, ""));
            }
            Ordering::Greater => {}
        }
    }
}

/// "3 of 4 recordings used; rejected: d.csv"; nothing where all are used, or none is.
fn used(diagnosis: &Diagnosis) -> Option<String> {
    let rejected: Vec<&str> = diagnosis.uses.iter().filter(|u| !u.used).map(|u| u.name.as_str()).collect();
    let (all, used) = (diagnosis.uses.len(), diagnosis.uses.len() - rejected.len());
    (used > 0 && used < all).then(|| format!("{used} of {all} recordings used; rejected: {}", rejected.join(", ")))
}

fn given_as_held_out(answer: &Answer, name: &str) -> bool {
    answer.loaded.recorded.iter().any(|r| r.held_out && r.name == name)
}

/// The verdict in one sentence.
pub fn sentence(answer: &Answer) -> String {
    let diagnosis = answer.diagnosis;
    if let Some(law) = super::law::headline(answer) {
        return law.to_string();
    }
    match diagnosis.verdict() {
        Verdict::None => "NONE  nothing is missing that these recordings could show".into(),
        Verdict::Named => format!("NAMED  {}", diagnosis.effects().iter().map(lone).collect::<Vec<_>>().join(" and ")),
        Verdict::OneOf => {
            let why = diagnosis.conclusion.doubt().map_or("these recordings cannot distinguish them".into(), |doubt| {
                let chosen = answer.chosen();
                // What no effect explains is explained by none of them by far.
                let by = if matches!(doubt, Doubt::DiscrepancyRemains) { "" } else { " by far" };
                let fit = if chosen.len() == 1 { "fits" } else { "fit" };
                format!("{} {fit} best{by}, but {doubt}", chosen.join(" and "))
            });
            format!("ONE OF  {}: {why}", choices(answer))
        }
        Verdict::Unknown => {
            let nearest = answer.candidates().first().map(|n| format!(" (nearest: {n})")).unwrap_or_default();
            format!("UNKNOWN  something is missing, and no known effect explains it{nearest}")
        }
        Verdict::Insufficient => format!("INSUFFICIENT  {}", why_insufficient(diagnosis)),
    }
}

/// What is left to choose from, place by place: `wind, magnus; in addition to quadratic_drag`.
fn choices(answer: &Answer) -> String {
    let (open, firm) = answer.open_and_firm();
    let one = |(i, names): (usize, &Vec<&str>)| {
        let article = if i > 0 && names.len() > 1 { "one of " } else { "" };
        format!("{article}{}", names.join(", "))
    };
    let open: Vec<String> = open.iter().enumerate().map(one).collect();
    let unknown = if answer.allows_unknown() { format!(", or {NOT_IN_CATALOGUE}") } else { String::new() };
    let certain = if firm.is_empty() { String::new() } else { format!("; in addition to {}", firm.join(" and ")) };
    format!("{}{unknown}{certain}", open.join("; and "))
}

fn lone(named: &NamedEffect) -> String {
    format!("{} {}", named.effect.name, phase::name(&named.effect.phase))
}

/// What a person wants to know beyond the verdict.
fn details(answer: &Answer) -> Vec<String> {
    let diagnosis = answer.diagnosis;
    let mut lines: Vec<String> = diagnosis.conclusion.description().map(Into::into).into_iter().collect();
    for named in diagnosis.effects() {
        for (fitted, key) in named.coefficients.iter().zip(answer.keys_of(named)) {
            let unit = if fitted.unit == "1" { "" } else { &fitted.unit };
            for value in &fitted.values {
                let object = answer.object(value).filter(|_| fitted.values.len() > 1);
                let object = object.map(|o| format!("{o}: ")).unwrap_or_default();
                let drag = answer.drag_coefficient(named, value);
                let drag = drag.map(|d| format!(", drag coefficient {}", ranged(&d, ""))).unwrap_or_default();
                let shown = named.shows(&fitted.key, value);
                let size = if shown { ranged(value, unit) } else { "is not shown by these recordings".into() };
                lines.push(format!("{object}{} {key} {size}{drag}", named.effect.name));
            }
        }
    }
    for (effect, objects) in answer.unneeded() {
        lines.push(format!("{effect} is not needed by the recordings of {}", objects.join(", ")));
    }
    lines.extend(diagnosis.parameters.iter().map(|tuned| parameter(answer, tuned)));
    if let Some(gap) = &diagnosis.gap {
        if !diagnosis.effects().is_empty() {
            lines.push(gap_line(gap));
        }
        if let Some((wrong, after)) = &gap.control {
            lines.push(format!("control: with {wrong} instead, held out {}", in_words(*after, &gap.unit)));
        }
    }
    lines
}

/// The gap of each object, or of each channel, where that says more than the one of all.
fn gaps(answer: &Answer) -> Vec<Vec<String>> {
    let parts = answer.gaps();
    let held_out = parts.iter().any(|part| part.held_out.is_some());
    let columns = ["gap of", "before", "after", "noise floor", "held out"];
    let shown = if held_out { columns.len() } else { columns.len() - 1 };
    let row = |part: &&PartGap| {
        let words = |value: f64| in_words(value, &part.unit);
        let change = |c: &Change| format!("{} → {}", words(c.before), words(c.after));
        let judged = part.held_out.as_ref().map_or("-".into(), change);
        let all = [answer.part_name(part), words(part.before), words(part.after), words(part.noise_floor), judged];
        all[..shown].to_vec()
    };
    let head = columns[..shown].iter().map(|&column| column.to_owned()).collect();
    if parts.is_empty() { Vec::new() } else { std::iter::once(head).chain(parts.iter().map(row)).collect() }
}

/// The best candidates, and the model without any.
fn candidates(diagnosis: &Diagnosis) -> Vec<Vec<String>> {
    let mut rows = vec![["effect", "BIC gain", "behind best", "held out"].map(String::from).to_vec()];
    let row = |c: &Candidate| {
        let about = if c.fitted { "" } else { "~" };
        let ratio = c.held_out_ratio.map_or("-".into(), |r| format!("×{}", with_decimals(r, 3)));
        vec![c.name.to_string(), format!("{about}{}", whole(c.bic_gain)), format!("{about}{}", whole(c.delta)), ratio]
    };
    let shown = |(i, c): &(usize, &Candidate)| *i < SHOWN || verbose() || diagnosis.names().contains(&c.name.as_ref());
    let left = diagnosis.candidates.iter().filter(|c| c.excluded.is_none()).enumerate().filter(shown);
    rows.extend(left.map(|(_, c)| row(c)));
    rows.push(vec!["none".into(), "0".into(), "-".into(), "×1".into()]);
    rows
}

/// What cannot be the answer, and why; together where the reason is the same.
fn excluded(diagnosis: &Diagnosis) -> Vec<String> {
    let all: Vec<(&str, String)> =
        diagnosis.candidates.iter().filter_map(|c| Some((c.name.as_ref(), c.excluded.as_ref()?.to_string()))).collect();
    let first = all.iter().enumerate().filter(|(i, (_, why))| all[..*i].iter().all(|(_, other)| other != why));
    let one = |(_, (_, why)): (usize, &(&str, String))| {
        let names: Vec<&str> = all.iter().filter(|(_, other)| other == why).map(|(name, _)| *name).collect();
        format!("{} ({why})", names.join(", "))
    };
    first.map(one).collect()
}

/// A whole number, and none that is 0 with a sign.
fn whole(value: f64) -> String {
    with_decimals(value.round() + 0.0, 0)
}

/// Two explanations that lie nearer to each other than this are as good.
const LEVEL: f64 = 0.5;

/// Margins and tests in one line.
fn margins(diagnosis: &Diagnosis) -> Option<String> {
    if diagnosis.adequacy.is_empty() {
        return None;
    }
    let passed = diagnosis.adequacy.iter().filter(|t| t.passed).count();
    let mut line = format!("{passed} of {} residual tests passed", diagnosis.adequacy.len());
    let failed: Vec<&str> = diagnosis.adequacy.iter().filter(|t| !t.passed).map(|t| t.name).collect();
    if !failed.is_empty() {
        line = format!("{line} (failed: {})", failed.join(", "));
    }
    let runners_up =
        diagnosis.effects().iter().filter_map(|e| Some((e.evidence.runner_up.as_ref()?, e.evidence.runner_up_bic_gap)));
    if let Some((name, gap)) = runners_up.min_by(|a, b| a.1.total_cmp(&b.1)) {
        // What is ahead was passed over for another reason than its evidence.
        let place = match gap {
            gap if gap.abs() < LEVEL => "as good".to_owned(),
            gap if gap < 0.0 => format!("{} ahead", whole(-gap)),
            gap => format!("{} behind", whole(gap)),
        };
        let kept = match &diagnosis.conclusion {
            // What is farther behind is kept where a doubt forbids a lone name.
            Conclusion::OneOf { names, .. } if gap > diagnosis.margin && names.contains(name) => {
                "kept with the best, which is in doubt".to_owned()
            }
            _ => format!("candidates within ΔBIC {:.0} are kept", diagnosis.margin),
        };
        line = format!("next best: {name}, {place}; {kept}; {line}");
    }
    Some(line)
}
