//! The page of `tunenet diagnose`.

mod candidates;
mod change;
mod course;
mod finding;
mod law;
mod left_over;
mod numbers;
mod pairs;

use std::path::Path;

use maud::{Markup, html};
use tunenet_core::diagnose::{Change, Diagnosis, Explained, GapOf, Verdict};
use tunenet_core::observation::{Kind, with_decimals};
use tunenet_formats::Result;
use tunenet_sim::phase;

use self::pairs::{Pair, pairs};
use super::provenance::Provenance;
use super::series::{Series, drawings};
use super::verdict::{capital, prose, quantity};
use super::{checks, page};
use crate::answers::diagnose::{Answer, Edited};

/// Recordings whose held-out gap is drawn.
const MOST_PAIRS: usize = 12;

/// Writes the page.
pub fn write(
    path: &Path,
    answer: &Answer,
    edits: &std::result::Result<Vec<Edited>, &'static str>,
    provenance: &Provenance,
) -> Result<()> {
    let body = html! {
        (finding::finding(answer))
        (seen(answer))
        (evidence(answer))
        (numbers(answer))
        (law::section(answer))
        (apart(answer))
        h2 { "Changes to the simulation file" }
        (change::change(edits))
        h2 { "Excluded effects and recordings" }
        (excluded(answer))
        h2 { "Warnings and notes" }
        (checks::warnings(&answer.notes()))
        h2 { "Provenance" }
        (provenance.section(&answer.rollouts().to_string()))
    };
    page::write(path, &page::page("Diagnosis", &title(answer), &body))
}

fn title(answer: &Answer) -> String {
    let (recorded, objects) = (&answer.loaded.recorded, answer.loaded.objects.len());
    match &recorded[..] {
        [one] => one.name.clone(),
        several if objects > 1 => format!("{} recordings of {objects} objects", several.len()),
        several => format!("{} recordings", several.len()),
    }
}

/// Whether the simulation after differs from that before.
fn differs(all: &[Explained]) -> bool {
    all.iter().any(|one| one.before != one.after)
}

/// Measured and simulated, and what is left.
fn seen(answer: &Answer) -> Markup {
    let all = answer.explained();
    let both = differs(&all);
    if all.is_empty() {
        let series: Vec<Series> =
            answer.loaded.recorded.iter().flat_map(|r| Series::unused(&r.name, &r.seen)).take(12).collect();
        return html! { h2 { "Recordings" } (drawings(&series, false)) };
    }
    let shown = left_over::chosen(&all);
    let added = if answer.found().is_some() { "law" } else { "effect" };
    let dots = if both { format!("with the {added}") } else { "tuned".to_owned() };
    html! {
        h2 { "Measured and simulated" @if both { ", before and after" } }
        (left_over::overlays(&shown, both, added))
        h2 { "Residuals" @if both { ", before and after" } }
        (left_over::residuals(&shown, all.len(), both, &dots))
        h2 { @if answer.diagnosis.verdict() == Verdict::None { "Location of the residual" } @else { "Location of the effect" } }
        (place(answer, &all, both))
    }
}

/// In which phase and state of the motion the disagreement shows.
fn place(answer: &Answer, explained: &[Explained], both: bool) -> Markup {
    let diagnosis = answer.diagnosis;
    let groups = left_over::places(explained);
    let all_of = |kind: Kind| answer.loaded.recorded.iter().all(|r| r.seen.kind() == kind);
    let (driven, other) = (all_of(Kind::Joints), all_of(Kind::Other));
    html! {
        @if !diagnosis.effects().is_empty() && answer.found().is_none() {
            ul.plain {
                @for named in diagnosis.effects() {
                    li { code { (named.effect.name) } " acts " b { (phase::name(&named.effect.phase)) } ": " (named.effect.sentence) "." }
                }
            }
        }
        @if let Some(text) = &diagnosis.conclusion.description() { p { (capital(text)) "." } }
        div.grid {
            @for (title, places) in &groups {
                @let rows: Vec<Pair> = places.iter().map(|p| pair(&p.name, both.then_some(p.before), p.after, |v| format!("{}\u{a0}\u{3c3}", with_decimals(v, 2)))).collect();
                figure { figcaption.above { "Misfit " (title) } (pairs(&rows, Some((1.0, "noise floor")), &format!("misfit {title}"))) }
            }
            @if !groups.is_empty() {
                p.how {
                    "Root mean square of the residuals above. " @if both { "The dashed mark is before, the dot after. " }
                    @if driven { "What follows speed, acceleration or pose shows most where these are large; a wrong reading shows in one joint." }
                    @else if other { "A wrong clock shows most where things change fast; a wrong scale where they are large." }
                    @else { "A force in flight bends every flight and shows most where the ball is fast or high; an effect of contact does "
                    "not change the first flight; one of the measurement shows along one axis or at one height." }
                }
            }
        }
    }
}

fn pair(name: &str, before: Option<f64>, after: f64, words: impl Fn(f64) -> String) -> Pair {
    let shown = before.map_or_else(|| words(after), |b| format!("{} \u{2192} {}", words(b), words(after)));
    Pair { name: name.into(), before, after, shown }
}

/// Candidates and held-out recordings.
fn evidence(answer: &Answer) -> Markup {
    let diagnosis = answer.diagnosis;
    let left = candidates::left(diagnosis).next().is_some();
    // Of a thing that is no ball, the start is what its file says it is.
    let fitted_start = diagnosis.explained.iter().any(|one| !one.nuisances.is_empty());
    let single = diagnosis.uses.iter().filter(|u| u.used && !u.held_out).count() == 1;
    let other = answer.loaded.recorded.iter().all(|r| r.seen.kind() == Kind::Other);
    let one_throw = if other { "One motion" } else { "One throw" };
    html! {
        @if left {
            h2 { "Candidate effects" }
            div.grid {
                figure {
                    (candidates::gains(diagnosis))
                }
                p.how {
                    "Decrease of the information criterion with only this effect added. An effect has to gain "
                    (format!("{:.0}", diagnosis.least_gain)) ", and every candidate within "
                    (format!("{:.0}", diagnosis.margin)) " of the best could be the answer as well, unless a warning says why not"
                    @if diagnosis.verdict() == Verdict::OneOf && diagnosis.conclusion.doubt().is_none() { "; the bracket holds what these recordings do not distinguish" }
                    "."
                    @if let Some(doubt) = diagnosis.conclusion.doubt() { " " (capital(&doubt.to_string())) ", so " @if diagnosis.names().len() > diagnosis.effects().len() { "the second-best candidate is kept as well." } @else { "an effect outside the catalogue remains possible." } }
                    @else if single && diagnosis.verdict() == Verdict::OneOf { " " (one_throw) " does not identify one effect, so the second-best candidate is kept as well." }
                }
            }
            (candidates::table(answer))
        }
        @if let Some(gap) = &diagnosis.gap {
            h2 { "Gap before and after" @if answer.found().is_some() { ", without the law" } }
            div.grid {
                figure { figcaption.above { "All recordings" } (pairs(&totals(answer), Some((gap.noise_floor, "noise floor")), "gap before and after")) }
                @let held = held_out(diagnosis);
                @if !held.is_empty() {
                    figure { figcaption.above { "Held out, one by one" } (pairs(&held, Some((gap.noise_floor, "noise floor")), "held-out gap of each recording")) }
                }
                p.how {
                    "Root mean square of measured \u{2212} simulated, "
                    @if same_unit(answer) { "all channels as one distance" }
                    @else { "each channel in standard deviations of its noise (\u{3c3}), since their units differ" }
                    @if gap.of == GapOf::Events { ", with flights straightened, so that contacts alone count" }
                    @if gap.of == GapOf::Segments { ", of flights that were cut at the contacts: each has a start and a spin of its own, so this says "
                        "nothing of how well a whole recording is predicted" }
                    ". "
                    @if !diagnosis.effects().is_empty() {
                        "The dashed mark is the simulation without the effect, parameters tuned; the dot is the one with it. "
                    }
                    @if gap.held_out.is_some() && fitted_start { "For held-out recordings only the initial state is fitted; the forecast uses the first 40 % and is compared with the rest. " }
                    @else if gap.held_out.is_some() { "For held-out recordings nothing is fitted; the forecast is compared with what follows the first 40 % of each. " }
                    @else { "No recording was held out, so the result was not validated." }
                }
            }
            (parts(answer))
        }
    }
}

/// Whether all channels of all recordings have one unit.
fn same_unit(answer: &Answer) -> bool {
    answer.loaded.recorded.iter().all(|recorded| recorded.seen.common_unit().is_some())
}

/// The gap of each object, or of each channel, where that says more than the one of all.
fn parts(answer: &Answer) -> Markup {
    let parts = answer.gaps();
    let change = |c: &Change, unit: &str| format!("{} \u{2192} {}", quantity(c.before, unit), quantity(c.after, unit));
    html! {
        @if !parts.is_empty() {
            table {
                thead { tr { th { "gap of" } th { "before" } th { "after" } th { "noise floor" } th { "held out" } } }
                tbody {
                    @for part in &parts {
                        tr {
                            th scope="row" { (answer.part_name(part)) }
                            td.number data-name="before" { (quantity(part.before, &part.unit)) }
                            td.number data-name="after" { (quantity(part.after, &part.unit)) }
                            td.number data-name="noise floor" { (quantity(part.noise_floor, &part.unit)) }
                            td.number data-name="held out" { @if let Some(held_out) = &part.held_out { (change(held_out, &part.unit)) } }
                        }
                    }
                }
            }
        }
    }
}

fn totals(answer: &Answer) -> Vec<Pair> {
    let Some(gap) = &answer.diagnosis.gap else { return Vec::new() };
    let named = !answer.diagnosis.effects().is_empty();
    let one =
        |name: &str, before: f64, after: f64| pair(name, named.then_some(before), after, |v| quantity(v, &gap.unit));
    let mut rows = vec![one("fitted", gap.before, gap.after)];
    rows.extend(gap.held_out.map(|h| one("held out", h.before, h.after)));
    if let (Some(h), Some((name, after))) = (&gap.held_out, &gap.control) {
        rows.push(pair(&format!("control: {name}"), Some(h.before), *after, |v| quantity(v, &gap.unit)));
    }
    rows.extend(gap.forecast.map(|f| one("forecast", f.before, f.after)));
    rows
}

/// The gap of every held-out recording.
fn held_out(diagnosis: &Diagnosis) -> Vec<Pair> {
    let unit = diagnosis.gap.as_ref().map_or("m", |g| g.unit.as_str());
    let named = !diagnosis.effects().is_empty();
    let held = diagnosis.explained.iter().filter(|one| one.held_out).take(MOST_PAIRS);
    held.map(|one| {
        let before = named.then(|| one.root_mean_square(&one.before));
        pair(&left_over::label(one), before, one.root_mean_square(&one.after), |v| quantity(v, unit))
    })
    .collect()
}

/// What was fitted, and whether what is left is noise.
fn numbers(answer: &Answer) -> Markup {
    let diagnosis = answer.diagnosis;
    html! {
        @if !diagnosis.effects().is_empty() || !diagnosis.parameters.is_empty() {
            h2 { "Coefficients and parameters" }
            @if !diagnosis.effects().is_empty() { (numbers::coefficients(answer)) }
            (numbers::parameters(answer))
        }
        @if !diagnosis.adequacy.is_empty() {
            h2 { "Residual diagnostics" @if answer.found().is_some() { " without the law" } }
            (numbers::adequacy(&diagnosis.adequacy))
            @if differs(&diagnosis.explained) {
                p { "Residuals with the effect, on their own scale:" }
                (left_over::residuals(&left_over::chosen(&diagnosis.explained), diagnosis.explained.len(), false, "with the effect"))
            }
        }
    }
}

/// What these recordings cannot distinguish, and what to record next.
fn apart(answer: &Answer) -> Markup {
    let diagnosis = answer.diagnosis;
    let names = candidates::confusable(diagnosis);
    html! {
        @if !names.is_empty() {
            h2 { "Indistinguishable effects" }
            ul.plain {
                @for name in names {
                    li { code { (name) } @if let Some(effect) = answer.entry(name) { " \u{b7} " (phase::name(&effect.phase)) ": " (effect.sentence) } }
                }
            }
        }
        @if let Some(next) = diagnosis.next_experiment.as_ref().filter(|_| answer.found().is_none()) {
            h2 { "Next experiment" }
            p { (capital(&next.text)) "." }
            @if !next.settings.is_empty() {
                table { tbody { @for (name, value) in &next.settings { tr { th scope="row" { code { (name) } } td { (super::verdict::number(*value)) } } } } }
            }
        }
    }
}

/// Effects and recordings that were left out.
fn excluded(answer: &Answer) -> Markup {
    let diagnosis = answer.diagnosis;
    let unused: Vec<_> = diagnosis.uses.iter().filter(|u| !u.used || !u.notes.is_empty()).collect();
    let effects = diagnosis.candidates.iter().any(|c| c.excluded.is_some());
    html! {
        (candidates::excluded(diagnosis))
        @if !unused.is_empty() {
            table {
                thead { tr { th { "recording" } th { "used" } th { "why" } } }
                tbody {
                    @for one in &unused {
                        tr {
                            th.file scope="row" { (one.name) }
                            td.state data-name="used" { @if one.used { "in part" } @else { "no" } }
                            td { @for note in &one.notes { p { code { (note.kind) } " " (prose(&note.text)) @if !note.remedy.is_empty() { " " span.try { (prose(&note.remedy)) } } } } }
                        }
                    }
                }
            }
        }
        @if unused.is_empty() && !effects { p.none { "Nothing." } }
    }
}

/// An effect's name as words.
fn plain(name: &str) -> String {
    name.replace('_', " ")
}
