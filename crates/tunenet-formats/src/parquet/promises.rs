//! Lists in a file's descriptions that promise more elements than the file has bytes: the crate `parquet` counts through elements
//! without bytes, and a few bytes can promise thousands of millions of them.
//!
//! Source: the compact protocol of Apache Thrift, in which the descriptions of Parquet are written.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};

/// Deepest nesting that is followed, as the crate does.
const DEEPEST: u8 = 64;
/// So many bytes of a page are looked at first for its header, and at most.
const HEADER: u64 = 1 << 12;
const LARGEST_HEADER: u64 = 1 << 20;
/// Bytes at the end of a file: the length of its description, and the mark.
const TAIL: u64 = 8;
/// The field of a page's header that states how many bytes follow it.
const COMPRESSED_SIZE: i16 = 3;

/// Why a description is not walked to its end.
#[derive(Debug, PartialEq)]
enum Stop {
    /// It promises this many elements.
    Promises(u64),
    /// It is cut off or no description; whoever reads it says so.
    Broken,
}

/// How many elements a list in the description at the end of `file` promises, where that is more than can be there.
pub(super) fn footer_promises(file: &mut File) -> std::io::Result<Option<u64>> {
    let end = file.seek(SeekFrom::End(0))?;
    let Some(tail) = end.checked_sub(TAIL) else { return Ok(None) };
    let mut length = [0; 4];
    file.seek(SeekFrom::Start(tail))?;
    file.read_exact(&mut length)?;
    let Some(begin) = tail.checked_sub(u64::from(u32::from_le_bytes(length))) else { return Ok(None) };
    let bytes = part(file, begin, tail - begin)?;
    Ok(match Walk::new(&bytes).description() {
        Err(Stop::Promises(count)) => Some(count),
        _ => None,
    })
}

/// The same of the headers of the pages from `begin` on, `length` bytes in all.
pub(super) fn pages_promise(file: &mut File, begin: u64, length: u64) -> std::io::Result<Option<u64>> {
    let end = begin.saturating_add(length);
    let mut at = begin;
    while at < end {
        let mut most = HEADER;
        let (header, size) = loop {
            let bytes = part(file, at, most.min(end - at))?;
            let mut walk = Walk::new(&bytes);
            match walk.description() {
                Ok(()) => break (walk.at as u64, walk.compressed_size),
                Err(Stop::Promises(count)) => return Ok(Some(count)),
                Err(Stop::Broken) if bytes.len() as u64 == most && most < LARGEST_HEADER => most = LARGEST_HEADER,
                Err(Stop::Broken) => return Ok(None),
            }
        };
        let Some(size) = size.and_then(|size| u64::try_from(size).ok()) else { return Ok(None) };
        at = at.saturating_add(header).saturating_add(size);
    }
    Ok(None)
}

fn part(file: &mut File, begin: u64, length: u64) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    file.seek(SeekFrom::Start(begin))?;
    file.take(length).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// A walk through a description, field by field.
struct Walk<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Elements that may still come: each has a byte at least, but for those that are true or false.
    left: u64,
    compressed_size: Option<i64>,
}

impl<'a> Walk<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, left: bytes.len() as u64, compressed_size: None }
    }

    fn byte(&mut self) -> Result<u8, Stop> {
        let byte = *self.bytes.get(self.at).ok_or(Stop::Broken)?;
        self.at += 1;
        Ok(byte)
    }

    fn skip(&mut self, count: u64) -> Result<(), Stop> {
        let left = self.bytes.len() - self.at;
        let count = usize::try_from(count).ok().filter(|count| *count <= left).ok_or(Stop::Broken)?;
        self.at += count;
        Ok(())
    }

    fn varint(&mut self) -> Result<u64, Stop> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 0x7f) << shift;
            if byte & 0x80 == 0 {
                return Ok(value);
            }
        }
        Err(Stop::Broken)
    }

    fn elements(&mut self, count: u64) -> Result<(), Stop> {
        self.left = self.left.checked_sub(count).ok_or(Stop::Promises(count))?;
        Ok(())
    }

    /// The whole description, a struct.
    fn description(&mut self) -> Result<(), Stop> {
        let mut last = 0i16;
        loop {
            let head = self.byte()?;
            if head == 0 {
                return Ok(());
            }
            last = match head >> 4 {
                0 => zigzag(self.varint()?).try_into().map_err(|_| Stop::Broken)?,
                step => last.checked_add(i16::from(step)).ok_or(Stop::Broken)?,
            };
            let begin = self.at;
            self.value(head & 0xf, DEEPEST)?;
            if last == COMPRESSED_SIZE && head & 0xf == 5 {
                let after = std::mem::replace(&mut self.at, begin);
                self.compressed_size = Some(zigzag(self.varint()?));
                self.at = after;
            }
        }
    }

    fn value(&mut self, kind: u8, depth: u8) -> Result<(), Stop> {
        let depth = depth.checked_sub(1).ok_or(Stop::Broken)?;
        match kind {
            1 | 2 => Ok(()),
            3 => self.skip(1),
            4..=6 => self.varint().map(|_| ()),
            7 => self.skip(8),
            8 => {
                let length = self.varint()?;
                self.skip(length)
            }
            9 | 10 => {
                let head = self.byte()?;
                let count = if head >> 4 == 15 { self.varint()? } else { u64::from(head >> 4) };
                self.elements(count)?;
                (0..count).try_for_each(|_| self.value(head & 0xf, depth))
            }
            11 => {
                let count = self.varint()?;
                self.elements(count)?;
                let kinds = if count > 0 { self.byte()? } else { 0 };
                (0..count).try_for_each(|_| self.value(kinds >> 4, depth).and_then(|()| self.value(kinds & 0xf, depth)))
            }
            12 => loop {
                let head = self.byte()?;
                if head == 0 {
                    return Ok(());
                }
                if head >> 4 == 0 {
                    self.varint()?;
                }
                self.value(head & 0xf, depth)?;
            },
            13 => self.skip(16),
            _ => Err(Stop::Broken),
        }
    }
}

fn zigzag(value: u64) -> i64 {
    (value >> 1).cast_signed() ^ -(value & 1).cast_signed()
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    #[test]
    fn a_list_that_promises_more_than_there_is_stops_the_walk() {
        // Field 1, a list of 2³¹ − 1 truths; then the same in a struct in field 2.
        let list = [0x19, 0xf1, 0xff, 0xff, 0xff, 0xff, 0x07, 0];
        assert_eq!(Walk::new(&list).description(), Err(Stop::Promises((1 << 31) - 1)));
        let inner = [&[0x2c][..], &list, &[0]].concat();
        assert_eq!(Walk::new(&inner).description(), Err(Stop::Promises((1 << 31) - 1)));
        // Three numbers, a text and a map of two.
        let sound = [0x19, 0x35, 2, 4, 6, 0x18, 1, b'a', 0x1b, 2, 0x55, 1, 2, 3, 4, 0];
        let mut walk = Walk::new(&sound);
        assert_eq!((walk.description(), walk.at), (Ok(()), sound.len()));
        assert_eq!(Walk::new(&sound[..4]).description(), Err(Stop::Broken));
    }

    #[test]
    fn pages_are_walked_by_what_their_headers_state() {
        let page = |size: u8, more: &[u8]| {
            // Kind 0, 5 bytes whole, `size` compressed, then `more`.
            let head = [&[0x15, 0, 0x15, 10, 0x15, size << 1][..], more, &[0]].concat();
            [head, vec![0xee; usize::from(size)]].concat()
        };
        let promise = [0x19, 0xf1, 0xff, 0xff, 0xff, 0xff, 0x07];
        let found = |pages: &[Vec<u8>]| {
            let mut file = tempfile::tempfile().unwrap();
            file.write_all(&pages.concat()).unwrap();
            let length = file.stream_position().unwrap();
            pages_promise(&mut file, 0, length).unwrap()
        };
        assert_eq!(found(&[page(5, &[]), page(3, &[]), page(60, &[])]), None);
        assert_eq!(found(&[page(5, &[]), page(3, &promise)]), Some((1 << 31) - 1));
        assert_eq!(found(&[vec![0xff; 40]]), None);
    }
}
