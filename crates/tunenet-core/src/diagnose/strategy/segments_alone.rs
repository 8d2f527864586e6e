//! Segments alone: every segment between two events as a recording of its own, whose start is unknown.
//!
//! An event that no entry of the catalogue describes corrupts every prediction of what comes after it. Separate segments do not
//! depend on it: what acts on them, and how they were seen, shows as clearly as if the event were understood. One recording
//! brings several of them, so that one can be held out for validation.

use crate::Result;
use crate::diagnose::evidence::Evidence;
use crate::diagnose::evidence::recording::PreparedRecording;
use crate::diagnose::hypothesis::candidate_scores::CandidateFit;
use crate::diagnose::hypothesis::catalogue::{Entry, catalogue};
use crate::diagnose::hypothesis::context::{Context, Hypothesis};
use crate::diagnose::hypothesis::forward_selection::Selection;
use crate::diagnose::hypothesis::forward_selection::search;
use crate::diagnose::hypothesis::multistart::fit_without_effects;
use crate::diagnose::hypothesis::plausibility::Exclusion;
use crate::diagnose::hypothesis::pruning::prune;
use crate::diagnose::hypothesis::structure::FixedEffect;
use crate::diagnose::judge::adequacy::{is_adequate, residual_diagnostics};
use crate::diagnose::judge::practical_significance::noise_floor;
use crate::diagnose::strategy::by_name::ByName;
use crate::diagnose::strategy::discrepancy_as_noise::with_inflated_noise;
use crate::diagnose::strategy::unmeasured_axes::without_unmeasured;
use crate::diagnose::{Progress, Subject, Test};
use crate::simulator::{Phase, Preparation, Simulator, Text};

/// Of so many segments of an object one is held out: the second, so that others are faster, and others slower.
const ENOUGH: usize = 3;
const HELD_OUT: usize = 1;
/// Less than this share of the noise's variance is nothing to explain.
const SMALL: f64 = 0.3;

/// What segments say.
pub(in crate::diagnose) struct SegmentFindings {
    /// The effects that act on them, or on how they were seen, with the values found.
    pub given: Vec<FixedEffect>,
    /// For each of them: its gain, and what else could be in its place.
    pub selected: Vec<ByName>,
    /// How far behind an explanation is left.
    pub margin: f64,
    pub tests: Vec<Test>,
    /// Every candidate as it stood alone.
    pub alone: Vec<NamedScore>,
}

/// A candidate added to segments or events alone.
pub(in crate::diagnose) struct NamedScore {
    pub name: Text,
    pub gain: f64,
    pub excluded: Option<Exclusion>,
}

/// What the segments of all recordings say; `None` where they are too few, or nothing explains them either.
pub(in crate::diagnose) fn segments_alone(
    context: &Context<'_>,
    progress: &dyn Fn(Progress),
) -> Result<Option<SegmentFindings>> {
    let simulators: Option<Vec<Box<dyn Simulator>>> =
        context.subjects.iter().map(|s| s.simulator.segmented()?.free_segment()).collect();
    let Some(simulators) = simulators else { return Ok(None) };
    let named = context.subjects.iter().zip(&simulators);
    let subjects: Vec<Subject> =
        named.map(|(s, simulator)| Subject { name: s.name.clone(), simulator: simulator.as_ref() }).collect();
    let evidence = evidence_of(&subjects, context.recordings())?;
    if evidence.training.len() < ENOUGH {
        return Ok(None);
    }
    let mut catalogue = catalogue(&subjects);
    catalogue.retain(|entry| entry.of[0].phase != Phase::Event);
    let context = Context::new(&subjects, evidence, catalogue, context.settings, &context.rollouts);
    let Some((context, found, tests)) = understood(context, progress)? else { return Ok(None) };
    Ok(Some(summarised(&context, &found, tests)))
}

/// The search, and the tests that its answer passes; `None` where it fails some.
fn understood<'a>(
    context: Context<'a>,
    progress: &dyn Fn(Progress),
) -> Result<Option<(Context<'a>, Selection<'a>, Vec<Test>)>> {
    let base = fit_without_effects(&context)?;
    let context = without_unmeasured(context, &base)?;
    let found = search(&context, base, is_adequate, progress)?;
    let best = found.best.as_ref().unwrap_or(&found.base);
    let tests = residual_diagnostics(&context, best).tests;
    // Rounding has a pattern of its own, far below the noise.
    let small = best.deviance(best.scale()) < SMALL * context.count() as f64;
    let adequate = small || tests.iter().all(|t| t.passed);
    if found.best.is_none() {
        let tests = if small { Vec::new() } else { tests };
        return Ok(adequate.then_some((context, found, tests)));
    }
    // The least that takes the large part away, where held-out segments confirm it.
    if !context.evidence.validation.is_empty() {
        let mut second = with_inflated_noise(&context, &found, noise_floor(context.recordings()), progress)?;
        prune(&second.context, &mut second.found)?;
        if second.passes() {
            return Ok(Some((second.context, second.found, second.tests)));
        }
    }
    Ok(adequate.then_some((context, found, tests)))
}

/// The candidates by name.
pub(in crate::diagnose) fn by_name(context: &Context<'_>, found: &Selection) -> Vec<NamedScore> {
    let name = |entry: usize| context.catalogue[entry].name.clone();
    let one = |c: &CandidateFit| NamedScore { name: name(c.entry), gain: c.gain, excluded: c.excluded.clone() };
    found.alone.iter().map(one).collect()
}

fn summarised(context: &Context<'_>, found: &Selection, tests: Vec<Test>) -> SegmentFindings {
    let objects = context.subjects.len();
    let given = |model: &Hypothesis| -> Vec<FixedEffect> {
        let each = model.structure.effects.iter().enumerate();
        each.map(|(position, &entry)| {
            let entry = &context.catalogue[entry];
            let values = (0..objects).map(|object| values(model, position, entry, object)).collect();
            FixedEffect { entry: entry.clone(), values }
        })
        .collect()
    };
    let ordered = found.best.iter().flat_map(|model| &model.structure.effects);
    let with_gain = |entry: &usize| found.selected.iter().find(|selected| selected.entry == *entry);
    let selected = ordered.filter_map(with_gain).map(|selected| ByName::of(context, selected)).collect();
    SegmentFindings {
        given: found.best.as_ref().map_or_else(Vec::new, given),
        selected,
        margin: context.margin(),
        tests,
        alone: by_name(context, found),
    }
}

/// The coefficients of one object's effect; absent where it has no segment.
fn values(model: &Hypothesis, position: usize, entry: &Entry, object: usize) -> Vec<f64> {
    let shared = &model.structure.shared;
    let of = |k: usize| {
        let mine = |column: &usize| {
            shared[*column].effect == Some((position, k)) && shared[*column].object.is_none_or(|owner| owner == object)
        };
        (0..shared.len()).find(mine).map(|column| model.fit.point.parameters[column])
    };
    entry.of[object].coefficients.iter().enumerate().map(|(k, c)| of(k).unwrap_or(c.absent)).collect()
}

/// Every segment as a recording, one of each object held out where there are enough.
fn evidence_of(subjects: &[Subject], recordings: &[PreparedRecording]) -> Result<Evidence> {
    let mut all: Vec<PreparedRecording> = Vec::new();
    for recording in recordings {
        // What follows the last event may hold more of them, too small to be found.
        let segments = recording.free_segments().into_iter().take(recording.events.len().max(1));
        for range in segments.flatten() {
            let Ok(seen) = recording.prepared.seen.slice(range.clone()) else { continue };
            if let Preparation::Usable(prepared) = subjects[recording.object].simulator.prepare(&seen)? {
                // Segments of one recording differ as motions do: the first are fast, the last are slow.
                all.push(PreparedRecording { motion: all.len(), ..recording.piece(range, *prepared) });
            }
        }
    }
    for object in 0..subjects.len() {
        let mine: Vec<usize> = (0..all.len()).filter(|&i| all[i].object == object).collect();
        if mine.len() >= ENOUGH {
            all[mine[HELD_OUT]].held_out = true;
        }
    }
    Ok(Evidence::new(all))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::tests::zoo::{AT_EVENTS, BETWEEN, in_shuttles, in_swings};

    #[test]
    fn segments_show_what_acts_in_them_whatever_happens_at_events() {
        in_shuttles(&[(BETWEEN, 0.6), (AT_EVENTS, 0.3)], |context| {
            let found = segments_alone(context, &|_| {}).unwrap().unwrap();
            let names: Vec<&str> = found.given.iter().map(|given| given.entry.name.as_ref()).collect();
            assert_eq!(names, ["friction"]);
            let rate = found.given[0].value(0, BETWEEN).unwrap();
            assert!((rate - 0.6).abs() < 0.03, "{rate}");
            assert!(
                found.alone.iter().all(|score| !["kick", "slip"].contains(&score.name.as_ref())),
                "they act at events"
            );
        });
    }

    #[test]
    fn segments_that_need_nothing_give_nothing_and_what_has_none_is_not_asked() {
        in_shuttles(&[(AT_EVENTS, 0.3)], |context| {
            let found = segments_alone(context, &|_| {}).unwrap().unwrap();
            assert!(found.given.is_empty() && found.selected.is_empty());
        });
        in_swings(&[], 2, 0, |context| assert!(segments_alone(context, &|_| {}).unwrap().is_none()));
    }
}
