//! What a file is: content first, by the marks at its beginning.

use std::io::Read as _;
use std::path::Path;

use crate::documents::{LOOKED_AT, refuse_document, refuse_pointer};
use crate::encoding;
use crate::source::{LARGEST_TEXT, open};
use crate::{Action, Error, Result};

/// What a file is, judged by its first bytes and, where they say nothing, by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Format {
    Csv,
    Mcap,
    /// An MCAP file, compressed as a whole.
    PackedMcap,
    /// A bag of ROS 2 in SQLite.
    Bag,
    Parquet,
    /// Demonstrations or a log in HDF5.
    Hdf5,
    /// One array of NumPy.
    Npy,
    /// Several arrays of NumPy.
    Npz,
    /// Variables of MATLAB, versions 5 to 7.
    Mat,
}

/// The mark of an SQLite database, and how the names of bags that are compressed end.
const SQLITE: &[u8] = b"SQLite format 3\0";
const PACKED_BAG: &str = ".db3.zstd";
const HDF5: &[u8] = b"\x89HDF\r\n\x1a\n";
const NUMPY: &[u8] = b"\x93NUMPY";
const ZIP: &[u8] = b"PK\x03\x04";
const MATLAB: &[u8] = b"MATLAB 5.0";
const PARQUET: &[u8] = b"PAR1";
const PACKED_MCAP: &str = ".mcap.zstd";

/// How to get a tool that reads more than CSV and MCAP.
pub(crate) const WITH_LOGS: &str = "build tunenet with the feature `logs`: `cargo install --locked --path crates/tunenet-cli --no-default-features --features logs`";

/// How every frame of zstd begins. No message in CDR does: its first byte is 0.
pub(crate) const ZSTD: &[u8] = b"\x28\xb5\x2f\xfd";

/// Files of other kinds: where in them their mark stands, the mark, what they are, and what to do.
const OTHERS: [(usize, &[u8], &str, &str); 13] = [
    (0, b"#ROSBAG V2.0", "a ROS 1 bag", "convert it with `mcap convert` and record ROS 2 messages"),
    (0, ZIP, "a zip archive or a spreadsheet", "unpack it, or export the sheet as CSV"),
    (0, b"\xd0\xcf\x11\xe0", "an old spreadsheet", "export the sheet as CSV"),
    (0, b"\x1f\x8b", "a gzip archive", "unpack it first"),
    (0, ZSTD, "a zstd archive", "unpack it first"),
    (0, b"\xfd7zXZ\0", "an xz archive", "unpack it first"),
    (0, b"\x89PNG", "a picture", "give the numbers that were measured, as CSV"),
    (0, b"\xff\xd8\xff", "a picture", "give the numbers that were measured, as CSV"),
    (0, b"%PDF", "a PDF document", "give the numbers that were measured, as CSV"),
    (4, b"ftyp", "a video", "give the positions that were seen in it, as CSV"),
    (0, b"ARROW1", "an Arrow or Feather file", AS_PARQUET),
    (0, b"FEA1", "a Feather file (version 1)", AS_PARQUET),
    (0, b"MATLAB 7.3", "a MATLAB file (version 7.3)", MATLAB_73),
];

/// What makes Parquet of a file of Arrow.
const AS_PARQUET: &str = "write it as Parquet: `python3 -c \"import sys, pyarrow.feather as f, pyarrow.parquet as p; \
    p.write_table(f.read_table(sys.argv[1]), sys.argv[2])\" OLD.feather NEW.parquet`";

/// How files end that are no texts, and what they are: one without its mark is broken.
const NAMED: [(&str, &str); 7] = [
    ("db3", "a bag of ROS 2 in SQLite"),
    ("hdf5", "an HDF5 file"),
    ("h5", "an HDF5 file"),
    ("parquet", "a Parquet file"),
    ("npz", "an archive of NumPy arrays"),
    ("npy", "an array of NumPy"),
    ("mat", "a MATLAB file"),
];

/// What makes columns of the variables of a MATLAB file: a table by MATLAB itself, or arrays by Python.
const MATLAB_73: &str = "write them as arrays of NumPy: `python3 -c \"import h5py, numpy; f = h5py.File('log.mat'); \
    numpy.savez('log.npz', **{k: v[()].T.squeeze() for k, v in f.items() if isinstance(v, h5py.Dataset)})\"`, or as CSV in \
    MATLAB: `writetable(table(t_s, z_m), 'log.csv')`";

/// Content first: an MCAP file under any name is read as one, and a text file named `.mcap` is not called empty.
pub(crate) fn format(path: &Path) -> Result<Format> {
    let mut start = Vec::new();
    let file = open(path)?;
    let bytes = file.metadata().map_err(|e| Error::io(path, Action::Reading, e))?.len();
    file.take(LOOKED_AT).read_to_end(&mut start).map_err(|e| Error::io(path, Action::Reading, e))?;
    let named_mcap = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("mcap"));
    if start.starts_with(mcap::MAGIC) {
        return Ok(Format::Mcap);
    }
    refuse_pointer(path, &start)?;
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    if start.starts_with(SQLITE) || start.starts_with(ZSTD) && name.ends_with(PACKED_BAG) {
        return with_logs(path, "a bag of ROS 2 in SQLite", Format::Bag);
    }
    if start.starts_with(PARQUET) {
        return with_logs(path, "a Parquet file", Format::Parquet);
    }
    if start.starts_with(HDF5) {
        return with_logs(path, "an HDF5 file", Format::Hdf5);
    }
    if start.starts_with(NUMPY) {
        return with_logs(path, "a NumPy array", Format::Npy);
    }
    if start.starts_with(ZIP) && path.extension().is_some_and(|e| e.eq_ignore_ascii_case("npz")) {
        return with_logs(path, "arrays of NumPy", Format::Npz);
    }
    if start.starts_with(MATLAB) {
        return with_logs(path, "a MATLAB file", Format::Mat);
    }
    if start.starts_with(ZSTD) && name.ends_with(PACKED_MCAP) {
        return with_logs(path, "an MCAP file, compressed as a whole", Format::PackedMcap);
    }
    if named_mcap {
        let message = if start.is_empty() {
            "expected an MCAP file, found an empty one".to_owned()
        } else if mcap::MAGIC.starts_with(&start) {
            format!("the file ends after {} bytes, in the middle of its first mark", start.len())
        } else {
            "expected the mark of an MCAP file at its start, found other bytes".to_owned()
        };
        return Err(Error::file(path, message, "copy the recording again, or name a text file `.csv`"));
    }
    if let Some((_, _, what, hint)) =
        OTHERS.iter().find(|(at, mark, ..)| start.get(*at..).is_some_and(|s| s.starts_with(mark)))
    {
        return Err(Error::file(path, format!("expected a recording, found {what}"), *hint));
    }
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    if let Some((_, expected)) = NAMED.iter().find(|(known, _)| *known == ending) {
        let found = match &start[..] {
            [] => "an empty one",
            // The end of an archive, at its start.
            [b'P', b'K', 5, 6, ..] => "one with no array in it",
            _ => "other bytes",
        };
        let message = format!("expected {expected}, found {found}");
        return Err(Error::file(path, message, "copy the recording again, or name a text file `.csv`"));
    }
    encoding::refuse_foreign(path, &start[..start.len().min(512)])?;
    refuse_document(path, &start)?;
    if bytes > LARGEST_TEXT {
        let message = format!("expected at most {LARGEST_TEXT} bytes of text, found {bytes}");
        let hint = "keep the columns that are needed, for example `cut -d, -f1,4`, or cut the file into pieces";
        return Err(Error::file(path, message, hint));
    }
    Ok(Format::Csv)
}

/// Whether there is an HDF5 file by its mark. What cannot be opened is none: whoever reads it says why.
pub(crate) fn is_hdf5(path: &Path) -> bool {
    let mut start = Vec::new();
    let read = open(path).ok().map(|file| file.take(HDF5.len() as u64).read_to_end(&mut start));
    matches!(read, Some(Ok(_))) && start.starts_with(HDF5)
}

/// `format`, where this build reads it.
///
/// # Errors
/// [`Error::File`] with what to build, where it does not.
pub(crate) fn with_logs(path: &Path, what: &str, format: Format) -> Result<Format> {
    if cfg!(feature = "logs") {
        return Ok(format);
    }
    let message = format!("expected CSV or MCAP, which this build reads, found {what}");
    Err(Error::file(path, message, WITH_LOGS))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{error_text, file};

    #[test]
    fn a_file_without_the_mark_of_its_name_is_broken() {
        let refused = |name: &str, bytes: &[u8]| {
            let (_folder, path) = file(name, bytes);
            error_text(&format(&path).unwrap_err()).0
        };
        assert_eq!(refused("a.h5", b""), "a.h5: expected an HDF5 file, found an empty one");
        assert_eq!(refused("a.hdf5", b"\x89HDF\r\n\x1a"), "a.hdf5: expected an HDF5 file, found other bytes");
        assert_eq!(refused("a.parquet", &[0; 99]), "a.parquet: expected a Parquet file, found other bytes");
        assert_eq!(refused("a.npz", b"\x1f\x8b\x08"), "a.npz: expected a recording, found a gzip archive");
        assert_eq!(
            refused("a.feather", b"ARROW1\0\0"),
            "a.feather: expected a recording, found an Arrow or Feather file"
        );
        assert_eq!(refused("a.db3", b""), "a.db3: expected a bag of ROS 2 in SQLite, found an empty one");
    }
}
