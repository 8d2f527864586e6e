//! A log as far as its chunks hold whole records.
//!
//! The reader of crate `mcap` 0.26 takes the length of every record off what is left of its chunk without looking whether so
//! much is left: in a chunk that is not compressed, one record too long is a panic where overflow is checked, and otherwise
//! swallows every chunk that follows. So the bytes pass by here first.

use std::io::{BufReader, Read, Result};

use byteorder::{ByteOrder, LittleEndian};
use mcap::records::op;

/// How much is asked of the file at a time, in bytes, independent of what a record promises.
pub(crate) const PIECE: usize = 64 << 10;

/// Kind and length before every record, in bytes.
const RECORD_HEAD: usize = 9;

/// A chunk up to the length of its compression's name, in bytes.
const CHUNK_HEAD: usize = 32;

/// The length of a chunk's records, in bytes.
const SIZE: usize = 8;

/// The bytes of a log. They end before a record that is longer than the chunk it stands in, as a file that is cut off there.
#[derive(Debug)]
pub(crate) struct WholeChunks<R> {
    /// Buffered: a record is asked for in two pieces, its head and its body.
    bytes: BufReader<R>,
    outline: Outline,
}

impl<R: Read> WholeChunks<R> {
    pub(crate) fn new(bytes: R) -> Self {
        Self { bytes: BufReader::with_capacity(PIECE, bytes), outline: Outline::start() }
    }

    /// Whether a record runs past the end of its chunk, as far as was read.
    pub(crate) fn overrun(&self) -> bool {
        self.outline.at == At::Overrun
    }
}

impl<R: Read> Read for WholeChunks<R> {
    fn read(&mut self, into: &mut [u8]) -> Result<usize> {
        let read = self.bytes.read(into)?;
        Ok(self.outline.pass(&into[..read]))
    }
}

/// What the next bytes are that matter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum At {
    /// A record of the file.
    Record,
    /// A chunk of so many bytes.
    Chunk { bytes: u64 },
    /// The length of a plain chunk's records, in a chunk of so many bytes.
    Size { bytes: u64 },
    /// A record in a plain chunk, of which so many bytes are left, with so many behind them.
    Inside { left: u64, behind: u64 },
    /// A record was longer than its chunk.
    Overrun,
}

/// Where the lengths are such as the reader itself refuses, everything passes.
const LET_BY: (At, u64) = (At::Record, u64::MAX);

/// Where in a log one is: the lengths alone.
#[derive(Debug)]
struct Outline {
    at: At,
    /// Bytes until then.
    skip: u64,
    /// What has come of them.
    head: Vec<u8>,
}

impl Outline {
    fn start() -> Self {
        Self { at: At::Record, skip: mcap::MAGIC.len() as u64, head: Vec::with_capacity(CHUNK_HEAD) }
    }

    /// Goes on over `piece`; how many bytes of it come before an overrun.
    fn pass(&mut self, piece: &[u8]) -> usize {
        let mut rest = piece;
        while !rest.is_empty() {
            if self.skip > 0 {
                let over = usize::try_from(self.skip).unwrap_or(usize::MAX).min(rest.len());
                self.skip -= over as u64;
                rest = &rest[over..];
                continue;
            }
            let length = match self.at {
                At::Record | At::Inside { .. } => RECORD_HEAD,
                At::Chunk { .. } => CHUNK_HEAD,
                At::Size { .. } => SIZE,
                At::Overrun => return piece.len() - rest.len(),
            };
            let (taken, after) = rest.split_at((length - self.head.len()).min(rest.len()));
            self.head.extend_from_slice(taken);
            rest = after;
            if self.head.len() == length {
                (self.at, self.skip) = next(self.at, &self.head);
                self.head.clear();
                if self.at == At::Overrun {
                    return piece.len() - rest.len() - taken.len();
                }
            }
        }
        piece.len()
    }
}

/// What follows `head`, and after how many bytes.
fn next(at: At, head: &[u8]) -> (At, u64) {
    match at {
        At::Record => {
            let bytes = LittleEndian::read_u64(&head[1..]);
            if head[0] == op::CHUNK { (At::Chunk { bytes }, 0) } else { (At::Record, bytes) }
        }
        At::Chunk { bytes } => {
            let Some(left) = bytes.checked_sub((CHUNK_HEAD + SIZE) as u64) else { return LET_BY };
            // A compressed chunk is unpacked by the reader record by record, and its length not counted down.
            let plain = head[CHUNK_HEAD - 4..].iter().all(|byte| *byte == 0);
            if plain { (At::Size { bytes: left }, 0) } else { (At::Record, left + SIZE as u64) }
        }
        At::Size { bytes } => {
            let left = LittleEndian::read_u64(head);
            let Some(behind) = bytes.checked_sub(left) else { return LET_BY };
            inside(left, behind, 0)
        }
        At::Inside { left, behind } => {
            let body = LittleEndian::read_u64(&head[1..]);
            match left.checked_sub(RECORD_HEAD as u64).and_then(|left| left.checked_sub(body)) {
                Some(left) => inside(left, behind, body),
                None => (At::Overrun, 0),
            }
        }
        At::Overrun => (at, 0),
    }
}

/// After `body` more bytes: the next record of the chunk, or of the file.
fn inside(left: u64, behind: u64, body: u64) -> (At, u64) {
    if left == 0 { (At::Record, body + behind) } else { (At::Inside { left, behind }, body) }
}

#[cfg(test)]
mod tests {
    use mcap::Compression;

    use super::*;
    use crate::mcap::reader::messages;
    use crate::testing::{bag, ball, error_text, file};
    use crate::{ReadOptions, read};

    /// Gives its bytes `0` at a time.
    struct Crumbs<'a>(usize, &'a [u8]);

    impl Read for Crumbs<'_> {
        fn read(&mut self, into: &mut [u8]) -> Result<usize> {
            let (now, later) = self.1.split_at(self.0.min(self.1.len()).min(into.len()));
            into[..now.len()].copy_from_slice(now);
            self.1 = later;
            Ok(now.len())
        }
    }

    fn passed(bytes: &[u8], crumb: usize) -> (Vec<u8>, bool) {
        let mut all = Vec::new();
        let mut reader = WholeChunks::new(Crumbs(crumb, bytes));
        reader.read_to_end(&mut all).unwrap();
        (all, reader.overrun())
    }

    /// A plain log, where in it its chunk begins, and where the length of the chunk's last record stands.
    fn plain() -> (Vec<u8>, usize, usize) {
        let bytes = bag(None, &[ball(20)]);
        let body = |at: usize| usize::try_from(LittleEndian::read_u64(&bytes[at + 1..])).unwrap();
        let mut chunk = mcap::MAGIC.len();
        while bytes[chunk] != op::CHUNK {
            chunk += RECORD_HEAD + body(chunk);
        }
        let (mut record, end) = (chunk + RECORD_HEAD + CHUNK_HEAD + SIZE, chunk + RECORD_HEAD + body(chunk));
        while record + RECORD_HEAD + body(record) < end {
            record += RECORD_HEAD + body(record);
        }
        assert_eq!(bytes[record], op::MESSAGE);
        (bytes, chunk, record + 1)
    }

    #[test]
    fn a_sound_log_passes_unchanged_in_pieces_of_any_size() {
        for compression in [None, Some(Compression::Zstd), Some(Compression::Lz4)] {
            let bytes = bag(compression, &[ball(20)]);
            for crumb in [1, 7, 8, 9, 40, 1 << 20] {
                assert_eq!(passed(&bytes, crumb), (bytes.clone(), false));
            }
        }
    }

    #[test]
    fn the_bytes_end_before_a_record_that_is_longer_than_its_chunk() {
        let (mut bytes, _, length) = plain();
        bytes[length] += 1;
        for crumb in [1, 7, 8, 9, 40, 1 << 20] {
            let (all, overrun) = passed(&bytes, crumb);
            assert!(overrun);
            // A head that came in crumbs is let by as far as it had come; it is no record.
            assert!((length - 1..length + 8).contains(&all.len()), "{} of {length}", all.len());
            assert_eq!(all, bytes[..all.len()]);
        }
    }

    #[test]
    fn lengths_of_any_kind_are_no_panic() {
        let (bytes, ..) = plain();
        for at in 8..bytes.len() {
            let mut broken = bytes.clone();
            broken[at] = 0xff;
            let (all, overrun) = passed(&broken, 64);
            assert!(overrun || all == broken);
        }
    }

    #[test]
    fn a_recording_with_such_a_record_is_refused_and_says_so() {
        let (mut bytes, chunk, length) = plain();
        bytes[length] += 1;
        // No sum over the chunk, so its records are accepted one by one.
        bytes[chunk + RECORD_HEAD + 24..][..4].fill(0);
        let (_folder, path) = file("a.mcap", &bytes);
        assert_eq!(messages(&path).unwrap().flatten().count(), 19);
        let (message, _) = error_text(&read(&path, &ReadOptions::default()).unwrap_err());
        assert_eq!(message, "a.mcap: a record is longer than the chunk it stands in: 19 messages could be read before");
    }
}
