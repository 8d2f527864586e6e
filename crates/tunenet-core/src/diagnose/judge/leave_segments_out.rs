//! Segments of a recording that are hidden from the fit and predicted from the others: what confirms an effect where no
//! recording of the same object can be set aside.

use crate::Result;
use crate::diagnose::evidence::recording::Set;
use crate::diagnose::hypothesis::context::{Context, FULL, Hypothesis};
use crate::diagnose::hypothesis::joint::Joint;

/// Every so many segments one is hidden, the first never: nothing else shows how it began.
const EVERY: usize = 3;

/// Root mean square, in units of what each channel takes for noise, of what `model`, fitted anew to the other
/// segments, leaves on those hidden, every one but the first of each recording in its turn. `None` where no recording has two events.
pub(in crate::diagnose) fn leave_segments_out(context: &Context<'_>, model: &Hypothesis) -> Result<Option<f64>> {
    let (mut squares, mut samples) = (0.0, 0.0);
    for turn in 0..EVERY {
        let (shown, judged): (Vec<Set>, Vec<Set>) = context.sets().iter().map(|set| without(set, turn)).unzip();
        let count: usize = judged.iter().map(Set::count).sum();
        if count == 0 {
            continue;
        }
        let joint = Joint { structure: &model.structure, sets: &shown, rollouts: &context.rollouts };
        let point = joint.fit(model.fit.point.clone(), FULL)?.point;
        for (set, plain) in judged.iter().zip(joint.plain_residuals(&point)?) {
            let kept = plain.iter().enumerate().filter(|(i, _)| set.keep[*i]);
            squares += kept.map(|(i, v)| (v / set.noise[i % set.width()]).powi(2)).sum::<f64>();
        }
        samples += count as f64;
    }
    Ok((samples > 0.0).then(|| (squares / samples).sqrt()))
}

/// A recording without the segments of this turn, and with them alone.
fn without(set: &Set, turn: usize) -> (Set, Set) {
    let width = set.width();
    let (mut shown, mut judged) = (set.clone(), set.clone());
    for (k, t) in set.clock().iter().enumerate() {
        let segment = set.events.partition_point(|c| c <= t);
        let hide = segment > 0 && segment % EVERY == turn;
        for i in k * width..(k + 1) * width {
            shown.keep[i] &= !hide;
            judged.keep[i] &= hide;
        }
    }
    shown.prewhiten(0.0);
    (shown, judged)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::tests::zoo::in_swings;

    use crate::diagnose::hypothesis::multistart::fit_without_effects;

    #[test]
    fn without_events_there_is_no_segment_to_leave_out() {
        in_swings(&[], 2, 0, |context| {
            let base = fit_without_effects(context).unwrap();
            assert_eq!(leave_segments_out(context, &base).unwrap(), None);
        });
    }

    #[test]
    fn a_segment_left_out_is_predicted_from_the_others() {
        in_swings(&[], 2, 0, |context| {
            let mut evidence = crate::diagnose::evidence::Evidence::clone(&context.evidence);
            evidence.training.iter_mut().for_each(|set| set.events = vec![0.5, 1.0, 1.5]);
            let context = context.with_evidence(evidence);
            let base = fit_without_effects(&context).unwrap();
            let left = leave_segments_out(&context, &base).unwrap().unwrap();
            assert!((left - 1.0).abs() < 0.25, "{left}");
        });
    }
}
