//! The range of every number of a ball's world.

/// The greatest size of any number of a scene or a start: beyond it, sums of squares would lose the ball's own size.
pub const GREATEST: f64 = 1e9;

/// Refuses what lies outside `min` to `max`, NaN included.
pub(crate) fn within(name: &str, value: f64, min: f64, max: f64) -> Result<(), String> {
    if (min..=max).contains(&value) {
        return Ok(());
    }
    Err(format!("`{name}` is {value}, but has to lie within {min} and {max}"))
}
