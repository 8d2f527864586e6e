//! Data sets made in code.

use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use parquet::column::reader::ColumnReader;
use parquet::data_type::{FloatType, Int64Type};
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;
use serde_json::{Value, json};

use crate::testing::{claim_rows, error_text};
use crate::{Contents, ReadOptions, UnitRule, contents, episodes, findings, read};
use tunenet_core::observation::Channel;

/// Readings of an encoder with 4096 counts a turn, normalised over `counts` of them.
fn reading(frame: u32, joint: u32, counts: u32) -> f32 {
    let count = 200 + (frame * frame * 7 + frame * 3 + joint * 31) % (counts - 400);
    count as f32 / counts as f32 * 200.0 - 100.0
}

/// Writes frames of these episodes into one file, a group of rows for each; joints `a` and `b`, commands one more.
fn data(path: &Path, episodes: &[(i64, u32)]) {
    frames(path, episodes, |frame, joint| reading(frame, joint, if joint == 0 { 1789 } else { 2477 }));
}

fn frames(path: &Path, episodes: &[(i64, u32)], reading: impl Fn(u32, u32) -> f32) {
    stamped(path, episodes, reading, |k| k as f32 / 30.0);
}

fn stamped(path: &Path, episodes: &[(i64, u32)], reading: impl Fn(u32, u32) -> f32, stamp: impl Fn(u32) -> f32) {
    let schema = "message frames {
        required group observation.state (LIST) { repeated group list { optional float element; } }
        required group action (LIST) { repeated group list { optional float element; } }
        required float timestamp; required int64 frame_index; required int64 episode_index; }";
    let schema = Arc::new(parse_message_type(schema).unwrap());
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    let properties = Arc::new(WriterProperties::builder().build());
    let mut writer = SerializedFileWriter::new(File::create(path).unwrap(), schema, properties).unwrap();
    for (episode, frames) in episodes {
        let mut group = writer.next_row_group().unwrap();
        let frame: Vec<i64> = (0..i64::from(*frames)).collect();
        for offset in [0.0, 1.0] {
            let values: Vec<f32> =
                (0..*frames).flat_map(|k| [reading(k, 0) + offset, reading(k, 1) + offset]).collect();
            let levels = vec![2; values.len()];
            let repetition: Vec<i16> = (0..values.len()).map(|i| i16::from(i % 2 == 1)).collect();
            let mut column = group.next_column().unwrap().unwrap();
            column.typed::<FloatType>().write_batch(&values, Some(&levels), Some(&repetition)).unwrap();
            column.close().unwrap();
        }
        let stamps: Vec<f32> = (0..*frames).map(&stamp).collect();
        let mut column = group.next_column().unwrap().unwrap();
        column.typed::<FloatType>().write_batch(&stamps, None, None).unwrap();
        column.close().unwrap();
        for values in [frame.clone(), vec![*episode; frame.len()]] {
            let mut column = group.next_column().unwrap().unwrap();
            column.typed::<Int64Type>().write_batch(&values, None, None).unwrap();
            column.close().unwrap();
        }
        group.close().unwrap();
    }
    writer.close().unwrap();
}

fn info(folder: &Path, version: &str, names: &Value) {
    let row = json!({ "dtype": "float32", "shape": [2], "names": names });
    let info = json!({
        "codebase_version": version, "robot_type": "so101", "fps": 30, "total_episodes": 3,
        "features": { "observation.state": row, "action": row, "timestamp": { "dtype": "float32", "shape": [1], "names": null } },
    });
    std::fs::create_dir_all(folder.join("meta")).unwrap();
    std::fs::write(folder.join("meta/info.json"), info.to_string()).unwrap();
}

fn units(text: &str) -> Vec<UnitRule> {
    text.split(',').map(|rule| UnitRule::parse(rule).unwrap()).collect()
}

/// The layouts of versions 2 and 3 with the same three episodes.
fn both() -> (tempfile::TempDir, std::path::PathBuf, std::path::PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let (old, new) = (folder.path().join("old"), folder.path().join("new"));
    info(&old, "v2.1", &json!({ "motors": ["a.pos", "b.pos"] }));
    for (episode, frames) in [(0, 40), (1, 50), (2, 60)] {
        data(&old.join(format!("data/chunk-000/episode_{episode:06}.parquet")), &[(episode, frames)]);
    }
    info(&new, "v3.0", &json!([["a.pos", "b.pos"]]));
    data(&new.join("data/chunk-000/file-000.parquet"), &[(0, 40), (1, 20)]);
    data(&new.join("data/chunk-000/file-001.parquet"), &[(2, 60)]);
    (folder, old, new)
}

fn state(rules: &str) -> ReadOptions {
    let channels = ["a_rad", "b_rad"].map(|header| Channel::from_header(header).unwrap()).to_vec();
    ReadOptions { channels, units: if rules.is_empty() { Vec::new() } else { units(rules) }, ..ReadOptions::default() }
}

#[test]
fn an_episode_reads_alike_from_files_of_its_own_and_from_shared_ones() {
    let (_folder, old, new) = both();
    let options = state("a=deg,b=2deg");
    let found = read(old.join("episode_2"), &options).unwrap();
    assert_eq!(read(new.join("episode_2"), &options).unwrap(), found);
    let seen = &found.observation;
    assert_eq!((seen.len(), seen.clock()[7].to_bits()), (60, (7.0f64 / 30.0).to_bits()));
    let degree = std::f64::consts::PI / 180.0;
    assert_eq!(seen.row(5), [f64::from(reading(5, 0, 1789)) * degree, f64::from(reading(5, 1, 2477)) * (2.0 * degree)]);
    assert!(found.notes.iter().any(|note| note.kind == findings::CLOCK_COMPUTED));
    // One of an episode's file is said to be another's.
    let moved = old.join("data/chunk-000/episode_000009.parquet");
    std::fs::rename(old.join("data/chunk-000/episode_000001.parquet"), moved).unwrap();
    let (message, _) = error_text(&read(old.join("episode_9"), &options).unwrap_err());
    assert!(message.ends_with("expected frames of episode 9, found one of episode 1"), "{message}");
}

#[test]
fn an_episode_amid_a_group_of_rows_reads_as_by_itself() {
    let (_folder, old, new) = both();
    // One group of rows, as other writers make: all three episodes in pages of seven rows.
    let path = new.join("data/chunk-000/file-000.parquet");
    std::fs::remove_file(new.join("data/chunk-000/file-001.parquet")).unwrap();
    let whole = new.join("whole.parquet");
    data(&whole, &[(0, 40), (1, 50), (2, 60)]);
    let merged = SerializedFileReader::new(File::open(&whole).unwrap()).unwrap();
    let schema = merged.metadata().file_metadata().schema_descr().root_schema_ptr();
    let properties =
        Arc::new(WriterProperties::builder().set_data_page_row_count_limit(7).set_write_batch_size(5).build());
    let mut writer = SerializedFileWriter::new(File::create(&path).unwrap(), schema, properties).unwrap();
    let mut group = writer.next_row_group().unwrap();
    for at in 0..5 {
        let (mut floats, mut whole, mut definition, mut repetition) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for part in 0..3 {
            let rows = merged.get_row_group(part).unwrap();
            match rows.get_column_reader(at).unwrap() {
                ColumnReader::FloatColumnReader(mut from) => {
                    from.read_records(1000, Some(&mut definition), Some(&mut repetition), &mut floats).unwrap();
                }
                ColumnReader::Int64ColumnReader(mut from) => {
                    from.read_records(1000, None, None, &mut whole).unwrap();
                }
                _ => panic!("another column"),
            }
        }
        let mut column = group.next_column().unwrap().unwrap();
        if at < 3 {
            let levels = (at < 2).then_some(());
            let written = column.typed::<FloatType>();
            written.write_batch(&floats, levels.map(|()| &definition[..]), levels.map(|()| &repetition[..])).unwrap();
        } else {
            column.typed::<Int64Type>().write_batch(&whole, None, None).unwrap();
        }
        column.close().unwrap();
    }
    group.close().unwrap();
    writer.close().unwrap();
    for episode in ["episode_0", "episode_1", "episode_2"] {
        let alone = read(old.join(episode), &state("rad")).unwrap();
        assert_eq!(read(new.join(episode), &state("rad")).unwrap(), alone, "{episode}");
    }
}

#[test]
fn units_are_asked_for_by_the_flag_that_the_numbers_suggest() {
    let (_folder, _, new) = both();
    let (message, hint) = error_text(&read(new.join("episode_2"), &state("")).unwrap_err());
    assert!(message.contains("the unit of `a` is not stated in the file (normalised, as of LeRobot"), "{message}");
    // 1789 and 2477 counts of 360°/4096 over 200.
    assert!(hint.contains("`--units a=0.7862deg,b=1.0885deg`"), "{hint}");
    let Contents::Episodes(listed) = contents(&new).unwrap() else { panic!("episodes") };
    // What is said of a joint holds for its command.
    assert_eq!(listed.units, "a=0.7862deg,b=1.0885deg");
    assert_eq!(listed.episodes.iter().map(|e| e.frames).collect::<Vec<_>>(), [Some(40), Some(20), Some(60)]);
    let unknown = read(new.join("episode_2"), &state("c=deg")).unwrap_err().to_string();
    assert!(unknown.contains("one of the columns `a`, `b`, `action.a`, `action.b`"), "{unknown}");
    // What is mapped has no unit either.
    let columns = vec![("u_v".to_owned(), "action.a".to_owned())];
    let input = ReadOptions { columns, channels: vec![Channel::from_header("u_v").unwrap()], ..ReadOptions::default() };
    assert!(
        error_text(&read(new.join("episode_2"), &input).unwrap_err())
            .0
            .contains("the unit of `action.a` is not stated")
    );
    let plain = ReadOptions { units: units("action.a=1"), ..input };
    assert_eq!(read(new.join("episode_2"), &plain).unwrap().observation.row(3), [f64::from(reading(3, 0, 1789) + 1.0)]);
}

#[test]
fn a_listing_refuses_a_clock_that_falls_as_reading_does() {
    let folder = tempfile::tempdir().unwrap();
    info(folder.path(), "v2.1", &json!(["a", "b"]));
    let stamp = |k: u32| if k < 50 { k as f32 / 30.0 } else { k as f32 / 30.0 - 5.0 };
    let file = folder.path().join("data/chunk-000/episode_000000.parquet");
    stamped(&file, &[(0, 100)], |frame, joint| reading(frame, joint, 1789), stamp);
    let listed = contents(folder.path()).unwrap_err().to_string();
    assert!(listed.contains("episode_0: `timestamp` does not rise in frame 51"), "{listed}");
    assert_eq!(read(folder.path().join("episode_0"), &state("*=deg")).unwrap_err().to_string(), listed);
}

#[test]
fn several_episodes_are_chosen_by_name_or_number() {
    let (_folder, old, new) = both();
    let (message, hint) = error_text(&read(&new, &state("rad")).unwrap_err());
    assert!(message.ends_with("expected one recording, found 3 episodes"), "{message}");
    assert!(hint.contains("new/episode_0") && hint.contains("--episodes"), "{hint}");
    let names = |asked: &str| {
        let all = episodes(&new, Some(&asked.parse().unwrap())).unwrap().unwrap();
        all.iter().map(|path| path.file_name().unwrap().to_str().unwrap().to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(names("1-2"), ["episode_1", "episode_2"]);
    assert_eq!(names("2,0"), ["episode_2", "episode_0"]);
    let absent = episodes(&old, Some(&"5-7".parse().unwrap())).unwrap_err().to_string();
    assert!(absent.contains("found 5-7"), "{absent}");
    // A folder above it is the data set as well.
    assert_eq!(read(old.parent().unwrap().join("old/episode_1"), &state("rad")).unwrap().observation.len(), 50);
}

#[cfg(unix)]
#[test]
fn a_file_that_cannot_be_read_is_no_pointer() {
    let (_folder, old, _) = both();
    for path in [old.join("data/chunk-000/episode_000001.parquet"), old.join("meta/episodes.jsonl")] {
        let _ = std::fs::remove_file(&path);
        // It is there and cannot be opened: a pipe waits for its writer.
        let made = std::process::Command::new("mkfifo").arg(&path).status().unwrap();
        assert!(made.success());
        let (message, _) = error_text(&episodes(&old, None).unwrap_err());
        assert!(message.ends_with("expected a file, found a pipe"), "{message}");
        std::fs::remove_file(&path).unwrap();
    }
}

#[cfg(unix)]
#[test]
fn an_episode_is_read_without_looking_at_the_others() {
    let (_folder, old, new) = both();
    let pipe = |path: &Path| {
        let _ = std::fs::remove_file(path);
        assert!(std::process::Command::new("mkfifo").arg(path).status().unwrap().success());
    };
    pipe(&old.join("data/chunk-000/episode_000001.parquet"));
    assert_eq!(read(old.join("episode_2"), &state("rad")).unwrap().observation.len(), 60);
    table(&new, &[[0, 40, 0, 0], [1, 20, 0, 0], [2, 60, 0, 1]]);
    std::fs::remove_file(new.join("data/chunk-000/file-000.parquet")).unwrap();
    assert_eq!(read(new.join("episode_2"), &state("rad")).unwrap().observation.len(), 60);
    let Contents::Episodes(listed) = contents(new.join("episode_2")).unwrap() else { panic!("episodes") };
    assert_eq!((listed.episodes.len(), listed.episodes[0].name.as_str()), (1, "episode_2"));
    assert_eq!(listed.notes, []);
    for absent in ["episode_0", "episode_7"] {
        let (message, _) = error_text(&contents(new.join(absent)).unwrap_err());
        assert!(message.contains("expected an episode that is there (`episode_2`), found"), "{message}");
    }
}

#[test]
fn lengths_of_episodes_are_read_line_by_line() {
    let (_folder, old, _) = both();
    let long = "x".repeat(3 << 20);
    let lines =
        format!("{{\"episode_index\": 0, \"length\": 40}}\n{long}\nno JSON\n{{\"episode_index\": 2, \"length\": 60}}");
    std::fs::write(old.join("meta/episodes.jsonl"), lines).unwrap();
    let Contents::Episodes(listed) = contents(&old).unwrap() else { panic!("episodes") };
    assert_eq!(listed.episodes.iter().map(|e| e.frames).collect::<Vec<_>>(), [Some(40), None, Some(60)]);
}

/// The table of episodes of version 3: number, length, chunk and file of each.
fn table(folder: &Path, rows: &[[i64; 4]]) {
    let schema = "message episodes { required int64 episode_index; required int64 length;
        required int64 data/chunk_index; required int64 data/file_index; }";
    let path = folder.join("meta/episodes/chunk-000/file-000.parquet");
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    let (schema, properties) =
        (Arc::new(parse_message_type(schema).unwrap()), Arc::new(WriterProperties::builder().build()));
    let mut writer = SerializedFileWriter::new(File::create(path).unwrap(), schema, properties).unwrap();
    let mut group = writer.next_row_group().unwrap();
    for at in 0..4 {
        let values: Vec<i64> = rows.iter().map(|row| row[at]).collect();
        let mut column = group.next_column().unwrap().unwrap();
        column.typed::<Int64Type>().write_batch(&values, None, None).unwrap();
        column.close().unwrap();
    }
    group.close().unwrap();
    writer.close().unwrap();
}

#[test]
fn an_episode_that_is_listed_twice_is_one() {
    let (_folder, old, new) = both();
    table(&new, &[[0, 40, 0, 0], [1, 20, 0, 0], [1, 20, 0, 0], [2, 60, 0, 1]]);
    let names = |all: Vec<std::path::PathBuf>| -> Vec<String> {
        all.iter().map(|path| path.file_name().unwrap().to_str().unwrap().to_owned()).collect()
    };
    assert_eq!(names(episodes(&new, None).unwrap().unwrap()), ["episode_0", "episode_1", "episode_2"]);
    assert_eq!(read(new.join("episode_1"), &state("rad")).unwrap().observation.len(), 20);
    // A file of its own is there once.
    std::fs::create_dir(old.join("data/chunk-001")).unwrap();
    let copy = old.join("data/chunk-001/episode_000001.parquet");
    std::fs::copy(old.join("data/chunk-000/episode_000001.parquet"), copy).unwrap();
    let refused = episodes(&old, None).unwrap_err().to_string();
    assert!(refused.contains("expected one file of episode 1, found"), "{refused}");
}

#[test]
fn what_is_missing_or_was_not_downloaded_is_named() {
    let (_folder, old, new) = both();
    let pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 7\n";
    std::fs::write(old.join("data/chunk-000/episode_000001.parquet"), pointer).unwrap();
    let Contents::Episodes(listed) = contents(&old).unwrap() else { panic!("episodes") };
    assert_eq!((listed.notes[0].kind, listed.episodes.len()), (findings::EPISODES_MISSING, 2));
    assert!(listed.notes[0].remedy.contains("git lfs pull"), "{:?}", listed.notes);
    let (_, hint) = error_text(&read(old.join("episode_1"), &state("rad")).unwrap_err());
    assert!(hint.contains("git lfs pull"), "{hint}");
    for file in ["file-000.parquet", "file-001.parquet"] {
        std::fs::write(new.join("data/chunk-000").join(file), pointer).unwrap();
    }
    assert!(contents(&new).unwrap_err().to_string().contains("a Git LFS pointer"));
    info(&new, "v1.6", &json!(["a", "b"]));
    assert!(contents(&new).unwrap_err().to_string().contains("of version 2 or 3, found `v1.6`"));
}

#[test]
fn a_robot_that_stands_still_is_noticed() {
    let folder = tempfile::tempdir().unwrap();
    info(folder.path(), "v3.0", &json!(["a", "b"]));
    let path = folder.path().join("data/chunk-000/file-000.parquet");
    let still =
        || read(folder.path(), &state("rad")).unwrap().notes.into_iter().find(|n| n.kind == findings::STATE_CONSTANT);
    data(&path, &[(0, 30)]);
    assert_eq!(still(), None);
    frames(&path, &[(0, 30)], |_, _| 0.25);
    assert!(still().unwrap().text.ends_with("stands still: `a`, `b`, `action.a`, `action.b`"));
}

#[test]
fn frames_that_only_the_end_of_a_file_counts_are_none() {
    let folder = tempfile::tempdir().unwrap();
    info(folder.path(), "v2.1", &json!(["a", "b"]));
    let path = folder.path().join("data/chunk-000/episode_000000.parquet");
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    let schema = Arc::new(parse_message_type("message frames { required float other; }").unwrap());
    let properties = Arc::new(WriterProperties::builder().build());
    let mut writer = SerializedFileWriter::new(File::create(&path).unwrap(), schema, properties).unwrap();
    let mut group = writer.next_row_group().unwrap();
    let mut column = group.next_column().unwrap().unwrap();
    column.typed::<FloatType>().write_batch(&[0.0, 1.0, 2.0], None, None).unwrap();
    column.close().unwrap();
    group.close().unwrap();
    writer.close().unwrap();
    claim_rows(&path, i64::MAX);
    let message = read(folder.path().join("episode_0"), &state("rad")).unwrap_err().to_string();
    assert!(message.contains("expected a column"), "{message}");
    // Without any features, no column says how many there are.
    let empty = json!({ "codebase_version": "v2.1", "fps": 30, "features": {} });
    std::fs::write(folder.path().join("meta/info.json"), empty.to_string()).unwrap();
    let message = read(folder.path().join("episode_0"), &state("rad")).unwrap_err().to_string();
    assert!(message.contains("expected frames in episode 0, found none"), "{message}");
}
