//! Which unit numbers may be in, judged by the smallest step between them and by their range.
//!
//! An encoder counts steps of one size, so that its readings lie on a lattice. A step of 360/2ⁿ, of 2π/2ⁿ or of 1 says degrees,
//! radians or counts; any other step says how many degrees one in the file is, if the encoder has 4096 counts a turn, as those
//! of the common bus servos (Feetech STS and Dynamixel X) have.

use tunenet_core::observation::lattice_step;

/// Counts a turn of the encoders of common bus servos.
const COUNTS: f64 = 4096.0;

/// The least number of degrees that one in a file stands for.
const LEAST_DEGREES: f64 = 1e-3;

/// How many turns a joint may make that is proposed by its step alone.
const TURNS: f64 = 2.0;

/// What an encoder may count in a turn: 2¹⁰ to 2²⁰.
const BITS: std::ops::RangeInclusive<i32> = 10..=20;

/// How far a step may be from that of an encoder, as a share of it.
const NEAR: f64 = 1e-3;

/// Fewest different readings that show a lattice.
const FEWEST: usize = 16;

/// A unit that numbers may be in.
#[derive(Debug, Clone, PartialEq)]
pub struct Proposal {
    /// What `--units` would say of it, behind the `=`: `deg`, `1.0122deg`, `1`. `None` where the numbers do not show it.
    pub unit: Option<String>,
    /// What it is concluded from.
    pub why: String,
}

/// The smallest step between these readings of one channel, where they lie on the lattice of an encoder.
#[cfg(feature = "logs")]
pub(crate) fn encoder_step(readings: &[f64]) -> Option<f64> {
    let different = different(readings);
    let way = different.last()? - different.first()?;
    step(&different).filter(|step| way <= TURNS * COUNTS * step)
}

/// Each finite reading once, the least first.
fn different(readings: &[f64]) -> Vec<f64> {
    let mut sorted: Vec<f64> = readings.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    sorted.dedup();
    sorted
}

/// The smallest step between different readings, where there are enough of them.
fn step(different: &[f64]) -> Option<f64> {
    if different.len() < FEWEST { None } else { lattice_step(different) }
}

/// The proposal for these readings of one channel; they are in any order.
pub(crate) fn proposal(readings: &[f64]) -> Proposal {
    let different = different(readings);
    let (Some(low), Some(high)) = (different.first().copied(), different.last().copied()) else {
        return Proposal { unit: None, why: "no numbers".into() };
    };
    if low == high {
        return Proposal { unit: None, why: format!("constant {}: it does not move", shortest(low)) };
    }
    let range = format!("{low:.4} to {high:.4}");
    match step(&different) {
        Some(step) => by_step(step, low, high, &range),
        None => by_range(low, high, &range),
    }
}

/// A number with as many digits as distinguish it in single precision, where it has no more.
fn shortest(number: f64) -> String {
    #[expect(clippy::cast_possible_truncation, reason = "it is compared with what it was")]
    let single = number as f32;
    let written_single = number.fract() != 0.0 && f64::from(single).to_bits() == number.to_bits();
    if written_single { single.to_string() } else { number.to_string() }
}

fn by_step(step: f64, low: f64, high: f64, range: &str) -> Proposal {
    let is = |expected: f64| (step / expected - 1.0).abs() < NEAR;
    let counts = |turn: f64| BITS.map(|bits| 2f64.powi(bits)).find(|counts| is(turn / counts));
    let said = |unit: &str, why: String| Proposal { unit: Some(unit.into()), why };
    if let Some(counts) = counts(360.0) {
        return said("deg", format!("its step {step:.6} is 360°/{counts}"));
    }
    if let Some(counts) = counts(std::f64::consts::TAU) {
        return said("rad", format!("its step {step:.6} is 2π/{counts}"));
    }
    if is(1.0) && high - low > 300.0 {
        return said(
            &format!("{:.6}deg", 360.0 / COUNTS),
            format!("whole numbers {range}: counts of 360°/4096, if its encoder has as many"),
        );
    }
    // Digits that were written, not counted.
    if let Some(decimal) = (-9..=0).map(|digits| 10f64.powi(digits)).find(|decimal| is(*decimal)) {
        return Proposal {
            why: format!("{}; the numbers are rounded to {}", by_range(low, high, range).why, decimal),
            unit: None,
        };
    }
    // A lattice finer than the encoder, over the whole way, is one of arithmetic.
    if high - low > TURNS * COUNTS * step {
        return by_range(low, high, range);
    }
    let degrees = 360.0 / COUNTS / step;
    // Numbers whose step is so large are no readings of an encoder: one of them is broken.
    if degrees < LEAST_DEGREES {
        return by_range(low, high, range);
    }
    let normalised = low >= -100.5 && high <= 100.5;
    let what = if normalised { "normalised, as of LeRobot: " } else { "" };
    said(
        &format!("{degrees:.4}deg"),
        format!("{what}range {range}, step {step:.6}: 360°/4096, if its encoder counts 4096 a turn"),
    )
}

/// What the range alone suggests; nothing that is to be taken without a look.
fn by_range(low: f64, high: f64, range: &str) -> Proposal {
    let most = low.abs().max(high.abs());
    let guess = if low >= 0.0 && high <= 1.0 {
        "a share of its range"
    } else if most <= 3.5 {
        "radians, if it turns"
    } else if low >= -100.5 && high <= 100.5 {
        "normalised or degrees"
    } else if most <= 360.5 {
        "degrees, if it turns"
    } else {
        "counts"
    };
    Proposal { unit: None, why: format!("range {range} alone: {guess}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Readings of an encoder in single precision: so much a step, from `offset` on.
    fn readings(step: f64, offset: f64) -> Vec<f64> {
        let count = |i: u32| f64::from((i * i * 7 + i * 3) % 911);
        #[expect(clippy::cast_possible_truncation, reason = "as a log stores them")]
        let stored = |value: f64| f64::from(value as f32);
        (0..400).map(|i| stored(offset + step * count(i))).collect()
    }

    #[test]
    fn the_step_of_an_encoder_is_found() {
        let unit = |step: f64, offset: f64| proposal(&readings(step, offset)).unit;
        assert_eq!(unit(360.0 / 4096.0, -31.2).as_deref(), Some("deg"));
        assert_eq!(unit(std::f64::consts::TAU / 16384.0, -1.2).as_deref(), Some("rad"));
        assert_eq!(unit(1.0, 1500.0).as_deref(), Some("0.087891deg"));
        // 200 units over 1789 counts: 0.7862° for each.
        assert_eq!(unit(200.0 / 1789.0, -97.0).as_deref(), Some("0.7862deg"));
    }

    #[test]
    fn one_broken_number_gives_no_unit() {
        let broken: Vec<f64> = readings(1e20, 0.0).into_iter().chain([1e30]).collect();
        assert_eq!(proposal(&broken).unit, None);
    }

    #[test]
    fn numbers_without_a_step_are_not_given_a_unit() {
        let smooth: Vec<f64> = (0..400).map(|i| (f64::from(i) * 0.1234).sin() * 2.1).collect();
        let found = proposal(&smooth);
        assert_eq!((found.unit, found.why.contains("radians, if it turns")), (None, true));
        assert!(proposal(&readings(1e-4, 0.2)).why.contains("the numbers are rounded to 0.0001"));
        assert_eq!(proposal(&[1_727_325_696.0; 9]).why, "constant 1727325696: it does not move");
        assert_eq!(proposal(&[f64::from(-0.3917f32); 9]).why, "constant -0.3917: it does not move");
        // Steps of a sum in single precision, far finer than an encoder's.
        let fine: Vec<f64> =
            readings(5.7e-5, -6.9).into_iter().chain([2.0f64.mul_add(5.7e-5 * 10_000.0, -6.9)]).collect();
        assert_eq!(proposal(&fine).unit, None);
        assert!(proposal(&[0.25; 50]).why.contains("does not move"));
        assert_eq!(proposal(&[f64::NAN]).unit, None);
    }
}
