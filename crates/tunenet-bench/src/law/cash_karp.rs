//! The embedded Runge–Kutta pair of Cash and Karp (1990, ACM TOMS 16:201), order 5(4), with step control; an event ends it
//! where bisection finds it.

/// Numbers of a state: three of position, three of velocity, two that nobody sees.
pub type State = [f64; 8];

/// Error of a step that is allowed, in the units of the state.
const TOLERANCE: f64 = 1e-10;
/// Halvings of a step in which an event happens: down to the clock's last bits.
const HALVINGS: usize = 60;
/// Below this step, s, control gives up and takes the step as it is; a jump of the force costs that much accuracy.
const SHORTEST_S: f64 = 1e-9;
/// Bounds of one change of the step, and the share of the estimated step that is taken.
const SHRINK: f64 = 0.2;
const GROW: f64 = 4.0;
const SAFETY: f64 = 0.9;

const NODES: [f64; 6] = [0.0, 0.2, 0.3, 0.6, 1.0, 0.875];
const WEIGHTS: [[f64; 5]; 6] = [
    [0.0; 5],
    [0.2, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0],
    [0.3, -0.9, 1.2, 0.0, 0.0],
    [-11.0 / 54.0, 2.5, -70.0 / 27.0, 35.0 / 27.0, 0.0],
    [1631.0 / 55296.0, 175.0 / 512.0, 575.0 / 13824.0, 44275.0 / 110_592.0, 253.0 / 4096.0],
];
const FIFTH: [f64; 6] = [37.0 / 378.0, 0.0, 250.0 / 621.0, 125.0 / 594.0, 0.0, 512.0 / 1771.0];
const FOURTH: [f64; 6] = [2825.0 / 27648.0, 0.0, 18575.0 / 48384.0, 13525.0 / 55296.0, 277.0 / 14336.0, 0.25];

/// What moves: its slope, and a number that is negative once an event has happened.
pub trait Motion {
    fn slope(&self, time_s: f64, state: &State) -> State;

    /// Positive or 0 before the event.
    fn gap(&self, time_s: f64, state: &State) -> f64;
}

/// Follows `motion` from `now` to `end`, in steps of at most `longest_s`; ends at once where an event happens. Gives the time,
/// the state there, and whether an event ended it. The state may not be finite where the force is not.
pub fn follow(motion: &impl Motion, now: f64, state: State, end: f64, longest_s: f64) -> (f64, State, bool) {
    let (mut now, mut state, mut wanted) = (now, state, longest_s);
    while end - now > 1e-13 {
        let h = wanted.min(longest_s).min(end - now);
        let (next, error) = step(motion, now, &state, h);
        let share = error / TOLERANCE;
        if share > 1.0 && h > SHORTEST_S {
            wanted = (h * (SAFETY * share.powf(-0.25)).max(SHRINK)).max(SHORTEST_S);
            continue;
        }
        // A step that the end cut short says nothing against longer ones.
        wanted = (wanted.max(h) * (SAFETY * share.max(1e-9).powf(-0.2)).clamp(SHRINK, GROW)).min(longest_s);
        if motion.gap(now + h, &next) < 0.0 {
            let (mut low, mut high) = (0.0, h);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                let there = step(motion, now, &state, middle).0;
                if motion.gap(now + middle, &there) >= 0.0 { low = middle } else { high = middle }
            }
            return (now + low, step(motion, now, &state, low).0, true);
        }
        if !next.iter().all(|v| v.is_finite()) {
            return (end, next, false);
        }
        (now, state) = (now + h, next);
    }
    (end, state, false)
}

/// One step of order 5, and the largest difference of a number to that of order 4.
fn step(motion: &impl Motion, now: f64, state: &State, h: f64) -> (State, f64) {
    let mut slopes = [[0.0; 8]; 6];
    for stage in 0..6 {
        let there = ahead(state, h, &WEIGHTS[stage][..stage], &slopes);
        slopes[stage] = motion.slope(now + NODES[stage] * h, &there);
    }
    let next = ahead(state, h, &FIFTH, &slopes);
    let other = ahead(state, h, &FOURTH, &slopes);
    let error = next.iter().zip(&other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    (next, error)
}

fn ahead(state: &State, h: f64, weights: &[f64], slopes: &[State; 6]) -> State {
    std::array::from_fn(|i| state[i] + h * weights.iter().zip(slopes).map(|(w, slope)| w * slope[i]).sum::<f64>())
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Orbit;

    impl Motion for Orbit {
        fn slope(&self, _: f64, s: &State) -> State {
            let cube = s[0].hypot(s[1]).powi(3);
            [s[3], s[4], 0.0, -s[0] / cube, -s[1] / cube, 0.0, 0.0, 0.0]
        }

        fn gap(&self, _: f64, _: &State) -> f64 {
            1.0
        }
    }

    #[test]
    fn an_eccentric_orbit_of_kepler_closes_after_its_period() {
        // At the apocentre 1 + e of an ellipse with semi-axis 1; its period is 2π.
        let e: f64 = 0.6;
        let start = [1.0 + e, 0.0, 0.0, 0.0, ((1.0 - e) / (1.0 + e)).sqrt(), 0.0, 0.0, 0.0];
        let (_, end, _) = follow(&Orbit, 0.0, start, std::f64::consts::TAU, 0.05);
        let worst = start.iter().zip(&end).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-7, "{worst}");
    }

    struct Fall;

    impl Motion for Fall {
        fn slope(&self, _: f64, s: &State) -> State {
            [s[3], 0.0, 0.0, -9.81, 0.0, 0.0, 0.0, 0.0]
        }

        fn gap(&self, _: f64, s: &State) -> f64 {
            s[0]
        }
    }

    #[test]
    fn an_event_is_found_to_the_last_digits() {
        let start = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        let (at, state, happened) = follow(&Fall, 0.0, start, 1.0, 0.1);
        assert!(happened && (at - (2.0_f64 / 9.81).sqrt()).abs() < 1e-13, "{at}");
        assert!(state[0] >= 0.0 && state[0] < 1e-12, "{state:?}");
        let (at, _, happened) = follow(&Fall, 0.0, start, 0.3, 0.1);
        assert!(!happened && at == 0.3);
    }
}
