//! Columns of tables as `simulate` and the recordings have them.

use std::path::Path;

use anyhow::{Context, Result};

/// A column by its name; what is no number is NaN.
///
/// # Errors
/// Where the file cannot be read or has no such column.
pub fn column(path: &Path, name: &str) -> Result<Vec<f64>> {
    let text = std::fs::read_to_string(path).with_context(|| format!("reading {}", path.display()))?;
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let head = lines.next().unwrap_or_default();
    let at = head.split(',').position(|cell| cell.trim() == name);
    let at = at.with_context(|| format!("{}: expected a column `{name}`", path.display()))?;
    Ok(lines
        .map(|line| line.split(',').nth(at).and_then(|cell| cell.trim().parse().ok()).unwrap_or(f64::NAN))
        .collect())
}

/// Pairs of a measured and a simulated value at the same instants; both clocks rise, and what only one of them has is left out.
pub fn paired(measured: (&[f64], &[f64]), simulated: (&[f64], &[f64])) -> Vec<(f64, f64)> {
    /// Half of the last digit that instants are written with, s.
    const SAME_S: f64 = 5e-7;
    let mut at = 0;
    let mut pairs = Vec::new();
    for (time, value) in measured.0.iter().zip(measured.1) {
        while simulated.0.get(at).is_some_and(|own| *own < time - SAME_S) {
            at += 1;
        }
        if simulated.0.get(at).is_some_and(|own| (own - time).abs() <= SAME_S) {
            pairs.push((*value, simulated.1[at]));
        }
    }
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_found_by_name_and_pairs_by_time() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        std::fs::write(&path, "# note\nt_s,q_rad\n0.0,1.5\n0.1,x\n").unwrap();
        let found = column(&path, "q_rad").unwrap();
        assert!(found[0] == 1.5 && found[1].is_nan());
        assert!(column(&path, "w").is_err());
        let pairs = paired((&[0.0, 0.1, 0.2], &[1.0, 2.0, 3.0]), (&[0.0, 0.2], &[5.0, 6.0]));
        assert_eq!(pairs, [(1.0, 5.0), (3.0, 6.0)]);
    }
}
