//! Files of results, and figures that several tables write alike.

use std::path::Path;

use anyhow::Result;
use serde_json::Value;
use statrs::statistics::{Data, OrderStatistics, Statistics as _};
use tunenet_core::statistics::mean;
use tunenet_formats::write_atomically;

/// Writes each text under its name into `folder`; none is ever half written.
///
/// # Errors
/// Where a file cannot be written.
pub fn write_all<const N: usize>(folder: &Path, files: [(&str, String); N]) -> Result<()> {
    for (name, text) in files {
        write_atomically(folder.join(name), |file| file.write_all(text.as_bytes()))?;
    }
    Ok(())
}

/// JSON as a file holds it.
pub fn file_of(value: &Value) -> String {
    format!("{value:#}\n")
}

/// The mean, and the sample standard deviation (0 of one value).
pub fn mean_and_sd(values: &[f64]) -> (f64, f64) {
    (mean(values.iter().copied()), if values.len() > 1 { values.std_dev() } else { 0.0 })
}

/// The mean, and the median (of an even number, half way between the two in the middle).
pub fn mean_and_median(values: Vec<f64>) -> (f64, f64) {
    (mean(values.iter().copied()), Data::new(values).median())
}

/// The share of `all` of which something holds; 0 of none.
pub fn share<T>(all: &[T], is: impl Fn(&T) -> bool) -> f64 {
    all.iter().filter(|one| is(one)).count() as f64 / all.len().max(1) as f64
}

/// A share in percent, with one decimal.
pub fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}
