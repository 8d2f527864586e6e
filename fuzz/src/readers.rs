//! What the fuzz targets and the test of their corpora run: every reader of a foreign file, on bytes of any kind.
//!
//! A reader may refuse; it may neither panic nor take memory out of proportion. What it accepts has to hold what it promises.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use tunenet_core::network::Side;
use tunenet_core::observation::{Kind, Observation};
use tunenet_core::simulator::Scale;
use tunenet_formats::dataset::DatasetReader;
use tunenet_formats::pictures::pictures;
use tunenet_formats::{ReadOptions, UnitRule, contents_with, read, read_calibration};
use tunenet_formats::{model_from_bytes, model_to_bytes};
use tunenet_sim::shot::Task;
use tunenet_sim::{Session, SimulationFile, simulator};

/// A file of this process in memory, where the system has such a folder.
fn file(name: &str, bytes: &[u8]) -> PathBuf {
    let memory = Path::new("/dev/shm");
    let folder = if memory.is_dir() { memory.to_path_buf() } else { std::env::temp_dir() };
    let path = folder.join(format!("tunenet-fuzz-{}-{name}", std::process::id()));
    std::fs::write(&path, bytes).expect("a file of this process");
    path
}

/// The first byte, which chooses among `count`, and the rest.
fn choice(bytes: &[u8], count: usize) -> (usize, &[u8]) {
    bytes.split_first().map_or((0, bytes), |(first, rest)| (usize::from(*first) % count, rest))
}

/// Every number of an observation is finite, and its clock rises.
fn sound(seen: &Observation) {
    assert!(seen.values().iter().all(|v| v.is_finite()), "a number that is not finite was read");
    assert!(seen.clock().windows(2).all(|w| w[0] < w[1]), "a clock that does not rise was read");
}

/// A table: the first byte says how it is read.
pub fn csv(bytes: &[u8]) {
    let (way, bytes) = choice(bytes, 5);
    let pairs = |text: &[(&str, &str)]| text.iter().map(|(a, b)| ((*a).into(), (*b).into())).collect();
    let options = ReadOptions {
        columns: match way {
            1 => pairs(&[("t_s", "time"), ("z_mm", "height")]),
            2 => pairs(&[("t_ms", "1"), ("q1..2_rad", "2..3"), ("tau1..2_nm", "effort_*")]),
            _ => Vec::new(),
        },
        skip_broken: way == 3,
        joints: if way == 4 { vec!["shoulder".into(), "elbow".into()] } else { Vec::new() },
        ..ReadOptions::default()
    };
    let path = file("a.csv", bytes);
    let _ = contents_with(&path, &options);
    if let Ok(found) = read(&path, &options) {
        sound(&found.observation);
    }
}

/// The kinds of message that are read, and one that is not. The last is read by its definition.
const SCHEMAS: [(&str, &str); 10] = [
    ("geometry_msgs/msg/PointStamped", "cdr"),
    ("geometry_msgs/msg/PoseStamped", "cdr"),
    ("nav_msgs/msg/Odometry", "cdr"),
    ("sensor_msgs/msg/JointState", "cdr"),
    ("sensor_msgs/msg/Image", "cdr"),
    ("sensor_msgs/msg/CompressedImage", "cdr"),
    ("anything", "json"),
    ("other/msg/Thing", "cdr"),
    ("trajectory_msgs/msg/JointTrajectory", "cdr"),
    ("motor/msg/Status", "cdr"),
];

/// Fields of every kind.
const DEFINITION: &str = "\
std_msgs/Header header
bool on
string[] names
float64[] position
float32[2] gains
Axis[] axes
================================================================================
MSG: motor/Axis
int16 count
uint8[<=4] bytes
string label
";

/// What reads a log: the listing, the recording, one topic of joints by name, the numbers of a topic as columns, the pictures, the pairs.
const LOG_READERS: usize = 6;

/// A log: the first byte says which reader gets it, and whether these bytes are the file (even) or the file is well formed
/// and only the messages in it are foreign: a byte for the kind, one for the length, one for the time, and so many bytes.
pub fn mcap(bytes: &[u8]) {
    let (way, bytes) = choice(bytes, 2 * LOG_READERS);
    read_log(way / 2, way % 2 == 1, bytes);
}

/// As [`mcap`], by every reader.
pub fn mcap_by_all(bytes: &[u8]) {
    let (way, bytes) = choice(bytes, 2);
    (0..LOG_READERS).for_each(|reader| read_log(reader, way == 1, bytes));
}

fn read_log(reader: usize, messages: bool, bytes: &[u8]) {
    let bytes = if messages { Cow::Owned(log(bytes)) } else { Cow::Borrowed(bytes) };
    let path = file("a.mcap", &bytes);
    let named = || vec!["elbow".into(), "shoulder".into()];
    match reader {
        0 => drop(contents_with(&path, &ReadOptions::default())),
        1 | 2 => {
            let options = if reader == 1 {
                ReadOptions::default()
            } else {
                ReadOptions { joints: named(), topic: Some("/3".into()), ..ReadOptions::default() }
            };
            if let Ok(found) = read(&path, &options) {
                sound(&found.observation);
            }
        }
        3 => {
            let columns = vec![("z_m".into(), "position.0".into())];
            let options = ReadOptions { topic: Some("/9".into()), columns, ..ReadOptions::default() };
            if let Ok(found) = read(&path, &options) {
                sound(&found.observation);
            }
        }
        4 => {
            if let Ok(all) = pictures(&path, None) {
                all.take(100).for_each(drop);
            }
        }
        _ => {
            if let Ok(pairs) = DatasetReader::open(&path) {
                pairs.take(1000).for_each(drop);
            }
        }
    }
}

/// A bag in SQLite: the listing, the recording, the numbers of a topic.
pub fn bag(bytes: &[u8]) {
    let path = file("a.db3", bytes);
    let _ = contents_with(&path, &ReadOptions::default());
    let numbers = ReadOptions {
        topic: Some("/status".into()),
        columns: vec![("z_m".into(), "position".into())],
        definitions: vec![("Status".into(), "float64 position".into())],
        ..ReadOptions::default()
    };
    for options in [ReadOptions::default(), numbers] {
        if let Ok(found) = read(&path, &options) {
            sound(&found.observation);
        }
    }
}

/// A table in Parquet.
pub fn parquet(bytes: &[u8]) {
    let path = file("a.parquet", bytes);
    let _ = contents_with(&path, &ReadOptions::default());
    let columns = vec![("t_s".into(), "timestamp".into()), ("z_m".into(), "action.0".into())];
    if let Ok(found) = read(&path, &ReadOptions { columns, ..ReadOptions::default() }) {
        sound(&found.observation);
    }
}

/// Demonstrations in HDF5.
pub fn hdf5(bytes: &[u8]) {
    let path = file("a.hdf5", bytes);
    let Ok(found) = contents_with(&path, &ReadOptions::default()) else { return };
    let episode = match &found {
        tunenet_formats::Contents::Episodes(found) => found.episodes.first().map(|episode| episode.name.clone()),
        _ => None,
    };
    let options = ReadOptions {
        columns: vec![("z_m".into(), "obs.joint_pos.0".into())],
        units: vec![UnitRule::parse("m").expect("a unit")],
        rate_hz: Some(20.0),
        ..ReadOptions::default()
    };
    let path = episode.filter(|name| !name.is_empty()).map_or(path.clone(), |name| path.join(name));
    if let Ok(found) = read(&path, &options) {
        sound(&found.observation);
    }
}

/// Arrays of NumPy, in an archive or alone.
pub fn npz(bytes: &[u8]) {
    for name in ["a.npz", "a.npy", "a.mat"] {
        let path = file(name, bytes);
        let _ = contents_with(&path, &ReadOptions::default());
        let columns = vec![("t_s".into(), "1".into()), ("z_m".into(), "2".into())];
        if let Ok(found) = read(&path, &ReadOptions { columns, ..ReadOptions::default() }) {
            sound(&found.observation);
        }
    }
}

/// A calibration file of LeRobot: what it states is the unit of a joint.
pub fn calibration(bytes: &[u8]) {
    if let Ok(rules) = read_calibration(file("a.json", bytes)) {
        assert!(
            rules.iter().all(|rule| rule.factor.is_finite() && rule.factor > 0.0),
            "a factor that is none was read"
        );
    }
}

/// A data set of LeRobot: what describes it and, behind a NUL, its only file.
pub fn lerobot(bytes: &[u8]) {
    let split = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    let (info, data) = (&bytes[..split], bytes.get(split + 1..).unwrap_or_default());
    let folder = file("dataset", b"").with_extension("folder");
    let make = |part: &str| std::fs::create_dir_all(folder.join(part)).expect("a folder of this process");
    make("meta");
    make("data/chunk-000");
    std::fs::write(folder.join("meta/info.json"), info).expect("a file of this process");
    std::fs::write(folder.join("data/chunk-000/episode_000000.parquet"), data).expect("a file of this process");
    let _ = contents_with(&folder, &ReadOptions::default());
    let channels = vec![tunenet_core::observation::Channel::new("a", "rad")];
    let units = vec![UnitRule::parse("deg").expect("a unit")];
    if let Ok(found) = read(folder.join("episode_0"), &ReadOptions { channels, units, ..ReadOptions::default() }) {
        sound(&found.observation);
    }
}

/// A well-formed log of these messages.
pub fn log(mut rest: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let options = mcap::WriteOptions::new().compression(None).compression_threads(0);
    let mut writer = options.create(Cursor::new(&mut bytes)).expect("a log in memory");
    let (mut log_time, mut sequence) = (0, 0);
    let ids = SCHEMAS.iter().enumerate().map(|(i, (schema, encoding))| {
        let definition = if schema.starts_with("motor/") { DEFINITION } else { "text" };
        let schema = writer.add_schema(schema, "ros2msg", definition.as_bytes()).expect("a schema");
        writer.add_channel(schema, &format!("/{i}"), encoding, &BTreeMap::new()).expect("a channel")
    });
    let ids: Vec<u16> = ids.collect();
    while let [kind, length, later, tail @ ..] = rest {
        let (data, after) = tail.split_at(usize::from(*length).min(tail.len()));
        log_time += u64::from(*later) * 1_000_000;
        let channel_id = ids[usize::from(*kind) % ids.len()];
        let header = mcap::records::MessageHeader { channel_id, sequence, log_time, publish_time: log_time };
        writer.write_to_known_channel(&header, data).expect("a message");
        (rest, sequence) = (after, sequence + 1);
    }
    writer.finish().expect("the end of a log");
    drop(writer);
    bytes
}

/// A simulation file and, behind a NUL, an assignment as `--set` takes it.
pub fn simulation(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let (text, assignment) = text.split_once('\0').map_or((text, None), |(a, b)| (a, Some(b)));
    let path = Path::new("a.toml");
    let Ok(mut file) = SimulationFile::parse(path, text) else { return };
    if let Some(assignment) = assignment {
        let _ = file.set(assignment);
    }
    SimulationFile::parse(path, &file.text()).expect("what was accepted is accepted again");
    let _ = (file.essence(), file.scene(), file.effects(), file.parameters());
    for kind in [Kind::Positions, Kind::EventTimes] {
        let Ok(world) = simulator(&file, kind, &Session::default()) else { continue };
        let values: Vec<f64> = world.parameters().iter().map(|p| p.value).collect();
        let clock = [0.0, 0.05, 0.1];
        let mut seen = vec![0.0; clock.len() * world.channels().len()];
        let _ = world.rollout(&values, &[], &clock, &mut seen);
    }
}

/// A task file.
pub fn task(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    if let Ok(task) = Task::parse(Path::new("a.toml"), text) {
        assert!(task.release.heights_m.0 < task.release.heights_m.1, "heights in the wrong order were accepted");
    }
}

/// A model file, and one estimate by it.
pub fn model(bytes: &[u8]) {
    let Ok(model) = model_from_bytes("a.safetensors", bytes) else { return };
    let written = model_to_bytes(&model).expect("what was read can be written");
    model_from_bytes("a.safetensors", &written).expect("what was written can be read");
    let clock = model.clock();
    if clock.len() < 2 || clock.len() > 100 {
        return;
    }
    let channels = model.channels().to_vec();
    let values: Vec<f64> = (0..clock.len() * channels.len()).map(|i| (i as f64).sin()).collect();
    if let Ok(seen) = Observation::new(Kind::Other, channels, clock.to_vec(), values) {
        let scale = Scale::new(0.1, 1.2, 0.0, 0.4).ok();
        for scale in [None, scale.as_ref()] {
            let _ = model.start(Side { observation: &seen, scale });
            let _ = model.estimate(&seen, scale, &seen, scale);
        }
    }
}
