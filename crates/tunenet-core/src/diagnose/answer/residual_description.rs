//! Description of an unmodelled residual: where it acts, along which axis, its size, and what it follows.

use nalgebra::{DMatrix, DVector};

use crate::Result;
use crate::diagnose::evidence::recording::PreparedRecording;
use crate::diagnose::hypothesis::context::{Context, Hypothesis};
use crate::diagnose::hypothesis::wording::{Wording, is_segmented, words};
use crate::observation::{Channel, three_digits};
use crate::simulator::Phase;

/// An arc with fewer samples says nothing of its bend.
const LEAST_SAMPLES: usize = 10;
/// Arcs that go with a quantity this closely (correlation) are said to.
const CLOSE: f64 = 0.7;
const FEWEST_ARCS: usize = 4;

/// One free segment of one channel: what the residual does in it beyond the model.
struct Arc {
    channel: usize,
    /// Which segment of its recording, from 0.
    number: usize,
    /// Mean of the residual, in the channel's unit, its slope per s, and its bend per s².
    offset: f64,
    slope: f64,
    acceleration: f64,
    /// What each of them explains of the weighted squares.
    offset_square: f64,
    slope_square: f64,
    bend_square: f64,
    samples: usize,
    middle_s: f64,
    level: f64,
    speed: f64,
}

impl Arc {
    fn line_square(&self) -> f64 {
        self.offset_square + self.slope_square
    }
}

/// Describes what `model` leaves, and says where it acts as far as that shows.
pub(in crate::diagnose) fn describe(context: &Context, model: &Hypothesis) -> Result<(String, Option<Phase>)> {
    let residuals = context.weighted(model)?;
    let arcs: Vec<Arc> = context
        .recordings()
        .iter()
        .zip(&residuals)
        .flat_map(|(recording, residual)| arcs(recording, residual, is_segmented(context)))
        .collect();
    let channels = context.subjects[0].simulator.channels();
    let excess = |channel: usize| -> f64 {
        arcs.iter().filter(|a| a.channel == channel).map(|a| a.bend_square + a.line_square() - 3.0).sum()
    };
    let shown = (0..channels.len()).filter(|&channel| arcs.iter().any(|a| a.channel == channel));
    let Some(worst) = shown.max_by(|&a, &b| excess(a).total_cmp(&excess(b))) else {
        return Ok(("the remaining residual has no recognisable pattern".into(), None));
    };
    let mine: Vec<&Arc> = arcs.iter().filter(|a| a.channel == worst).collect();
    let count = mine.len().max(1) as f64;
    let (bend, line) =
        mine.iter().fold((0.0, 0.0), |(b, l), a| (b + a.bend_square / count, l + a.line_square() / (2.0 * count)));
    let axis = &channels[worst];
    let later = mine.iter().any(|a| a.number > 0);
    let words = words(context);
    if !is_segmented(context) {
        return Ok((of_anything(&mine, axis, bend > 4.0 || line > 4.0, words), None));
    }
    let size = three_digits(root_mean_square(&mine, |a| a.acceleration));
    let (shape, phase) = if bend > 4.0 || !later {
        let text =
            format!("within the {}, as a bend of about {size} {}/s² along {}", words.segment[1], axis.unit, axis.name);
        (text, Some(Phase::Segment))
    } else if line > 4.0 {
        let [one, _] = words.segment;
        let text = format!("from one {one} to the next, so at the {}, along {}", words.events, axis.name);
        (text, Some(Phase::Event))
    } else {
        (format!("faster than a {}, as an oscillation or a jitter along {}", words.segment[0], axis.name), None)
    };
    let with = with(&mine, |a| a.acceleration, [words.level, "the speed", words.event_count]);
    Ok((format!("the residual acts {shape}; {with}"), phase))
}

/// The same of what has no segments: whether a whole record is off by a constant, by a drift or by a bend, whichever explains most.
fn of_anything(arcs: &[&Arc], axis: &Channel, slow: bool, words: &Wording) -> String {
    let sum = |of: fn(&Arc) -> f64| arcs.iter().map(|arc| of(arc)).sum::<f64>();
    let (offset, slope, bend) = (sum(|a| a.offset_square), sum(|a| a.slope_square), sum(|a| a.bend_square));
    let (unit, name) = (&axis.unit, &axis.name);
    let (of, shape): (fn(&Arc) -> f64, String) = if !slow {
        (|a| a.acceleration, format!("faster than the record is long, as an oscillation or a jitter of {name}"))
    } else if offset >= slope.max(bend) {
        let size = three_digits(root_mean_square(arcs, |a| a.offset));
        let side = if arcs.iter().all(|a| a.offset > 0.0) {
            ", measured above simulated"
        } else if arcs.iter().all(|a| a.offset < 0.0) {
            ", measured below simulated"
        } else {
            ""
        };
        (
            |a| a.offset,
            format!("over the whole of each record, as a constant offset of about {size} {unit} of {name}{side}"),
        )
    } else if slope >= bend {
        let size = three_digits(root_mean_square(arcs, |a| a.slope));
        (|a| a.slope, format!("over the whole of each record, as a drift of about {size} {unit}/s of {name}"))
    } else {
        let size = three_digits(root_mean_square(arcs, |a| a.acceleration));
        (|a| a.acceleration, format!("over the whole of each record, as a bend of about {size} {unit}/s² of {name}"))
    };
    format!("the residual acts {shape}; {}", with(arcs, of, ["its size", "how fast things change", words.event_count]))
}

/// Root mean square of a quantity of the arcs, each weighed by its samples.
fn root_mean_square(arcs: &[&Arc], of: fn(&Arc) -> f64) -> f64 {
    let weight: f64 = arcs.iter().map(|a| a.samples as f64).sum();
    (arcs.iter().map(|a| a.samples as f64 * of(a).powi(2)).sum::<f64>() / weight.max(1.0)).sqrt()
}

/// What a quantity of the arcs goes with, in words; level, speed and the count of events as they are called.
fn with(arcs: &[&Arc], of: fn(&Arc) -> f64, names: [&'static str; 3]) -> String {
    goes_with(arcs, of, names).map_or_else(
        || {
            let bare = |name: &'static str| name.trim_start_matches("the ");
            format!("it follows neither {}, {} nor time clearly", bare(names[0]), bare(names[1]))
        },
        |(what, r)| format!("it {} with {what}", if r > 0.0 { "grows" } else { "falls" }),
    )
}

/// What the quantity follows most closely from arc to arc, with the correlation, where it is close.
fn goes_with(
    arcs: &[&Arc],
    of: fn(&Arc) -> f64,
    [level, speed, count]: [&'static str; 3],
) -> Option<(&'static str, f64)> {
    if arcs.len() < FEWEST_ARCS {
        return None;
    }
    let sizes: Vec<f64> = arcs.iter().map(|a| of(a)).collect();
    let each: [(&'static str, Vec<f64>); 4] = [
        (level, arcs.iter().map(|a| a.level).collect()),
        (speed, arcs.iter().map(|a| a.speed).collect()),
        ("the time in the record", arcs.iter().map(|a| a.middle_s).collect()),
        (count, arcs.iter().map(|a| a.number as f64).collect()),
    ];
    let best = each.into_iter().map(|(name, values)| (name, correlation(&sizes, &values)));
    best.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).filter(|(_, r)| r.abs() > CLOSE)
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len() as f64;
    let (mean_a, mean_b) = (a.iter().sum::<f64>() / n, b.iter().sum::<f64>() / n);
    let sum = |f: &dyn Fn(f64, f64) -> f64| a.iter().zip(b).map(|(x, y)| f(x - mean_a, y - mean_b)).sum::<f64>();
    let scale = (sum(&|x, _| x * x) * sum(&|_, y| y * y)).sqrt();
    if scale > 0.0 { sum(&|x, y| x * y) / scale } else { 0.0 }
}

/// The segments between events, each channel's residual fitted by a parabola. The level is the last channel where the motion
/// has segments; otherwise each channel has a size of its own.
fn arcs(recording: &PreparedRecording, residual: &[f64], segmented: bool) -> Vec<Arc> {
    let (clock, width) = (recording.clock(), recording.width());
    let seen = &recording.prepared.seen;
    let mut edges = vec![0];
    edges.extend(recording.events.iter().map(|t| clock.partition_point(|c| c < t)));
    edges.push(clock.len());
    let mut all = Vec::new();
    for (number, edge) in edges.windows(2).enumerate() {
        // The samples next to an event may belong to either side.
        let (begin, end) = (edge[0] + usize::from(edge[0] > 0), edge[1].saturating_sub(1).max(edge[0]));
        if end < begin + LEAST_SAMPLES {
            continue;
        }
        let (middle_s, half) = (0.5 * (clock[begin] + clock[end - 1]), 0.5 * (clock[end - 1] - clock[begin]));
        let travelled: f64 =
            (0..width).map(|c| (seen.row(end - 1)[c] - seen.row(begin)[c]).powi(2)).sum::<f64>().sqrt();
        for channel in 0..width {
            let kept: Vec<usize> = (begin..end).filter(|&k| recording.keep[k * width + channel]).collect();
            if kept.len() < LEAST_SAMPLES {
                continue;
            }
            // Legendre's polynomials, near enough orthogonal on even samples.
            let x = |k: usize| (clock[k] - middle_s) / half;
            let basis = DMatrix::from_fn(kept.len(), 3, |i, j| match j {
                0 => 1.0,
                1 => x(kept[i]),
                _ => 1.5 * x(kept[i]).powi(2) - 0.5,
            });
            let level = if segmented { width - 1 } else { channel };
            let values = DVector::from_iterator(kept.len(), kept.iter().map(|&k| residual[k * width + channel]));
            let Some(inverse) = (basis.transpose() * &basis).try_inverse() else { continue };
            let fit = &inverse * (basis.transpose() * values);
            all.push(Arc {
                channel,
                number,
                offset: fit[0] * recording.noise[channel],
                slope: fit[1] / half * recording.noise[channel],
                acceleration: 3.0 * fit[2] / (half * half) * recording.noise[channel],
                offset_square: fit[0].powi(2) / inverse[(0, 0)],
                slope_square: fit[1].powi(2) / inverse[(1, 1)],
                bend_square: fit[2].powi(2) / inverse[(2, 2)],
                samples: kept.len(),
                middle_s,
                level: kept.iter().map(|&k| seen.row(k)[level]).sum::<f64>() / kept.len() as f64,
                speed: travelled / (2.0 * half),
            });
        }
    }
    all
}
