//! The page of `tunenet tune`.

use std::path::Path;
use tunenet_core::findings;

use maud::{Markup, html};
use tunenet_core::observation::Observation;
use tunenet_core::simulator::{Parameter, Simulator};
use tunenet_core::tune::{ChannelGap, Detail, Evidence, Outcome, evidence, over_recordings};
use tunenet_formats::Result;

use super::figures::{Rung, autocorrelation, bars, ladder, profile, regions};
use super::provenance::Provenance;
use super::series::{Series, drawings};
use super::verdict::quantity;
use super::verdict::{interval, value, verdict, word};
use super::{checks, page, parameters};

/// Most drawings of autocorrelations on one page.
const MOST_AUTOCORRELATIONS: usize = 6;

/// An outcome with all that is drawn of it.
pub struct Answer {
    names: Vec<String>,
    seen: Vec<Observation>,
    simulated: Vec<Parameter>,
    outcome: Outcome,
    evidence: Evidence,
    detail: Detail,
}

impl Answer {
    /// Of `simulator` tuned to observations called `names`.
    pub fn new(
        simulator: &dyn Simulator,
        names: Vec<String>,
        seen: Vec<Observation>,
        outcome: Outcome,
        detail: Detail,
    ) -> Result<Self> {
        let evidence = evidence(simulator, &outcome, detail)?;
        Ok(Self { names, seen, simulated: simulator.parameters().to_vec(), outcome, evidence, detail })
    }

    fn title(&self) -> String {
        match self.names.as_slice() {
            [one] => one.clone(),
            several => format!("{} recordings", several.len()),
        }
    }

    /// The names of the recordings that were tuned to.
    fn used(&self) -> Vec<String> {
        let pairs = self.names.iter().zip(&self.outcome.used);
        pairs.filter(|(_, used)| **used).map(|(name, _)| name.clone()).collect()
    }

    fn rollouts(&self) -> (usize, usize) {
        (self.outcome.rollouts, self.evidence.rollouts)
    }

    fn series(&self) -> Vec<Series> {
        if self.evidence.recordings.is_empty() {
            return self.names.iter().zip(&self.seen).flat_map(|(name, seen)| Series::unused(name, seen)).collect();
        }
        let used = self.used();
        used.iter().zip(&self.evidence.recordings).flat_map(|(name, c)| Series::of(name, c)).collect()
    }

    fn sections(&self, heading: fn(&str) -> Markup) -> Markup {
        let outcome = &self.outcome;
        let used = self.used();
        html! {
            (verdict(outcome, &self.title()))
            (heading(if self.evidence.recordings.is_empty() { "Recordings" } else { "Measured and simulated" }))
            (drawings(&self.series(), outcome.nuisances.iter().any(|own| !own.is_empty())))
            @if !outcome.parameters.is_empty() {
                (heading("Parameters"))
                (parameters::parameters(outcome))
            }
            @if outcome.gap.is_some() {
                (heading("Gap before and after"))
                (self.gap(&used))
            }
            @if !self.evidence.profiles.is_empty() {
                (heading("Profile likelihood"))
                (self.likelihood())
            } @else if self.detail == Detail::Recordings && !outcome.parameters.is_empty() {
                (heading("Profile likelihood"))
                p { "Not drawn: it takes further rollouts, which --quick and --max-rollouts leave out; for an external program \
                     or robot joints, add --profiles." }
            }
            @if !self.evidence.recordings.is_empty() {
                (heading("Residual diagnostics"))
                (self.left_over(&used))
            }
            @if outcome.nuisances.iter().any(|own| !own.is_empty()) {
                (heading("Nuisance parameters"))
                (parameters::estimated(&used, &outcome.nuisances))
            }
            (heading("Recording checks"))
            @for (name, found) in self.names.iter().zip(&outcome.preflight) { (checks::checks(name, found)) }
            (heading("Warnings and notes"))
            (checks::warnings(&outcome.notes))
        }
    }

    fn gap(&self, used: &[String]) -> Markup {
        let Some(gap) = &self.outcome.gap else { return html! {} };
        let rung =
            |name: &str, class, value: f64| Rung { name: name.into(), class, value, shown: quantity(value, &gap.unit) };
        let rungs = [
            rung("before", "before", gap.before),
            rung("tuned", "after", gap.after),
            rung("noise floor", "floor", gap.noise_floor),
        ];
        let rows: Vec<Rung> = used
            .iter()
            .zip(&self.evidence.recordings)
            .map(|(name, c)| Rung {
                name: if used.len() > 1 { shortened(name) } else { "residual / noise".into() },
                class: if c.adequacy.poor() { "before" } else { "after" },
                value: c.adequacy.ratio,
                shown: format!("{}{}", significant(c.adequacy.ratio), if c.adequacy.tested { "" } else { " untested" }),
            })
            .collect();
        let limit = self.evidence.recordings.iter().map(|c| c.adequacy.limit).fold(0.0, f64::max);
        let units = |pair: &[ChannelGap]| pair[0].unit == pair[1].unit;
        let alike = self.outcome.gaps.windows(2).all(units);
        html! {
            @if !alike { (self.channels(used)) }
            div.grid {
                @if alike { figure {
                    (ladder(&rungs, "gap before, tuned, and the noise floor"))
                    figcaption { "Root mean square of measured \u{2212} simulated, all channels as one distance. Tuned should be \
                                  close to the dotted line, the noise floor." }
                } }
                figure {
                    (bars(&rows, (limit, &format!("limit of noise: {limit:.2}")), "residual over noise, with its limit"))
                    figcaption { "Residual of the worst channel divided by its noise. Beyond the dotted line noise does not explain it: \
                                  something is missing." }
                }
            }
        }
    }

    /// The gap of each channel, in its unit, and of each recording where there are several.
    fn channels(&self, used: &[String]) -> Markup {
        let name = |gap: &ChannelGap| match used.get(gap.recording).filter(|_| used.len() > 1) {
            Some(recording) => format!("{} of {}", gap.channel, shortened(recording)),
            None => gap.channel.clone(),
        };
        let whole = if used.len() > 1 { over_recordings(&self.outcome.gaps) } else { Vec::new() };
        let whole = whole.iter().map(|gap| (format!("{}, all recordings", gap.channel), gap));
        let rows: Vec<(String, &ChannelGap)> =
            whole.chain(self.outcome.gaps.iter().map(|gap| (name(gap), gap))).collect();
        html! {
            table {
                thead { tr { th { "gap of" } th { "before" } th { "tuned" } th { "noise floor" } } }
                tbody {
                    @for (name, gap) in &rows {
                        tr {
                            th scope="row" { (name) }
                            td.number data-name="before" { (quantity(gap.before, &gap.unit)) }
                            td.number data-name="tuned" { (quantity(gap.after, &gap.unit)) }
                            td.number data-name="noise floor" { (quantity(gap.noise_floor, &gap.unit)) }
                        }
                    }
                }
            }
        }
    }

    fn likelihood(&self) -> Markup {
        let known = |i: usize| &self.simulated[i];
        let value = |i: usize| self.outcome.point.as_ref().map_or(f64::NAN, |p| p.parameters[i]);
        let contours = &self.evidence.contours;
        let pairs: Vec<_> = contours.chunk_by(|a, b| a.parameters == b.parameters).collect();
        html! {
            div.grid {
                @for curve in &self.evidence.profiles {
                    figure { (profile(curve, known(curve.parameter), value(curve.parameter))) }
                }
                @for pair in &pairs {
                    figure {
                        (regions(&pair.iter().collect::<Vec<_>>(), (known(pair[0].parameters.0), known(pair[0].parameters.1))))
                    }
                }
            p.how {
                "Misfit with one parameter fixed and all others fitted again, in squared standard deviations. "
                "Values below the dotted line make the 95 % interval (shaded), the thick line on the axis the 50 % interval; the dot is \
                 the tuned value. A narrow minimum: the data determine it. A flat one: they do not."
                @if self.outcome.notes.iter().any(|n| n.kind == findings::FIT_LOCAL) {
                    " Here the fit to the whole record is poor, so the tuned value was estimated from the contacts only and need not lie \
                     at the minimum of the whole."
                }
                @if !pairs.is_empty() {
                    " The closed lines enclose the pairs of values that fit together: thick 50 %, thin 95 %. A slanted shape means that \
                     one parameter can replace the other."
                }
            }
            }
        }
    }

    fn left_over(&self, used: &[String]) -> Markup {
        let mut all: Vec<(String, &[f64], f64)> = Vec::new();
        for (name, c) in used.iter().zip(&self.evidence.recordings) {
            for (channel, about) in c.seen.channels().iter().enumerate().filter(|(i, _)| c.moves[*i]) {
                let title = if used.len() > 1 {
                    format!("{name}, residual of {}", about.name)
                } else {
                    format!("residual of {}", about.name.replace('_', " "))
                };
                if c.autocorrelation[channel].len() > 1 {
                    all.push((title, &c.autocorrelation[channel], c.envelope()));
                }
            }
        }
        html! {
            div.grid {
                @for (title, values, envelope) in all.iter().take(MOST_AUTOCORRELATIONS) {
                    figure { figcaption.above { (title) } (autocorrelation(values, *envelope)) }
                }
            p.how {
                "Autocorrelation of the residuals by lag. For white noise 95 of 100 stems lie within the band; a run of stems \
                 on one side means structure that the simulation lacks, or a recording that was smoothed."
                @if all.len() > MOST_AUTOCORRELATIONS {
                    " The first " (MOST_AUTOCORRELATIONS) " of " (all.len()) " are drawn."
                }
            }
            }
        }
    }
}

/// Writes the page of observations that were tuned to together.
pub fn together(path: &Path, answer: &Answer, provenance: &Provenance) -> Result<()> {
    let body = html! {
        (answer.sections(second))
        (second("Provenance"))
        (provenance.section(&rolled(answer.rollouts())))
    };
    page::write(path, &page::page("Tuning report", &answer.title(), &body))
}

/// Writes the page of observations that were tuned to one by one: each an answer, or why it was refused.
pub fn each(
    path: &Path,
    cases: &[(String, std::result::Result<Answer, String>)],
    provenance: &Provenance,
) -> Result<()> {
    let rollouts = cases.iter().filter_map(|(_, case)| case.as_ref().ok()).map(Answer::rollouts);
    let rollouts = rollouts.fold((0, 0), |sum, r| (sum.0 + r.0, sum.1 + r.1));
    let body = html! {
        table {
            thead { tr { th { "recording" } th { "verdict" } th { "answer" } } }
            tbody {
                @for (i, (name, case)) in cases.iter().enumerate() {
                    tr {
                        th.file scope="row" { @if case.is_ok() { a href={ "#" (i) } { (name) } } @else { (name) } }
                        (row(case))
                    }
                }
            }
        }
        @for (i, (name, case)) in cases.iter().enumerate() {
            @if let Ok(answer) = case { article id=(i) { h2 { (name) } (answer.sections(third)) } }
        }
        article {
            (second("Provenance"))
            (provenance.section(&rolled(rollouts)))
        }
    };
    let title = format!("{} recordings, one by one", cases.len());
    page::write(path, &page::page("Tuning report", &title, &body))
}

fn rolled((tuning, drawing): (usize, usize)) -> String {
    format!("{tuning} to tune, {drawing} to draw this page")
}

fn row(case: &std::result::Result<Answer, String>) -> Markup {
    match case {
        Ok(answer) => {
            let known: Vec<_> = answer.outcome.parameters.iter().filter(|e| e.identified).collect();
            html! {
                td.state data-name="verdict" { (word(&answer.outcome)) }
                td data-name="answer" {
                    @for (i, e) in known.iter().enumerate() {
                        @if i > 0 { ", " }
                        (e.name) " " (value(e)) " (95 %: " (interval(e)) ")"
                    }
                    @if known.is_empty() { "\u{2013}" }
                }
            }
        }
        Err(reason) => html! { td.state data-name="verdict" { "Refused" } td data-name="reason" { (reason) } },
    }
}

fn second(text: &str) -> Markup {
    html! { h2 { (text) } }
}

fn third(text: &str) -> Markup {
    html! { h3 { (text) } }
}

/// A ratio with three digits.
fn significant(ratio: f64) -> String {
    let decimals = if ratio < 10.0 { 2 } else { usize::from(ratio < 100.0) };
    format!("{ratio:.decimals$}")
}

/// A name that leaves room for a drawing next to it.
fn shortened(name: &str) -> String {
    const MOST: usize = 18;
    if name.chars().count() <= MOST {
        return name.into();
    }
    let end = name.chars().count() - MOST + 1;
    format!("\u{2026}{}", name.chars().skip(end).collect::<String>())
}
