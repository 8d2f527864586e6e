//! Standard error: progress, notes and warnings; and how numbers, lists and tables read.

pub(crate) mod diagnose;
mod fit;
mod fitted;
pub(crate) mod law;
mod plain;
pub(crate) mod plan;
pub(crate) mod track;
pub(crate) mod tune;

pub use fit::FitProgress;

use std::io::{IsTerminal as _, Write as _};
use std::sync::atomic::{AtomicU8, Ordering};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressState, ProgressStyle};
use tunenet_core::finding::Severity;
use tunenet_core::observation::{Check, State};
use tunenet_core::observation::{Note, three_digits, with_decimals};
use tunenet_core::text::visible;
use tunenet_sim::Session;

/// How much a command says besides its answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verbosity {
    /// Only the answer and errors.
    Quiet,
    /// Notes, warnings and progress as well.
    Normal,
    /// Details as well.
    Verbose,
}

static VERBOSITY: AtomicU8 = AtomicU8::new(Verbosity::Normal as u8);

/// Sets how much this process says, once and before anything is printed.
pub fn set_verbosity(verbosity: Verbosity) {
    VERBOSITY.store(verbosity as u8, Ordering::Relaxed);
}

/// Whether details are asked for.
pub fn verbose() -> bool {
    VERBOSITY.load(Ordering::Relaxed) == Verbosity::Verbose as u8
}

fn quiet() -> bool {
    VERBOSITY.load(Ordering::Relaxed) == Verbosity::Quiet as u8
}

/// Hides a bar where nothing but the answer is asked for. Without a terminal lines take its place.
fn shown(bar: ProgressBar, state: impl Fn(&ProgressBar) -> String + Send + 'static) -> ProgressBar {
    if quiet() {
        return ProgressBar::hidden();
    }
    if !std::io::stderr().is_terminal() {
        plain::report(&bar, plain::INTERVAL, move |bar| note(&state(bar)));
    }
    bar
}

/// A progress bar on standard error; where that is no terminal, now and then a line.
pub fn progress(total: u64, what: &'static str) -> ProgressBar {
    let bar = shown(ProgressBar::new(total).with_message(what), plain::counted);
    let style = ProgressStyle::with_template("{msg:<10} [{bar:24}] {human_pos}/{human_len}, {eta} left {prefix}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> "));
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

/// Shows that work goes on where its end is not known; where standard error is no terminal, by a line now and then.
pub fn working(what: &'static str) -> ProgressBar {
    let bar = shown(ProgressBar::new_spinner().with_message(what), plain::elapsed);
    let style = ProgressStyle::with_template("{spinner} {msg}, {prefix}{elapsed}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()));
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

/// As [`working`], with the number of rollouts that the programs of `session` were asked for.
pub fn rolling(what: &'static str, session: &Session) -> ProgressBar {
    let asked = session.clone();
    let state = move |bar: &ProgressBar| plain::rolled(bar, asked.rollouts());
    let (bar, session) = (shown(ProgressBar::new_spinner().with_message(what), state), session.clone());
    let style = ProgressStyle::with_template("{spinner} {msg}, {rollouts} rollouts, {prefix}{elapsed}");
    let count = move |_: &ProgressState, to: &mut dyn std::fmt::Write| {
        let _ = write!(to, "{}", session.rollouts());
    };
    bar.set_style(style.map_or_else(|_| ProgressStyle::default_spinner(), |style| style.with_key("rollouts", count)));
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

/// How many rollouts it took: `120 rollouts, 4 re-asked`.
pub fn rolled_out(rollouts: usize, re_asks: u64) -> String {
    let again = if re_asks > 0 { format!(", {re_asks} re-asked") } else { String::new() };
    format!("{rollouts} rollouts{again}")
}

/// Prints a line to standard error. Where that cannot be written, as on a full disk, the line is lost: neither the result nor
/// the exit status depends on it.
pub fn to_stderr(line: impl std::fmt::Display) {
    let _ = writeln!(anstream::stderr().lock(), "{line}");
}

/// Prints a line of notes to standard error.
pub fn note(text: &str) {
    if !quiet() {
        to_stderr(visible(text));
    }
}

/// Prints a finished stage to standard error: `read     drop.csv, 360 samples`.
pub fn stage(what: &str, text: &str) {
    if quiet() {
        return;
    }
    to_stderr(format_args!("{what:<9}{}", visible(text)));
}

/// `text` without what a stranger's file could hide in it; our own ends of lines stay.
pub fn lines(text: &str) -> String {
    text.split('\n').map(visible).collect::<Vec<_>>().join("\n")
}

/// What to try, as it stands behind `try: `.
pub fn without_try(hint: &str) -> &str {
    hint.strip_prefix("try ").unwrap_or(hint)
}

/// Prints notes and warnings to standard error: those of one kind and remedy together, with the remedy once below them.
pub fn warn_all(notes: &[Note]) {
    let alike = |a: &Note, b: &Note| a.kind == b.kind && a.remedy == b.remedy;
    for (i, note) in notes.iter().enumerate() {
        if notes[..i].iter().any(|other| alike(other, note)) {
            continue;
        }
        let mut group: Vec<&Note> = notes[i..].iter().filter(|other| alike(other, note)).collect();
        group.dedup();
        for (number, one) in group.iter().enumerate() {
            let remedy = if number + 1 < group.len() { String::new() } else { one.remedy.clone() };
            warn(&Note { remedy, ..(*one).clone() });
        }
    }
}

/// Prints a note or a warning with its remedy to standard error.
pub fn warn(note: &Note) {
    if quiet() {
        return;
    }
    let severity = note.kind.severity();
    let accent = match severity {
        Severity::Note => anstyle::AnsiColor::Cyan,
        Severity::Warning => anstyle::AnsiColor::Yellow,
    };
    let (style, reset) = (accent.on_default().bold(), anstyle::Reset);
    to_stderr(format_args!("{style}{}{reset}[{}]: {}", severity.name(), note.kind, lines(&note.text)));
    if !note.remedy.is_empty() {
        to_stderr(format_args!("  try: {}", lines(without_try(&note.remedy))));
    }
}

/// "9 passed, 2 noticed, 1 not run".
pub fn tally(checks: &[Check]) -> String {
    let states = [State::Passed, State::Noticed, State::Failed, State::NotRun];
    let counts = states.map(|state| (checks.iter().filter(|c| c.state == state).count(), state.name()));
    counts.iter().filter(|(n, _)| *n > 0).map(|(n, name)| format!("{n} {name}")).collect::<Vec<_>>().join(", ")
}

/// Lines with columns two spaces apart: those that hold numbers are right-aligned, those of words, and the first,
/// left-aligned.
pub fn table(rows: &[Vec<String>]) -> String {
    let rows: Vec<Vec<String>> = rows.iter().map(|row| row.iter().map(|cell| visible(cell)).collect()).collect();
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |c: usize| rows.iter().filter_map(|r| r.get(c)).map(|s| s.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let numeric = |cell: &String| cell.trim_start_matches('-').starts_with(|first: char| first.is_ascii_digit());
    let words: Vec<bool> = (0..columns).map(|c| c == 0 || !rows.iter().filter_map(|r| r.get(c)).any(numeric)).collect();
    let line = |row: &Vec<String>| {
        let cells = row.iter().enumerate().map(|(c, cell)| {
            let pad = " ".repeat(widths[c] - cell.chars().count());
            if words[c] { format!("{cell}{pad}") } else { format!("{pad}{cell}") }
        });
        format!("  {}", cells.collect::<Vec<_>>().join("  ").trim_end())
    };
    rows.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// Columns of a line of people's text, as of the help.
const LINE: usize = 100;

/// Most names that a message lists.
const MOST_LISTED: usize = 12;

/// Names in a message.
pub fn listed<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let names: Vec<String> = names.into_iter().map(|name| format!("`{}`", visible(name))).collect();
    match names.len().saturating_sub(MOST_LISTED) {
        0 if names.is_empty() => "none".into(),
        0 => names.join(", "),
        more => format!("{} and {more} more", names[..MOST_LISTED].join(", ")),
    }
}

/// `lead` and then `items` with commas, broken between items into lines that are indented as `lead` is long.
pub fn list(lead: &str, items: &[String]) -> String {
    let indent = lead.chars().count() + 1;
    let (mut text, mut column) = (lead.to_string(), indent - 1);
    for (i, item) in items.iter().enumerate() {
        let comma = usize::from(i + 1 < items.len());
        let width = item.chars().count() + comma;
        if i > 0 && column + 1 + width > LINE {
            text = format!("{text}\n{}", " ".repeat(indent - 1));
            column = indent - 1;
        }
        text = format!("{text} {item}{}", if comma == 1 { "," } else { "" });
        column += 1 + width;
    }
    text
}

/// No measurement of a ball is worth more digits.
const MOST_DECIMALS: f64 = 8.0;
const SMALL: f64 = 1e-4;

/// A number with as many decimals as two digits of its uncertainty need.
pub fn rounded(value: f64, half_width: f64) -> String {
    if !half_width.is_finite() || half_width <= 0.0 {
        return with_decimals(value, 6);
    }
    let decimals = 1.0 - half_width.log10().floor();
    // Smaller numbers are written with a power of ten.
    if decimals > MOST_DECIMALS && value != 0.0 && value.abs() < SMALL {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        let digits = (decimals + value.abs().log10().floor()).clamp(0.0, MOST_DECIMALS) as usize;
        return format!("{value:.digits$e}");
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    let decimals = decimals.clamp(0.0, MOST_DECIMALS) as usize;
    with_decimals(value, decimals)
}

/// A range of two numbers; a dash next to a sign would be read as one.
pub fn between(low: &str, high: &str) -> String {
    if low.starts_with('-') || high.starts_with('-') { format!("{low} to {high}") } else { format!("{low}–{high}") }
}

/// A number with at most four significant digits, and no zeros that say nothing.
pub fn four_digits(value: f64) -> String {
    let short: f64 = format!("{value:.3e}").parse().unwrap_or(value);
    // A number with that many digits or fewer stands as it is.
    if short.abs() >= 1e7 || short != 0.0 && short.abs() < 1e-4 { format!("{short:e}") } else { format!("{short}") }
}

/// A length or time in the unit that reads best: 0.0091 m is `9.1 mm`.
pub fn in_words(value: f64, unit: &str) -> String {
    let small = match unit {
        "m" => Some("mm"),
        "s" => Some("ms"),
        _ => None,
    };
    match small {
        Some(small) if value.abs() < 0.1 => format!("{} {small}", three_digits(value * 1e3)),
        _ => format!("{} {unit}", three_digits(value)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        assert_eq!(rounded(0.732_04, 0.0015), "0.7320");
        assert_eq!([rounded(1.234e99, 0.0), rounded(-1.234e99, 1e97)], ["1.23e99", "-1.23e99"]);
        assert_eq!(four_digits(0.029_275_664_634), "0.02928");
        assert_eq!([0.0, 0.5, 2.805, -1234.56, 3e-9].map(four_digits), ["0", "0.5", "2.805", "-1235", "3e-9"]);
        assert_eq!(between("-0.2", "-0.1"), "-0.2 to -0.1");
        assert_eq!(between("0.1", "0.2"), "0.1–0.2");
        assert_eq!(in_words(0.009_14, "m"), "9.14 mm");
        assert_eq!(in_words(12.345, "m"), "12.3 m");
        assert_eq!(in_words(2e-9, "m"), "2.0e-6 mm");
        assert_eq!(in_words(1.234e99, "m"), "1.23e99 m");
        assert_eq!(table(&[vec!["a".into(), "10".into()], vec!["bcd".into(), "2".into()]]), "  a    10\n  bcd   2");
        let words = [vec!["a".into(), "one".into(), "-1".into()], vec!["b".into(), "- no".into(), "10".into()]];
        assert_eq!(table(&words), "  a  one   -1\n  b  - no  10");
    }

    #[test]
    fn long_lists_break_between_items() {
        let items: Vec<String> = (0..30).map(|i| format!("item {i}")).collect();
        let text = list("  all:", &items);
        assert!(text.lines().count() > 1 && text.lines().all(|l| l.len() <= LINE), "{text}");
        assert!(text.lines().skip(1).all(|l| l.starts_with("       item")), "{text}");
        assert_eq!(text.split_whitespace().collect::<Vec<_>>().join(" "), format!("all: {}", items.join(", ")));
    }
}
