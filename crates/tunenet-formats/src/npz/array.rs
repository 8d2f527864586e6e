//! One array: its header, and its numbers.

use std::io::Read;

use crate::arrays::{Array, Item, WIDEST, numbers};
use crate::recording::MOST_NUMBERS;

/// Longest header, in bytes.
const LONGEST_HEADER: usize = 1 << 16;

/// Reads an array.
///
/// # Errors
/// What is wrong with it.
pub(super) fn read(mut from: impl Read) -> Result<Array, String> {
    let header = header(&mut from)?;
    let (items, names) = items(value(&header, "descr").ok_or("expected `descr` in the header, found none")?)?;
    let fortran = value(&header, "fortran_order").is_some_and(|text| text.starts_with("True"));
    let shape = shape(value(&header, "shape").ok_or("expected `shape` in the header, found none")?)?;
    let (rows, columns, flat) = match shape.as_slice() {
        [rows] => (*rows, 1, true),
        [rows, columns] => (*rows, *columns, false),
        other => return Err(format!("expected a list or rows of numbers, found {} dimensions", other.len())),
    };
    let width = columns.saturating_mul(items.len());
    let count = rows.checked_mul(width).filter(|count| *count <= MOST_NUMBERS && width <= WIDEST);
    let count =
        count.ok_or_else(|| format!("expected at most {MOST_NUMBERS} numbers in {WIDEST} columns, found {shape:?}"))?;
    if width == 0 {
        return Err(format!("expected at least one column, found the shape {shape:?}"));
    }
    if !names.is_empty() && !flat {
        return Err("expected a list of records, found rows of them".into());
    }
    let values = numbers(from, &items, count)?;
    let values = if fortran && !flat {
        (0..rows)
            .flat_map(|row| (0..columns).map(move |column| (row, column)))
            .map(|(r, c)| values[c * rows + r])
            .collect()
    } else {
        values
    };
    Ok(Array { rows, width, flat, names, values })
}

/// The header as text.
fn header(from: &mut impl Read) -> Result<String, String> {
    let cut = |_| "the array is cut off".to_owned();
    let mut start = [0; 8];
    from.read_exact(&mut start).map_err(cut)?;
    if !start.starts_with(super::MARK) {
        return Err("expected the mark of a NumPy array, found other bytes".into());
    }
    let mut length = [0; 4];
    let size = if start[6] == 1 { 2 } else { 4 };
    from.read_exact(&mut length[..size]).map_err(cut)?;
    let length = usize::try_from(u32::from_le_bytes(length)).unwrap_or(usize::MAX);
    if length > LONGEST_HEADER {
        return Err(format!("expected a header of at most {LONGEST_HEADER} bytes, found {length}"));
    }
    let mut text = vec![0; length];
    from.read_exact(&mut text).map_err(cut)?;
    Ok(String::from_utf8_lossy(&text).into_owned())
}

/// What follows a key of the header.
fn value<'a>(header: &'a str, key: &str) -> Option<&'a str> {
    let quoted = [format!("'{key}'"), format!("\"{key}\"")];
    let at = quoted.iter().find_map(|key| header.find(key.as_str()).map(|at| at + key.len()))?;
    Some(header[at..].trim_start().strip_prefix(':')?.trim_start())
}

/// The numbers in brackets.
fn shape(text: &str) -> Result<Vec<usize>, String> {
    let inside = text.strip_prefix('(').and_then(|rest| rest.split(')').next());
    let parts = inside.ok_or("expected a shape in brackets")?.split(',').map(str::trim).filter(|part| !part.is_empty());
    parts
        .map(|part| part.parse::<usize>().map_err(|_| format!("expected whole numbers in the shape, found `{part}`")))
        .collect()
}

/// How numbers are written: `'<f8'`, or records `[('t_s', '<f8'), ('z_m', '<f4')]` with the names of their columns.
fn items(text: &str) -> Result<(Vec<Item>, Vec<String>), String> {
    let mark = text.chars().next().unwrap_or(' ');
    if matches!(mark, '\'' | '"') {
        return Ok((vec![item(text[1..].split(mark).next().unwrap_or_default())?], Vec::new()));
    }
    let inside = text.strip_prefix('[').and_then(|rest| rest.split(']').next()).ok_or("expected a type in quotes")?;
    let mut parts = inside.split(['\'', '"']).skip(1).step_by(2);
    let (mut items, mut names) = (Vec::new(), Vec::new());
    while let (Some(name), Some(kind)) = (parts.next(), parts.next()) {
        names.push(name.to_owned());
        items.push(item(kind)?);
    }
    if items.is_empty() || inside.matches('(').count() != items.len() {
        return Err("expected records of single numbers".into());
    }
    Ok((items, names))
}

fn item(text: &str) -> Result<Item, String> {
    let refuse = || format!("expected numbers, found the type `{text}`");
    let order = text.chars().next().filter(|order| "<>|=".contains(*order));
    let rest = &text[order.map_or(0, char::len_utf8)..];
    let kind = *rest.as_bytes().first().ok_or_else(refuse)?;
    // What is no letter of ASCII has no first byte of its own.
    let bytes = rest.get(1..).and_then(|digits| digits.parse::<usize>().ok()).ok_or_else(refuse)?;
    let known = match kind {
        b'f' => matches!(bytes, 2 | 4 | 8),
        b'i' | b'u' => matches!(bytes, 1 | 2 | 4 | 8),
        b'b' => bytes == 1,
        _ => false,
    };
    if known { Ok(Item { kind, bytes, big: order == Some('>') }) } else { Err(refuse()) }
}
