//! What was checked before tuning, and what a person should know after it.

use maud::{Markup, html};
use tunenet_core::finding::Severity;
use tunenet_core::observation::Note;
use tunenet_core::observation::{Check, State};

use super::verdict::prose;

/// The checks of one recording, apart by how they ended.
pub fn checks(name: &str, checks: &[Check]) -> Markup {
    html! {
        @if checks.is_empty() {
            p.none { (name) ": no check was run." }
        } @else {
            table {
                caption { (name) ": " (counts(checks)) }
                thead { tr { th { "check" } th { "state" } th { "found" } } }
                tbody {
                    @for state in [State::Failed, State::Noticed, State::Passed, State::NotRun] {
                        @for check in checks.iter().filter(|c| c.state == state) {
                            tr {
                                th scope="row" { code { (check.kind) } }
                                td.state data-name="state" { (sign(state)) " " (state.name()) }
                                td {
                                    (prose(&check.text))
                                    @if !check.remedy.is_empty() { " " span.try { (prose(&check.remedy)) } }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

fn counts(checks: &[Check]) -> String {
    let count = |state: State| (checks.iter().filter(|c| c.state == state).count(), state.name());
    let all = [State::Passed, State::Noticed, State::Failed, State::NotRun].map(count);
    all.iter().filter(|(n, _)| *n > 0).map(|(n, name)| format!("{n} {name}")).collect::<Vec<_>>().join(", ")
}

fn sign(state: State) -> char {
    match state {
        State::Passed => '\u{2713}',
        State::Noticed => '!',
        State::Failed => '\u{2717}',
        State::NotRun => '\u{2013}',
    }
}

/// Warnings and notes with their remedies, the warnings first.
pub fn warnings(notes: &[Note]) -> Markup {
    let (warnings, others): (Vec<_>, Vec<_>) = notes.iter().partition(|n| n.kind.severity() == Severity::Warning);
    html! {
        @if notes.is_empty() {
            p.none { "None." }
        } @else {
            ul.plain {
                @for note in warnings.into_iter().chain(others) {
                    li {
                        b { (note.kind.severity().name()) } " " code { (note.kind) } " \u{b7} " (prose(&note.text))
                        @if !note.remedy.is_empty() { br; span.try { (prose(&note.remedy)) } }
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_stay_apart_and_texts_are_escaped() {
        let check = |state, text: &str| Check {
            kind: tunenet_ball::findings::CLOCK_GAPS,
            state,
            text: text.into(),
            remedy: String::new(),
        };
        let all = [check(State::NotRun, "no clock"), check(State::Passed, "<b>even</b>"), check(State::Failed, "none")];
        let page = checks("a.csv", &all).into_string();
        assert!(page.contains("1 passed, 1 failed, 1 not run") && page.contains("&lt;b&gt;even"), "{page}");
        assert!(page.find("\u{2717} failed") < page.find("\u{2713} passed"), "{page}");
        assert!(checks("a.csv", &[]).into_string().contains("no check was run"));
    }
}
