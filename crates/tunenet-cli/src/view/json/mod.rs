//! What standard output holds: the one JSON object of a command, or a text that is its answer.

pub(crate) mod diagnose;
pub(crate) mod law;
pub(crate) mod plan;
pub(crate) mod ranges;
pub(crate) mod track;
pub(crate) mod tune;

use std::io::{ErrorKind, Write};

use serde_json::{Value, json};
use tunenet_core::observation::Note;
use tunenet_formats::{Action, Error, Result};

/// A note as every command's JSON has it.
pub fn warning(note: &Note) -> Value {
    json!({ "code": note.kind, "severity": note.kind.severity(), "text": note.text, "remedy": note.remedy })
}

/// Prints the one JSON object of a command.
///
/// # Errors
/// As [`print()`].
pub fn print_json(value: &Value) -> Result<()> {
    print(format!("{value:#}\n").as_bytes())
}

/// Writes an answer to standard output. A reader that has gone away is no error.
///
/// # Errors
/// [`Error::Io`] where it cannot be written: half an answer must not pass for a whole one.
pub fn print(text: &[u8]) -> Result<()> {
    write_to(&mut std::io::stdout().lock(), text)
}

/// Writes text to standard output, without colours where they are not wanted.
///
/// # Errors
/// As [`print()`].
pub fn print_text(text: &str) -> Result<()> {
    write_to(&mut anstream::stdout().lock(), text.as_bytes())
}

fn write_to(out: &mut dyn Write, text: &[u8]) -> Result<()> {
    match out.write_all(text).and_then(|()| out.flush()) {
        Err(source) if source.kind() != ErrorKind::BrokenPipe => {
            Err(Error::Io { path: "standard output".into(), action: Action::Writing, source })
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Broken(ErrorKind);

    impl Write for Broken {
        fn write(&mut self, _: &[u8]) -> std::io::Result<usize> {
            Err(self.0.into())
        }

        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_reader_that_left_is_no_error_and_a_full_disk_is_one() {
        assert!(write_to(&mut Broken(ErrorKind::BrokenPipe), b"{}").is_ok());
        let full = write_to(&mut Broken(ErrorKind::StorageFull), b"{}").unwrap_err().to_string();
        assert!(full.starts_with("standard output: writing failed: "), "{full}");
    }
}
