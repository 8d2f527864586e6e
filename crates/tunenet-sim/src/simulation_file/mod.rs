//! The simulation file: one TOML file that describes a simulation completely, read, overridden, and written back with its
//! comments and its order kept.

mod arm_effects;
mod arm_schema;
pub(crate) mod check;
mod domain;
mod effects;
mod permission;
pub(crate) mod process_schema;
pub mod schema;
mod tally;
mod template;

use std::path::{Path, PathBuf};

use toml_edit::{Document, DocumentMut, Item, Table, Value};
use tunenet_core::observation::recording::read_text;
use tunenet_core::simulator::Parameter;
use tunenet_core::{Error, Result};

pub use arm_effects::{ARM_EFFECT_KEYS, PresentArmEffect};
pub use arm_schema::ARM_KEYS;
pub use domain::{Definition, Domain};
pub use effects::PresentEffect;
pub use permission::Permission;
pub(crate) use permission::Settles;
pub use process_schema::{PROCESS_EFFECT_KEYS, PROCESS_KEYS};
pub(crate) use tally::{Tally, Why};
pub use template::template;

use schema::item_number;

/// How a ball's scene may start, record by record: what is `None` is estimated from the data.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Release {
    /// Height of fall, from the ball's lowest point to the surface, m.
    pub height_m: Option<f64>,
    /// Start of the centre, m.
    pub position_m: Option<[f64; 3]>,
    /// Start velocity, m/s.
    pub velocity_m_s: Option<[f64; 3]>,
    /// Spin, rad/s.
    pub spin_rad_s: Option<[f64; 3]>,
    /// When it is let go, s.
    pub time_s: Option<f64>,
}

/// What `simulate` and `gen` write.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Record {
    /// Frames per second.
    pub rate_hz: f64,
    /// How many.
    pub frames: usize,
}

impl Record {
    /// The instants of the frames, s, from 0.
    #[must_use]
    pub fn clock(&self) -> Vec<f64> {
        (0..self.frames).map(|i| i as f64 / self.rate_hz).collect()
    }
}

impl Default for Record {
    fn default() -> Self {
        Self { rate_hz: 120.0, frames: 360 }
    }
}

/// A simulation file, checked.
#[derive(Debug, Clone)]
pub struct SimulationFile {
    path: PathBuf,
    document: DocumentMut,
    permission: Option<Permission>,
}

impl SimulationFile {
    /// Reads and checks the file at `path`.
    ///
    /// # Errors
    /// [`Error::Io`] where it cannot be read; [`Error::File`] where it is no text in UTF-8; [`Error::Text`] with line and column where it is not TOML, holds an unknown
    /// key, a value of the wrong kind or outside its bounds; [`Error::File`] where a key is missing.
    pub fn read(path: &Path) -> Result<Self> {
        Self::parse(path, &read_text(path)?)
    }

    /// Checks `text` as the content of `path`.
    ///
    /// # Errors
    /// As [`SimulationFile::read`].
    pub fn parse(path: &Path, text: &str) -> Result<Self> {
        let document = Document::parse(text).map_err(|e| {
            let span = e.span().unwrap_or(0..0);
            check::located(
                path,
                text,
                span,
                e.message().to_string(),
                "a simulation file is TOML, `key = value` lines under [table] heads; is this the recording?",
            )
        })?;
        check::document(path, text, document.as_table())?;
        Ok(Self { path: path.to_path_buf(), document: document.into_mut(), permission: None })
    }

    /// Overrides one key, as `--set TABLE.KEY=VALUE` does.
    ///
    /// # Errors
    /// [`Error::Setting`] where the text is not of that form, the key is unknown, or the value does not fit it.
    pub fn set(&mut self, assignment: &str) -> Result<()> {
        let refuse = |expected: String, found: String| Err(Error::Setting { name: "--set", expected, found });
        let Some((path, text)) = assignment.split_once('=') else {
            return refuse("TABLE.KEY=VALUE".into(), format!("`{assignment}`"));
        };
        let (path, text) = (path.trim(), text.trim());
        let Some(key) = self.domain().find(path) else {
            let known = self.domain().siblings(path).join(", ");
            return refuse(format!("a key of a simulation file ({known})"), format!("`{path}`"));
        };
        let value: Value = text.parse().unwrap_or_else(|_| Value::from(text));
        if !key.shape.accepts(&value) {
            return refuse(format!("{} for `{path}`", key.shape.expected()), format!("`{text}`"));
        }
        if let (Domain::Process, ["parameters", name, ..]) = (self.domain(), &*path.split('.').collect::<Vec<_>>()) {
            let known = check::names(Domain::Process, self.document.as_table());
            if !known.contains(name) {
                return refuse(format!("a parameter of the file ({})", known.join(", ")), format!("`{name}`"));
            }
        }
        let mut table = self.document.as_table_mut();
        let parts: Vec<&str> = path.split('.').collect();
        for part in &parts[..parts.len() - 1] {
            let item = table.entry(part).or_insert_with(|| Item::Table(Table::new()));
            let Some(inner) = item.as_table_mut() else {
                return refuse(format!("`{part}` as a [table]"), "something else in the file".into());
            };
            table = inner;
        }
        table[parts[parts.len() - 1]] = Item::Value(value);
        if let (Domain::Arm, ["parameters", name, "value"]) = (self.domain(), parts.as_slice()) {
            // Who says a value knows it: what an earlier tuning was sure of it is another value's.
            self.unset(&format!("provenance.interval95.{name}"));
        }
        check::contradiction(self.domain(), self.document.as_table())
            .map_or(Ok(()), |(path, _, expected, found)| refuse(format!("{expected} for `{path}`"), found))
    }

    /// Removes the key at `path`, as if the file had left it out.
    pub fn unset(&mut self, path: &str) {
        let Some((tables, key)) = path.rsplit_once('.') else { return };
        let mut item = Some(self.document.as_item_mut());
        for table in tables.split('.') {
            item = item.and_then(|item| item.as_table_like_mut()?.get_mut(table));
        }
        if let Some(table) = item.and_then(Item::as_table_like_mut) {
            table.remove(key);
        }
    }

    /// The file's path.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The file as text.
    #[must_use]
    pub fn text(&self) -> String {
        self.document.to_string()
    }

    /// What the file describes.
    #[must_use]
    pub fn domain(&self) -> Domain {
        // Checked where the file was read; `--set` cannot change it.
        self.item("kind").and_then(Item::as_str).and_then(Domain::named).unwrap_or(Domain::Ball)
    }

    /// The parameters in the order of [`Domain::parameters`]; those left out stand at their default. Of a program those that the
    /// file describes, in its order.
    ///
    /// # Errors
    /// [`Error::Parameter`] where bounds and value contradict each other.
    pub fn parameters(&self) -> Result<Vec<Parameter>> {
        if self.domain() == Domain::Process {
            return self.named_parameters();
        }
        let each = self.domain().parameters().iter().map(|known| {
            let (name, [value, min, max]) = (known.name, known.default);
            let Some(table) = self.item(&format!("parameters.{name}")).and_then(Item::as_table_like) else {
                return Ok(Parameter { tune: known.tune, ..Parameter::new(name, known.unit, value, min, max)? });
            };
            let number = |field: &str, default: f64| table.get(field).and_then(item_number).unwrap_or(default);
            let tune = table.get("tune").and_then(Item::as_bool).unwrap_or(true);
            let unit = table.get("unit").and_then(Item::as_str).unwrap_or(known.unit);
            let parameter = Parameter::new(name, unit, number("value", value), number("min", min), number("max", max))?;
            let known95 = if tune { None } else { self.known95(name, parameter.value) };
            Ok(Parameter { tune, known95, ..parameter })
        });
        each.collect()
    }

    fn named_parameters(&self) -> Result<Vec<Parameter>> {
        let each = check::names(Domain::Process, self.document.as_table()).into_iter().map(|name| {
            let field = |field: &str| self.item(&format!("parameters.{name}.{field}"));
            let number = |key: &str| field(key).and_then(item_number).unwrap_or(0.0);
            let unit = field("unit").and_then(Item::as_str).unwrap_or("1");
            let parameter = Parameter::new(name, unit, number("value"), number("min"), number("max"))?;
            Ok(Parameter { tune: field("tune").and_then(Item::as_bool).unwrap_or(true), ..parameter })
        });
        each.collect()
    }

    /// The 95 % interval of a parameter that an earlier tuning wrote into `[provenance]`.
    #[must_use]
    pub fn tuned95(&self, name: &str) -> Option<(f64, f64)> {
        let ends: [f64; 2] = self.numbers(&format!("provenance.interval95.{name}"))?.try_into().ok()?;
        (ends[0] < ends[1]).then_some((ends[0], ends[1]))
    }

    /// How well an arm's value is known that an earlier tuning wrote into the file and that stands there still.
    fn known95(&self, name: &str, value: f64) -> Option<(f64, f64)> {
        self.tuned95(name).filter(|(low, high)| self.domain() == Domain::Arm && (*low..=*high).contains(&value))
    }

    /// What determines how this file's thing moves while it is tuned, in a fixed order: neither comments, nor what is
    /// recorded, nor the values that tuning is to find.
    #[must_use]
    pub fn essence(&self) -> String {
        let keys = self.domain().keys().filter(|key| !key.path.starts_with("record."));
        let scene = keys.filter_map(|key| {
            let mut value = self.item(&key.path)?.as_value()?.clone();
            value.decor_mut().clear();
            Some(format!("{}={value}", key.path))
        });
        let parameters = self.parameters().unwrap_or_default().into_iter().map(|p| {
            let value = if p.tune { "tuned".into() } else { p.value.to_string() };
            format!("{}={value} in {} to {}", p.name, p.min, p.max)
        });
        scene.chain(parameters).collect::<Vec<_>>().join("\n")
    }

    /// How the ball starts.
    #[must_use]
    pub fn release(&self) -> Release {
        Release {
            height_m: self.number("release.height_m"),
            position_m: self.vector("release.position_m"),
            velocity_m_s: self.vector("release.velocity_m_s"),
            spin_rad_s: self.vector("release.spin_rad_s"),
            time_s: self.number("release.time_s"),
        }
    }

    /// What is written of a rollout.
    #[must_use]
    pub fn record(&self) -> Record {
        let default = Record::default();
        let frames = self.item("record.frames").and_then(Item::as_integer).and_then(|n| usize::try_from(n).ok());
        Record {
            rate_hz: self.number("record.rate_hz").unwrap_or(default.rate_hz),
            frames: frames.unwrap_or(default.frames),
        }
    }

    /// The number at `path`, where there is one.
    #[must_use]
    pub fn number(&self, path: &str) -> Option<f64> {
        self.item(path).and_then(item_number)
    }

    /// Whether the ball moves in air, as it does where nothing else is said.
    #[must_use]
    pub fn in_air(&self) -> bool {
        self.item("world.medium").and_then(Item::as_str).is_none_or(|medium| medium == "air")
    }

    /// The text at `path`, where there is one.
    #[must_use]
    pub fn text_at(&self, path: &str) -> Option<&str> {
        self.item(path).and_then(Item::as_str)
    }

    /// The numbers of the list at `path`, where there is one.
    #[must_use]
    pub fn numbers(&self, path: &str) -> Option<Vec<f64>> {
        Some(self.item(path)?.as_array()?.iter().filter_map(schema::number).collect())
    }

    fn vector(&self, path: &str) -> Option<[f64; 3]> {
        let array = self.item(path)?.as_array()?;
        let numbers: Vec<f64> = array.iter().filter_map(schema::number).collect();
        numbers.try_into().ok()
    }

    pub(crate) fn item(&self, path: &str) -> Option<&Item> {
        let mut item = self.document.as_item();
        for part in path.split('.') {
            item = item.as_table_like()?.get(part)?;
        }
        Some(item)
    }

    /// Writes a parameter's value, everything else kept as it stands.
    pub fn set_value(&mut self, name: &str, value: f64) {
        let parameters = table(self.document.as_table_mut(), "parameters", true);
        let one = table(parameters, name, false);
        let decor = one.get("value").and_then(Item::as_value).map(|v| v.decor().clone());
        let mut new = Value::from(value);
        if let Some(decor) = decor {
            *new.decor_mut() = decor;
        }
        one["value"] = Item::Value(new);
        // A table that `--set` made has no more than the key that it set.
        let known = Domain::ALL.iter().find_map(|domain| domain.parameter(name));
        let (unit, [_, min, max]) = known.map_or(("1", [0.0, 0.0, 1.0]), |p| (p.unit, p.default));
        if !one.contains_key("min") && !one.contains_key("max") {
            (one["min"], one["max"], one["unit"]) =
                (toml_edit::value(min), toml_edit::value(max), toml_edit::value(unit));
        }
    }

    /// Replaces `[provenance]` by these entries, in this order.
    pub fn set_provenance(&mut self, entries: &[(&str, Value)]) {
        self.document.remove("provenance");
        let provenance = table(self.document.as_table_mut(), "provenance", false);
        for (key, value) in entries {
            provenance[key] = Item::Value(value.clone());
        }
    }
}

/// The table `name` within `parent`, made where it is missing; an implicit one shows no head of its own.
fn table<'a>(parent: &'a mut Table, name: &str, implicit: bool) -> &'a mut Table {
    let item = parent.entry(name).or_insert_with(|| {
        let mut new = Table::new();
        new.set_implicit(implicit);
        Item::Table(new)
    });
    if !item.is_table() {
        // `restitution = { value = … }` becomes a table with a head.
        *item = std::mem::take(item).into_table().map_or_else(|_| Item::Table(Table::new()), Item::Table);
    }
    item.as_table_mut().expect("made a table above")
}
