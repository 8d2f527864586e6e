//! Sine of an angle that moves little from step to step: addition theorems, with Taylor polynomials of the difference (Abramowitz and Stegun
//! 1964, 4.3.16, 4.3.65 and 4.3.66).

/// Largest difference, rad: the first terms that are left out, d⁷/5040 and d⁸/40320, are below 5e-17 there.
const LARGEST_RAD: f64 = 1.0 / 64.0;
/// After so many differences the sine is computed anew, so that their rounding does not add up.
const MOST: u32 = 256;

/// Sine and cosine of the last angle.
#[derive(Debug, Clone)]
pub(super) struct NearSine {
    angle: f64,
    sin: f64,
    cos: f64,
    differences: u32,
}

impl NearSine {
    pub fn new(angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self { angle, sin, cos, differences: 0 }
    }

    /// The sine of an angle, in rad.
    #[inline]
    pub fn sin(&mut self, angle: f64) -> f64 {
        let d = angle - self.angle;
        // Written so that an angle that is no number comes out as none.
        if d.abs() <= LARGEST_RAD && self.differences < MOST {
            let square = d * d;
            let sin = d - d * square * (1.0 / 6.0 - square * (1.0 / 120.0));
            let versine = square * (0.5 - square * (1.0 / 24.0 - square * (1.0 / 720.0)));
            let turned = self.sin + (self.cos * sin - self.sin * versine);
            self.cos -= self.sin * sin + self.cos * versine;
            (self.sin, self.angle) = (turned, angle);
            self.differences += 1;
        } else {
            *self = Self::new(angle);
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
            let mut near = NearSine::new(path(0.0));
            for i in 0..20_000 {
                let angle = path(f64::from(i) * 1e-3);
                let (found, exact) = (near.sin(angle), angle.sin());
                assert!((found - exact).abs() < 2e-14, "{angle}: {found} {exact}");
            }
        }
    }

    #[test]
    fn what_is_no_angle_has_no_sine() {
        let mut near = NearSine::new(0.3);
        assert!(near.sin(f64::NAN).is_nan() && near.sin(f64::INFINITY).is_nan());
        assert_eq!(near.sin(0.5), 0.5_f64.sin());
    }
}
