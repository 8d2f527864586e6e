//! Times that are written as dates: they are no numbers, and what to do about it.

use std::path::Path;

use super::lines::{Lines, cells, separator};
use crate::Result;

/// What to type.
pub(crate) const HINT: &str = "write times as seconds, for example with pandas: `t = pandas.to_datetime(table[\"time\"])`, `table[\"t_s\"] = (t - t[0]).dt.total_seconds()`";

/// Whether a cell begins with a date: `2024-01-31T12:00:00`.
///
/// Source: ISO 8601, calendar date in the extended format.
pub(crate) fn is_date(cell: &str) -> bool {
    let form = |(at, byte): (usize, u8)| if matches!(at, 4 | 7) { byte == b'-' } else { byte.is_ascii_digit() };
    cell.len() >= 10 && cell.bytes().take(10).enumerate().all(form)
}

/// What to do where the first row of a table has a date.
///
/// # Errors
/// As [`Lines::next`].
pub(crate) fn remedy(path: &Path) -> Result<Option<String>> {
    let mut lines = Lines::open(path)?;
    let (Some(header), Some(first)) = (lines.next()?, lines.next()?) else { return Ok(None) };
    let dated = cells(&first.text, separator(&header.text)).iter().any(|cell| is_date(cell.text));
    Ok(dated.then(|| HINT.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{error_text, file};
    use crate::{Contents, ReadOptions, contents, read};

    #[test]
    fn a_date_is_known_by_its_form() {
        assert!(is_date("2024-01-31T12:00:00") && is_date("2024-01-31 12:00") && is_date("2024-01-31"));
        assert!(!is_date("20240131") && !is_date("1.5") && !is_date("2024-01-3") && !is_date("-024-01-31"));
    }

    #[test]
    fn a_table_with_dates_says_how_to_write_seconds() {
        let rows = "2024-01-01T00:00:00.0,0.0\n2024-01-01T00:00:00.1,0.1\n2024-01-01T00:00:00.2,0.2\n";
        let (_folder, path) = file("a.csv", format!("time,j_rad\n{rows}"));
        let Contents::Table(table) = contents(&path).unwrap() else { panic!("a table") };
        assert_eq!((table.described, table.remedy.as_str()), (None, HINT));
        let columns = vec![("t_s".into(), "time".into()), ("z_m".into(), "j_rad".into())];
        let refused = read(&path, &ReadOptions { columns, ..ReadOptions::default() }).unwrap_err();
        assert!(error_text(&refused).1.starts_with(HINT), "{refused}");
    }
}
