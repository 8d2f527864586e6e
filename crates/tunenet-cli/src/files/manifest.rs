//! The manifest of a diagnosis: recordings grouped into objects, each with its keys of the scene.

use std::path::{Path, PathBuf};

use anyhow::Result;
use toml_edit::{Document, Item, TableLike};
use tunenet_formats::{Error, is_episode, read_text};

/// The object of files that nobody groups: it is called by its kind in the end.
pub const ONLY: &str = "";

/// What an entry may contain in addition to keys of the scene.
const KEYS: &str = "`file`, `object`, `held_out`, `reference`, `payload_mass_kg`";
/// What the arm of an object is known to hold, kg: the one key of a scene that has no table of its own.
pub const KNOWN_PAYLOAD: &str = "payload_mass_kg";

/// One file, and what is said of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Source {
    pub path: PathBuf,
    pub object: String,
    pub held_out: bool,
    /// The same motion without the payload, of an arm's log.
    pub reference: Option<PathBuf>,
    /// Keys of the scene that differ for its object, with their values.
    pub scene: Vec<(String, String)>,
}

impl Source {
    /// A file by itself.
    pub fn alone(path: &Path, object: &str, reference: Option<PathBuf>) -> Self {
        let (path, object) = (path.to_path_buf(), object.to_owned());
        Self { path, object, held_out: false, reference, scene: Vec::new() }
    }
}

/// The recordings that a manifest lists, in its order, each of which is there.
pub fn read(path: &Path) -> Result<Vec<Source>> {
    let entries = listed(path)?;
    // An episode has no file of its own.
    let absent = |source: &Source| !source.path.exists() && !is_episode(&source.path);
    if let Some(number) = entries.iter().position(absent) {
        let file = entries[number].path.display();
        let message = format!("[[observation]] {}: expected the file {file}, found none", number + 1);
        return Err(Error::file(path, message, "a manifest names its files as seen from its own folder").into());
    }
    Ok(entries)
}

/// The same, where recordings may still have to be made.
pub fn listed(path: &Path) -> Result<Vec<Source>> {
    let text = read_text(path)?;
    let document = Document::parse(text.as_str()).map_err(|e| {
        let start = e.span().map_or(0, |span| span.start);
        let line = text[..start].lines().count().max(1);
        let written = text.lines().nth(line - 1).unwrap_or_default().trim();
        let hint = match written.split_once('=').map(|(_, value)| value.trim().trim_start_matches(['+', '-'])) {
            Some(value) if value.starts_with('.') => format!("TOML wants a digit before the point: write 0{value}"),
            _ => "a manifest is TOML: [[observation]] tables".into(),
        };
        Error::file(path, format!("line {line}, `{written}`: {}", e.message()), hint)
    })?;
    let mut entries = None;
    for (key, item) in document.as_table() {
        match (key, item) {
            ("observation", Item::ArrayOfTables(all)) => entries = Some(all),
            ("observation", _) => {
                return Err(wrong(path, "expected [[observation]] tables, found another `observation`").into());
            }
            _ => {
                return Err(wrong(path, &format!("expected [[observation]] tables, found `{key}` next to them")).into());
            }
        }
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    let entries = entries.filter(|all| !all.is_empty());
    let entries = entries.ok_or_else(|| wrong(path, "expected at least one [[observation]], found none"))?;
    let read = |(number, entry)| source(path, folder, number, entry);
    entries.iter().enumerate().map(|(i, table)| (i + 1, table as &dyn TableLike)).map(read).collect()
}

fn wrong(path: &Path, message: &str) -> Error {
    Error::file(
        path,
        message,
        "each [[observation]] has `file`, and may have `object`, `held_out` and keys of the scene",
    )
}

fn source(manifest: &Path, folder: &Path, number: usize, entry: &dyn TableLike) -> Result<Source> {
    let place = |what: &str| wrong(manifest, &format!("[[observation]] {number}: {what}"));
    let (mut file, mut object, mut held_out, mut scene) = (None, ONLY.to_owned(), false, Vec::new());
    let mut reference = None;
    for (key, item) in entry.iter() {
        match key {
            "file" => file = Some(item.as_str().ok_or_else(|| place("expected a name in quotes for `file`"))?),
            "object" => {
                let name = item.as_str().filter(|name| !name.trim().is_empty());
                name.ok_or_else(|| place("expected a name in quotes for `object`"))?.clone_into(&mut object);
            }
            "held_out" => {
                held_out = item.as_bool().ok_or_else(|| place("expected true or false for `held_out`"))?;
            }
            "reference" => {
                let name = item.as_str().ok_or_else(|| place("expected a name in quotes for `reference`"))?;
                reference = Some(folder.join(name));
            }
            // A scene's key has a table before its name.
            _ if item.as_table_like().is_none() && !key.contains('.') && key != KNOWN_PAYLOAD => {
                return Err(place(&format!("expected {KEYS} or a key of the scene, found `{key}`")).into());
            }
            _ => keys(key, item, &mut scene),
        }
    }
    let path = folder.join(file.ok_or_else(|| place("expected `file`, found none"))?);
    Ok(Source { path, object, held_out, reference, scene })
}

/// The scene's keys below `item`, whether written `ball.radius_m = …`, `"ball.radius_m" = …` or as tables.
fn keys(path: &str, item: &Item, into: &mut Vec<(String, String)>) {
    match item.as_table_like() {
        Some(table) => table.iter().for_each(|(key, inner)| keys(&format!("{path}.{key}"), inner, into)),
        None => into.push((path.to_owned(), item.to_string().trim().to_owned())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn manifest(text: &str) -> Result<Vec<Source>> {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.csv"), "a").unwrap();
        std::fs::write(folder.path().join("m.toml"), text).unwrap();
        read(&folder.path().join("m.toml"))
    }

    #[test]
    fn keys_of_the_scene_may_be_written_in_every_way_of_toml() {
        let ways = ["ball.radius_m = 0.1", "\"ball.radius_m\" = 0.1", "ball = { radius_m = 0.1 }"];
        for way in ways {
            let found = manifest(&format!("[[observation]]\nfile = \"a.csv\"\nobject = \"red\"\n{way}\n")).unwrap();
            assert_eq!((found[0].object.as_str(), found[0].held_out), ("red", false));
            assert_eq!(found[0].scene, [("ball.radius_m".to_owned(), "0.1".to_owned())], "{way}");
        }
    }

    #[test]
    fn what_is_wrong_is_said_with_its_place() {
        for (text, expected) in [
            ("", "at least one [[observation]]"),
            ("x = 1\n", "found `x` next to"),
            ("observation = 3\n", "another `observation`"),
            ("[[observation]]\nobject = \"a\"\n", "[[observation]] 1: expected `file`"),
            ("[[observation]]\nfile = 3\n", "a name in quotes for `file`"),
            ("[[observation]]\nfile = \"a.csv\"\nheld_out = 1\n", "true or false"),
            ("[[observation]\n", "line 1"),
            (
                "[[observation]]\nfile = \"a.csv\"\n[[observation]]\nfile = \"b.csv\"\n",
                "[[observation]] 2: expected the file",
            ),
            ("[[observation]]\nfile = \"a.csv\"\nball.radius_m = .0155\n", "line 3, `ball.radius_m = .0155`"),
            ("[[observation]]\nfile = \"a.csv\"\nheldout = true\n", "found `heldout`"),
        ] {
            let message = manifest(text).unwrap_err().to_string();
            assert!(message.contains(expected), "{text}: {message}");
        }
    }
}
