//! Arrays of NumPy: one in a `.npy` file, several by their names in an `.npz` file.
//!
//! Source: the NumPy file format (NEP 1): a mark, a version, a header in the form of a Python table, then the numbers.

mod array;

use std::io::{BufReader, Read as _, Seek as _, SeekFrom};
use std::path::Path;

use flate2::read::DeflateDecoder;
use zip::CompressionMethod;

use crate::arrays::{Array, sheet};
use crate::recording::MOST_NUMBERS;
use crate::sheet::Sheet;
use crate::source::open;
use crate::{Action, Error, Result};

/// The mark at the start of an array.
const MARK: &[u8] = b"\x93NUMPY";

/// Most arrays of a file.
const MOST_ARRAYS: usize = 10_000;

/// How `numpy.savez_compressed` packs, by its number: the crate is built without it.
#[expect(deprecated, reason = "the crate has no other name for a method that it does not unpack itself")]
const DEFLATED: CompressionMethod = CompressionMethod::Unsupported(8);

/// What is tried where a file is broken.
const AGAIN: &str = "copy the file again, or save it again with `numpy.savez`";

/// The columns of the array in a `.npy` file; they have no names.
///
/// # Errors
/// [`Error::File`] where it is broken, or no table of numbers.
pub(crate) fn single(path: &Path) -> Result<Sheet> {
    let array = array::read(BufReader::new(open(path)?)).map_err(|why| Error::file(path, why, AGAIN))?;
    if array.names.is_empty() {
        let names = vec![String::new(); array.width];
        return Ok(Sheet { names, values: array.values, unnamed: true, ..Sheet::default() });
    }
    Ok(Sheet { names: array.names, values: array.values, ..Sheet::default() })
}

/// The columns of the arrays in an `.npz` file that have as many rows as most of them: `NAME`, or `NAME.0` … of an array of rows.
///
/// # Errors
/// [`Error::File`] where it is broken, or holds no table of numbers.
pub(crate) fn several(path: &Path) -> Result<Sheet> {
    let broken = |why: String| Error::file(path, format!("the archive is cut off or broken: {why}"), AGAIN);
    let mut archive = zip::ZipArchive::new(BufReader::new(open(path)?)).map_err(|e| broken(e.to_string()))?;
    if archive.len() > MOST_ARRAYS {
        return Err(broken(format!("expected at most {MOST_ARRAYS} arrays, found {}", archive.len())));
    }
    if let Some(listed) = listed(path)?.filter(|listed| *listed > archive.len()) {
        let message = format!("expected arrays of different names, found {listed} arrays of {} names", archive.len());
        return Err(Error::file(path, message, "save every array under a name of its own"));
    }
    let (mut arrays, mut refused): (Vec<(String, Array)>, Vec<String>) = (Vec::new(), Vec::new());
    let mut total = 0;
    for number in 0..archive.len() {
        let entry = archive.by_index_raw(number).map_err(|e| broken(e.to_string()))?;
        let Some(name) = entry.name().strip_suffix(".npy").map(str::to_owned) else { continue };
        // A number takes eight bytes at most, so that no more is unpacked than may be read.
        let most = 16 * MOST_NUMBERS as u64;
        let read = match entry.compression() {
            CompressionMethod::Stored => array::read(entry.take(most)),
            DEFLATED => array::read(DeflateDecoder::new(entry).take(most)),
            other => Err(format!("expected an array stored or deflated, found {other}")),
        };
        match read {
            Ok(array) => {
                total += array.values.len();
                arrays.push((name, array));
            }
            Err(why) => refused.push(format!("`{name}`: {why}")),
        }
        if total > MOST_NUMBERS {
            return Err(broken(format!("expected at most {MOST_NUMBERS} numbers, found more")));
        }
    }
    sheet(path, arrays, refused)
}

/// How many members the end of an archive lists: the crate keeps one of each name. `None` where no end says it.
///
/// Source: APPNOTE.TXT of ZIP, "end of central directory record".
fn listed(path: &Path) -> Result<Option<usize>> {
    const END: &[u8] = b"PK\x05\x06";
    const LONGEST_END: u64 = 22 + u16::MAX as u64;
    let failed = |e| Error::io(path, Action::Reading, e);
    let mut file = open(path)?;
    let length = file.seek(SeekFrom::End(0)).map_err(failed)?;
    file.seek(SeekFrom::Start(length.saturating_sub(LONGEST_END))).map_err(failed)?;
    let mut end = Vec::new();
    file.read_to_end(&mut end).map_err(failed)?;
    let at = end.windows(END.len()).rposition(|bytes| bytes == END);
    let count = at.and_then(|at| end.get(at + 10..at + 12)).map(|count| u16::from_le_bytes([count[0], count[1]]));
    // A larger archive has its count in another place.
    Ok(count.filter(|count| *count != u16::MAX).map(usize::from))
}

#[cfg(test)]
mod tests;
