//! Whether an array has a row of numbers for each instant, and its numbers.

use std::fmt;

use hdf5_pure::{DType, Dataset, Datatype, DatatypeByteOrder, Error, FormatError, Layout};

use crate::arrays::half;
use crate::recording::MOST_NUMBERS;
use tunenet_core::observation::FEWEST_SAMPLES;

/// Most numbers of a row of one array that are columns: more are a picture or a map.
const WIDEST: u64 = 512;

/// Bits of the exponent and of the fraction of a number of half precision; two bytes may be divided in other ways.
const HALF: (u8, u8) = (5, 10);

/// An array with a row for each instant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Shape {
    pub rows: usize,
    /// Numbers in a row.
    pub width: usize,
    /// Whether it is a list of numbers, not of rows.
    pub flat: bool,
}

/// Why an array is no columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NoColumns {
    /// It holds no numbers, or no row for each of three instants.
    NoRows,
    /// It has so many numbers.
    Large(u64),
    /// Its numbers stand in another file.
    External,
}

impl fmt::Display for NoColumns {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoRows => to.write_str("no rows of numbers"),
            Self::Large(numbers) => write!(to, "{numbers} numbers, more than {MOST_NUMBERS}"),
            Self::External => to.write_str("in an external file, which is not followed"),
        }
    }
}

/// Its shape, where it has a row of numbers for each instant.
pub(super) fn shape(data: &Dataset) -> Result<Shape, NoColumns> {
    let (rows, width, flat) = match data.shape().map_err(|_| NoColumns::NoRows)?.as_slice() {
        [rows] => (*rows, 1, true),
        [rows, width @ 1..=WIDEST] => (*rows, *width, false),
        _ => return Err(NoColumns::NoRows),
    };
    if !data.dtype().is_ok_and(|kind| is_number(&kind)) || rows < FEWEST_SAMPLES as u64 {
        return Err(NoColumns::NoRows);
    }
    let numbers = rows.saturating_mul(width);
    if numbers > MOST_NUMBERS as u64 {
        return Err(NoColumns::Large(numbers));
    }
    if is_external(data) {
        return Err(NoColumns::External);
    }
    let whole = |number: u64| usize::try_from(number).map_err(|_| NoColumns::Large(numbers));
    Ok(Shape { rows: whole(rows)?, width: whole(width)?, flat })
}

/// Its numbers, row by row.
///
/// # Errors
/// Where it is broken.
pub(super) fn numbers(data: &Dataset) -> Result<Vec<f64>, Error> {
    let DType::Other(kind) = data.dtype()? else { return data.read_f64() };
    let big = matches!(*kind, Datatype::FloatingPoint { byte_order: DatatypeByteOrder::BigEndian, .. });
    let number = |two: &[u8]| {
        half(if big { u16::from_be_bytes([two[0], two[1]]) } else { u16::from_le_bytes([two[0], two[1]]) })
    };
    Ok(data.read_raw()?.chunks_exact(2).map(number).collect())
}

fn is_number(kind: &DType) -> bool {
    match kind {
        DType::F32
        | DType::F64
        | DType::I8
        | DType::I16
        | DType::I32
        | DType::I64
        | DType::U8
        | DType::U16
        | DType::U32
        | DType::U64 => true,
        DType::Other(kind) => is_half(kind),
        _ => false,
    }
}

fn is_half(kind: &Datatype) -> bool {
    match kind {
        Datatype::FloatingPoint { size: 2, byte_order, layout } => {
            *byte_order != DatatypeByteOrder::Vax && (layout.exponent_size, layout.mantissa_size) == HALF
        }
        _ => false,
    }
}

/// Whether its numbers stand in other files: such an array looks as one without numbers, and refuses to be read.
fn is_external(data: &Dataset) -> bool {
    let empty = matches!(data.layout(), Ok(Layout::Contiguous { address: None, .. }));
    empty && matches!(data.read_raw_rows(0, 1), Err(Error::Format(FormatError::UnsupportedExternalStorage)))
}
