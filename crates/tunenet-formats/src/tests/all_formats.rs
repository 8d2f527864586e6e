//! One recording in every format, written by other programs: NumPy, `PyArrow`, h5py and rosbags.

use std::path::Path;
use std::process::Command;

use rand::{Rng as _, SeedableRng as _};

use crate::quantity::Quantity;
use crate::{ReadOptions, UnitRule, read, write_csv, write_mcap};
use tunenet_core::observation::{Kind, Observation};

/// Two joints with their angles, rates and torques at 100 Hz, of random bits.
fn recording() -> Observation {
    let mut draw = rand_chacha::ChaCha8Rng::seed_from_u64(7);
    let clock: Vec<f64> = (0..200).map(|k| f64::from(k) / 100.0).collect();
    let channels = [Quantity::Angle, Quantity::Speed, Quantity::Torque].into_iter();
    let channels = channels.flat_map(|family| [family(1).channel(), family(2).channel()]).collect();
    let values = (0..6 * clock.len()).map(|_| draw.random::<f64>() * 2.0 - 1.0).collect();
    Observation::new(Kind::Joints, channels, clock, values).unwrap()
}

/// What a script of `tests/logs` prints; `None`, with the reason on standard error, where Python or a package is missing.
fn python(script: &str, paths: &[&Path]) -> Option<String> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/logs").join(script);
    let Ok(done) = Command::new("python3").arg(script).args(paths).output() else {
        eprintln!("skipped: python3 is not there");
        return None;
    };
    let said = String::from_utf8_lossy(&done.stderr);
    if said.contains("ModuleNotFoundError") {
        eprintln!("skipped: `make judges` installs what it needs; its folder bin has to come first in PATH: {said}");
        return None;
    }
    assert!(done.status.success(), "{said}");
    Some(String::from_utf8_lossy(&done.stdout).into_owned())
}

#[test]
fn validate_one_recording_in_all_formats_has_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let (expected, csv) = (recording(), folder.path().join("a.csv"));
    write_csv(&expected, &csv).unwrap();
    if python("write_all.py", &[&csv, folder.path()]).is_none() {
        return;
    }
    let seen = |name: &str, options: &ReadOptions| read(folder.path().join(name), options).unwrap().observation;
    let plain = ReadOptions::default();
    for name in ["a.csv", "a.parquet", "a.npz", "sqlite", "sqlite_file", "sqlite_message", "mcap"] {
        assert_eq!(seen(name, &plain), expected, "{name}");
    }
    let pair = |(ours, theirs): (&str, &str)| (ours.to_owned(), theirs.to_owned());
    let numbers = [("t_s", "1"), ("q1..2_rad", "2..3"), ("dq1..2_rad_s", "4..5"), ("tau1..2_nm", "6..7")];
    let numbered = ReadOptions { columns: numbers.map(pair).to_vec(), ..plain.clone() };
    assert_eq!(seen("a.npy", &numbered), expected);
    let unit = |rule: &str| UnitRule::parse(rule).unwrap();
    let names = ["q1", "q2", "dq1", "dq2", "tau1", "tau2"];
    let units = names.iter().zip(["rad", "rad", "rad_s", "rad_s", "nm", "nm"]);
    let stated = units.map(|(name, suffix)| unit(&format!("{name}_{suffix}={suffix}"))).collect();
    let own = names.iter().zip(["rad", "rad", "rad_s", "rad_s", "nm", "nm"]);
    let columns = own.map(|(name, suffix)| (format!("{name}_{suffix}"), format!("{name}_{suffix}"))).collect();
    assert_eq!(seen("a.hdf5", &ReadOptions { columns, units: stated, ..plain.clone() }), expected);
    let angles = [("q1_rad", "shoulder"), ("q2_rad", "elbow")].map(pair).to_vec();
    let found = seen("lerobot", &ReadOptions { columns: angles, units: vec![unit("rad")], ..plain });
    assert_eq!(found.clock(), expected.clock());
    for joint in 0..2 {
        assert!(found.column(joint).eq(expected.column(joint)));
    }
}

#[test]
fn validate_rosbags_reads_the_mcap_that_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let (written, path) = (recording(), folder.path().join("a.mcap"));
    write_mcap(&written, &path).unwrap();
    let Some(text) = python("read_mcap.py", &[&path]) else { return };
    let rows: Vec<Vec<f64>> =
        text.lines().map(|line| line.split(' ').map(|word| word.parse().unwrap()).collect()).collect();
    assert_eq!(rows.len(), written.len());
    for (i, row) in rows.iter().enumerate() {
        assert!((row[0] / 1e9 - written.clock()[i]).abs() < 1e-9 && row[1..] == *written.row(i), "{i}: {row:?}");
    }
}
