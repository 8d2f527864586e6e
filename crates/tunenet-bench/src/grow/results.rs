//! The figures, for programs and for users.

use std::fmt::Write;

use serde::Serialize;

use crate::process::ProcessCost;

/// What one process took.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spent {
    pub seconds: f64,
    /// Greatest resident memory; none where the system does not report it.
    pub peak_bytes: Option<u64>,
}

impl From<ProcessCost> for Spent {
    fn from(cost: ProcessCost) -> Self {
        Self { seconds: cost.seconds, peak_bytes: cost.peak_bytes }
    }
}

/// One size.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SizeCost {
    pub pairs: u64,
    /// Length of the file.
    pub bytes: u64,
    pub generate: Spent,
    pub merge: Spent,
    pub train: Spent,
}

/// What a cluster would need for a set; extrapolated from a measured one, in proportion.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cluster {
    pub pairs: u64,
    pub nodes: u32,
    pub cores_per_node: u32,
    /// The measured row that it follows from.
    pub from_pairs: u64,
    pub generate_s: f64,
    pub merge_s: f64,
    /// Of the whole file; the shards take as much again until they are removed.
    pub bytes: f64,
    /// Of every process, as measured: it does not grow with the pairs. None where the system does not report it.
    pub peak_bytes_per_process: Option<u64>,
    pub extrapolated: bool,
}

impl Cluster {
    /// Of `pairs` on `nodes` of so many cores each, all of them busy, from a row measured on `threads`.
    pub fn extrapolated(pairs: u64, nodes: u32, cores: u32, threads: usize, row: &SizeCost) -> Self {
        let times = pairs as f64 / row.pairs as f64;
        let at_once = f64::from(nodes) * f64::from(cores) / threads as f64;
        Self {
            pairs,
            nodes,
            cores_per_node: cores,
            from_pairs: row.pairs,
            generate_s: row.generate.seconds * times / at_once,
            merge_s: row.merge.seconds * times,
            bytes: row.bytes as f64 * times,
            peak_bytes_per_process: row.generate.peak_bytes,
            extrapolated: true,
        }
    }
}

/// Everything.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GrowResults {
    pub schema: &'static str,
    pub command: String,
    pub version: &'static str,
    pub preset: &'static str,
    pub seed: u64,
    pub threads: usize,
    pub shards: u32,
    pub rows: Vec<SizeCost>,
    pub cluster: Option<Cluster>,
    pub warnings: [&'static str; 0],
}

impl GrowResults {
    /// The tables. Writing to a string cannot fail, so its results are dropped.
    pub fn markdown(&self) -> String {
        let mut out = format!("    {}\n\n", self.command);
        let _ = writeln!(
            out,
            "| pairs | file | gen | its memory | merge of {} shards | its memory | train | its memory |\n\
             |---:|---:|---:|---:|---:|---:|---:|---:|",
            self.shards
        );
        for row in &self.rows {
            let each = [row.generate, row.merge, row.train]
                .map(|spent| format!("{} | {}", duration(spent.seconds), megabytes(spent.peak_bytes)))
                .join(" | ");
            let _ = writeln!(out, "| {} | {} | {each} |", grouped(row.pairs), size(row.bytes as f64));
        }
        if let Some(cluster) = &self.cluster {
            let Cluster { pairs, nodes, cores_per_node, from_pairs, .. } = cluster;
            let _ = writeln!(
                out,
                "\nExtrapolated in proportion from {} pairs: {} pairs on {nodes} nodes of {cores_per_node} cores take \
                 {} to generate, {} to merge on one core, and {}, twice that until the shards are removed.",
                grouped(*from_pairs),
                grouped(*pairs),
                duration(cluster.generate_s),
                duration(cluster.merge_s),
                size(cluster.bytes)
            );
        }
        out
    }
}

/// `1,000,000`.
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut out = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 10.0 => format!("{s:.1} s"),
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.1} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

fn size(bytes: f64) -> String {
    match bytes {
        b if b < 1e9 => format!("{:.1} MB", b * 1e-6),
        b if b < 1e12 => format!("{:.2} GB", b * 1e-9),
        b => format!("{:.2} TB", b * 1e-12),
    }
}

fn megabytes(bytes: Option<u64>) -> String {
    bytes.map_or_else(|| "–".into(), |bytes| format!("{:.0} MB", bytes as f64 * 1e-6))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spent(seconds: f64) -> Spent {
        Spent { seconds, peak_bytes: Some(18_000_000) }
    }

    #[test]
    fn a_cluster_is_computed_in_proportion() {
        let row =
            SizeCost { pairs: 1000, bytes: 3_000_000, generate: spent(2.0), merge: spent(1.0), train: spent(9.0) };
        let cluster = Cluster::extrapolated(100_000_000, 10, 20, 2, &row);
        // 100,000 times as much, 100 processes of two threads at once.
        assert_eq!((cluster.generate_s, cluster.merge_s, cluster.bytes), (2000.0, 100_000.0, 3e11));
        assert_eq!(cluster.peak_bytes_per_process, Some(18_000_000));
    }

    #[test]
    fn figures_are_rendered_in_words() {
        assert_eq!(grouped(1_000_000), "1,000,000");
        assert_eq!(grouped(999), "999");
        assert_eq!(duration(2.34), "2.3 s");
        assert_eq!(duration(125.0), "2.1 min");
        assert_eq!(duration(8000.0), "2.2 h");
        assert_eq!(size(2.5e9), "2.50 GB");
    }
}
