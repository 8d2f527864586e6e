//! Arrays by their names, as NumPy and MATLAB save them, and the columns that they make.

use std::io::Read;
use std::path::Path;

use crate::findings;
use crate::sheet::{Sheet, most_common_rows};
use crate::shown::counted;
use crate::{Error, Result};
use tunenet_core::observation::{FEWEST_SAMPLES, Note};
use tunenet_core::text::visible;

/// Most columns of an array.
pub(crate) const WIDEST: usize = 4_096;

/// Most arrays that a note names.
const MOST_NAMED: usize = 6;

/// Bytes that are read at a time.
const PIECE: usize = 1 << 16;

/// A table of numbers.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Array {
    pub rows: usize,
    pub width: usize,
    /// Whether it is a list, not rows.
    pub flat: bool,
    /// The names of its columns, where it is one of records.
    pub names: Vec<String>,
    /// Row by row.
    pub values: Vec<f64>,
}

/// A number as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Item {
    /// `f`, `i`, `u` or `b`.
    pub kind: u8,
    pub bytes: usize,
    pub big: bool,
}

/// The columns of the arrays that have as many rows as most of them: `NAME`, or `NAME.0` … of an array of rows. A note says which are
/// left out; `refused` are those that could not be read, with the reason.
///
/// # Errors
/// [`Error::File`] where they make no table.
pub(crate) fn sheet(path: &Path, mut arrays: Vec<(String, Array)>, mut refused: Vec<String>) -> Result<Sheet> {
    let Some(rows) = most_common_rows(arrays.iter().map(|(_, array)| array.rows)) else {
        let why = listed(&refused);
        let why = if why.is_empty() { why } else { format!(" ({why})") };
        let message = format!("expected arrays of numbers with {FEWEST_SAMPLES} rows or more, found none{why}");
        return Err(Error::file(path, message, "save the series as arrays of numbers"));
    };
    let other = |(name, array): &(String, Array)| {
        (array.rows != rows).then(|| format!("`{name}`: {}", counted(array.rows, "row")))
    };
    refused.extend(arrays.iter().filter_map(other));
    arrays.retain(|(_, array)| array.rows == rows);
    let notes = left_out(&refused, rows).into_iter().collect();
    let mut names = Vec::new();
    for (name, array) in &arrays {
        match (array.names.as_slice(), array.flat) {
            ([], true) => names.push(name.clone()),
            ([], false) => names.extend((0..array.width).map(|i| format!("{name}.{i}"))),
            (fields, _) => names.extend(fields.iter().map(|field| format!("{name}.{field}"))),
        }
    }
    let row =
        |row: usize| arrays.iter().flat_map(move |(_, a)| a.values[row * a.width..(row + 1) * a.width].iter().copied());
    let values = (0..rows).flat_map(row).collect();
    Ok(Sheet { names, values, notes, ..Sheet::default() })
}

/// Which arrays of a file are no columns, and why.
fn left_out(refused: &[String], rows: usize) -> Option<Note> {
    let text = format!("arrays that are no columns of numbers with {rows} rows: {}", listed(refused));
    (!refused.is_empty()).then(|| Note::new(findings::COLUMNS_IGNORED, text, "save them as such if they matter"))
}

/// Names with reasons, each after a semicolon, as many as a message takes.
fn listed(refused: &[String]) -> String {
    let mut all: Vec<String> = refused.iter().take(MOST_NAMED).map(|one| visible(one)).collect();
    if refused.len() > MOST_NAMED {
        all.push(format!("and {} more", refused.len() - MOST_NAMED));
    }
    all.join("; ")
}

/// So many numbers, read piece by piece: what a header promises is not set aside before it comes.
pub(crate) fn numbers(mut from: impl Read, items: &[Item], count: usize) -> std::result::Result<Vec<f64>, String> {
    let record: usize = items.iter().map(|item| item.bytes).sum();
    let records = count / items.len();
    let mut values = Vec::new();
    let mut left = records;
    let mut piece = vec![0; (PIECE / record).max(1) * record];
    while left > 0 {
        let now = left.min(piece.len() / record);
        let bytes = &mut piece[..now * record];
        from.read_exact(bytes)
            .map_err(|_| format!("the array is cut off: expected {count} numbers, found {}", values.len()))?;
        for one in bytes.chunks_exact(record) {
            let mut at = 0;
            for item in items {
                values.push(number(&one[at..at + item.bytes], *item));
                at += item.bytes;
            }
        }
        left -= now;
    }
    Ok(values)
}

#[expect(clippy::cast_possible_truncation, reason = "as many bits as were read are reinterpreted")]
fn number(bytes: &[u8], item: Item) -> f64 {
    let fold = |value: u64, byte: &u8| value << 8 | u64::from(*byte);
    let bits = if item.big { bytes.iter().fold(0, fold) } else { bytes.iter().rev().fold(0, fold) };
    match (item.kind, item.bytes) {
        (b'f', 2) => half(bits as u16),
        (b'f', 4) => f64::from(f32::from_bits(bits as u32)),
        (b'f', _) => f64::from_bits(bits),
        (b'i', 1) => f64::from((bits as u8).cast_signed()),
        (b'i', 2) => f64::from((bits as u16).cast_signed()),
        (b'i', 4) => f64::from((bits as u32).cast_signed()),
        (b'i', _) => bits.cast_signed() as f64,
        _ => bits as f64,
    }
}

/// A number of half precision, by its bits.
pub(crate) fn half(bits: u16) -> f64 {
    half::f16::from_bits(bits).to_f64()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_precision_is_read_by_its_bits() {
        for (bits, number) in [
            (0x3c00, 1.0),
            (0xc000, -2.0),
            (0x3555, 0.333_251_953_125),
            (0x7bff, 65_504.0),
            (0x0001, 2f64.powi(-24)),
            (0x0400, 2f64.powi(-14)),
            (0xfc00, f64::NEG_INFINITY),
        ] {
            assert_eq!(half(bits), number, "{bits:#x}");
        }
        assert!(half(0x7e00).is_nan() && half(0x8000).is_sign_negative());
    }
}
