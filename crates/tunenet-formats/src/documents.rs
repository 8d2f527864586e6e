//! Texts that are no tables: which kind of document one is, and what to do with it instead.

use std::io::Read as _;
use std::path::Path;

use crate::source::open;
use crate::{Action, Error, Result};

/// How much of a document is looked at: licences stand above the root of many models.
pub(crate) const LOOKED_AT: u64 = 16 << 10;

/// A text that holds no table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Document {
    GitLfsPointer,
    Urdf,
    Mjcf,
    Sdf,
    Html,
    Xml,
    Json,
    Yaml,
    Toml,
    Markdown,
    Readme,
}

impl Document {
    fn name(self) -> &'static str {
        match self {
            Self::GitLfsPointer => "a Git LFS pointer, which stands for a file that was not downloaded",
            Self::Urdf => "a URDF, the description of a robot",
            Self::Mjcf => "a MuJoCo model (MJCF)",
            Self::Sdf => "an SDF, the description of a world or a robot",
            Self::Html => "an HTML page",
            Self::Xml => "an XML document",
            Self::Json => "a JSON document",
            Self::Yaml => "a YAML document",
            Self::Toml => "a TOML file",
            Self::Markdown => "a Markdown document",
            Self::Readme => "a text about other files",
        }
    }

    fn remedy(self) -> &'static str {
        match self {
            Self::GitLfsPointer => "run `git lfs pull` in its repository, and give the file again",
            Self::Urdf | Self::Mjcf => {
                "`tunenet init robot --model FILE` writes a simulation file that names it (for a payload from torques, \
                 `tunenet init arm`); give that with --sim"
            }
            Self::Sdf => {
                "give the recording; an arm is described by a URDF, which the simulation file names as `arm.urdf`"
            }
            Self::Html => "download the file itself instead of the page that shows it",
            Self::Json => "export the series as CSV with a header such as `t_s,z_m`",
            Self::Yaml => "give the recording that belongs to it, such as the .mcap file next to it",
            Self::Toml => {
                "give a simulation file with --sim, a manifest with `diagnose --manifest`, and recordings by themselves"
            }
            Self::Xml | Self::Markdown | Self::Readme => "give the recording itself",
        }
    }

    /// What a file is that is named so and begins so; `None` where it may hold a table.
    fn of(path: &Path, start: &[u8]) -> Option<Self> {
        if start.starts_with(GIT_LFS) {
            return Some(Self::GitLfsPointer);
        }
        let text = String::from_utf8_lossy(start);
        let text = text.trim_start_matches('\u{feff}').trim_start();
        marked_up(text).or_else(|| is_json(text).then_some(Self::Json)).or_else(|| Self::by_name(path))
    }

    /// What the name says, for documents that begin as a table may.
    fn by_name(path: &Path) -> Option<Self> {
        let lower =
            |part: Option<&std::ffi::OsStr>| part.map(|p| p.to_string_lossy().to_lowercase()).unwrap_or_default();
        match (lower(path.extension()).as_str(), lower(path.file_stem()).as_str()) {
            ("md" | "markdown" | "rst", _) => Some(Self::Markdown),
            ("yaml" | "yml", _) => Some(Self::Yaml),
            ("toml", _) => Some(Self::Toml),
            ("" | "txt", "readme" | "license" | "licence" | "changelog" | "notice") => Some(Self::Readme),
            _ => None,
        }
    }
}

/// How every Git LFS pointer begins.
const GIT_LFS: &[u8] = b"version https://git-lfs.github.com/spec/";

/// The kind of a document in angle brackets, by its root.
fn marked_up(text: &str) -> Option<Document> {
    if !text.starts_with('<') {
        return None;
    }
    let mut rest = text;
    loop {
        rest = rest.trim_start();
        let end = if rest.starts_with("<!--") { "-->" } else { ">" };
        if !rest.starts_with("<?") && !rest.starts_with("<!") {
            break;
        }
        if rest.to_lowercase().starts_with("<!doctype html") {
            return Some(Document::Html);
        }
        // Where it ends is beyond what was looked at.
        let Some((_, after)) = rest.split_once(end) else { return Some(Document::Xml) };
        rest = after;
    }
    let root: String = rest.chars().skip(1).take_while(|c| c.is_alphanumeric() || "_:-.".contains(*c)).collect();
    Some(match root.as_str() {
        "robot" => Document::Urdf,
        "mujoco" | "mujocoinclude" => Document::Mjcf,
        "sdf" => Document::Sdf,
        root if root.eq_ignore_ascii_case("html") => Document::Html,
        _ => Document::Xml,
    })
}

/// Whether a text begins as an object or a list of JSON does. A unit in brackets, `[s],[m]`, does not.
fn is_json(text: &str) -> bool {
    let inside = |open: char| text.strip_prefix(open).map(|rest| rest.trim_start().chars().next());
    match (inside('{'), inside('[')) {
        (Some(next), _) => matches!(next, None | Some('"' | '}')),
        (_, Some(next)) => next.is_none_or(|c| c.is_ascii_digit() || "{[\"-]".contains(c)),
        _ => false,
    }
}

/// Refuses a document by what it is, where a table is asked for.
pub(crate) fn refuse_document(path: &Path, start: &[u8]) -> Result<()> {
    match Document::of(path, start) {
        Some(document) => {
            let message = format!("expected a recording, found {}", document.name());
            Err(Error::file(path, message, document.remedy()))
        }
        None => Ok(()),
    }
}

/// Refuses a document in angle brackets, such as a URDF, by what it is; `expected` names what was asked for instead.
///
/// # Errors
/// [`Error::File`] where `text` begins as such a document does.
pub fn refuse_markup(path: impl AsRef<Path>, text: &str, expected: &str) -> Result<()> {
    match marked_up(text.trim_start()) {
        Some(document) => {
            let message = format!("expected {expected}, found {}", document.name());
            Err(Error::file(path.as_ref(), message, document.remedy()))
        }
        None => Ok(()),
    }
}

/// Refuses what a clone without Git LFS leaves in place of a file, whatever was asked for.
pub(crate) fn refuse_pointer(path: &Path, start: &[u8]) -> Result<()> {
    if !start.starts_with(GIT_LFS) {
        return Ok(());
    }
    let pointer = Document::GitLfsPointer;
    Err(Error::file(path, format!("expected the file itself, found {}", pointer.name()), pointer.remedy()))
}

/// As for every file that is read here: refuses what a clone without Git LFS leaves in place of a file. For those who read a
/// file by other means.
///
/// # Errors
/// [`Error::File`] where it is such a pointer; [`Error::Io`] where the system refuses.
pub fn refuse_git_lfs_pointer(path: impl AsRef<Path>) -> Result<()> {
    let path = path.as_ref();
    refuse_pointer(path, &start(path)?)
}

/// Whether Git LFS has not downloaded a file.
///
/// # Errors
/// [`Error::Io`] where the system refuses.
#[cfg(feature = "logs")]
pub(crate) fn is_git_lfs_pointer(path: &Path) -> Result<bool> {
    Ok(start(path)?.starts_with(GIT_LFS))
}

/// As much of a file as the mark of a pointer has.
fn start(path: &Path) -> Result<Vec<u8>> {
    let mut start = Vec::new();
    let beginning = open(path)?.take(GIT_LFS.len() as u64).read_to_end(&mut start);
    beginning.map_err(|e| Error::io(path, Action::Reading, e))?;
    Ok(start)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(name: &str, start: &str) -> Option<Document> {
        Document::of(Path::new(name), start.as_bytes())
    }

    #[test]
    fn documents_are_known_by_their_beginning() {
        let pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 7\n";
        assert_eq!(of("log.parquet", pointer), Some(Document::GitLfsPointer));
        for (start, document) in [
            ("<?xml version=\"1.0\"?>\n<!-- a, > b -->\n<robot name=\"a\">", Document::Urdf),
            ("\u{feff}<robot>", Document::Urdf),
            ("<mujoco model=\"a\">", Document::Mjcf),
            ("<mujocoinclude>", Document::Mjcf),
            ("<?xml version=\"1.0\"?><sdf version=\"1.6\">", Document::Sdf),
            ("<!DOCTYPE html><html>", Document::Html),
            ("<html>", Document::Html),
            ("<default>", Document::Xml),
            ("<!-- no end", Document::Xml),
            ("{\n  \"fps\": 30\n}", Document::Json),
            ("[[0.0, 1.0], [0.1, 0.9]]", Document::Json),
        ] {
            assert_eq!(of("a.csv", start), Some(document), "{start}");
        }
    }

    #[test]
    fn documents_that_begin_as_tables_are_known_by_their_names() {
        for (name, document) in [
            ("notes.md", Document::Markdown),
            ("README", Document::Readme),
            ("ReadMe.txt", Document::Readme),
            ("metadata.yaml", Document::Yaml),
            ("ball.toml", Document::Toml),
        ] {
            assert_eq!(of(name, "# Drops\n"), Some(document), "{name}");
        }
    }

    #[test]
    fn tables_are_no_documents() {
        for start in
            ["t_s,z_m\n0,1\n", "# by hand\nt_s,z_m\n", "[s],[m]\n0,1\n", "{t},{z}\n", "0 1\n", "", "\"t_s\",\"z_m\"\n"]
        {
            assert_eq!(of("a.csv", start), None, "{start}");
            assert_eq!(of("a.txt", start), None, "{start}");
        }
    }
}
