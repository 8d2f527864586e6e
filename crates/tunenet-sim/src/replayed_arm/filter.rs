//! Zero-phase Butterworth filter (Gustafsson 1996) and differentiation.
//!
//! A filter of fourth order runs forwards, then backwards, so that phases cancel and amplitudes are multiplied
//! by 1 / (1 + (f / cut-off)⁸): motion at a third of the cut-off keeps all but 2e-4 of itself.

/// Two second-order sections of a fourth-order Butterworth low-pass (bilinear transform, cut-off kept).
struct Section {
    b: [f64; 3],
    a: [f64; 2],
}

/// Damping of the two sections: 1 / (2 sin((2k − 1) π / 8)) is the quality of each.
const QUALITY: [f64; 2] = [1.306_562_964_876_376_5, 0.541_196_100_146_197];

impl Section {
    fn new(cutoff_hz: f64, rate_hz: f64, quality: f64) -> Self {
        let k = (std::f64::consts::PI * cutoff_hz / rate_hz).tan();
        let norm = 1.0 / (1.0 + k / quality + k * k);
        let b = k * k * norm;
        Self { b: [b, 2.0 * b, b], a: [2.0 * (k * k - 1.0) * norm, (1.0 - k / quality + k * k) * norm] }
    }

    /// Filters in place, starting as if the first value had stood for ever.
    fn run(&self, values: &mut [f64]) {
        let Some(&first) = values.first() else { return };
        let [b0, b1, b2] = self.b;
        let [a1, a2] = self.a;
        let mut z2 = (b2 - a2) * first;
        let mut z1 = (b1 - a1) * first + z2;
        for value in values {
            let x = *value;
            let y = b0 * x + z1;
            z1 = b1 * x - a1 * y + z2;
            z2 = b2 * x - a2 * y;
            *value = y;
        }
    }
}

/// How many samples at each end are not to be trusted: two periods of the cut-off.
pub(super) fn edge(cutoff_hz: f64, rate_hz: f64) -> usize {
    whole((2.0 * rate_hz / cutoff_hz).ceil())
}

/// The whole number below a finite one; 0 below 0.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "numbers of samples, far below 2⁵³")]
pub(super) fn whole(value: f64) -> usize {
    value as usize
}

/// `values` without what is faster than `cutoff_hz`, and without delay. The ends are continued by their point mirror.
pub(super) fn smooth(values: &[f64], cutoff_hz: f64, rate_hz: f64) -> Vec<f64> {
    let n = values.len();
    let pad = edge(cutoff_hz, rate_hz).min(n.saturating_sub(1));
    let (first, last) = (values[0], values[n - 1]);
    let mut long: Vec<f64> = (1..=pad).rev().map(|i| 2.0 * first - values[i]).collect();
    long.extend_from_slice(values);
    long.extend((1..=pad).map(|i| 2.0 * last - values[n - 1 - i]));
    let sections = QUALITY.map(|quality| Section::new(cutoff_hz, rate_hz, quality));
    for _ in 0..2 {
        for section in &sections {
            section.run(&mut long);
        }
        long.reverse();
    }
    long[pad..pad + n].to_vec()
}

/// The slope of evenly spaced values, by differences that are exact for polynomials up to the fourth degree; of lower order at
/// the two samples of each end.
pub(super) fn slope(values: &[f64], step: f64) -> Vec<f64> {
    let n = values.len();
    let at = |i: usize| match i {
        0 => values[1] - values[0],
        i if i == n - 1 => values[n - 1] - values[n - 2],
        i if i == 1 || i == n - 2 => (values[i + 1] - values[i - 1]) / 2.0,
        i => (8.0 * (values[i + 1] - values[i - 1]) - (values[i + 2] - values[i - 2])) / 12.0,
    };
    (0..n).map(|i| at(i) / step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(hz: f64) -> Vec<f64> {
        (0..2000).map(|i| (std::f64::consts::TAU * hz * f64::from(i) / 200.0).sin()).collect()
    }

    #[test]
    fn amplitudes_follow_butterworth_and_phases_stay() {
        for hz in [1.0, 5.0, 10.0, 20.0] {
            let (raw, smoothed) = (wave(hz), smooth(&wave(hz), 10.0, 200.0));
            // The bilinear transform bends the scale of frequencies.
            let bent = |f: f64| (std::f64::consts::PI * f / 200.0).tan();
            let kept = 1.0 / (1.0 + (bent(hz) / bent(10.0)).powi(8));
            let worst = (200..1800).map(|i| (smoothed[i] - kept * raw[i]).abs()).fold(0.0, f64::max);
            assert!(worst < 2e-4, "{hz} Hz: {worst}");
        }
    }

    #[test]
    fn constants_and_slopes_pass_unchanged() {
        let line: Vec<f64> = (0..300).map(|i| 2.0 + 0.5 * f64::from(i)).collect();
        let smoothed = smooth(&line, 5.0, 100.0);
        // Half a unit a sample: what starting the filter leaves has died away beyond the edge.
        let mut inner = edge(5.0, 100.0)..300 - edge(5.0, 100.0);
        assert!(inner.all(|i| (line[i] - smoothed[i]).abs() < 1e-3));
        assert!(smooth(&[3.0; 50], 5.0, 100.0).iter().all(|v| (v - 3.0).abs() < 1e-12));
        assert!(slope(&line, 0.01).iter().all(|v| (v - 50.0).abs() < 1e-9));
        let quartic: Vec<f64> = (0..20).map(|i| (0.1 * f64::from(i)).powi(4)).collect();
        assert!((slope(&quartic, 0.1)[9] - 4.0 * 0.9f64.powi(3)).abs() < 1e-12);
    }
}
