//! Which of the effects each object's own recordings show (Wald test, Wald 1943), the simulations without the others, and the
//! gap of each object.
//!
//! Objects share which effects there are, so that one that shows an effect clearly speaks for those that hardly do. What is true
//! of all together need not be needed by each: drag slows a light body visibly, and a heavy one hardly.

use crate::Result;
use crate::diagnose::answer::intervals::Intervals;
use crate::diagnose::answer::judgement::Judgement;
use crate::diagnose::answer::judgement::root_mean_square;
use crate::diagnose::answer::{Change, Explained, OfObject, OwnEffect, PartGap, Verdict};
use crate::diagnose::evidence::recording::PreparedRecording;
use crate::diagnose::hypothesis::context::{Context, Hypothesis};
use crate::diagnose::hypothesis::forward_selection::SelectedEffect;
use crate::diagnose::judge::held_out_proof::{HeldOut, validate};
use crate::diagnose::strategy::Scope;
use crate::observation::common_unit;

/// The verdict of each object that has recordings to fit, in order; of a single one that of the whole.
pub(in crate::diagnose) fn by_object(judged: &Judgement, intervals: &Intervals) -> Vec<OfObject> {
    let context = &judged.context;
    let seen = |object: &usize| context.recordings().iter().any(|recording| recording.object == *object);
    let objects: Vec<usize> = (0..context.subjects.len()).filter(seen).collect();
    let (whole, alternatives) = (judged.decision.verdict, &judged.decision.alternatives);
    let several = objects.len() > 1;
    let of = |object: usize| {
        let each = judged.found.selected.iter().filter(|_| judged.reports_effects());
        let effects: Vec<OwnEffect> = each.map(|selected| own(judged, intervals, selected, object)).collect();
        let shown = || effects.iter().zip(alternatives).filter(|(effect, _)| effect.shown);
        // Doubt about the whole that names no other is doubt about each.
        let doubt = whole == Verdict::OneOf && alternatives.iter().all(Vec::is_empty);
        let verdict = if !judged.reports_effects() || !several {
            whole
        } else if shown().next().is_none() {
            Verdict::None
        } else if doubt || shown().any(|(_, near)| !near.is_empty()) {
            Verdict::OneOf
        } else {
            Verdict::Named
        };
        OfObject { object, verdict, effects }
    };
    let mut all: Vec<OfObject> = objects.into_iter().map(of).collect();
    if judged.scope == Scope::Whole {
        mark_unneeded(&mut all);
    }
    all
}

/// One effect in the recordings of one object.
fn own(judged: &Judgement, intervals: &Intervals, selected: &SelectedEffect, object: usize) -> OwnEffect {
    let (context, last) = (&judged.context, judged.last());
    let position = last.structure.effects.iter().position(|&entry| entry == selected.entry);
    let all: Vec<usize> = position.map_or_else(Vec::new, |p| last.structure.of_effect(p));
    let mine: Vec<usize> =
        all.into_iter().filter(|&column| last.structure.shared[column].object == Some(object)).collect();
    let recordings = context.recordings().iter().filter(|recording| recording.object == object);
    let count: usize = recordings.map(PreparedRecording::count).sum();
    let price = mine.len() as f64 * (context.effective_fraction() * count as f64).max(1.0).ln();
    // What all objects share all of them show; and where events are not understood, no whole recording can be weighed.
    let weighed = !mine.is_empty() && !judged.events_open();
    let bic_gain = weighed.then(|| intervals.squared_distance_from_absence(&mine) - price);
    let shown = bic_gain.is_none_or(|gain| gain > context.settings.margin);
    OwnEffect { name: context.catalogue[selected.entry].name.clone(), bic_gain, shown, needed: true }
}

/// An effect that some objects show is not needed by the others. What none shows by itself all show together, and all need.
fn mark_unneeded(objects: &mut [OfObject]) {
    let count = objects.first().map_or(0, |first| first.effects.len());
    for k in 0..count {
        let any = objects.iter().any(|one| one.effects[k].shown);
        for one in objects.iter_mut() {
            one.effects[k].needed = one.effects[k].shown || !any;
        }
    }
}

/// The hypothesis of the answer without the effects that objects do not need, fitted anew.
pub(in crate::diagnose) struct Spared<'a> {
    /// Under which it was fitted.
    pub context: Context<'a>,
    pub model: Hypothesis<'a>,
    /// Root mean square of what it leaves of the recordings that were fitted.
    pub left: f64,
    pub held_out: Option<HeldOut>,
}

/// Leaves out what objects do not need; `None` where each needs all, or where the fit shows that they do need it: then they are
/// marked so.
pub(in crate::diagnose) fn without_unneeded<'a>(
    judged: &Judgement<'a>,
    objects: &mut [OfObject],
) -> Result<Option<Spared<'a>>> {
    let (context, last) = (&judged.context, judged.last());
    let unneeded = |one: &OfObject| -> Vec<(usize, usize)> {
        let each = judged.found.selected.iter().zip(&one.effects);
        each.filter(|(_, effect)| !effect.needed).map(|(selected, _)| (selected.entry, one.object)).collect()
    };
    let spared: Vec<(usize, usize)> = objects.iter().flat_map(unneeded).collect();
    if spared.is_empty() {
        return Ok(None);
    }
    let context = Context { spared: spared.into(), ..context.clone() };
    let model = context.fit_near(&last.structure.effects, last)?;
    let coefficients = (last.structure.shared.len() - model.structure.shared.len()) as f64;
    let scale = last.scale();
    if context.criterion(model.deviance(scale), last.deviance(scale), coefficients) > context.settings.margin {
        objects.iter_mut().flat_map(|one| &mut one.effects).for_each(|effect| effect.needed = true);
        return Ok(None);
    }
    let (left, held_out) = (root_mean_square(&context, &model)?, validate(&context, &model)?);
    Ok(Some(Spared { context, model, left, held_out }))
}

/// The gap of every object with recordings that were fitted: of all channels as one distance where these have one unit, then of
/// each.
pub(in crate::diagnose) fn gaps(explained: &[Explained]) -> Vec<PartGap> {
    let mut objects: Vec<usize> = explained.iter().filter(|one| !one.held_out).map(|one| one.object).collect();
    objects.sort_unstable();
    objects.dedup();
    let of = |object: usize| {
        let mine: Vec<&Explained> = explained.iter().filter(|one| one.object == object).collect();
        let channels = mine.first().map_or(&[][..], |one| one.seen.channels());
        let alike = common_unit(channels).is_some();
        let whole = (alike && channels.len() > 1).then_some(None);
        let parts: Vec<Option<usize>> = whole.into_iter().chain((0..channels.len()).map(Some)).collect();
        parts.into_iter().filter_map(|channel| part_gap(&mine, channel)).collect::<Vec<_>>()
    };
    objects.into_iter().flat_map(of).collect()
}

/// The gap of one object in one channel, or in all as one distance; `None` where nothing of it counted.
fn part_gap(mine: &[&Explained], channel: Option<usize>) -> Option<PartGap> {
    let fitted = || mine.iter().copied().filter(|one| !one.held_out);
    let held_out = || mine.iter().copied().filter(|one| one.held_out);
    let before = part_rms(fitted(), channel, |one, i, c| one.before[i] * one.noise[c])?;
    let after = part_rms(fitted(), channel, |one, i, c| one.after[i] * one.noise[c])?;
    let noise_floor = part_rms(fitted(), channel, |one, _, c| one.measured_noise[c])?;
    let judged = part_rms(held_out(), channel, |one, i, c| one.before[i] * one.noise[c]).zip(part_rms(
        held_out(),
        channel,
        |one, i, c| one.after[i] * one.noise[c],
    ));
    let first = mine.first()?;
    let of = &first.seen.channels()[channel.unwrap_or(0)];
    Some(PartGap {
        object: first.object,
        channel: channel.map(|_| of.name.clone()),
        unit: of.unit.clone(),
        before,
        after,
        noise_floor,
        held_out: judged.map(|(before, after)| Change { before, after }),
    })
}

impl Explained {
    /// Root mean square of these residuals, [`before`](Explained::before) or [`after`](Explained::after), over what counted, in the unit of
    /// the [gap](crate::observation::gap_unit).
    #[must_use]
    pub fn root_mean_square(&self, residuals: &[f64]) -> f64 {
        let width = self.noise.len();
        let one_unit = common_unit(self.seen.channels()).is_some();
        let unit = |c: usize| if one_unit { self.noise[c] } else { self.noise[c] / self.measured_noise[c] };
        let counted = residuals.iter().enumerate().filter(|(i, _)| self.kept[*i]);
        let (sum, count) = counted.fold((0.0, 0.0), |(s, n), (i, r)| (s + (r * unit(i % width)).powi(2), n + 1.0));
        let values_per_sample = if one_unit { self.measured_channels() as f64 } else { 1.0 };
        (sum * values_per_sample / f64::max(count, 1.0)).sqrt()
    }

    /// How many channels have a value that counted, at least 1.
    fn measured_channels(&self) -> usize {
        let width = self.noise.len();
        (0..width).filter(|c| self.kept.iter().skip(*c).step_by(width).any(|kept| *kept)).count().max(1)
    }
}

/// Root mean square of `value` (of a recording, a position in it, a channel) over what counted; all channels of a sample count once.
fn part_rms<'e>(
    recordings: impl Iterator<Item = &'e Explained>,
    channel: Option<usize>,
    value: impl Fn(&Explained, usize, usize) -> f64,
) -> Option<f64> {
    let (mut squares, mut samples) = (0.0, 0.0);
    for one in recordings {
        let width = one.noise.len();
        let share = if channel.is_some() { 1.0 } else { 1.0 / one.measured_channels() as f64 };
        let counted = (0..one.kept.len()).filter(|i| one.kept[*i] && channel.is_none_or(|c| i % width == c));
        for i in counted {
            squares += value(one, i, i % width).powi(2);
            samples += share;
        }
    }
    (samples > 0.0).then(|| (squares / samples).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::{Channel, Kind, Observation};

    fn own(shown: bool) -> OwnEffect {
        OwnEffect { name: "drag".into(), bic_gain: Some(if shown { 90.0 } else { -3.0 }), shown, needed: true }
    }

    fn needed(shown: &[bool]) -> Vec<bool> {
        let of = |(object, &shown)| OfObject { object, verdict: Verdict::Named, effects: vec![own(shown)] };
        let mut all: Vec<OfObject> = shown.iter().enumerate().map(of).collect();
        mark_unneeded(&mut all);
        all.iter().map(|one| one.effects[0].needed).collect()
    }

    #[test]
    fn an_effect_is_needed_by_those_that_show_it_and_by_all_where_none_does() {
        assert_eq!(needed(&[true, false, true]), [true, false, true]);
        assert_eq!(needed(&[false, false]), [true, true]);
    }

    fn explained(units: [&str; 2], held_out: bool) -> Explained {
        let channel = |(name, unit): (&str, &str)| Channel::new(name, unit);
        let channels = [("a", units[0]), ("b", units[1])].map(channel).to_vec();
        let seen = Observation::new(Kind::Other, channels, vec![0.0, 0.1, 0.2], vec![0.0; 6]).unwrap();
        Explained {
            recording: 0,
            object: 0,
            name: "one".into(),
            segment: None,
            held_out,
            seen,
            kept: vec![true, true, true, false, false, false],
            before: vec![3.0, 4.0, 3.0, 0.0, 0.0, 0.0],
            after: vec![1.0, 1.0, 1.0, 0.0, 0.0, 0.0],
            noise: vec![0.1, 2.0],
            measured_noise: vec![0.05, 1.0],
            events: Vec::new(),
            nuisances: Vec::new(),
        }
    }

    /// Channel a: 3 · 0.1 twice; channel b: 4 · 2 once, since its other values do not count.
    #[test]
    fn gaps_of_channels_are_in_their_units_and_a_distance_needs_one_unit() {
        let mixed = gaps(&[explained(["m", "rad"], false), explained(["m", "rad"], true)]);
        let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
        assert_eq!(mixed.iter().map(|one| one.channel.as_deref()).collect::<Vec<_>>(), [Some("a"), Some("b")]);
        assert!(near(mixed[0].before, 0.3) && near(mixed[0].after, 0.1) && near(mixed[0].noise_floor, 0.05));
        assert!(near(mixed[1].before, 8.0) && near(mixed[1].held_out.unwrap().after, 2.0) && mixed[1].unit == "rad");
        let alike = gaps(&[explained(["m", "m"], false)]);
        assert_eq!(alike.iter().map(|one| one.channel.as_deref()).collect::<Vec<_>>(), [None, Some("a"), Some("b")]);
        // Three values of two channels are one and a half samples.
        assert!(near(alike[0].before, ((2.0 * 0.09 + 64.0) / 1.5f64).sqrt()) && alike[0].held_out.is_none());
        // Of a channel without values there is nothing to count.
        let half = Explained { kept: vec![true, false, true, false, false, false], ..explained(["m", "m"], false) };
        let one = gaps(std::slice::from_ref(&half));
        assert!(near(one[0].before, 0.3) && near(half.root_mean_square(&half.before), 0.3), "{one:?}");
    }
}
