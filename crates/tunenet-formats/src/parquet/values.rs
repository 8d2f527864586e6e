//! The values of one column, distinguished by their levels.

use parquet::column::reader::ColumnReaderImpl;
use parquet::data_type::DataType;
use parquet::errors::ParquetError;

use crate::recording::MOST_NUMBERS;

/// Rows that are read at a time.
const BATCH: usize = 8_192;

/// The greatest levels of a column: 0 where nothing is optional, and where nothing is repeated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Levels {
    pub definition: i16,
    pub repetition: i16,
    /// Whether an element may be missing: then one level below it is not an empty row.
    pub optional: bool,
}

/// The numbers of a column: `width` in each of its rows, row by row. One that is missing is not a number.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Numbers {
    pub values: Vec<f64>,
    pub width: usize,
    pub rows: usize,
}

/// Why a column is not read.
#[derive(Debug)]
pub(super) enum Failure {
    /// The crate refuses it.
    Broken(ParquetError),
    /// It has more numbers than are read.
    TooMany(String),
    /// Its rows have lists of different lengths.
    Uneven(String),
}

impl From<ParquetError> for Failure {
    fn from(error: ParquetError) -> Self {
        Self::Broken(error)
    }
}

fn too_many() -> Failure {
    Failure::TooMany(format!("expected at most {MOST_NUMBERS} numbers, found more"))
}

/// The values of the rows of a column after so many that are `skipped`, as far as there are so many.
pub(super) fn read<T: DataType>(
    reader: &mut ColumnReaderImpl<T>,
    levels: Levels,
    (skipped, rows): (usize, usize),
    number: impl Fn(&T::T) -> f64,
) -> Result<Numbers, Failure> {
    let mut found = Ragged::default();
    if skipped > 0 && reader.skip_records(skipped)? < skipped {
        return found.even();
    }
    let mut left = rows;
    loop {
        let (mut definition, mut repetition, mut values) = (Vec::new(), Vec::new(), Vec::new());
        let (records, _, _) = reader.read_records(
            BATCH.min(left),
            (levels.definition > 0).then_some(&mut definition),
            (levels.repetition > 0).then_some(&mut repetition),
            &mut values,
        )?;
        if records == 0 {
            return found.even();
        }
        left = left.saturating_sub(records);
        found.add(levels, &definition, &repetition, values.iter().map(&number))?;
        if found.values.len() > MOST_NUMBERS || found.starts.len() > MOST_NUMBERS {
            return Err(too_many());
        }
    }
}

/// Rows that may be of different lengths.
#[derive(Default)]
struct Ragged {
    values: Vec<f64>,
    /// Where each row starts.
    starts: Vec<usize>,
}

impl Ragged {
    fn add(
        &mut self,
        levels: Levels,
        definition: &[i16],
        repetition: &[i16],
        mut values: impl ExactSizeIterator<Item = f64>,
    ) -> Result<(), ParquetError> {
        let short = || ParquetError::General("fewer values than its levels announce".into());
        let count = if levels.definition > 0 { definition.len() } else { values.len() };
        if levels.repetition > 0 && repetition.len() != count {
            return Err(short());
        }
        for at in 0..count {
            let is_new = levels.repetition == 0 || repetition[at] == 0;
            if is_new {
                self.starts.push(self.values.len());
            }
            let level = if levels.definition > 0 { definition[at] } else { levels.definition };
            if level == levels.definition {
                self.values.push(values.next().ok_or_else(short)?);
            } else if levels.repetition == 0 || levels.optional && level + 1 == levels.definition {
                self.values.push(f64::NAN);
            }
        }
        Ok(())
    }

    /// The rows where all are of one length; an empty one is missing.
    fn even(self) -> Result<Numbers, Failure> {
        let rows = self.starts.len();
        let end = |row: usize| self.starts.get(row + 1).copied().unwrap_or(self.values.len());
        let width = (0..rows).map(|row| end(row) - self.starts[row]).max().unwrap_or(0);
        if self.values.len() == rows * width {
            return Ok(Numbers { values: self.values, width, rows });
        }
        if rows.saturating_mul(width) > MOST_NUMBERS {
            return Err(too_many());
        }
        let mut values = Vec::with_capacity(rows * width);
        for row in 0..rows {
            match end(row) - self.starts[row] {
                0 => values.extend(std::iter::repeat_n(f64::NAN, width)),
                found if found == width => values.extend_from_slice(&self.values[self.starts[row]..end(row)]),
                found => {
                    let why = format!("expected {width} numbers in each row, found {found} in row {}", row + 1);
                    return Err(Failure::Uneven(why));
                }
            }
        }
        Ok(Numbers { values, width, rows })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ragged(definition: &[i16], repetition: &[i16], values: &[f64]) -> Result<Numbers, Failure> {
        let mut found = Ragged::default();
        found.add(
            Levels { definition: 3, repetition: 1, optional: true },
            definition,
            repetition,
            values.iter().copied(),
        )?;
        found.even()
    }

    #[test]
    fn rows_are_distinguished_by_their_levels() {
        let two = ragged(&[3, 3, 3, 3], &[0, 1, 0, 1], &[1.0, 2.0, 3.0, 4.0]).unwrap();
        assert_eq!((two.width, two.rows, two.values), (2, 2, vec![1.0, 2.0, 3.0, 4.0]));
        // An empty row, and an element that is missing.
        let gaps = ragged(&[1, 3, 2], &[0, 0, 1], &[5.0]).unwrap();
        assert_eq!((gaps.width, gaps.rows), (2, 2));
        assert!(gaps.values[0].is_nan() && gaps.values[1].is_nan() && gaps.values[3].is_nan());
        assert_eq!(gaps.values[2], 5.0);
        let uneven = ragged(&[3, 3, 3], &[0, 1, 0], &[1.0, 2.0, 3.0]);
        assert!(matches!(uneven, Err(Failure::Uneven(why)) if why.ends_with("found 1 in row 2")));
        assert!(ragged(&[3, 3], &[0, 1], &[1.0]).is_err());
    }
}
