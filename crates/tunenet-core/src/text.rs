//! Sanitised text: characters of an untrusted file that are safe to print.

/// Whether a character can change what a user sees of the others: control characters, marks that turn the direction of
/// writing, signs without width, and those that break a line.
#[must_use]
pub fn is_hidden(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{61c}' | '\u{180e}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}')
        || matches!(c, '\u{feff}' | '\u{fff9}'..='\u{fffb}' | '\u{e0000}'..='\u{e007f}')
}

/// `text` with `\u{fffd}` in place of every [hidden](is_hidden) character.
#[must_use]
pub fn visible(text: &str) -> String {
    text.chars().map(|c| if is_hidden(c) { '\u{fffd}' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_seen_is_marked() {
        assert_eq!(visible("a\u{1b}[31mb\n"), "a\u{fffd}[31mb\u{fffd}");
        for c in "\u{61c}\u{200b}\u{200d}\u{200e}\u{200f}\u{202a}\u{202e}\u{2060}\u{2066}\u{2069}\u{feff}".chars() {
            assert_eq!(visible(&format!("x{c}y")), "x\u{fffd}y", "{c:?}");
        }
        let plain = "Höhe [cm], µs, N·m, 5–7 °C, `時間`, — …";
        assert_eq!(visible(plain), plain);
    }
}
