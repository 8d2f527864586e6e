//! Replacing a file in one step.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use tempfile::TempPath;

use crate::{Action, Error, Result};

/// Writes a file so that its name always stands for a whole one: into a new file in the same folder, to the disk, then
/// under its name. Where anything fails, what stood there before still does, and nothing half-written stays; on most
/// disks under Linux not even after a kill.
///
/// A device or a pipe has no contents to protect and is written directly.
///
/// # Errors
/// [`Error::Io`] with `path` where the system refuses or `write` returns an error.
pub fn write_atomically(
    path: impl AsRef<Path>,
    write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<()> {
    let path = path.as_ref();
    replace(path, write).map_err(|e| Error::io(path, Action::Writing, e))
}

fn replace(path: &Path, write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>) -> std::io::Result<()> {
    match std::fs::metadata(path) {
        Ok(about) if about.is_dir() => return Err(std::io::ErrorKind::IsADirectory.into()),
        Ok(about) if !about.is_file() => {
            let mut out = BufWriter::new(std::fs::OpenOptions::new().write(true).open(path)?);
            write(&mut out)?;
            return out.flush();
        }
        _ => {}
    }
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let (file, named) = new_file(folder)?;
    let mut out = BufWriter::new(file);
    write(&mut out)?;
    out.flush()?;
    let file = out.into_inner().map_err(std::io::IntoInnerError::into_error)?;
    file.sync_all()?;
    let named = match named {
        Some(named) => named,
        None => link(&file, folder)?,
    };
    named.persist(path).map_err(|e| e.error)?;
    // The name itself reaches the disk with its folder; not every system lets a folder be opened.
    if let Ok(folder) = std::fs::File::open(folder) {
        folder.sync_all().ok();
    }
    Ok(())
}

/// A file to write into: without a name where the system has such files, so that a kill leaves nothing behind, otherwise
/// under a name that goes away with the second value.
fn new_file(folder: &Path) -> std::io::Result<(File, Option<TempPath>)> {
    #[cfg(target_os = "linux")]
    if let Some(file) = unnamed(folder) {
        return Ok((file, None));
    }
    let mut builder = names();
    // A temporary file is private by default; this one becomes the user's, under the usual mask.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    // The message does not contain the temporary name, only the system's error.
    let file = builder.tempfile_in(folder).map_err(|e| std::io::Error::from(e.kind()))?;
    let (file, name) = file.into_parts();
    Ok((file, Some(name)))
}

fn names() -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".tunenet-");
    builder
}

/// A file in `folder` without a name. `None` where the disk has none such (NFS), or where it could not be named later.
#[cfg(target_os = "linux")]
fn unnamed(folder: &Path) -> Option<File> {
    use std::os::unix::fs::OpenOptionsExt;
    let flags = rustix::fs::OFlags::TMPFILE.bits().cast_signed();
    let file = std::fs::OpenOptions::new().write(true).mode(0o666).custom_flags(flags).open(folder).ok()?;
    handle(&file).exists().then_some(file)
}

/// Where the system shows an open file.
#[cfg(target_os = "linux")]
fn handle(file: &File) -> std::path::PathBuf {
    use std::os::fd::AsRawFd;
    format!("/proc/self/fd/{}", file.as_raw_fd()).into()
}

/// Gives a file without a name one, for the instant until it is renamed.
#[cfg(target_os = "linux")]
fn link(file: &File, folder: &Path) -> std::io::Result<TempPath> {
    use rustix::fs::{AtFlags, CWD, linkat};
    let named = names().make_in(folder, |name| {
        linkat(CWD, handle(file), CWD, name, AtFlags::SYMLINK_FOLLOW).map_err(std::io::Error::from)
    });
    Ok(named.map_err(|e| std::io::Error::from(e.kind()))?.into_temp_path())
}

#[cfg(not(target_os = "linux"))]
fn link(_: &File, _: &Path) -> std::io::Result<TempPath> {
    Err(std::io::ErrorKind::Unsupported.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        write_atomically(&path, |out| out.write_all(b"old")).unwrap();
        let failed = write_atomically(&path, |out| {
            out.write_all(b"half")?;
            Err(std::io::ErrorKind::StorageFull.into())
        });
        let message = failed.unwrap_err().to_string();
        assert!(message.starts_with(&format!("{}: writing failed: ", path.display())), "{message}");
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_missing_folder_names_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("none/a.csv");
        let message = write_atomically(&path, |_| Ok(())).unwrap_err().to_string();
        assert!(message.starts_with(&format!("{}: writing failed", path.display())), "{message}");
    }

    #[test]
    fn a_folder_is_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        assert!(write_atomically(folder.path(), |_| Ok(())).is_err());
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_device_is_an_error() {
        let failed = write_atomically("/dev/full", |out| out.write_all(&vec![0; 100_000]));
        assert!(failed.unwrap_err().to_string().starts_with("/dev/full: writing failed"));
    }
}
