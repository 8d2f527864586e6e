//! One column of a file's schema: whether it holds numbers, and in which form they are written.

use parquet::basic::{ConvertedType, LogicalType, TimeUnit, TimestampType, Type as Physical};
use parquet::schema::types::ColumnDescriptor;

use super::values::Levels;
use crate::arrays::half;
use crate::ros::stamps::to_s;

/// Most digits behind the point of a decimal, and most of its bytes: more than a double distinguishes.
const MOST_DIGITS: i32 = 38;
const MOST_BYTES: usize = 16;

/// A column of numbers, or of as many numbers in each row.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Column {
    pub name: String,
    pub of: Holds,
    pub(super) index: usize,
    pub(super) levels: Levels,
    pub(super) form: Form,
}

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Holds {
    /// One number in each row.
    Number,
    /// One instant in each row.
    Instant,
    /// A list of numbers in each row.
    List,
    /// Anything else.
    Other,
}

/// How its numbers are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    /// As numbers of their own type.
    Plain,
    /// As ticks, so many of which are a second.
    Ticks(i64),
    /// As whole numbers with so many digits behind the point.
    Decimal(i32),
    /// As two bytes of half precision, the lower one first.
    Half,
}

impl Form {
    /// The number that a whole one stands for.
    pub(super) fn whole(self, value: i64) -> f64 {
        match self {
            // Nanoseconds keep their last digit.
            Self::Ticks(a_second) => {
                value.checked_mul(1_000_000_000 / a_second).map_or(value as f64 / a_second as f64, to_s)
            }
            Self::Decimal(digits) => value as f64 / 10f64.powi(digits),
            Self::Plain | Self::Half => value as f64,
        }
    }

    /// The number that bytes stand for; not a number where they are none of its form.
    pub(super) fn bytes(self, bytes: &[u8]) -> f64 {
        match (self, bytes) {
            (Self::Half, [low, high]) => half(u16::from_le_bytes([*low, *high])),
            // A whole number in two's complement, the highest byte first.
            (Self::Decimal(digits), [first, ..]) if bytes.len() <= MOST_BYTES => {
                let sign = if *first < 0x80 { 0 } else { -1 };
                let value = bytes.iter().fold(sign, |value: i128, byte| value << 8 | i128::from(*byte));
                value as f64 / 10f64.powi(digits)
            }
            _ => f64::NAN,
        }
    }
}

impl Column {
    /// What it is called in a table, with `width` numbers in each row.
    pub(super) fn names(&self, width: usize) -> Vec<String> {
        match self.of {
            Holds::List => (0..width).map(|i| format!("{}.{i}", self.name)).collect(),
            Holds::Instant if !self.name.ends_with("_s") => vec![format!("{}_s", self.name)],
            _ => vec![self.name.clone()],
        }
    }
}

/// A column of the schema. A list is named as its field is, not as what Parquet calls its elements.
pub(super) fn column(index: usize, described: &ColumnDescriptor) -> Column {
    let (definition, repetition) = (described.max_def_level(), described.max_rep_level());
    let levels = Levels { definition, repetition, optional: described.self_type().is_optional() };
    let parts = described.path().parts();
    let list = levels.repetition == 1;
    let named = if list { &parts[..1.max(parts.len().saturating_sub(2))] } else { parts };
    let form = form(described);
    let of = match form {
        Some(_) if levels.repetition > 1 => Holds::Other,
        Some(Form::Ticks(_)) if !list => Holds::Instant,
        Some(_) if list => Holds::List,
        Some(_) => Holds::Number,
        None => Holds::Other,
    };
    // Instants in a list are plain numbers.
    let form = form.filter(|form| of == Holds::Instant || !matches!(form, Form::Ticks(_))).unwrap_or(Form::Plain);
    Column { name: named.join("."), of, index, levels, form }
}

/// How the numbers of a column are written; `None` where it holds none.
fn form(described: &ColumnDescriptor) -> Option<Form> {
    let ticks = match (described.logical_type_ref(), described.converted_type()) {
        (Some(LogicalType::Timestamp(TimestampType { unit: TimeUnit::MILLIS, .. })), _)
        | (_, ConvertedType::TIMESTAMP_MILLIS) => 1_000,
        (Some(LogicalType::Timestamp(TimestampType { unit: TimeUnit::MICROS, .. })), _)
        | (_, ConvertedType::TIMESTAMP_MICROS) => 1_000_000,
        (Some(LogicalType::Timestamp(TimestampType { unit: TimeUnit::NANOS, .. })), _) => 1_000_000_000,
        _ => 0,
    };
    let decimal = described.converted_type() == ConvertedType::DECIMAL;
    match described.physical_type() {
        Physical::INT96 => None,
        Physical::FIXED_LEN_BYTE_ARRAY if matches!(described.logical_type_ref(), Some(LogicalType::Float16)) => {
            Some(Form::Half)
        }
        _ if decimal => {
            let digits = described.type_scale();
            let few = usize::try_from(described.type_length()).is_ok_and(|bytes| bytes <= MOST_BYTES);
            let fixed = described.physical_type() == Physical::FIXED_LEN_BYTE_ARRAY;
            ((0..=MOST_DIGITS).contains(&digits) && (few || !fixed)).then_some(Form::Decimal(digits))
        }
        Physical::BYTE_ARRAY | Physical::FIXED_LEN_BYTE_ARRAY => None,
        Physical::INT64 if ticks > 0 => Some(Form::Ticks(ticks)),
        Physical::BOOLEAN | Physical::INT32 | Physical::INT64 | Physical::FLOAT | Physical::DOUBLE => Some(Form::Plain),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_decimals_or_of_half_precision() {
        assert_eq!(Form::Decimal(2).bytes(&[0x01, 0x00]), 2.56);
        assert_eq!(Form::Decimal(2).bytes(&[0xff, 0x9c]), -1.0);
        assert_eq!(Form::Decimal(0).bytes(&[0x80; 16]), i128::from_be_bytes([0x80; 16]) as f64);
        assert_eq!(Form::Half.bytes(&[0x00, 0x3c]), 1.0);
        assert!(Form::Half.bytes(&[0x00]).is_nan() && Form::Decimal(1).bytes(&[]).is_nan());
        assert!(Form::Decimal(1).bytes(&[0; 17]).is_nan() && Form::Plain.bytes(&[0; 2]).is_nan());
    }

    #[test]
    fn whole_numbers_are_ticks_or_decimals() {
        assert_eq!(Form::Ticks(1_000).whole(1_500), 1.5);
        assert_eq!(Form::Ticks(1_000).whole(i64::MAX), i64::MAX as f64 / 1e3);
        assert_eq!((Form::Decimal(3).whole(-1_250), Form::Plain.whole(7)), (-1.25, 7.0));
    }
}
