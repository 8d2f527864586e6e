use tempfile::TempDir;

use super::*;

const HASH: &str = "0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef";

fn request(value: f64) -> Request {
    Request { variant: 0, recording: 1, samples: 2, values: vec![value.to_bits()] }
}

fn answer(value: f64) -> Vec<f64> {
    vec![value, -0.0, 0.1 + 0.2, 5e-324]
}

fn bits(numbers: &[f64]) -> Vec<u64> {
    numbers.iter().map(|number| number.to_bits()).collect()
}

/// A file with three answers of two channels, and its bytes.
fn kept() -> (TempDir, PathBuf, Vec<u8>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.rollouts");
    let file = RolloutFile::open(&path, HASH, 2).unwrap();
    for value in [1.0, 2.0, 3.0, 1.0] {
        file.keep(&request(value), &answer(value));
    }
    assert_eq!(file.used(), RolloutFileUse { kept: 3, recalled: 0, incomplete: None });
    drop(file);
    let bytes = std::fs::read(&path).unwrap();
    (folder, path, bytes)
}

#[test]
fn answers_come_back_bit_for_bit_and_count_once() {
    let (_folder, path, _) = kept();
    let file = RolloutFile::open(&path, HASH, 2).unwrap();
    for _ in 0..2 {
        assert_eq!(bits(&file.recall(&request(2.0)).unwrap()), bits(&answer(2.0)));
    }
    assert_eq!(file.recall(&Request { variant: 1, ..request(2.0) }), None);
    file.keep(&request(4.0), &answer(4.0));
    assert_eq!(file.recall(&request(4.0)), Some(answer(4.0)));
    assert_eq!(file.used(), RolloutFileUse { kept: 4, recalled: 1, incomplete: None });
}

#[test]
fn a_file_cut_anywhere_holds_the_whole_records_before_and_goes_on() {
    let (_folder, path, bytes) = kept();
    let first = bytes.iter().position(|byte| *byte == b'\n').unwrap() + 1;
    let record = (bytes.len() - first) / 3;
    for cut in 0..bytes.len() {
        std::fs::write(&path, &bytes[..cut]).unwrap();
        let file = RolloutFile::open(&path, HASH, 2).unwrap();
        assert_eq!(file.used().kept, cut.saturating_sub(first) / record, "cut at {cut}");
        for value in [1.0, 2.0, 3.0] {
            file.keep(&request(value), &answer(value));
        }
        drop(file);
        assert!(std::fs::read(&path).unwrap() == bytes, "cut at {cut}");
    }
}

#[test]
fn a_changed_byte_is_refused_or_ends_the_file_and_never_changes_an_answer() {
    let (_folder, path, bytes) = kept();
    for (at, flip) in (0..bytes.len()).flat_map(|at| [1, 0x80, 0xff].map(|flip| (at, flip))) {
        let mut changed = bytes.clone();
        changed[at] ^= flip;
        std::fs::write(&path, &changed).unwrap();
        let Ok(file) = RolloutFile::open(&path, HASH, 2) else { continue };
        for value in [1.0, 2.0, 3.0] {
            let found = file.recall(&request(value));
            assert!(found.is_none_or(|found| bits(&found) == bits(&answer(value))), "byte {at} ^ {flip}");
        }
        assert!(file.used().kept < 3, "byte {at} ^ {flip}");
    }
}

/// Refused with one sentence that holds `wanted`, and left as it is.
#[track_caller]
fn refused(path: &Path, channels: usize, wanted: &str) {
    let before = std::fs::read(path).unwrap();
    let error = RolloutFile::open(path, HASH, channels).unwrap_err();
    assert!(error.to_string().contains(wanted) && error.hint() == Some(ANOTHER), "{error}");
    assert!(std::fs::read(path).unwrap() == before, "{wanted}");
}

#[test]
fn other_files_and_other_problems_are_refused_and_left_as_they_are() {
    let (_folder, path, bytes) = kept();
    refused(&path, 3, "a damaged one");
    std::fs::write(&path, [&bytes[..], b"\x08\0\0\0 nothing that was written, and more"].concat()).unwrap();
    refused(&path, 2, "a damaged one");
    std::fs::write(&path, String::from_utf8_lossy(&bytes).replacen("0123", "f00d", 1)).unwrap();
    refused(&path, 2, "(SHA-256 0123456789ab), found those of others (f00d456789ab)");
    std::fs::write(&path, String::from_utf8_lossy(&bytes).replacen("rollouts.1", "rollouts.2", 1)).unwrap();
    refused(&path, 2, "found another file");
    for other in ["t_s,z_m\n0,1\n", "{}\n", "no line", "\n"] {
        std::fs::write(&path, other).unwrap();
        refused(&path, 2, "found another file");
        assert!(!RolloutFile::is_one(&path));
    }
}

#[test]
fn numbers_that_no_simulator_answers_are_refused() {
    let (_folder, path, bytes) = kept();
    for value in [f64::NAN, f64::INFINITY, 1e101] {
        let forged = record::encode(&request(9.0), &answer(value)).unwrap();
        // Behind it a whole one, so that it is not the last.
        let good = record::encode(&request(8.0), &answer(8.0)).unwrap();
        std::fs::write(&path, [&bytes[..], &forged, &good].concat()).unwrap();
        refused(&path, 2, "a damaged one");
    }
    let huge = Request { samples: usize::MAX, ..request(9.0) };
    let forged = record::encode(&huge, &answer(1.0)).unwrap();
    std::fs::write(&path, [&bytes[..], &forged].concat()).unwrap();
    refused(&path, 2, "a damaged one");
}

#[test]
fn a_file_in_use_and_a_folder_are_refused() {
    let (folder, path, _) = kept();
    let first = RolloutFile::open(&path, HASH, 2).unwrap();
    let error = RolloutFile::open(&path, HASH, 2).unwrap_err();
    assert!(error.to_string().contains("found it in use"), "{error}");
    drop(first);
    assert!(RolloutFile::open(&path, HASH, 2).is_ok() && RolloutFile::is_one(&path));
    let error = RolloutFile::open(folder.path(), HASH, 2).unwrap_err();
    assert!(error.to_string().contains("found a folder"), "{error}");
}

#[test]
fn a_full_file_keeps_what_it_has_and_says_so() {
    let (_folder, path, bytes) = kept();
    let file = RolloutFile::open(&path, HASH, 2).unwrap();
    file.state().most = bytes.len() as u64 + 10;
    for value in [4.0, 5.0] {
        file.keep(&request(value), &answer(value));
    }
    let used = file.used();
    assert!(used.kept == 3 && used.incomplete.unwrap().starts_with("it would be longer than "));
    assert!(file.recall(&request(3.0)).is_some() && file.recall(&request(4.0)).is_none());
    assert!(std::fs::read(&path).unwrap() == bytes);
    file.clear().unwrap();
    assert_eq!((file.used().kept, std::fs::read(&path).unwrap().len()), (0, 0));
}
