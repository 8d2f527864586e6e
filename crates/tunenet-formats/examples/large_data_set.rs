//! Writes a large data set of LeRobot (version 3) into a folder for temporary files, lists it and reads single episodes of it, and prints
//! the time and the peak memory of each step: `large_data_set [GIGABYTES]`, or `large_data_set GIGABYTES FOLDER`, which keeps the
//! data set. It ends with status 1 if the peak exceeds what one episode and the index need.

use std::fs::File;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use parquet::data_type::{FloatType, Int64Type};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::parser::parse_message_type;
use rand::{Rng as _, SeedableRng as _};
use tunenet_core::observation::Channel;
use tunenet_formats::{ReadOptions, Result, UnitRule, contents, episodes, read};

/// Joints, frames of an episode (20 s at 50 Hz), and episodes of a file; a frame takes 4 bytes for each joint and each command.
const JOINTS: usize = 14;
const FRAMES: usize = 1_000;
const IN_FILE: usize = 1_000;
const FRAME_BYTES: usize = 2 * 4 * JOINTS + 20;

/// Peak memory that is allowed, in MB: one column of a group of rows, the program itself, and some leeway.
const MOST_MB: u64 = 300;

type Done = std::result::Result<(), Box<dyn std::error::Error>>;

/// A column of whole numbers.
fn whole(group: &mut SerializedRowGroupWriter<'_, File>, values: &[i64]) -> Done {
    let mut column = group.next_column()?.ok_or("a column")?;
    column.typed::<Int64Type>().write_batch(values, None, None)?;
    Ok(column.close()?)
}

/// A column of numbers, or of lists of `width`.
fn numbers(group: &mut SerializedRowGroupWriter<'_, File>, width: usize, values: &[f32]) -> Done {
    let mut column = group.next_column()?.ok_or("a column")?;
    let levels = vec![2; values.len()];
    let repetition: Vec<i16> = (0..values.len()).map(|i| i16::from(i % width != 0)).collect();
    let lists = width > 1;
    let typed = column.typed::<FloatType>();
    typed.write_batch(values, lists.then_some(&levels[..]), lists.then_some(&repetition[..]))?;
    Ok(column.close()?)
}

/// Writes a file of episodes from number `first` on in one group of rows, as LeRobot does.
fn write_file(path: &Path, first: usize, count: usize) -> Done {
    let schema = "message frames {
        required group observation.state (LIST) { repeated group list { optional float element; } }
        required group action (LIST) { repeated group list { optional float element; } }
        required float timestamp; required int64 frame_index; required int64 episode_index; }";
    let schema = Arc::new(parse_message_type(schema)?);
    let properties = WriterProperties::builder().set_dictionary_enabled(false).set_max_row_group_row_count(None);
    let mut writer = SerializedFileWriter::new(File::create(path)?, schema, Arc::new(properties.build()))?;
    let mut group = writer.next_row_group()?;
    let mut draw = rand_chacha::ChaCha8Rng::seed_from_u64(first as u64);
    let frames = count * FRAMES;
    for _ in 0..2 {
        let values: Vec<f32> = (0..frames * JOINTS).map(|_| draw.random::<f32>()).collect();
        numbers(&mut group, JOINTS, &values)?;
    }
    let in_episode = |frame: usize| frame % FRAMES;
    numbers(&mut group, 1, &(0..frames).map(|frame| in_episode(frame) as f32 / 50.0).collect::<Vec<f32>>())?;
    let index = |frame: usize| i64::try_from(in_episode(frame)).unwrap_or(0);
    whole(&mut group, &(0..frames).map(index).collect::<Vec<i64>>())?;
    let episode = |frame: usize| i64::try_from(first + frame / FRAMES).unwrap_or(0);
    whole(&mut group, &(0..frames).map(episode).collect::<Vec<i64>>())?;
    group.close()?;
    writer.close()?;
    Ok(())
}

/// Writes the table of the episodes: number, length, chunk and file of each.
fn write_index(path: &Path, count: usize) -> Done {
    let schema = "message episodes { required int64 episode_index; required int64 length;
        required int64 data/chunk_index; required int64 data/file_index; }";
    let schema = Arc::new(parse_message_type(schema)?);
    let mut writer = SerializedFileWriter::new(File::create(path)?, schema, Arc::default())?;
    let mut group = writer.next_row_group()?;
    let number = |i: usize| i64::try_from(i).unwrap_or(0);
    for column in [&number as &dyn Fn(usize) -> i64, &|_| number(FRAMES), &|_| 0, &|i| number(i / IN_FILE)] {
        whole(&mut group, &(0..count).map(column).collect::<Vec<i64>>())?;
    }
    group.close()?;
    writer.close()?;
    Ok(())
}

fn write(folder: &Path, gigabytes: f64) -> Done {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a positive number of episodes")]
    let count = (gigabytes * 1e9 / (FRAME_BYTES * FRAMES) as f64).max(1.0) as usize;
    for part in ["meta/episodes/chunk-000", "data/chunk-000"] {
        std::fs::create_dir_all(folder.join(part))?;
    }
    let names: Vec<String> = (0..JOINTS).map(|joint| format!("joint_{joint}.pos")).collect();
    let row = serde_json::json!({ "dtype": "float32", "shape": [JOINTS], "names": names });
    let info = serde_json::json!({
        "codebase_version": "v3.0", "robot_type": "made", "fps": 50, "total_episodes": count,
        "features": { "observation.state": row, "action": row },
    });
    std::fs::write(folder.join("meta/info.json"), info.to_string())?;
    for first in (0..count).step_by(IN_FILE) {
        let path = folder.join(format!("data/chunk-000/file-{:03}.parquet", first / IN_FILE));
        write_file(&path, first, IN_FILE.min(count - first))?;
    }
    write_index(&folder.join("meta/episodes/chunk-000/file-000.parquet"), count)
}

/// Peak memory of this process in MB, where the system states it (Linux).
fn peak_mb() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().trim_end_matches(" kB").parse::<u64>().ok().map(|kilobytes| kilobytes / 1000)
}

fn timed<T>(what: &str, step: impl FnOnce() -> Result<T>) -> Result<T> {
    let start = Instant::now();
    let done = step()?;
    let peak = peak_mb().map_or("unknown".into(), |mb| format!("{mb} MB"));
    println!("{what}: {:.2} s, peak memory {peak}", start.elapsed().as_secs_f64());
    Ok(done)
}

fn main() -> std::result::Result<ExitCode, Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let gigabytes: f64 = arguments.next().map_or(Ok(2.0), |text| text.parse())?;
    let temporary = tempfile::tempdir()?;
    let folder = arguments.next().map_or_else(|| temporary.path().to_owned(), Into::into);
    // Writing takes more memory than reading, so another process does it.
    if std::env::var_os(WRITES).is_some() {
        write(&folder, gigabytes)?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut other = std::process::Command::new(std::env::current_exe()?);
    if !other.arg(gigabytes.to_string()).arg(&folder).env(WRITES, "1").status()?.success() {
        return Ok(ExitCode::FAILURE);
    }
    timed("listed", || contents(&folder))?;
    let all = timed("named", || episodes(&folder, None))?.unwrap_or_else(|| vec![folder.join("episode_0")]);
    let channel = Channel::from_header("joint_3_rad").ok_or("a channel")?;
    let units = vec![UnitRule::parse("rad")?];
    let options = ReadOptions { channels: vec![channel], units, ..ReadOptions::default() };
    for episode in [&all[0], &all[all.len() / 2], &all[all.len() - 1]] {
        let name = episode.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let seen = timed(&name, || read(episode, &options))?.observation;
        assert_eq!(seen.len(), FRAMES, "{name}");
    }
    let mut some = all.iter().step_by(all.len().div_ceil(100));
    timed("a hundred episodes", || some.try_for_each(|episode| read(episode, &options).map(drop)))?;
    Ok(if peak_mb().is_some_and(|mb| mb > MOST_MB) { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

/// Set in the process that writes the data set.
const WRITES: &str = "TUNENET_LARGE_DATA_SET_WRITES";
