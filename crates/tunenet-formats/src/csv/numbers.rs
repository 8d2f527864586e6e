//! All numbers of a text table, for a look at what its columns may be.

use std::path::Path;

use super::lines::{Lines, cells, named, number, separator};
use crate::Result;
use crate::sheet::Sheet;

/// Most numbers that are looked at: a hundred columns over a minute at 600 Hz.
const MOST: usize = 4_000_000;

/// The first rows of a text table; a cell that is no number is missing.
///
/// # Errors
/// [`Error::Io`](crate::Error::Io) where the system refuses the file, [`Error::File`](crate::Error::File) where it is no text.
pub(crate) fn sheet(path: &Path) -> Result<Sheet> {
    let mut lines = Lines::open(path)?;
    let Some(first) = lines.next()? else { return Ok(Sheet::default()) };
    let separator = separator(&first.text);
    let header = cells(&first.text, separator);
    let named = named(&header, separator);
    let name = |text: &str| if named { text.to_owned() } else { String::new() };
    let names: Vec<String> = header.iter().map(|cell| name(cell.text)).collect();
    let mut values = Vec::new();
    let mut next = if named { lines.next()? } else { Some(first.clone()) };
    while let Some(line) = next.filter(|_| values.len() + names.len() <= MOST) {
        let row = cells(&line.text, separator);
        let of = |column: usize| row.get(column).and_then(|cell| number(cell.text, separator).ok());
        values.extend((0..names.len()).map(|column| of(column).unwrap_or(f64::NAN)));
        next = lines.next()?;
    }
    Ok(Sheet { names, values, unnamed: !named, ..Sheet::default() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::file;

    #[test]
    fn what_is_no_number_is_missing() {
        let (_folder, path) = file("a.csv", "time;q;note\n0;1,5;a\n0,1;;b\n");
        let found = sheet(&path).unwrap();
        assert_eq!(found.names, ["time", "q", "note"]);
        assert_eq!(found.column(0).collect::<Vec<_>>(), [0.0, 0.1]);
        assert_eq!(
            found.values.iter().map(|v| v.is_nan()).collect::<Vec<_>>(),
            [false, false, true, false, true, true]
        );
        let (_folder, path) = file("a.csv", "0,1\n1,2\n");
        let found = sheet(&path).unwrap();
        assert_eq!((found.unnamed, found.rows()), (true, 2));
    }
}
