//! The change of the simulation file.

use maud::{Markup, html};
use similar::{ChangeTag, TextDiff};

use crate::answers::diagnose::Edited;

/// Unchanged lines around a change.
const AROUND: usize = 3;

/// A unified diff for each object, or why there is none.
pub fn change(edits: &Result<Vec<Edited>, &'static str>) -> Markup {
    html! {
        @match edits {
            Err(why) => p.none { "The simulation file stays as it is: " (why) "." },
            Ok(all) => {
                @for one in all {
                    @if all.len() > 1 { h3 { (one.object) } }
                    (difference(&one.given, &one.improved))
                }
                p.how { "Lines with + are added, lines with \u{2212} are removed. The provenance is omitted; " code { "--out" } " writes the whole file." }
            }
        }
    }
}

fn difference(given: &str, improved: &str) -> Markup {
    let diff = TextDiff::from_lines(given, improved);
    let groups = diff.grouped_ops(AROUND);
    html! {
        @if groups.is_empty() {
            p.none { "Nothing changes." }
        } @else {
            pre.code.diff {
                @for (i, group) in groups.iter().enumerate() {
                    @if i > 0 { span.gap { "\u{22ee}" } }
                    @for change in group.iter().flat_map(|op| diff.iter_changes(op)) {
                        @let text = change.value().trim_end_matches(['\n', '\r']);
                        @match change.tag() {
                            ChangeTag::Equal => span { "  " (text) },
                            ChangeTag::Insert => span.new { "+ " (text) },
                            ChangeTag::Delete => span.old { "\u{2212} " (text) },
                        }
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::difference;

    #[test]
    fn only_what_changes_is_shown_and_it_is_escaped() {
        let given = (0..30).map(|i| format!("line {i}")).collect::<Vec<_>>().join("\n") + "\n";
        let improved = given.replace("line 3\n", "<b>\n").replace("line 25\n", "");
        let shown = difference(&given, &improved).into_string();
        for part in ["\u{2212} line 3<", "+ &lt;b&gt;<", "\u{2212} line 25<", "\u{22ee}"] {
            assert!(shown.contains(part), "no `{part}` in {shown}");
        }
        assert!(!shown.contains("line 15"), "{shown}");
        assert!(difference(&given, &given).into_string().contains("Nothing changes"));
    }
}
