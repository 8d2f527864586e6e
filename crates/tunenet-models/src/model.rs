//! A model file of either format.

use std::path::{Path, PathBuf};

use quick_xml::Reader;
use quick_xml::events::Event;

use crate::mjcf::{self, Mjcf};
use crate::urdf::{self, Urdf};
use crate::xml::{Document, Reach, SourceFile, load, parse, read_file, shown};
use crate::{Error, Result, Robot};

/// The formats of model files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// That of MuJoCo, with the root `<mujoco>`.
    Mjcf,
    /// That of ROS, with the root `<robot>`.
    Urdf,
}

impl Format {
    /// What a text is by its first element; `None` where that belongs to neither.
    #[must_use]
    pub fn of(text: &str) -> Option<Self> {
        let mut reader = Reader::from_str(text.strip_prefix('\u{feff}').unwrap_or(text));
        loop {
            match reader.read_event() {
                Ok(Event::Start(first) | Event::Empty(first)) => {
                    return match first.name().as_ref() {
                        b"mujoco" | b"mujocoinclude" => Some(Self::Mjcf),
                        b"robot" => Some(Self::Urdf),
                        _ => None,
                    };
                }
                Ok(Event::Eof) | Err(_) => return None,
                Ok(_) => {}
            }
        }
    }
}

/// A model file.
///
/// ```
/// use tunenet_models::Model;
/// let text = r#"<mujoco><worldbody><body name="arm"><joint name="elbow" damping="0.5"/>
///   <inertial pos="0 0 0.1" mass="0.2" diaginertia="1e-3 1e-3 1e-4"/></body></worldbody></mujoco>"#;
/// let model = Model::parse("arm.xml".as_ref(), text)?;
/// let robot = model.robot();
/// assert_eq!((robot.joints[0].name.as_str(), robot.joints[0].damping), ("elbow", 0.5));
/// # Ok::<(), tunenet_models::Error>(())
/// ```
#[derive(Debug, Clone)]
pub enum Model {
    /// The format of MuJoCo.
    Mjcf(Box<Mjcf>),
    /// The format of ROS.
    Urdf(Box<Urdf>),
}

impl Model {
    /// Reads the model at `path`, and the files in its folder that it includes.
    ///
    /// # Errors
    /// As [`parse`](Self::parse), and [`Error::Io`] where a file cannot be read.
    pub fn read(path: &Path) -> Result<Self> {
        Self::parse(path, &read_file(path)?)
    }

    /// The model whose file at `path` holds `text`.
    ///
    /// # Errors
    /// [`Error::Text`] where a place of the text is wrong: no XML, neither MJCF nor URDF, an attribute that cannot be read, a
    /// name that stands for nothing, an inertia that no body can have, an include outside the folder or in a circle.
    /// [`Error::Io`] and [`Error::File`] where an included file cannot be read.
    pub fn parse(path: &Path, text: &str) -> Result<Self> {
        let folder: PathBuf = path.parent().map(Path::to_path_buf).unwrap_or_default();
        Self::parse_with(path, text, Reach { leaves: false, open: &|file| read_below(file, &folder) })
    }

    /// Reads the model at `path`, and the files below `folder` that it includes.
    ///
    /// # Errors
    /// As [`read`](Self::read), with `folder` in place of the folder of the model.
    pub fn read_within(path: &Path, folder: &Path) -> Result<Self> {
        let reach = Reach { leaves: true, open: &|file| read_below(file, folder) };
        Self::parse_with(path, &read_file(path)?, reach)
    }

    /// The same without any other file: an include is refused.
    ///
    /// # Errors
    /// As [`parse`](Self::parse).
    pub fn parse_alone(path: &Path, text: &str) -> Result<Self> {
        let none =
            |path: &Path| Err(Error::Io { path: path.to_path_buf(), source: std::io::ErrorKind::NotFound.into() });
        Self::parse_with(path, text, Reach { leaves: false, open: &none })
    }

    fn parse_with(path: &Path, text: &str, reach: Reach) -> Result<Self> {
        let source = SourceFile::new(path, text);
        let root = parse(&source, 0)?;
        let (found, hint) = match root.tag.as_str() {
            "mujoco" => return Ok(Self::Mjcf(Box::new(mjcf::read(load(source, root, reach)?)?))),
            "robot" => {
                return Ok(Self::Urdf(Box::new(urdf::read(Document {
                    files: vec![source],
                    root,
                    includes: Vec::new(),
                })?)));
            }
            "mujocoinclude" => ("a part of an MJCF".into(), "name the file that includes this one"),
            "sdf" => ("an SDF".into(), "name the URDF or MJCF of the robot"),
            tag => (format!("<{}>", shown(tag)), "is this the model of a robot?"),
        };
        let message = format!("expected an MJCF (<mujoco>) or a URDF (<robot>), found {found}");
        Err(source.error(root.open, message, hint))
    }

    /// The file that was named.
    #[must_use]
    pub fn path(&self) -> &Path {
        let document = match self {
            Self::Mjcf(mjcf) => &mjcf.document,
            Self::Urdf(urdf) => &urdf.document,
        };
        &document.files[0].path
    }

    /// The text of the named file with those that it includes in their places; `None` where it includes none.
    #[must_use]
    pub fn joined(&self) -> Option<String> {
        match self {
            Self::Mjcf(mjcf) => mjcf.document.joined(),
            Self::Urdf(urdf) => urdf.document.joined(),
        }
    }

    /// What the file describes.
    #[must_use]
    pub fn robot(&self) -> &Robot {
        match self {
            Self::Mjcf(mjcf) => mjcf.robot(),
            Self::Urdf(urdf) => urdf.robot(),
        }
    }
}

/// The text of a file that lies below a folder, links followed.
fn read_below(file: &Path, folder: &Path) -> Result<String> {
    let real = |path: &Path| {
        let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
        path.canonicalize().map_err(|source| Error::Io { path: path.to_path_buf(), source })
    };
    if !real(file)?.starts_with(real(folder)?) {
        let message = "expected a file in the folder of the model, found a link or a path that leads out of it";
        return Err(Error::file(file, message, "copy the file into the folder of the model"));
    }
    read_file(file)
}
