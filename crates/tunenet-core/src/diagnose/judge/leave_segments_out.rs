//! Segments of a recording that are hidden from the fit and predicted from the others: what confirms an effect where no
//! recording of the same object can be set aside.

use crate::Result;
use crate::diagnose::evidence::recording::PreparedRecording;
use crate::diagnose::hypothesis::context::{Context, FULL, Hypothesis};
use crate::diagnose::hypothesis::joint::Joint;

/// Every so many segments one is hidden, the first never: nothing else shows how it began.
const EVERY: usize = 3;

/// Root mean square, in units of what each channel takes for noise, of what `model`, fitted anew to the other
/// segments, leaves on those hidden, every one but the first of each recording in its turn. `None` where no recording has two events.
pub(in crate::diagnose) fn leave_segments_out(context: &Context<'_>, model: &Hypothesis) -> Result<Option<f64>> {
    let (mut squares, mut samples) = (0.0, 0.0);
    for turn in 0..EVERY {
        let split = context.recordings().iter().map(|recording| without(recording, turn));
        let (shown, judged): (Vec<PreparedRecording>, Vec<PreparedRecording>) = split.unzip();
        let count: usize = judged.iter().map(PreparedRecording::count).sum();
        if count == 0 {
            continue;
        }
        let joint =
            Joint { structure: &model.structure, recordings: &shown, separable: false, rollouts: &context.rollouts };
        let point = joint.fit(model.fit.point.clone(), FULL)?.point;
        for (recording, plain) in judged.iter().zip(joint.plain_residuals(&point)?) {
            let kept = plain.iter().enumerate().filter(|(i, _)| recording.keep[*i]);
            squares += kept.map(|(i, v)| (v / recording.noise[i % recording.width()]).powi(2)).sum::<f64>();
        }
        samples += count as f64;
    }
    Ok((samples > 0.0).then(|| (squares / samples).sqrt()))
}

/// A recording without the segments of this turn, and with them alone.
fn without(recording: &PreparedRecording, turn: usize) -> (PreparedRecording, PreparedRecording) {
    let width = recording.width();
    let (mut shown, mut judged) = (recording.clone(), recording.clone());
    for (k, t) in recording.clock().iter().enumerate() {
        let segment = recording.events.partition_point(|c| c <= t);
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
            evidence.training.iter_mut().for_each(|recording| recording.events = vec![0.5, 1.0, 1.5]);
            let context = context.with_evidence(evidence);
            let base = fit_without_effects(&context).unwrap();
            let left = leave_segments_out(&context, &base).unwrap().unwrap();
            assert!((left - 1.0).abs() < 0.25, "{left}");
        });
    }
}
