//! Single precision, in which the network learns.

/// In single precision.
#[expect(clippy::cast_possible_truncation, reason = "losing digits is the point")]
pub(super) fn single(number: f64) -> f32 {
    number as f32
}
