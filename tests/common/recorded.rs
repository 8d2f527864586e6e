//! Recordings that were not made here, in folders that environment variables name; tests that need them are skipped without.

use std::any::Any;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use super::{Folder, PEERS_BALL, Ran, SCENE, ball, each_its_own};

/// A folder that an environment variable names, and that is there.
pub fn folder(variable: &str, inside: &str) -> Option<PathBuf> {
    let path = std::env::var_os(variable).map(|root| Path::new(&root).join(inside)).filter(|path| path.is_dir());
    if path.is_none() {
        eprintln!("skipped: {variable} names no folder with {inside}");
    }
    path
}

/// A folder of real recordings.
pub fn measured(inside: &str) -> Option<PathBuf> {
    folder("TUNENET_MEASURED", inside)
}

/// A real recording.
pub fn measured_file(name: &str) -> Option<PathBuf> {
    let path = Path::new(&std::env::var_os("TUNENET_MEASURED").unwrap_or_default()).join(name);
    if !path.is_file() {
        eprintln!("skipped: TUNENET_MEASURED names no folder with {name}");
    }
    path.is_file().then_some(path)
}

/// The recordings of a set of another engine, which puts the ball's radius at 0.5 m.
pub fn peers(set: &str) -> Option<Vec<PathBuf>> {
    let mut drops = files(&folder("TUNENET_PEERS", "cross")?.join(set), "", ".csv");
    drops.retain(|path| !path.ends_with("truth.csv"));
    Some(drops)
}

/// The files of a folder whose names start and end so, sorted.
pub fn files(folder: &Path, start: &str, end: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let mut files: Vec<PathBuf> = entries.map(|e| e.expect("an entry").path()).collect();
    files.retain(|path| name(path).starts_with(start) && name(path).ends_with(end));
    files.sort();
    assert!(!files.is_empty(), "no {start}…{end} in {}", folder.display());
    files
}

pub fn name(path: &Path) -> String {
    path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default()
}

/// The numbers of a foreign table, row by row.
pub fn numbers(path: &Path) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(path).expect("a table");
    let row = |line: &str| line.split(['\t', ',']).map(|cell| cell.trim().parse().ok()).collect::<Option<Vec<f64>>>();
    text.lines().filter_map(row).collect()
}

/// Pixels become metres by a length in the picture; `up` turns an axis that points down.
pub fn metres(path: &Path, fps: f64, px_m: f64, up: f64) -> String {
    let rows = numbers(path);
    let line = |(i, row): (usize, &Vec<f64>)| format!("{},{},{}", i as f64 / fps, row[0] / px_m, up * row[1] / px_m);
    let lines: Vec<String> = rows.iter().enumerate().map(line).collect();
    format!("t_s,x_m,z_m\n{}\n", lines.join("\n"))
}

/// One of three balls that fell a metre: its name, the columns of x and z in its table, until when it is used (s), radius (m)
/// and mass (kg).
pub type Fallen = (&'static str, usize, usize, f64, f64, f64);

/// The three balls: foam, rubber and a table-tennis ball.
pub const FALLEN: [Fallen; 3] =
    [("red", 1, 2, 0.54, 0.0155, 0.0004), ("black", 2, 1, 9.0, 0.0199, 0.02455), ("white", 2, 1, 9.0, 0.0201, 0.0028)];

/// The fall of one of them as a table of positions, from their folder.
pub fn fallen(folder: &Path, (name, x, z, until_s, ..): Fallen) -> String {
    let rows = numbers(&folder.join(format!("{name}_ball.txt"))).into_iter().filter(|row| row[0] < until_s);
    let lines: Vec<String> = rows.map(|row| format!("{},{},{}", row[0], row[x], row[z])).collect();
    format!("t_s,x_m,z_m\n{}\n", lines.join("\n"))
}

/// The entry of one of them in a manifest, where each is an object of its own size.
pub fn fallen_entry((name, _, _, _, radius_m, mass_kg): Fallen) -> String {
    let scene = format!("ball.radius_m = {radius_m}\nball.mass_kg = {mass_kg}");
    format!("[[observation]]\nfile = \"{name}.csv\"\nobject = \"{name}\"\n{scene}\n")
}

/// The answer of a run that several tests judge: it runs once.
fn once<T: Send + Sync + 'static>(key: String, run: impl FnOnce() -> T) -> Arc<T> {
    type Kept = Arc<OnceLock<Arc<dyn Any + Send + Sync>>>;
    static ANSWERS: Mutex<BTreeMap<String, Kept>> = Mutex::new(BTreeMap::new());
    let place = Arc::clone(ANSWERS.lock().unwrap_or_else(PoisonError::into_inner).entry(key).or_default());
    let kept = Arc::clone(place.get_or_init(|| Arc::new(run())));
    kept.downcast().expect("a key belongs to one kind of answer")
}

/// `tune --each --json` over all table tennis flights, and the flights.
pub fn flights_tuned() -> Option<(Vec<PathBuf>, Arc<Ran>)> {
    let flights = files(&measured("tt-flights")?, "", ".csv");
    let answer = once("flights tuned".into(), || {
        let here = Folder::new();
        here.write("scene.toml", SCENE);
        let mut command = here.command();
        command.args(["tune", "--sim", "scene.toml", "--each", "--json", "--observation"]).args(&flights);
        Ran::from(command.output().expect("the binary starts"))
    });
    Some((flights, answer))
}

/// `diagnose --json` of the first `count` table tennis flights together. A table rubs.
pub fn flights_diagnosed(count: usize) -> Option<Arc<Ran>> {
    let flights = files(&measured("tt-flights")?, "", ".csv");
    Some(once(format!("{count} flights diagnosed"), || {
        let here = Folder::new();
        here.write("ball.toml", ball(0.02, Some(0.0027)));
        let mut command = here.command();
        command.args(["diagnose", "--sim", "ball.toml", "--set", "parameters.friction.tune=true", "--json"]);
        command.arg("--observation").args(&flights[..count.min(flights.len())]);
        Ran::from(command.output().expect("the binary starts"))
    }))
}

/// An answer, and the file that it wrote, where it wrote one.
pub type Improved = (Ran, Option<Vec<u8>>);

/// `diagnose --json` of one flight in seventeen, each alone.
pub fn single_flights_diagnosed() -> Option<Vec<(PathBuf, Arc<Improved>)>> {
    let flights = files(&measured("tt-flights")?, "", ".csv");
    let one = |flight: &PathBuf| {
        let answer = once(format!("{} diagnosed", flight.display()), || {
            let here = Folder::new();
            here.write("ball.toml", ball(0.02, Some(0.0027)));
            let mut command = here.command();
            command.args(["diagnose", "--sim", "ball.toml", "--out", "o.toml", "--json", "--observation"]).arg(flight);
            let ran = Ran::from(command.output().expect("the binary starts"));
            (ran, std::fs::read(here.path("o.toml")).ok())
        });
        (flight.clone(), answer)
    };
    Some(flights.iter().step_by(17).map(one).collect())
}

/// `diagnose --json` of the first `count` drops of a set of another engine, every one of a ball of its own.
pub fn peers_diagnosed(set: &str, count: usize) -> Option<Arc<Ran>> {
    let mut drops = peers(set)?;
    drops.truncate(count);
    Some(once(format!("{count} of {set}"), || {
        let here = Folder::new();
        here.write("ball.toml", PEERS_BALL);
        here.write("m.toml", each_its_own(&drops));
        let columns = "t_s=t,x_m=x,y_m=y,z_m=z";
        let line = ["diagnose", "--sim", "ball.toml", "--manifest", "m.toml", "--columns", columns, "--json"];
        here.call(&line)
    }))
}
