//! Sine of an angle that moves little from step to step: addition theorems, with Taylor polynomials of the difference (Abramowitz and Stegun
//! 1964, 4.3.16, 4.3.65 and 4.3.66).

/// Largest difference, rad: the first terms that are left out, d⁷/5040 and d⁸/40320, are below 5e-17 there.
const LARGEST_RAD: f64 = 1.0 / 64.0;
/// After so many differences the sine is computed anew, so that their rounding does not add up.
const MOST: u32 = 256;

/// A multiple of the sine of the last angle, and the same multiple of its cosine.
#[derive(Debug, Clone)]
pub(super) struct NearSine {
    amplitude: f64,
    sin: f64,
    cos: f64,
    differences: u32,
}

impl NearSine {
    /// `amplitude` times the sine, which begins at an angle in rad.
    pub fn new(amplitude: f64, angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self { amplitude, sin: amplitude * sin, cos: amplitude * cos, differences: 0 }
    }

    /// Its value at an angle that lies `difference` after the last one, rad.
    #[inline]
    pub fn at(&mut self, angle: f64, difference: f64) -> f64 {
        let (s, c, d) = (self.sin, self.cos, difference);
        // Written so that an angle that is no number comes out as none.
        if d.abs() <= LARGEST_RAD && self.differences < MOST {
            // By powers of the difference, added up in pairs, so that no product waits for many others.
            let square = d * d;
            let fourth = square * square;
            let sixth = square * fourth * (1.0 / 720.0);
            let near = |value: f64, slope: f64| {
                let second = value * 0.5 + slope * (1.0 / 6.0) * d;
                let further = value * (1.0 / 24.0) + slope * (1.0 / 120.0) * d;
                (value + slope * d) + (fourth * further - square * second) - value * sixth
            };
            (self.sin, self.cos) = (near(s, c), near(c, -s));
            self.differences += 1;
        } else {
            *self = Self::new(self.amplitude, angle);
        }
        self.sin
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Slow and fast swings, jumps, and many turns.
    #[test]
    fn it_is_the_sine() {
        let paths: [&dyn Fn(f64) -> f64; 4] =
            [&|t| 2.0 * (3.0 * t).sin(), &|t| 15.0 * t, &|t| 40.0 * t * t, &|t| (500.0 * t).floor() * 0.3];
        for path in paths {
            let mut last = path(0.0);
            let mut near = NearSine::new(2.0, last);
            for i in 0..20_000 {
                let angle = path(f64::from(i) * 1e-3);
                let (found, exact) = (near.at(angle, angle - last), 2.0 * angle.sin());
                assert!((found - exact).abs() < 4e-14, "{angle}: {found} {exact}");
                last = angle;
            }
        }
    }

    #[test]
    fn what_is_no_angle_has_no_sine() {
        let mut near = NearSine::new(1.0, 0.3);
        assert!(near.at(f64::NAN, f64::NAN).is_nan() && near.at(f64::INFINITY, f64::INFINITY).is_nan());
        assert_eq!(near.at(0.5, f64::NAN), 0.5_f64.sin());
    }
}
