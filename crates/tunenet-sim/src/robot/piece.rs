//! A straight piece of a piecewise linear signal.

/// A straight piece of a signal, on the clock of its samples.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Piece {
    pub value: f64,
    /// 1/s.
    pub slope: f64,
    /// Where it has that value.
    pub from_s: f64,
    /// Where it ends.
    pub until_s: f64,
}

impl Piece {
    #[inline]
    pub fn at(&self, time_s: f64) -> f64 {
        self.value + self.slope * (time_s - self.from_s)
    }
}
