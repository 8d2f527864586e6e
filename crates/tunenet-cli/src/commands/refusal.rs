//! What a model of the user's own refuses, a program or equations, reported as its own error: neither the recording nor the fit is to blame.

use tunenet_formats::Error;
use tunenet_sim::SimulationFile;
use tunenet_sim::simulation_file::Domain;

/// Which values it was asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Asked {
    /// Those of the file, to simulate them or to start a fit there.
    Present,
    /// Any within the bounds.
    Within,
}

/// A refusal by the program or the equations of `file`, or an unusable answer of it, and at which values; `None` for an
/// error that is neither.
pub fn of_program(file: &SimulationFile, asked: Asked, error: &tunenet_core::Error) -> Option<Error> {
    if !file.domain().declares() {
        return None;
    }
    let (tunenet_core::Error::Simulator { at, .. } | tunenet_core::Error::Prediction { at, .. }) = error else {
        return None;
    };
    let subject = match file.domain() {
        Domain::Process => "the program",
        Domain::Robot => "the robot",
        _ => "the equations",
    };
    let parameters = file.parameters().unwrap_or_default();
    let present = parameters.iter().map(|p| format!("{}={}", p.name, p.value)).collect::<Vec<_>>().join(" ");
    let example = parameters.first().map_or("NAME", |p| p.name.as_str());
    let values = match asked {
        Asked::Present if *at == present => format!("the file's own values ({at})"),
        _ => at.clone(),
    };
    let text = match error {
        tunenet_core::Error::Prediction { place, expected, found, .. } => {
            format!("{subject} answered {found} for {place} to {values}: expected {expected}")
        }
        tunenet_core::Error::Simulator { message, .. } => format!("{subject} refused {values}: {message}"),
        _ => return None,
    };
    let effects = if file.effects().is_empty() { "" } else { " or a number of `[effects.NAME]`" };
    let hint = match asked {
        Asked::Present => format!(
            "begin with values that it can simulate: change `[parameters.NAME] value`{effects} in the file, or `--set \
             parameters.{example}.value=…`"
        ),
        Asked::Within => "narrow the bounds of `[parameters.NAME]` to what it can simulate".into(),
    };
    Some(Error::file(file.path(), text, hint))
}
