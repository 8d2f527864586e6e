//! End of the motion: the first sample from which the height follows a straight line, because the ball rests or rolls.

use tunenet_core::observation::{Kind, Observation};

/// How long the height has to follow a straight line, s; a flight of this length leaves it by centimetres.
const WINDOW_S: f64 = 0.25;
/// Bounces lower than this share of the range of heights add no information to the earlier ones.
const LOW_SHARE: f64 = 2e-3;
/// ... nor do those slower than 0.1 m/s, m.
const LOW_M: f64 = 5e-4;
/// ... nor those lower than so many standard deviations of the noise.
const LOW_NOISE: f64 = 6.0;
/// What lies or rolls changes its height by no more than this, m/s, and this share of its way along the floor: a fall at its terminal
/// speed follows a straight line too.
const STILL_M_S: f64 = 0.3;
const STEEPEST: f64 = 0.7;
/// A record is not cut to fewer samples than this.
const FEWEST: usize = 24;

/// How many samples come before the rest in which a record of positions ends; all of them where it does not end so.
/// `noise` is the height's standard deviation.
pub(crate) fn before_rest(seen: &Observation, noise: f64) -> usize {
    let all = seen.len();
    if seen.kind() != Kind::Positions {
        return all;
    }
    let (clock, height): (&[f64], Vec<f64>) = (seen.clock(), seen.column(2).collect());
    let (low, high) = height.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), z| (l.min(*z), h.max(*z)));
    let least = LOW_M.max(LOW_SHARE * (high - low)).max(LOW_NOISE * noise);
    let mut begin = all;
    for k in (0..all).rev() {
        let end = clock.partition_point(|t| *t <= clock[k] + WINDOW_S);
        if end == all && clock[all - 1] - clock[k] < WINDOW_S {
            continue;
        }
        let change = |axis: usize| seen.row(end - 1)[axis] - seen.row(k)[axis];
        let rolls = STILL_M_S * (clock[end - 1] - clock[k]) + STEEPEST * change(0).hypot(change(1));
        if bend(&clock[k..end], &height[k..end]) > least || change(2).abs() > rolls + least {
            break;
        }
        begin = k;
    }
    begin.max(FEWEST.min(all))
}

/// The farthest that values stray from the chord of the stretch.
fn bend(clock: &[f64], values: &[f64]) -> f64 {
    let last = values.len() - 1;
    let slope = if last > 0 { (values[last] - values[0]) / (clock[last] - clock[0]) } else { 0.0 };
    clock.iter().zip(values).map(|(t, v)| (v - values[0] - slope * (t - clock[0])).abs()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fall of 1 m, a hop of 0.2 s, then rolling downhill.
    #[test]
    fn what_lies_or_rolls_is_set_aside() {
        let at = |t: f64| match t {
            t if t < 0.4 => 1.0 - 4.905 * t * t,
            t if t < 0.6 => 0.2152 + 0.981 * (t - 0.4) - 4.905 * (t - 0.4).powi(2),
            t => 0.2152 - 0.01 * (t - 0.6),
        };
        let clock: Vec<f64> = (0..300).map(|k| f64::from(k) * 0.01).collect();
        let rows: Vec<[f64; 3]> = clock.iter().map(|t| [0.1 * t, 0.0, at(*t)]).collect();
        let seen = Observation::positions(clock, &rows).unwrap();
        let kept = before_rest(&seen, 0.0);
        assert!((50..=62).contains(&kept), "{kept}");
        assert_eq!(before_rest(&seen.slice(0..50).unwrap(), 0.0), 50);
    }

    /// A fall at 22 m/s, where drag holds gravity: z = v²/g · ln cosh(g t / v) below the start.
    #[test]
    fn a_fall_at_terminal_speed_is_no_rest() {
        let clock: Vec<f64> = (0..60).map(|k| f64::from(k) / 15.0).collect();
        let fallen = |t: f64| 22.0 * 22.0 / 9.81 * (9.81 * t / 22.0).cosh().ln();
        let rows: Vec<[f64; 3]> = clock.iter().map(|t| [0.0, 0.0, 80.0 - fallen(*t)]).collect();
        assert_eq!(before_rest(&Observation::positions(clock, &rows).unwrap(), 0.02), 60);
    }
}
