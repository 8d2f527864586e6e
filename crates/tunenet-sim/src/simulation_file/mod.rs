//! The simulation file: one TOML file that describes a simulation completely, read, overridden, and written back with its
//! comments and its order kept.

mod arm_effects;
mod arm_schema;
mod assignment;
pub(crate) mod check;
mod declared;
mod declared_check;
pub(crate) mod declared_schema;
mod document;
mod domain;
mod effects;
mod equations_keys;
pub(crate) mod equations_schema;
mod joint_numbers;
mod moved;
pub(crate) mod process_schema;
mod robot_effects;
mod robot_keys;
pub(crate) mod robot_schema;
mod robot_template;
mod robot_values;
pub mod schema;
mod stated_effects;
mod template;

use std::path::{Path, PathBuf};

use toml_edit::de::from_document;
use toml_edit::{Item, Value};
use tunenet_core::simulator::Parameter;
use tunenet_formats::{Error, Result};
use tunenet_formats::{read_text, refuse_markup};

pub use arm_effects::{ARM_EFFECT_KEYS, PresentArmEffect};
pub use arm_schema::ARM_KEYS;
pub use declared_schema::{CANDIDATE_KEYS, COEFFICIENT_KEYS, Declares, FORMULA_KEYS, INPUT_KEYS, START_KEYS};
use document::{Document, table};
pub use domain::Domain;
pub use effects::PresentEffect;
pub use equations_keys::{
    ADDS, CONSTANT, DERIVATIVE, EQUATIONS_KEYS, EQUATIONS_TABLES, EVENT_KEYS, OUTPUT, STATE_KEYS, THEN,
};
pub use moved::seen_from;
pub use process_schema::{PROCESS_EFFECT_KEYS, PROCESS_KEYS};
pub use robot_effects::PresentRobotEffect;
pub use robot_keys::{ROBOT_EFFECT_KEYS, ROBOT_KEYS, ROBOT_TABLES};
pub use robot_template::{JointColumns, LogColumn, RobotStart, command_input, position_channel, robot_template};
pub use template::template;

use crate::scene::{ArmScene, BallScene, EquationsScene, Process, Record, RobotScene, Scene};
use schema::item_number;
pub use schema::{Definition, is_name};

/// What a ball's file may leave to the data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LeftOpen {
    /// `release.height_m`.
    ReleaseHeight,
    /// `release.position_m`.
    ReleasePosition,
    /// `release.velocity_m_s`.
    ReleaseVelocity,
    /// `release.spin_rad_s`.
    ReleaseSpin,
    /// `release.time_s`.
    ReleaseTime,
    /// `surface.height_m`.
    SurfaceHeight,
}

/// A simulation file, checked. A plain value: two files are equal where path and text are, and nothing runs in it.
#[derive(Debug, Clone, PartialEq)]
pub struct SimulationFile {
    path: PathBuf,
    document: Document,
    /// What the document says, read again after every change of it.
    scene: Scene,
}

impl SimulationFile {
    /// Reads and checks the file at `path`.
    ///
    /// # Errors
    /// [`Error::Io`] where it cannot be read; [`Error::File`] where it is no text in UTF-8; [`Error::Text`] with line and column where it is not TOML, holds an unknown
    /// key, a value of the wrong kind or outside its bounds; [`Error::File`] where a key is missing.
    pub fn read(path: &Path) -> Result<Self> {
        let text = read_text(path)?;
        refuse_markup(path, &text, "a simulation file (TOML)")?;
        Self::parse(path, &text)
    }

    /// Checks `text` as the content of `path`.
    ///
    /// # Errors
    /// As [`SimulationFile::read`].
    pub fn parse(path: &Path, text: &str) -> Result<Self> {
        let document = toml_edit::Document::parse(text).map_err(|e| {
            let span = e.span().unwrap_or(0..0);
            check::located(
                path,
                text,
                span,
                e.message().to_string(),
                "a simulation file is TOML, `key = value` lines under [table] heads; is this the recording?",
            )
        })?;
        let domain = check::document(path, text, document.as_table())?;
        let document = Document::new(document.into_mut());
        let scene = scene(domain, &document)
            .map_err(|e| Error::file(path, e.message(), "see docs/files.md for the keys and their values"))?;
        Ok(Self { path: path.to_path_buf(), document, scene })
    }

    /// Leaves these to the data, as if the file had left them out; of files of other kinds nothing.
    pub fn leave_open(&mut self, what: &[LeftOpen]) {
        for one in what {
            let Scene::Ball(BallScene { release, surface, .. }) = &mut self.scene else { return };
            let path = match one {
                LeftOpen::ReleaseHeight => {
                    release.height_m = None;
                    "release.height_m"
                }
                LeftOpen::ReleasePosition => {
                    release.position_m = None;
                    "release.position_m"
                }
                LeftOpen::ReleaseVelocity => {
                    release.velocity_m_s = None;
                    "release.velocity_m_s"
                }
                LeftOpen::ReleaseSpin => {
                    release.spin_rad_s = None;
                    "release.spin_rad_s"
                }
                LeftOpen::ReleaseTime => {
                    release.time_s = None;
                    "release.time_s"
                }
                LeftOpen::SurfaceHeight => {
                    surface.height_m = None;
                    "surface.height_m"
                }
            };
            self.document.remove(path);
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

    /// The kind of what the file describes.
    #[must_use]
    pub fn domain(&self) -> Domain {
        match &self.scene {
            Scene::Ball(_) => Domain::Ball,
            Scene::Arm(_) => Domain::Arm,
            Scene::Process(_) => Domain::Process,
            Scene::Equations(_) => Domain::Equations,
            Scene::Robot(_) => Domain::Robot,
        }
    }

    /// What the file describes.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The ball that the file describes.
    ///
    /// # Errors
    /// [`Error::File`] where it describes something else.
    pub fn ball(&self) -> Result<&BallScene> {
        if let Scene::Ball(ball) = &self.scene { Ok(ball) } else { Err(self.describes_no(Domain::Ball)) }
    }

    /// The arm that the file describes.
    ///
    /// # Errors
    /// As [`ball`](Self::ball).
    pub fn arm(&self) -> Result<&ArmScene> {
        if let Scene::Arm(arm) = &self.scene { Ok(arm) } else { Err(self.describes_no(Domain::Arm)) }
    }

    /// The program that the file describes.
    ///
    /// # Errors
    /// As [`ball`](Self::ball).
    pub fn process(&self) -> Result<&Process> {
        if let Scene::Process(scene) = &self.scene {
            Ok(&scene.process)
        } else {
            Err(self.describes_no(Domain::Process))
        }
    }

    /// The equations that the file holds.
    ///
    /// # Errors
    /// As [`ball`](Self::ball).
    pub fn equations(&self) -> Result<&EquationsScene> {
        if let Scene::Equations(scene) = &self.scene { Ok(scene) } else { Err(self.describes_no(Domain::Equations)) }
    }

    /// The robot that the file describes.
    ///
    /// # Errors
    /// As [`ball`](Self::ball).
    pub fn robot(&self) -> Result<&RobotScene> {
        if let Scene::Robot(scene) = &self.scene { Ok(scene) } else { Err(self.describes_no(Domain::Robot)) }
    }

    fn describes_no(&self, needed: Domain) -> Error {
        let message = format!("expected `kind = \"{}\"`, found \"{}\"", needed.name(), self.domain().name());
        Error::file(&self.path, message, format!("`tunenet init {}` writes one to start from", needed.name()))
    }

    /// The parameters in the order of [`Domain::parameters`]; those left out stand at their default. Where the file
    /// [names them itself](Domain::declares), those that it describes, in its order.
    ///
    /// # Errors
    /// [`Parameter`](tunenet_core::Error::Parameter) where bounds and value contradict each other.
    pub fn parameters(&self) -> Result<Vec<Parameter>> {
        if self.domain().declares() {
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
        let each = check::names(self.domain(), self.document.root()).into_iter().map(|name| {
            let field = |field: &str| self.item(&format!("parameters.{name}.{field}"));
            let number = |key: &str| field(key).and_then(item_number).unwrap_or(0.0);
            let unit = field("unit").and_then(Item::as_str).unwrap_or("1");
            let parameter = Parameter::new(name, unit, number("value"), number("min"), number("max"))?;
            Ok(Parameter { tune: field("tune").and_then(Item::as_bool).unwrap_or(true), ..parameter })
        });
        each.collect()
    }

    /// The value of a parameter, where the file itself says one.
    #[must_use]
    pub fn written_value(&self, name: &str) -> Option<f64> {
        self.item(&format!("parameters.{name}.value")).and_then(item_number)
    }

    /// The unit of a parameter, where the file itself says one.
    #[must_use]
    pub fn written_unit(&self, name: &str) -> Option<&str> {
        self.item(&format!("parameters.{name}.unit")).and_then(Item::as_str)
    }

    /// The 95 % interval of a parameter that an earlier tuning wrote into `[provenance]`.
    #[must_use]
    pub fn tuned95(&self, name: &str) -> Option<(f64, f64)> {
        let ends = self.item(&format!("provenance.interval95.{name}"))?.as_array()?;
        let ends: [f64; 2] = ends.iter().filter_map(schema::number).collect::<Vec<_>>().try_into().ok()?;
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
        // Formulas that act are part of it; those that are only declared change no rollout.
        let present = self.effects().into_iter().filter_map(|effect| {
            let candidate = self.candidate(&effect.name)?;
            Some(format!("effects.{}={:?} of {candidate:?}", effect.name, effect.values))
        });
        scene.chain(parameters).chain(present).collect::<Vec<_>>().join("\n")
    }

    /// What is written of a rollout.
    #[must_use]
    pub fn record(&self) -> Record {
        self.scene.record()
    }

    pub(crate) fn item(&self, path: &str) -> Option<&Item> {
        self.document.item(path)
    }

    /// Writes a parameter's value, everything else kept as it stands.
    pub fn set_value(&mut self, name: &str, value: f64) {
        let parameters = table(self.document.root_mut(), "parameters", true);
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
        self.document.root_mut().remove("provenance");
        let provenance = table(self.document.root_mut(), "provenance", false);
        for (key, value) in entries {
            provenance[key] = Item::Value(value.clone());
        }
    }
}

fn scene(domain: Domain, document: &Document) -> std::result::Result<Scene, toml_edit::de::Error> {
    let document = document.to_deserialize();
    Ok(match domain {
        Domain::Ball => Scene::Ball(from_document(document)?),
        Domain::Arm => Scene::Arm(from_document(document)?),
        Domain::Process => Scene::Process(from_document(document)?),
        Domain::Equations => Scene::Equations(Box::new(from_document(document)?)),
        Domain::Robot => Scene::Robot(Box::new(robot_schema::with_units(from_document(document)?))),
    })
}

/// A number that TOML refuses and people write: `.5`, `5.`.
fn number(text: &str) -> Option<f64> {
    text.parse().ok().filter(|_| text.contains(|c: char| c.is_ascii_digit()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Release;
    use schema::Shape;

    #[test]
    fn a_number_may_begin_or_end_with_its_point() {
        let mut file = SimulationFile::parse(Path::new("scene.toml"), &template(Domain::Ball)).unwrap();
        file.set("release.height_m=.425").unwrap();
        let Scene::Ball(ball) = file.scene() else { panic!("a ball") };
        assert_eq!(ball.release.height_m, Some(0.425));
        file.set("world.gravity_m_s2=9.").unwrap();
        assert!(file.set("world.gravity_m_s2=nan").is_err() && file.set("world.gravity_m_s2=.").is_err());
    }

    /// A network that was trained for a scene without a formula is none for the scene with it.
    #[test]
    fn the_essence_holds_the_formulas_that_act() {
        let declared = "kind = \"ball\"\nball.radius_m = 0.02\n[candidates.air]\nsentence = \"the air brakes\"\nacts = \"flight\"\n\
                        along = [\"v\"]\nformula = \"-c*speed_m_s^2\"\n\
                        coefficients.c = { unit = \"1/m\", absent = 0.0, min = 0.0, max = 2.0 }\n";
        let essence = |text: &str| SimulationFile::parse(Path::new("ball.toml"), text).unwrap().essence();
        let bare = essence(declared);
        let strong = essence(&format!("{declared}[effects.air]\nc = 0.2\n"));
        assert!(!bare.contains("air") && strong.contains("effects.air=[0.2]"), "{strong}");
        assert_ne!(strong, essence(&format!("{declared}[effects.air]\nc = 0.3\n")));
    }

    #[test]
    fn a_table_in_place_of_a_value_is_named() {
        let text = "kind = \"process\"\n[process]\ncommand = [\"true\"]\n[[process.channels]]\nname = \"z_m\"\n";
        let refused = SimulationFile::parse(Path::new("scene.toml"), text).unwrap_err().to_string();
        assert!(refused.starts_with("scene.toml:4:11: `process.channels`: expected "), "{refused}");
        assert!(refused.ends_with(", found a table"), "{refused}");
    }

    /// A list of keys and a struct are two descriptions of one file.
    #[test]
    fn every_key_is_a_field_of_the_scene() {
        for domain in Domain::ALL {
            let mut file = SimulationFile::parse(Path::new("scene.toml"), &template(domain)).unwrap();
            for key in domain.keys().filter(|key| !key.path.starts_with("effects.") && key.path != "kind") {
                let value = match key.shape {
                    Shape::Number(low, high) => format!("{:?}", low + 0.75 * (high - low)),
                    Shape::Whole(low, high) => i64::midpoint(low, high).to_string(),
                    Shape::Numbers(count, ..) => format!("{:?}", vec![1.0; count]),
                    Shape::List(..) | Shape::NumberOrList(..) => "[1.0, 2.0]".into(),
                    Shape::Word(words) => format!("{:?}", words.last().unwrap_or(&"word")),
                    Shape::Texts => "[\"a_m\"]".into(),
                    Shape::Flag | Shape::Anything | Shape::Names | Shape::NumberOrWord(..) => continue,
                };
                let before = file.scene().clone();
                file.set(&format!("{}={value}", key.path)).unwrap();
                assert_ne!(file.scene(), &before, "{} = {value} changes no field", key.path);
            }
        }
    }

    #[test]
    fn what_is_left_open_stands_neither_in_the_scene_nor_in_the_text() {
        let text = "kind = \"ball\"\nball.radius_m = 0.02\n[release]\nheight_m = 1 # of fall\ntime_s = 0.5\n";
        let mut file = SimulationFile::parse(Path::new("ball.toml"), text).unwrap();
        assert_eq!(file.ball().unwrap().release.height_m, Some(1.0));
        file.leave_open(&[LeftOpen::ReleaseHeight]);
        assert_eq!(file.ball().unwrap().release, Release { time_s: Some(0.5), ..Release::default() });
        assert!(!file.text().contains("height_m") && file.text().contains("time_s = 0.5"));
        assert!(file.arm().unwrap_err().to_string().contains("expected `kind = \"arm\"`, found \"ball\""));
    }
}
