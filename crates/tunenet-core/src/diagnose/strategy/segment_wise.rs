//! Segment-wise fit: if the tuned simulation leaves far more than noise, the segments between events are explained first, then the
//! events, with the effects of the segments fixed.

use super::{Attempt, Refinement, Scope};
use crate::Result;
use crate::diagnose::Progress;
use crate::diagnose::Test;
use crate::diagnose::evidence::recording::PreparedRecording;
use crate::diagnose::evidence::{Evidence, NoiseModel};
use crate::diagnose::hypothesis::candidate_scores::CandidateFit;
use crate::diagnose::hypothesis::catalogue::catalogue;
use crate::diagnose::hypothesis::context::{Context, Hypothesis};
use crate::diagnose::hypothesis::forward_selection::search;
use crate::diagnose::hypothesis::forward_selection::{SelectedEffect, Selection};
use crate::diagnose::hypothesis::joint::Point;
use crate::diagnose::hypothesis::multistart::fit_without_effects;
use crate::diagnose::hypothesis::pruning::prune;
use crate::diagnose::hypothesis::structure::FixedEffect;
use crate::diagnose::hypothesis::wording::words;
use crate::diagnose::judge::adequacy::is_adequate;
use crate::diagnose::judge::leave_segments_out::leave_segments_out;
use crate::diagnose::judge::practical_significance::{CONFIRMED, CONTROL, LEFT_SHARE};
use crate::diagnose::strategy::by_name::ByName;
use crate::diagnose::strategy::discrepancy_as_noise::search_inflated;
use crate::diagnose::strategy::segments_alone::by_name;
use crate::diagnose::strategy::segments_alone::{NamedScore, SegmentFindings, segments_alone};
use crate::simulator::{Phase, Text};

pub(super) struct SegmentWise;

impl Refinement for SegmentWise {
    fn applies(&self, attempt: &Attempt) -> bool {
        attempt.scope == Scope::Tuned && is_far_beyond_noise(&attempt.context, &attempt.found.base)
    }

    fn attempt<'a>(&self, attempt: Attempt<'a>, progress: &dyn Fn(Progress)) -> Result<Attempt<'a>> {
        let Some(both) = segments_and_events(&attempt.context, progress)? else { return Ok(attempt) };
        let practical = both.best.is_some().then_some(both.tests);
        let found = Selection { base: attempt.found.base, alone: both.alone, best: both.best, selected: both.selected };
        Attempt::tested(attempt.context, found, Scope::Segments { events_open: both.open }, practical)
    }
}

/// What segments and events say.
struct SegmentsAndEvents<'a> {
    /// All effects together at the values found; `None` where the segments need none and the events show none.
    pub best: Option<Hypothesis<'a>>,
    pub selected: Vec<SelectedEffect>,
    /// Every candidate alone, added to segments or to events.
    pub alone: Vec<CandidateFit<'a>>,
    pub tests: Vec<Test>,
    /// Whether events leave something that nothing takes away.
    pub open: bool,
}

/// What events say, the segments understood.
struct Events {
    point: Point,
    /// The effects that act at events, by name.
    names: Vec<Text>,
    /// Free numbers: object, name, value.
    values: Vec<(Option<usize>, String, f64)>,
    selected: Vec<ByName>,
    tests: Vec<Test>,
    confirmed: bool,
    alone: Vec<NamedScore>,
}

/// A residual of this many times the noise (RMS) is searched by segments before whole recordings.
const FAR_BEYOND: f64 = 50.0;

/// Whether what `model` leaves is so far beyond noise that whole recordings need not be searched first.
fn is_far_beyond_noise(context: &Context<'_>, model: &Hypothesis) -> bool {
    model.deviance(f64::MAX) > FAR_BEYOND * FAR_BEYOND * context.count() as f64
}

/// Judges segments and events separately. `None` where the segments are not understood.
fn segments_and_events<'a>(
    context: &Context<'a>,
    progress: &dyn Fn(Progress),
) -> Result<Option<SegmentsAndEvents<'a>>> {
    let Some(segments_alone) = segments_alone(context, progress)? else { return Ok(None) };
    let events = events(context, &segments_alone.given, progress)?;
    let mut names: Vec<Text> = segments_alone.given.iter().map(|g| g.entry.name.clone()).collect();
    if events.confirmed {
        names.extend(events.names);
    }
    let entry = |name: &str| context.catalogue.iter().position(|e| e.name == name);
    let effects: Vec<usize> = names.iter().filter_map(|name| entry(name)).collect();
    let candidate = |alone: &NamedScore| {
        Some(CandidateFit {
            excluded: alone.excluded.clone(),
            ..CandidateFit::unfitted(entry(&alone.name)?, alone.gain)
        })
    };
    let mut alone: Vec<CandidateFit> = segments_alone.alone.iter().chain(&events.alone).filter_map(candidate).collect();
    alone.sort_by(|a, b| a.excluded.is_some().cmp(&b.excluded.is_some()).then(b.gain.total_cmp(&a.gain)));
    if effects.is_empty() {
        return Ok(Some(SegmentsAndEvents { best: None, selected: Vec::new(), alone, tests: Vec::new(), open: true }));
    }
    let structure = context.structure(&effects)?;
    let parameters = structure.shared.iter().map(|shared| {
        let (owner, parameter) = (shared.object, &shared.parameter);
        let found = events.values.iter().find(|(object, name, _)| *object == owner && *name == parameter.name);
        found.map(|f| f.2).or_else(|| fixed_value(&segments_alone, owner, &parameter.name)).unwrap_or(parameter.value)
    });
    let point = Point { parameters: parameters.collect(), nuisances: events.point.nuisances };
    let fit = context.joint(&structure).evaluate(point)?;
    // What segments alone distinguish is distinguished.
    let between = segments_alone.selected.into_iter().map(|effect| effect.within(segments_alone.margin));
    let mut selected: Vec<SelectedEffect> =
        between.filter_map(|effect| effect.in_catalogue(&context.catalogue)).collect();
    let mut tests = segments_alone.tests;
    if events.confirmed {
        tests.extend(events.tests);
        selected.extend(events.selected.iter().filter_map(|effect| effect.in_catalogue(&context.catalogue)));
    }
    let best = Some(Hypothesis { structure, fit });
    Ok(Some(SegmentsAndEvents { best, selected, alone, tests, open: !events.confirmed }))
}

/// What events show, with the effects of the segments fixed at the values found.
fn events(context: &Context, given: &[FixedEffect], progress: &dyn Fn(Progress)) -> Result<Events> {
    let mut catalogue = catalogue(context.subjects);
    catalogue.retain(|entry| entry.of[0].phase == Phase::Event);
    let mut training = context.recordings().to_vec();
    training.iter_mut().for_each(PreparedRecording::hold_still);
    let given = given.to_vec().into();
    let evidence = Evidence { training, validation: Vec::new(), noise: NoiseModel::White };
    let new = Context::new(context.subjects, evidence, catalogue, context.settings, &context.rollouts);
    let context = Context { given, ..new };
    let base = fit_without_effects(&context)?;
    let first = search(&context, base, is_adequate, progress)?;
    let (context, mut found) = search_inflated(&context, &first, progress)?;
    prune(&context, &mut found)?;
    let (tests, confirmed) = confirmed(&context, &found)?;
    let best = found.best.as_ref().filter(|_| confirmed).unwrap_or(&found.base);
    let shared = best.structure.shared.iter().zip(&best.fit.point.parameters);
    let of = |entry: &usize| found.selected.iter().find(|selected| selected.entry == *entry);
    let selected = best.structure.effects.iter().filter_map(of).map(|selected| ByName::of(&context, selected));
    Ok(Events {
        point: best.fit.point.clone(),
        names: best.structure.effects.iter().map(|&e| context.catalogue[e].name.clone()).collect(),
        values: shared.map(|(shared, value)| (shared.object, shared.parameter.name.clone(), *value)).collect(),
        selected: selected.collect(),
        tests,
        confirmed,
        alone: by_name(&context, &found),
    })
}

/// Whether segments that were hidden from the fit bear out what was found at events, and no wrong effect as well.
fn confirmed(context: &Context<'_>, found: &Selection) -> Result<(Vec<Test>, bool)> {
    let Some(best) = &found.best else { return Ok((Vec::new(), false)) };
    let (Some(before), Some(after)) = (leave_segments_out(context, &found.base)?, leave_segments_out(context, best)?)
    else {
        return Ok((Vec::new(), false));
    };
    let wrong = |c: &&CandidateFit| c.excluded.is_none() && !best.structure.effects.contains(&c.entry);
    let control = match found.alone.iter().rev().find(wrong) {
        Some(candidate) => leave_segments_out(context, &context.fit_near(&[candidate.entry], &found.base)?)?,
        None => None,
    };
    let (whole, left) = (found.base.deviance(f64::MAX), best.deviance(f64::MAX));
    let test = |name, value, threshold| Test { name, value, threshold, passed: value <= threshold };
    let [of_none, of_wrong] = words(context).hidden_segments;
    let mut tests = vec![
        test("left over taken away", left / (whole - left).max(f64::MIN_POSITIVE), LEFT_SHARE),
        test(of_none, after / before, CONFIRMED),
    ];
    tests.extend(control.map(|c| test(of_wrong, after / c, CONTROL.recip())));
    let passed = tests.iter().all(|t| t.passed);
    Ok((tests, passed))
}

/// The value that the segments give a coefficient.
fn fixed_value(segments_alone: &SegmentFindings, object: Option<usize>, name: &str) -> Option<f64> {
    segments_alone.given.iter().find_map(|g| g.value(object.unwrap_or(0), name))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::tests::zoo::{AT_EVENTS, BETWEEN, FRICTION, in_context, in_shuttles, in_swings, names};
    use crate::testing::{Exact, Pendulum};

    #[test]
    fn what_knows_no_segments_is_left_to_whole_recordings() {
        let pendulum = Exact::new(Pendulum);
        let seen = [[0.2, 0.0], [0.0, 0.7]].map(|start| pendulum.observe(&[(FRICTION, 1.0)], &start, 1e-4, 1).unwrap());
        in_context(&pendulum, &seen, 0, |context| {
            let tuned = Attempt::tuned(context).unwrap();
            assert!(SegmentWise.applies(&tuned), "friction of 1/s is far beyond a noise of 0.1 mrad");
            let same = SegmentWise.attempt(tuned, &|_| {}).unwrap();
            assert!(same.scope == Scope::Tuned);
        });
        in_swings(&[], 2, 0, |context| assert!(!SegmentWise.applies(&Attempt::tuned(context).unwrap())));
    }

    #[test]
    fn segments_are_explained_first_and_then_the_events() {
        in_shuttles(&[(BETWEEN, 0.6), (AT_EVENTS, 0.3)], |context| {
            let tuned = Attempt::tuned(context).unwrap();
            assert!(SegmentWise.applies(&tuned), "a change of 0.3 m/s is far beyond a noise of 0.2 mm");
            let found = SegmentWise.attempt(tuned, &|_| {}).unwrap();
            assert!(found.scope == Scope::Segments { events_open: false });
            assert_eq!(names(&found.context, &found.last().structure.effects), ["friction", "kick"]);
            assert!(found.practical.unwrap().iter().all(|test| test.passed));
        });
    }
}
