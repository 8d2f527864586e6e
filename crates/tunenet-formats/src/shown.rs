//! Names from a file in a message, cut where they are too long.

use std::fmt::Display;
use std::path::Path;

use tunenet_core::text::visible;

/// The name of a file for a message: one line, and nothing in it that a reader cannot see.
#[must_use]
pub fn shown_path(path: &Path) -> String {
    visible(&path.display().to_string())
}

/// A word of a suggested command, in the quotes that a POSIX shell needs; characters that cannot be seen are replaced, so a
/// word that held some is no longer the name of that file.
#[must_use]
pub fn shell_word(text: &str) -> String {
    let text = visible(text);
    // More is safe than the crate leaves bare: the `=` and `,` of `--columns`, and letters beyond ASCII.
    if !text.is_empty() && text.chars().all(|c| c.is_alphanumeric() || "_-.,=/:+@%".contains(c)) {
        return text;
    }
    // Only a zero byte has no quotes, and `visible` leaves none.
    shlex::try_quote(&text).map_or_else(|_| String::new(), std::borrow::Cow::into_owned)
}

/// `a`, `b` and `c` in backquotes, at most `most` of them.
pub(crate) fn list<'a>(names: impl IntoIterator<Item = &'a str>, most: usize) -> String {
    let names: Vec<&str> = names.into_iter().collect();
    let shown: Vec<String> = names.iter().take(most).map(|name| format!("`{}`", visible(&shortened(name)))).collect();
    match names.len().saturating_sub(most) {
        0 if shown.is_empty() => "none".into(),
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}

/// "1 line", "2 lines".
pub(crate) fn counted<N: Copy + Display + PartialEq + From<u8>>(count: N, what: &str) -> String {
    format!("{count} {what}{}", if count == N::from(1) { "" } else { "s" })
}

/// Most characters of a user's text that a message repeats.
const LONGEST_SHOWN: usize = 40;

/// The text, cut where it is too long for a message.
pub(crate) fn shortened(text: &str) -> std::borrow::Cow<'_, str> {
    match text.char_indices().nth(LONGEST_SHOWN) {
        Some((end, _)) => format!("{}…", &text[..end]).into(),
        None => text.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_a_command_are_quoted() {
        assert_eq!(shell_word("t_s=time"), "t_s=time");
        assert_eq!(shell_word("a b;touch pwned.csv"), "'a b;touch pwned.csv'");
        assert_eq!(shell_word("$(id)"), "'$(id)'");
        assert_eq!(shell_word("it's"), "\"it's\"");
        assert_eq!(shell_word(""), "''");
        assert_eq!(shell_word("a\n\0b"), "'a\u{fffd}\u{fffd}b'");
    }

    #[test]
    fn names_in_a_list_are_one_visible_line() {
        assert_eq!(list(["j\u{1b}[31m\nX"], 3), "`j\u{fffd}[31m\u{fffd}X`");
    }

    #[test]
    fn a_file_name_is_one_visible_line() {
        assert_eq!(shown_path(Path::new("read     new\nline\u{202e}.csv")), "read     new\u{fffd}line\u{fffd}.csv");
    }
}
