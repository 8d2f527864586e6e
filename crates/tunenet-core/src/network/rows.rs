//! Out-of-core array of encoded rollouts: in memory, or beyond a limit in a temporary file that is read record by record.

use std::fs::File;
use std::io::{BufWriter, Read, Seek, SeekFrom, Write};
use std::ops::Range;

use crate::{Action, Error, Result};

/// Bytes read at once where all rollouts are looked through in order.
const SCANNED_BYTES: usize = 1 << 20;

/// One rollout as a branch sees it.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Rollout {
    /// What it covers of its row.
    pub(super) covered: Range<usize>,
    /// Tuned parameters less their least value, over their span. Double precision: the differences are what is learned.
    pub(super) normalised: Vec<f64>,
    /// Shape `[width]`.
    pub(super) row: Vec<f32>,
}

/// Where the records are. Both forms hold the same bytes, so that nothing that is learned depends on which it is.
enum Kept {
    Memory(Vec<u8>),
    File(BufWriter<File>),
}

/// Opens a file without a name, which the system takes away with the process.
pub type Overflow<'a> = dyn Fn() -> std::io::Result<File> + 'a;

/// Where encoded rollouts are kept: so many bytes in memory, and a temporary file for more, where there is one.
#[derive(Clone, Copy)]
pub(super) struct Room<'a> {
    pub(super) memory_bytes: usize,
    pub(super) overflow: Option<&'a Overflow<'a>>,
}

/// Records of one length, one for each rollout.
pub(super) struct Rows<'a> {
    parameters: usize,
    width: usize,
    count: usize,
    kept: Kept,
    room: Room<'a>,
}

impl<'a> Rows<'a> {
    /// None yet, of `parameters` normalised parameters and `width` numbers each.
    pub(super) fn new(parameters: usize, width: usize, room: Room<'a>) -> Self {
        Self { parameters, width, count: 0, kept: Kept::Memory(Vec::new()), room }
    }

    /// How many rollouts.
    pub(super) fn len(&self) -> usize {
        self.count
    }

    /// Appends one.
    pub(super) fn push(&mut self, rollout: &Rollout) -> Result<()> {
        let mut record = Vec::with_capacity(self.record_bytes());
        for bound in [rollout.covered.start, rollout.covered.end] {
            record.extend((bound as u64).to_le_bytes());
        }
        rollout.normalised.iter().for_each(|value| record.extend(value.to_le_bytes()));
        rollout.row.iter().for_each(|value| record.extend(value.to_le_bytes()));
        if let Kept::Memory(bytes) = &self.kept
            && bytes.len() + record.len() > self.room.memory_bytes
            && let Some(open) = self.room.overflow
        {
            let mut file = BufWriter::new(open().map_err(failed(Action::Creating))?);
            file.write_all(bytes).map_err(failed(Action::Writing))?;
            self.kept = Kept::File(file);
        }
        match &mut self.kept {
            Kept::Memory(bytes) => bytes.extend(record),
            Kept::File(file) => file.write_all(&record).map_err(failed(Action::Writing))?,
        }
        self.count += 1;
        Ok(())
    }

    /// All are there: from now on they are read.
    pub(super) fn finish(&mut self) -> Result<()> {
        match &mut self.kept {
            Kept::Memory(_) => Ok(()),
            Kept::File(file) => file.flush().map_err(failed(Action::Writing)),
        }
    }

    /// Rollout `number`, which is below [`len`](Self::len), into `rollout`.
    pub(super) fn read(&self, number: usize, rollout: &mut Rollout) -> Result<()> {
        let length = self.record_bytes();
        match &self.kept {
            Kept::Memory(bytes) => self.decode(&bytes[number * length..(number + 1) * length], rollout),
            Kept::File(_) => {
                let mut record = vec![0; length];
                self.fetch(number, &mut record)?;
                self.decode(&record, rollout);
            }
        }
        Ok(())
    }

    /// Shows every rollout to `look`, in order.
    pub(super) fn scan(&self, mut look: impl FnMut(usize, &Rollout)) -> Result<()> {
        let length = self.record_bytes();
        let at_once = (SCANNED_BYTES / length).max(1);
        let (mut rollout, mut buffer) = (Rollout::default(), Vec::new());
        for first in (0..self.count).step_by(at_once) {
            let end = (first + at_once).min(self.count);
            let block = match &self.kept {
                Kept::Memory(bytes) => &bytes[first * length..end * length],
                Kept::File(_) => {
                    buffer.resize((end - first) * length, 0);
                    self.fetch(first, &mut buffer)?;
                    &buffer
                }
            };
            for (number, record) in (first..).zip(block.chunks_exact(length)) {
                self.decode(record, &mut rollout);
                look(number, &rollout);
            }
        }
        Ok(())
    }

    /// Reads from the beginning of record `number` on; only with a file.
    fn fetch(&self, number: usize, into: &mut [u8]) -> Result<()> {
        let Kept::File(file) = &self.kept else { return Ok(()) };
        let mut file = file.get_ref();
        let start = SeekFrom::Start((number * self.record_bytes()) as u64);
        file.seek(start).and_then(|_| file.read_exact(into)).map_err(failed(Action::Reading))
    }

    fn decode(&self, record: &[u8], rollout: &mut Rollout) {
        let eight = |at: usize| <[u8; 8]>::try_from(&record[at..at + 8]).unwrap_or_default();
        let bound = |at: usize| usize::try_from(u64::from_le_bytes(eight(at))).unwrap_or(usize::MAX);
        rollout.covered = bound(0)..bound(8);
        rollout.normalised.clear();
        rollout.normalised.extend((0..self.parameters).map(|i| f64::from_le_bytes(eight(16 + 8 * i))));
        let row = record[16 + 8 * self.parameters..].chunks_exact(4);
        rollout.row.clear();
        rollout.row.extend(row.map(|four| f32::from_le_bytes(four.try_into().unwrap_or_default())));
    }

    fn record_bytes(&self) -> usize {
        16 + 8 * self.parameters + 4 * self.width
    }

    /// Whether they are in a file.
    #[cfg(test)]
    pub(super) fn on_disk(&self) -> bool {
        matches!(self.kept, Kept::File(_))
    }
}

fn failed(action: Action) -> impl Fn(std::io::Error) -> Error {
    move |source| Error::Overflow { action, source }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rollout(number: usize) -> Rollout {
        let value = number as f64 / 7.0;
        let row = (0..5u16).map(|i| f32::from(i) / 3.0 + super::super::numbers::single(value)).collect();
        Rollout { covered: number..number + 3, normalised: vec![value, -value], row }
    }

    #[test]
    fn memory_and_file_hold_the_same() {
        let folder = tempfile::tempdir().unwrap();
        // The third causes the move to the file.
        for (limit, on_disk) in [(1 << 20, false), (2 * 52 + 3, true), (0, true)] {
            let open = || tempfile::tempfile_in(folder.path());
            let mut rows = Rows::new(2, 5, Room { memory_bytes: limit, overflow: Some(&open) });
            (0..40).for_each(|i| rows.push(&rollout(i)).unwrap());
            rows.finish().unwrap();
            assert_eq!((rows.len(), rows.on_disk()), (40, on_disk));
            let mut seen = Rollout::default();
            for i in [39, 0, 17, 17, 3] {
                rows.read(i, &mut seen).unwrap();
                assert_eq!(seen, rollout(i));
            }
            let mut next = 0;
            rows.scan(|number, seen| {
                assert_eq!((number, seen), (next, &rollout(next)));
                next += 1;
            })
            .unwrap();
            assert_eq!(next, 40);
            assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "the file has no name");
        }
    }

    #[test]
    fn a_temporary_file_that_cannot_be_made_is_an_error() {
        let open = || Err(std::io::ErrorKind::StorageFull.into());
        let mut rows = Rows::new(2, 5, Room { memory_bytes: 0, overflow: Some(&open) });
        let refused = rows.push(&rollout(0)).unwrap_err().to_string();
        assert!(refused.starts_with("temporary file of the training: creating failed"), "{refused}");
    }
}
