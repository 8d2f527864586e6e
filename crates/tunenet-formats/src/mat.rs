//! Variables of a MATLAB file of versions 5 to 7.
//!
//! Source: `MathWorks`, MAT-File Format, Level 5: a header of 128 bytes, then elements, each with its type, its length and its data, filled up
//! to a multiple of eight bytes. A variable is an element of elements (flags, dimensions, name, numbers by columns), compressed or not.

use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use flate2::read::ZlibDecoder;

use crate::arrays::{Array, Item, WIDEST, numbers, sheet};
use crate::recording::MOST_NUMBERS;
use crate::sheet::Sheet;
use crate::source::open;
use crate::{Action, Error, Result};

/// Where the byte order stands in the header.
const ORDER_AT: usize = 126;
const HEADER: usize = 128;

/// Most variables of a file, and the longest name of one, in bytes.
const MOST_VARIABLES: usize = 10_000;
const LONGEST_NAME: usize = 4_096;

/// Types of elements.
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;

/// The bit of the flags that marks complex numbers.
const COMPLEX: u32 = 0x800;

/// What is tried where a file is broken.
const AGAIN: &str = "copy the file again, or save it again with `save('log.mat', '-v7')`";

/// The columns of the variables that have as many rows as most of them.
///
/// # Errors
/// [`Error::File`] where it is broken, or holds no table of numbers.
pub(crate) fn table(path: &Path) -> Result<Sheet> {
    let broken = |why: &str| Error::file(path, format!("the MATLAB file is cut off or broken: {why}"), AGAIN);
    let reading = |e| Error::io(path, Action::Reading, e);
    let mut file = BufReader::new(open(path)?);
    let mut header = [0; HEADER];
    file.read_exact(&mut header).map_err(|_| broken("it ends within its header"))?;
    let big = match &header[ORDER_AT..] {
        b"IM" => false,
        b"MI" => true,
        _ => return Err(broken("its header states no byte order")),
    };
    let (mut arrays, mut refused) = (Vec::new(), Vec::new());
    let end = file.get_ref().metadata().map_err(reading)?.len();
    let (mut at, mut total) = (HEADER as u64, 0);
    while let Some(tag) = Tag::next(&mut file, big).map_err(broken)? {
        if u64::from(tag.bytes) > end.saturating_sub(at + 8) {
            return Err(broken("it ends within a variable"));
        }
        let data = (&mut file).take(u64::from(tag.bytes));
        // Eight bytes a number, and as much again for names and marks: no more is unpacked than may be read.
        let most = 16 * MOST_NUMBERS as u64;
        let (name, found) = match tag.kind {
            MATRIX => variable(data, big),
            COMPRESSED => unpacked(ZlibDecoder::new(data).take(most), big),
            _ => Variable::default(),
        };
        match found {
            Some(Ok(array)) => {
                total += array.values.len();
                arrays.push((name, array));
            }
            Some(Err(why)) => refused.push(format!("`{name}`: {why}")),
            None => {}
        }
        if total > MOST_NUMBERS || arrays.len() + refused.len() > MOST_VARIABLES {
            let expected = format!("at most {MOST_NUMBERS} numbers in {MOST_VARIABLES} variables");
            return Err(Error::file(path, format!("expected {expected}, found more"), "save fewer of them"));
        }
        at += 8 + u64::from(tag.bytes);
        file.seek(SeekFrom::Start(at)).map_err(reading)?;
    }
    sheet(path, arrays, refused)
}

/// The name of a variable, and its numbers or why it has none; `None` where an element is no variable.
type Variable = (String, Option<std::result::Result<Array, String>>);

/// The variable in an element that was compressed.
fn unpacked(mut data: impl Read, big: bool) -> Variable {
    match Tag::next(&mut data, big) {
        Ok(Some(tag)) if tag.kind == MATRIX => variable(data, big),
        Ok(_) => Variable::default(),
        Err(why) => (String::new(), Some(Err(why.to_owned()))),
    }
}

/// The variable whose elements these are.
fn variable(mut data: impl Read, big: bool) -> Variable {
    let mut named = String::new();
    let found = head(&mut data, big, &mut named).and_then(|(rows, columns)| {
        let element = Element::open(&mut data, big)?;
        let item = item(element.kind, big).ok_or("its numbers have no known type")?;
        let count = rows * columns;
        if element.bytes != count * item.bytes {
            return Err(format!("expected {count} numbers, found {} bytes", element.bytes));
        }
        let by_columns = numbers(element.data.chain(&mut data), &[item], count)?;
        let values = (0..rows).flat_map(|row| (0..columns).map(move |column| column * rows + row));
        let flat = columns == 1 || rows == 1;
        let (rows, width) = if flat { (count, 1) } else { (rows, columns) };
        Ok(Array { rows, width, flat, names: Vec::new(), values: values.map(|at| by_columns[at]).collect() })
    });
    (named, Some(found))
}

/// Reads what comes before the numbers of a variable, and leaves its name in `named`; rows and columns.
fn head(data: &mut impl Read, big: bool, named: &mut String) -> std::result::Result<(usize, usize), String> {
    let flags = Element::open(data, big)?.whole(data, 8)?;
    let flags = word(&flags, big).ok_or("it has no flags")?;
    let dimensions = Element::open(data, big)?.whole(data, 4 * 64)?;
    let dimensions: Vec<usize> =
        dimensions.chunks(4).filter_map(|bytes| word(bytes, big)).map(|size| size as usize).collect();
    let name = Element::open(data, big)?.whole(data, LONGEST_NAME)?;
    *named = String::from_utf8_lossy(&name).into_owned();
    let kind = match flags & 0xff {
        1 => "cells",
        2 => "a structure",
        3 => "an object",
        4 => "a text",
        5 => "a sparse matrix",
        6..=15 if flags & COMPLEX != 0 => "complex numbers",
        6..=15 => "",
        _ => "a type that is not known",
    };
    if !kind.is_empty() {
        return Err(format!("expected numbers, found {kind}"));
    }
    let &[rows, columns] = dimensions.as_slice() else {
        return Err(format!("expected a list or rows of numbers, found {} dimensions", dimensions.len()));
    };
    let (width, count) = (if rows == 1 { 1 } else { columns }, rows.checked_mul(columns));
    if width > WIDEST || count.is_none_or(|count| count > MOST_NUMBERS) {
        return Err(format!(
            "expected at most {MOST_NUMBERS} numbers in {WIDEST} columns, found {rows} times {columns}"
        ));
    }
    Ok((rows, columns))
}

/// How numbers of this type of element are written.
fn item(kind: u32, big: bool) -> Option<Item> {
    let (kind, bytes) = match kind {
        1 => (b'i', 1),
        2 => (b'u', 1),
        3 => (b'i', 2),
        4 => (b'u', 2),
        5 => (b'i', 4),
        6 => (b'u', 4),
        7 => (b'f', 4),
        9 => (b'f', 8),
        12 => (b'i', 8),
        13 => (b'u', 8),
        _ => return None,
    };
    Some(Item { kind, bytes, big })
}

/// Four bytes as a number.
fn word(bytes: &[u8], big: bool) -> Option<u32> {
    let four: [u8; 4] = bytes.get(..4)?.try_into().ok()?;
    Some(if big { u32::from_be_bytes(four) } else { u32::from_le_bytes(four) })
}

/// What stands before an element.
struct Tag {
    kind: u32,
    bytes: u32,
}

impl Tag {
    /// The next one; `None` at the end.
    fn next(from: &mut impl Read, big: bool) -> std::result::Result<Option<Self>, &'static str> {
        let mut bytes = Vec::new();
        from.take(8).read_to_end(&mut bytes).map_err(|_| "it cannot be unpacked")?;
        match (word(&bytes, big), word(bytes.get(4..).unwrap_or_default(), big)) {
            (Some(kind), Some(bytes)) => Ok(Some(Self { kind, bytes })),
            _ if bytes.is_empty() => Ok(None),
            _ => Err("it ends within the mark of a variable"),
        }
    }
}

/// An element within a variable: short ones stand in their mark.
struct Element {
    kind: u32,
    bytes: usize,
    /// What was read of its data.
    data: std::io::Cursor<Vec<u8>>,
}

impl Element {
    fn open(from: &mut impl Read, big: bool) -> std::result::Result<Self, String> {
        let mut mark = [0; 8];
        from.read_exact(&mut mark).map_err(|_| "it is cut off")?;
        let (first, second) = (word(&mark, big).unwrap_or(0), word(&mark[4..], big).unwrap_or(0));
        let short = (first >> 16) as usize;
        if short > 0 {
            let data = mark[4..].get(..short).ok_or("one of its marks is broken")?.to_vec();
            return Ok(Self { kind: first & 0xffff, bytes: short, data: std::io::Cursor::new(data) });
        }
        Ok(Self { kind: first, bytes: second as usize, data: std::io::Cursor::default() })
    }

    /// All of its data, and what fills it up, where it has at most so many bytes.
    fn whole(self, from: &mut impl Read, most: usize) -> std::result::Result<Vec<u8>, String> {
        if !self.data.get_ref().is_empty() {
            return Ok(self.data.into_inner());
        }
        if self.bytes > most {
            return Err(format!("expected at most {most} bytes before its numbers, found {}", self.bytes));
        }
        let mut data = vec![0; self.bytes.next_multiple_of(8)];
        from.read_exact(&mut data).map_err(|_| "it is cut off")?;
        data.truncate(self.bytes);
        Ok(data)
    }
}

#[cfg(test)]
mod tests;
