//! Errors, printed once.

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use tunenet_core::Origin;

use crate::exit_status::Exit;
use crate::view::text::{lines, to_stderr, without_try};

/// A library's error, whose kind decides how it is printed and how the process ends.
#[derive(Debug, Clone, Copy)]
enum Known<'a> {
    /// Of a file: never [`tunenet_formats::Error::Core`].
    File(&'a tunenet_formats::Error),
    /// Of anything else: no [`tunenet_core::Error::Supplied`] that carries one of these.
    Core(&'a tunenet_core::Error),
}

impl<'a> Known<'a> {
    /// What stands in one place of a chain of causes, taken out of the error that carries it.
    fn of(cause: &'a (dyn std::error::Error + 'static)) -> Option<Self> {
        match cause.downcast_ref::<tunenet_formats::Error>() {
            Some(tunenet_formats::Error::Core(own)) => Some(Self::of_core(own)),
            Some(file) => Some(Self::File(file)),
            None => cause.downcast_ref::<tunenet_core::Error>().map(Self::of_core),
        }
    }

    fn of_core(error: &'a tunenet_core::Error) -> Self {
        match error {
            tunenet_core::Error::Supplied(carried) => Self::of(carried.as_ref()).unwrap_or(Self::Core(error)),
            own => Self::Core(own),
        }
    }

    fn exit(self) -> Exit {
        match self {
            Self::Core(
                tunenet_core::Error::Setting { origin: Origin::Flag | Origin::Caller, .. }
                | tunenet_core::Error::DeviceUnsupported { .. },
            ) => Exit::Usage,
            Self::Core(_) | Self::File(_) => Exit::Refused,
        }
    }

    /// What is wrong with an option, by its name on the command line; core names it by its setting.
    fn of_flag(self) -> Option<String> {
        match self {
            Self::Core(tunenet_core::Error::Setting { origin: Origin::Flag, name, expected, found })
                if !name.starts_with('-') =>
            {
                Some(format!("`--{}`: expected {expected}, found {found}", name.replace('_', "-")))
            }
            _ => None,
        }
    }

    /// What to try. Core names no command, so what to type after its errors is said here.
    fn hint(self) -> Option<&'a str> {
        match self {
            Self::File(error) => error.hint(),
            Self::Core(tunenet_core::Error::DeviceUnsupported { .. }) => {
                Some("install one with it: `cargo install --locked --path crates/tunenet-cli --features cuda`")
            }
            Self::Core(tunenet_core::Error::Device { .. }) => Some("check `nvidia-smi`, or train with `--device cpu`"),
            Self::Core(tunenet_core::Error::Model { .. }) => {
                Some("train a model for this scene: `tunenet gen`, then `tunenet train`")
            }
            Self::Core(_) => None,
        }
    }
}

/// Prints an error to standard error and says how the process ends.
pub fn render(error: &anyhow::Error) -> Exit {
    let known = error.chain().find_map(Known::of);
    let exit = known.map_or(Exit::Refused, Known::exit);
    if let Some(Known::File(tunenet_formats::Error::Text { path, line, column, width, source_line, message, hint })) =
        known
    {
        to_stderr(snippet(&path.display().to_string(), *line, *column, *width, source_line, message, hint));
        return exit;
    }
    let (red, reset) = (anstyle::AnsiColor::Red.on_default().bold(), anstyle::Reset);
    to_stderr(format_args!("{red}error{reset}: {}", lines(&sentence(error))));
    if let Some(hint) = hint(error) {
        let cyan = anstyle::AnsiColor::Cyan.on_default().bold();
        to_stderr(format_args!("{cyan}help{reset}: {}", lines(hint)));
    }
    exit
}

/// The whole chain in one sentence; what a message already ends with is not said again.
pub fn sentence(error: &anyhow::Error) -> String {
    let mut text = String::new();
    let mut complete = false;
    for cause in error.chain() {
        let said = Known::of(cause).and_then(Known::of_flag).unwrap_or_else(|| cause.to_string());
        if text.is_empty() {
            text = said;
        } else if !complete && !text.ends_with(&said) {
            text = format!("{text}: {said}");
        }
        // The message of a file's error says what the system said.
        complete |= matches!(Known::of(cause), Some(Known::File(_)));
    }
    text
}

/// The offending line with a caret under what is wrong.
fn snippet(path: &str, line: usize, column: usize, width: usize, source: &str, message: &str, hint: &str) -> String {
    let byte = |characters: usize| source.char_indices().nth(characters).map_or(source.len(), |(at, _)| at);
    let (start, end) = (byte(column - 1), byte(column - 1 + width));
    let place = Snippet::source(source)
        .line_start(line)
        .path(path)
        .annotation(AnnotationKind::Primary.span(start..end.max(start)));
    let mut report: Vec<Group> = vec![Level::ERROR.primary_title(message).element(place)];
    if !hint.is_empty() {
        report.push(Group::with_title(Level::HELP.secondary_title(hint)));
    }
    Renderer::styled().render(&report)
}

/// What to try after an error, where there is anything.
pub fn hint(error: &anyhow::Error) -> Option<&str> {
    error.chain().find_map(Known::of).and_then(Known::hint)
}

/// Why something is refused, and what to try.
pub fn refusal(error: &anyhow::Error) -> String {
    hint(error).map_or_else(|| sentence(error), |hint| format!("{}; try: {}", sentence(error), without_try(hint)))
}

#[cfg(test)]
mod tests {
    use anyhow::Context;

    use super::*;

    fn of(error: &anyhow::Error) -> (Exit, Option<&str>) {
        let known = error.chain().find_map(Known::of);
        (known.map_or(Exit::Refused, Known::exit), known.and_then(Known::hint))
    }

    fn setting(origin: Origin) -> tunenet_core::Error {
        tunenet_core::Error::Setting { origin, name: "rate", expected: "more".into(), found: "less".into() }
    }

    #[test]
    fn an_error_counts_the_same_whoever_carries_it() {
        let file = || tunenet_formats::Error::file("a.csv", "empty", "record it");
        for carried in [
            anyhow::Error::new(file()),
            anyhow::Error::new(tunenet_core::Error::from(file())),
            Err::<(), _>(tunenet_core::Error::from(file())).context("a recording").unwrap_err(),
        ] {
            assert_eq!(of(&carried), (Exit::Refused, Some("record it")), "{carried:?}");
        }
        for (origin, exit) in
            [(Origin::Flag, Exit::Usage), (Origin::Caller, Exit::Usage), (Origin::File, Exit::Refused)]
        {
            assert_eq!(of(&setting(origin).into()), (exit, None));
            assert_eq!(of(&tunenet_formats::Error::from(setting(origin)).into()), (exit, None));
        }
    }

    #[test]
    fn a_device_that_the_build_lacks_is_wrong_usage_and_says_how_to_get_it() {
        let device = tunenet_core::network::TrainDevice::Cuda;
        let error = tunenet_core::Error::DeviceUnsupported { device }.into();
        let (exit, hint) = of(&error);
        assert_eq!(exit, Exit::Usage);
        assert!(hint.is_some_and(|hint| hint.ends_with("--features cuda`")), "{hint:?}");
    }

    #[test]
    fn a_missing_file_is_said_once() {
        let missing =
            tunenet_formats::Error::io("a.csv", tunenet_formats::Action::Opening, std::io::Error::from_raw_os_error(2));
        assert_eq!(sentence(&missing.into()), "a.csv: no such file");
    }

    #[test]
    fn what_to_try_says_so_once() {
        let several = tunenet_formats::Error::file("a.mcap", "several topics can be used", "try `--topic /joints`");
        assert_eq!(refusal(&several.into()), "a.mcap: several topics can be used; try: `--topic /joints`");
    }

    #[test]
    fn an_unknown_error_is_a_refusal_without_a_hint() {
        assert_eq!(of(&anyhow::anyhow!("something")), (Exit::Refused, None));
    }
}
