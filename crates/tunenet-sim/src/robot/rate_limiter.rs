//! Rate limiter behind a piecewise linear signal: its output is piecewise linear too, and its corners have closed forms.

use super::piece::Piece;

/// A goal closer than this to what follows it is reached.
const REACHED: f64 = 1e-12;

/// What follows a signal at no more than a rate.
#[derive(Debug, Clone, Copy)]
pub(super) struct RateLimiter {
    /// The greatest rate, 1/s.
    rate: f64,
    /// What follows the piece at which it catches up with the signal.
    rest: Option<Piece>,
}

impl RateLimiter {
    /// One with this greatest rate, 1/s.
    pub const fn new(rate: f64) -> Self {
        Self { rate, rest: None }
    }

    /// The first piece of its output from an instant on, where it has this value, while its input is `input`. Where it reaches the input
    /// before that ends, [`rest`](Self::rest) gives the second one.
    pub fn behind(&mut self, input: Piece, (from_s, value): (f64, f64)) -> Piece {
        let behind = value - input.at(from_s);
        let reached = |from_s: f64, value: f64| Piece {
            value,
            slope: input.slope.clamp(-self.rate, self.rate),
            from_s,
            until_s: input.until_s,
        };
        if behind.abs() <= REACHED {
            return reached(from_s, value);
        }
        let slope = -behind.signum() * self.rate;
        let closing = input.slope - slope;
        let met_s = if closing * behind > 0.0 { from_s + behind / closing } else { f64::INFINITY };
        self.rest = (met_s < input.until_s).then(|| reached(met_s, input.at(met_s)));
        Piece { value, slope, from_s, until_s: met_s.min(input.until_s) }
    }

    /// What follows the last piece without a new sample of the input; asked again, nothing.
    pub fn rest(&mut self) -> Option<Piece> {
        self.rest.take()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line that rises by 1/s from 0 on until t = 3 s.
    const LINE: Piece = Piece { value: 0.0, slope: 1.0, from_s: 0.0, until_s: 3.0 };

    #[test]
    fn it_catches_up_with_a_line_from_either_side() {
        // From −2 at 3/s: it meets t at −2 + 3 t. From 2 at −3/s: at 2 − 3 t.
        for (start, slope, met_s) in [(-2.0, 3.0, 1.0), (2.0, -3.0, 0.5)] {
            let mut limiter = RateLimiter::new(3.0);
            let first = limiter.behind(LINE, (0.0, start));
            assert_eq!(first, Piece { value: start, slope, from_s: 0.0, until_s: met_s });
            assert_eq!(limiter.rest(), Some(Piece { value: met_s, slope: 1.0, from_s: met_s, until_s: 3.0 }));
            assert_eq!(limiter.rest(), None);
        }
    }

    #[test]
    fn a_line_that_is_too_steep_or_ends_too_early_is_not_reached() {
        let mut slow = RateLimiter::new(0.5);
        assert_eq!(slow.behind(LINE, (0.0, 0.0)), Piece { slope: 0.5, ..LINE });
        assert_eq!(slow.behind(LINE, (0.0, -1.0)), Piece { value: -1.0, slope: 0.5, ..LINE });
        // From above it falls towards the line, and is there after 8 s.
        assert_eq!(slow.behind(LINE, (0.0, 12.0)), Piece { value: 12.0, slope: -0.5, ..LINE });
        assert_eq!(slow.rest(), None);
    }

    #[test]
    fn what_it_has_reached_it_follows() {
        let mut limiter = RateLimiter::new(3.0);
        assert_eq!(limiter.behind(LINE, (1.0, 1.0)), Piece { value: 1.0, from_s: 1.0, ..LINE });
        assert_eq!(limiter.rest(), None);
    }
}
