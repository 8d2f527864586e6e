//! What a simulation file says of the program that simulates.

use std::path::{MAIN_SEPARATOR, Path, PathBuf};
use std::sync::OnceLock;
use std::time::Duration;

use serde_json::{Map, Value as Json};
use toml_edit::{Item, TableLike, Value};
use tunenet_core::observation::Channel;
use tunenet_core::simulator::{Effect, Parameter};
use tunenet_formats::{Error, Result};

use super::failure::printable;
use super::version::Version;
use crate::SimulationFile;
use crate::declared::{self, DeclaredInput};
use crate::scene::StartValue;

/// How many instants every copy of the program is asked for first.
const PROBED: usize = 4096;

/// A program, and how to speak with it.
#[derive(Debug, Clone)]
pub(super) struct Program {
    /// The simulation file that names it.
    pub file: PathBuf,
    /// Its name or path, then its arguments.
    pub command: Vec<String>,
    /// Where it runs.
    pub folder: PathBuf,
    /// How long it may take to answer.
    pub timeout: Duration,
    /// How long it may take to start.
    pub start_timeout: Duration,
    /// How many of it may run at a time.
    pub workers: usize,
    pub channels: Vec<Channel>,
    /// The names of the channels with their units, as the file has them.
    pub headers: Vec<String>,
    pub parameters: Vec<Parameter>,
    /// What drives the thing.
    pub inputs: Vec<DeclaredInput>,
    /// Names of its states.
    pub states: Vec<String>,
    /// The effects that it can take on.
    pub candidates: Vec<Effect>,
    /// The settings of each setup of its recordings; at least one.
    pub settings: Vec<Json>,
    /// What every copy is asked first; `None` where only a recording has what that takes.
    pub probe: Option<Probe>,
    /// Which version of the protocol it speaks, once that is known.
    pub speaks: OnceLock<Version>,
}

/// A rollout of the file's own values.
#[derive(Debug, Clone)]
pub(super) struct Probe {
    pub coefficients: Vec<f64>,
    pub start: Vec<f64>,
    pub times_s: Vec<f64>,
}

impl Program {
    /// What the files of all setups of its recordings say, of which there is at least one and which name the same program.
    ///
    /// # Errors
    /// [`Error::File`] where its folder is none, or a channel cannot be one.
    pub fn of(files: &[&SimulationFile]) -> Result<Self> {
        let file = files[0];
        let folder = file.program_folder();
        let folder = folder.canonicalize().ok().filter(|folder| folder.is_dir()).ok_or_else(|| {
            let message = format!("`process.folder`: expected a folder, found none at {}", folder.display());
            Error::file(file.path(), message, "make it, or correct the path, which is seen from the simulation file")
        })?;
        let process = file.process()?;
        let channels = declared::channels(file)?;
        declared::refuse_scale_without_lengths(file, &channels)?;
        Ok(Self {
            file: file.path().to_path_buf(),
            command: words(file),
            folder,
            timeout: Duration::from_secs_f64(process.timeout_s),
            start_timeout: Duration::from_secs_f64(process.start_timeout_s),
            workers: process.workers.unwrap_or_else(rayon::current_num_threads).max(1),
            headers: process.channels.clone(),
            channels,
            parameters: file.parameters()?,
            inputs: declared::inputs(file)?,
            states: file.starts().map(|(name, _)| name.to_owned()).collect(),
            candidates: declared::candidates(file),
            settings: files.iter().map(|file| settings(file)).collect(),
            probe: probe(file),
            speaks: OnceLock::new(),
        })
    }

    /// The settings of a setup.
    pub fn settings(&self, setup: usize) -> &Json {
        self.settings.get(setup).unwrap_or(&self.settings[0])
    }

    /// What it has to speak protocol 2 for, in words; `None` where protocol 1 suffices.
    pub fn beyond_one(&self) -> Option<String> {
        let each = |what: &str, names: Vec<&str>| {
            let names: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
            let ending = if names.len() == 1 { "" } else { "s" };
            (!names.is_empty()).then(|| format!("{what}{ending} {}", names.join(", ")))
        };
        let all = [
            each("input", self.inputs.iter().map(|i| i.name.as_str()).collect()),
            each("state", self.states.iter().map(String::as_str).collect()),
            each("candidate", self.candidates.iter().map(|effect| &*effect.name).collect()),
        ];
        let all: Vec<String> = all.into_iter().flatten().collect();
        (!all.is_empty()).then(|| all.join(" and "))
    }

    /// What is started: a name without a folder is looked for on the path, any other from the program's folder.
    pub fn executable(&self) -> PathBuf {
        let name = &self.command[0];
        if name.contains('/') || name.contains(MAIN_SEPARATOR) {
            self.folder.join(name)
        } else {
            Path::new(name).into()
        }
    }

    /// `python3 bouncer.py`, in backquotes.
    pub fn shown(&self) -> String {
        shown(&self.command)
    }
}

fn settings(file: &SimulationFile) -> Json {
    file.item("settings").and_then(json).unwrap_or_else(|| Json::Object(Map::new()))
}

/// The first question: the file's own values on the clock of `[record]`, unless a recording has to say what drives the thing or
/// where it starts.
fn probe(file: &SimulationFile) -> Option<Probe> {
    if file.inputs().len() > 0 {
        return None;
    }
    let number = |value: StartValue| if let StartValue::Number(value) = value { Some(value) } else { None };
    let start: Option<Vec<f64>> = file.starts().map(|(_, start)| number(start.value)).collect();
    Some(Probe {
        coefficients: declared::present(file),
        start: start?,
        times_s: file.record().clock().into_iter().take(PROBED).collect(),
    })
}

/// The program that `file` names and its arguments, word by word; never empty.
#[must_use]
pub fn words(file: &SimulationFile) -> Vec<String> {
    let words = file.process().map_or_else(|_| Vec::new(), |process| process.command.clone());
    // The schema asks for one; what asks for a program's first word must find it.
    if words.is_empty() { vec![String::new()] } else { words }
}

/// A command for users, shortened where it is long.
pub(super) fn shown(command: &[String]) -> String {
    format!("`{}`", printable(&line(command)))
}

/// A command in shell syntax: words with other than safe characters are quoted.
pub(super) fn line(command: &[String]) -> String {
    let safe = |c: char| c.is_ascii_alphanumeric() || "_-./:=,@%+".contains(c);
    let word = |word: &String| {
        if !word.is_empty() && word.chars().all(safe) {
            word.clone()
        } else {
            format!("'{}'", word.replace('\'', "'\\''"))
        }
    };
    command.iter().map(word).collect::<Vec<_>>().join(" ")
}

/// What TOML holds as JSON; dates and times become texts, and numbers that JSON has no word for nothing.
fn json(item: &Item) -> Option<Json> {
    match item {
        Item::None => None,
        Item::Value(value) => Some(of_value(value)),
        Item::Table(table) => Some(of_table(table)),
        Item::ArrayOfTables(all) => Some(Json::Array(all.iter().map(|one| of_table(one)).collect())),
    }
}

fn of_table(table: &dyn TableLike) -> Json {
    Json::Object(table.iter().filter_map(|(key, item)| Some((key.to_owned(), json(item)?))).collect())
}

fn of_value(value: &Value) -> Json {
    match value {
        Value::String(text) => text.value().as_str().into(),
        Value::Integer(number) => (*number.value()).into(),
        Value::Float(number) => (*number.value()).into(),
        Value::Boolean(flag) => (*flag.value()).into(),
        Value::Datetime(date) => date.value().to_string().into(),
        Value::Array(all) => Json::Array(all.iter().map(of_value).collect()),
        Value::InlineTable(table) => of_table(table),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: &str = "kind = \"process\"\n[process]\ncommand = [\"./a.py\", \"-x\"]\nchannels = [\"z_m\"]\n\
        [parameters.k]\nvalue = 1\nmin = 0\nmax = 2\n";

    #[test]
    fn settings_become_what_they_say() {
        let text = format!(
            "{SCENE}[settings]\nstep_s = 0.001\ncount = 3\nname = \"<b>\"\non = true\nlist = [1, 2.5]\nwhen = 2020-01-02\n[settings.deep]\nx = {{ y = 1 }}\n"
        );
        let file = SimulationFile::parse(Path::new("a.toml"), &text).unwrap();
        let program = Program::of(&[&file]).unwrap();
        let expected = r#"{"step_s":0.001,"count":3,"name":"<b>","on":true,"list":[1,2.5],"when":"2020-01-02","deep":{"x":{"y":1}}}"#;
        assert_eq!(program.settings[0].to_string(), expected);
        assert_eq!(program.parameters[0].span(), 2.0);
        assert!(program.executable().is_absolute() && program.executable().ends_with("a.py"));
        // The record is shorter than a probe may be.
        assert!(file.record().clock().len() < PROBED);
        assert_eq!(program.probe.unwrap().times_s, file.record().clock());
        assert_eq!(program.timeout, Duration::from_secs(10));
    }

    #[test]
    fn words_are_distinguished() {
        let words = ["sh", "-c", "touch a; cat", "", "it's", "--x=1", "~", "*"].map(str::to_owned);
        assert_eq!(line(&words), r"sh -c 'touch a; cat' '' 'it'\''s' --x=1 '~' '*'");
        assert_eq!(shown(&["a\nb".to_owned()]), "`'a\u{fffd}b'`");
    }

    #[test]
    fn a_name_alone_is_looked_for_on_the_path() {
        let text = SCENE.replace("./a.py", "python3");
        let file = SimulationFile::parse(Path::new("a.toml"), &text).unwrap();
        assert_eq!(Program::of(&[&file]).unwrap().executable(), Path::new("python3"));
    }

    #[test]
    fn a_scale_of_lengths_needs_a_length() {
        let text = format!("{}[effects.length_scale]\nfactor = 1.1\n", SCENE.replace("z_m", "angle_rad"));
        let file = SimulationFile::parse(Path::new("a.toml"), &text).unwrap();
        assert!(Program::of(&[&file]).unwrap_err().to_string().contains("a channel in m"));
    }
}
