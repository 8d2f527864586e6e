//! What the fuzz targets of `fuzz/` run for hours is run for seconds: every reader of a foreign file, on the seeds of its target and
//! on corrupted copies of them. `fuzz/run.sh TARGET EXECUTIONS` looks for more.

#[allow(dead_code, reason = "there is time for every reader of a log here, and no need for one drawn")]
#[path = "../../fuzz/src/readers.rs"]
mod readers;

use std::path::Path;

use crate::common::Noise;

/// Corrupted copies of every seed.
const COPIES: u64 = 150;

fn seeds(target: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus").join(target);
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    paths.sort();
    assert!(!paths.is_empty(), "no seeds of {target}");
    paths.iter().map(|path| std::fs::read(path).unwrap()).collect()
}

/// A seed with a few bytes changed, moved, doubled or left out, or with a piece of another one.
fn corrupted(seeds: &[Vec<u8>], which: usize, draw: &mut Noise) -> Vec<u8> {
    let mut bytes = seeds[which].clone();
    let mut below = |most: usize| usize::try_from(draw.next() % most.max(1) as u64).unwrap();
    for _ in 0..=below(4) {
        let (at, length) = (below(bytes.len()), 1 + below(16));
        let end = (at + length).min(bytes.len());
        match below(7) {
            0 => bytes[at] ^= 1 << below(8),
            1 => bytes[at..end].fill([0, 0xff, b'9', b'\n'][below(4)]),
            2 => drop(bytes.drain(at..end)),
            3 => bytes.extend_from_within(at..end),
            4 => bytes.truncate(at.max(1)),
            5 => {
                let extreme: [&[u8]; 6] = [b"nan", b"1e400", b"-0", b"9223372036854775808", b"\"", b"\xf0\x9f\x8f\x93"];
                bytes.splice(at..end, extreme[below(6)].iter().copied());
            }
            _ => {
                let other = &seeds[below(seeds.len())];
                let from = below(other.len());
                bytes.splice(at..end, other[from..].iter().take(length).copied());
            }
        }
        if bytes.is_empty() {
            bytes.push(0);
        }
    }
    bytes
}

/// A panic in `run` fails the test; the seed and the number of the copy are told.
fn holds(target: &str, run: fn(&[u8])) {
    let (seeds, mut draw) = (seeds(target), Noise(20));
    for (which, seed) in seeds.iter().enumerate() {
        run(seed);
        for copy in 0..COPIES {
            let bytes = corrupted(&seeds, which, &mut draw);
            let tried = std::panic::catch_unwind(|| run(&bytes));
            assert!(tried.is_ok(), "{target}: seed {which}, copy {copy}: {:?}", String::from_utf8_lossy(&bytes));
        }
    }
}

/// Set in the process that runs this test only, whose peak memory is that of the readers.
const ALONE: &str = "TUNENET_FUZZED_ALONE";

#[test]
fn no_reader_panics_or_takes_memory_out_of_proportion() {
    if std::env::var_os(ALONE).is_none() {
        let name = "files::fuzzed::no_reader_panics_or_takes_memory_out_of_proportion";
        let mut alone = std::process::Command::new(std::env::current_exe().unwrap());
        let done = alone.args([name, "--exact"]).env(ALONE, "1").output().unwrap();
        let said = String::from_utf8_lossy(&done.stdout);
        assert!(done.status.success() && said.contains("1 passed"), "{said}{}", String::from_utf8_lossy(&done.stderr));
        return;
    }
    holds("csv", readers::csv);
    holds("mcap", readers::mcap_by_all);
    holds("bag", readers::bag);
    holds("parquet", readers::parquet);
    holds("lerobot", readers::lerobot);
    holds("calibration", readers::calibration);
    holds("hdf5", readers::hdf5);
    holds("npz", readers::npz);
    holds("simulation", readers::simulation);
    holds("task", readers::task);
    holds("model", readers::model);
    // A file of 1 kB that promised a record of half a gigabyte once had it set aside.
    if let Ok(status) = std::fs::read_to_string("/proc/self/status") {
        let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
        let kilobytes: u64 = peak.trim().trim_end_matches(" kB").parse().unwrap();
        assert!(kilobytes < 300_000, "{kilobytes} kB at the most");
    }
}
