//! Recordings that were not made here, in folders that environment variables name; tests that need them are skipped without.

use std::path::{Path, PathBuf};

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
