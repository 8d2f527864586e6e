//! The classical method of Runge and Kutta of fourth order (Kutta 1901), with equal steps between the instants asked for.

/// Follows `slope(time, state)` from `start` at 0 s; `seen` is given each instant of `clock`, its number and the state there. Before
/// 0 s that is `start`.
pub fn follow<const N: usize>(
    start: [f64; N],
    clock: &[f64],
    longest_step_s: f64,
    slope: impl Fn(f64, [f64; N]) -> [f64; N],
    mut seen: impl FnMut(usize, f64, [f64; N]),
) {
    let (mut state, mut now) = (start, 0.0);
    for (number, &time) in clock.iter().enumerate() {
        let mut left = ((time - now) / longest_step_s).ceil();
        let h = if left > 0.0 { (time - now) / left } else { 0.0 };
        while left > 0.0 {
            let ahead = |k: [f64; N], h: f64| std::array::from_fn(|i| state[i] + h * k[i]);
            let a = slope(now, state);
            let b = slope(now + h / 2.0, ahead(a, h / 2.0));
            let c = slope(now + h / 2.0, ahead(b, h / 2.0));
            let d = slope(now + h, ahead(c, h));
            state = std::array::from_fn(|i| state[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
            now += h;
            left -= 1.0;
        }
        now = time.max(now);
        seen(number, time, state);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_oscillation_is_followed() {
        let clock = [0.0, 0.7, 1.9];
        let mut worst: f64 = 0.0;
        let error = |_, t: f64, [x, v]: [f64; 2]| worst = worst.max((x - t.cos()).abs()).max((v + t.sin()).abs());
        follow([1.0, 0.0], &clock, 0.01, |_, [x, v]| [v, -x], error);
        assert!(worst < 1e-9, "{worst}");
    }

    #[test]
    fn the_motion_begins_at_0_s() {
        let mut seen = Vec::new();
        follow([2.0], &[-0.5, -0.1, 0.3], 0.01, |_, _| [1.0], |_, _, [x]| seen.push(x));
        assert!(seen[..2] == [2.0, 2.0] && (seen[2] - 2.3).abs() < 1e-12, "{seen:?}");
    }
}
