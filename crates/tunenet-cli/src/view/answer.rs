//! What a command answers: text for readers or one JSON object on standard output, and notes on standard error.

use serde_json::Value;
use tunenet_core::observation::Note;
use tunenet_formats::Result;

use super::json::{print_json, print_text};
use super::text::{lines, table, warn_all};

/// An answer in words, and the notes that go with it.
#[derive(Debug, Default)]
pub struct Printout {
    text: String,
    notes: Vec<Note>,
}

impl Printout {
    /// Adds lines as they are.
    pub fn line(&mut self, text: &str) {
        self.text.push_str(&lines(text));
        self.text.push('\n');
    }

    /// Adds a line with a word in front: `motion   3 bounces`.
    pub fn row(&mut self, what: &str, text: &str) {
        self.line(&format!("{what:<8} {text}"));
    }

    /// Adds the verdict, in bold letters where a terminal shows them.
    pub fn verdict(&mut self, text: &str) {
        let (bold, reset) = (anstyle::Style::new().bold(), anstyle::Reset);
        self.text.extend([format!("{bold}"), lines(text), format!("{reset}\n")]);
    }

    /// Adds a table.
    pub fn table(&mut self, rows: &[Vec<String>]) {
        self.line(&table(rows));
    }

    /// Adds a warning, which goes to standard error.
    pub fn warn(&mut self, note: &Note) {
        self.notes.push(note.clone());
    }

    /// Adds warnings, which go to standard error.
    pub fn warn_all<'a>(&mut self, notes: impl IntoIterator<Item = &'a Note>) {
        self.notes.extend(notes.into_iter().cloned());
    }

    /// The text so far.
    #[cfg(test)]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Prints the text, or with `--json` the object, and then the warnings.
    ///
    /// # Errors
    /// As [`print_json`].
    pub fn show(&self, json: bool, object: impl FnOnce() -> Value) -> Result<()> {
        let printed = if json { print_json(&object()) } else { print_text(&self.text) };
        printed?;
        warn_all(&self.notes);
        Ok(())
    }
}

/// Prints one line of an answer that grows while the command works.
///
/// # Errors
/// As [`print_json`].
pub fn line(text: &str) -> Result<()> {
    print_text(&format!("{}\n", lines(text)))
}

/// Prints a text that is the answer, unless standard output is for the one JSON object.
///
/// # Errors
/// As [`print_json`].
pub fn text(json: bool, text: &str) -> Result<()> {
    if json { Ok(()) } else { line(text) }
}
