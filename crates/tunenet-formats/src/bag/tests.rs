//! Bags made in code.

use rusqlite::Connection;

use crate::testing::{error_text, joints, point};
use crate::{Contents, ReadOptions, contents, read};

const SCHEMA_3: &str = "
    CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
    INSERT INTO schema VALUES (3, 'humble');
    CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT NOT NULL,
        offered_qos_profiles TEXT NOT NULL);
    CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT NULL);
    CREATE INDEX timestamp_idx ON messages (timestamp ASC);";

/// A topic of a made bag: number, name, type, messages with their times in ns.
type Topic<'a> = (i64, &'a str, &'a str, Vec<(i64, Vec<u8>)>);

fn write(path: &std::path::Path, schema: &str, topics: &[Topic<'_>]) {
    fill(&Connection::open(path).unwrap(), schema, topics);
}

fn fill(bag: &Connection, schema: &str, topics: &[Topic<'_>]) {
    bag.execute_batch(schema).unwrap();
    for (id, name, kind, messages) in topics {
        let listed = "INSERT INTO topics(id, name, type, serialization_format, offered_qos_profiles) VALUES (?1, ?2, ?3, 'cdr', '')";
        bag.execute(listed, (id, name, kind)).unwrap();
        for (time, data) in messages {
            let row = "INSERT INTO messages(topic_id, timestamp, data) VALUES (?1, ?2, ?3)";
            bag.execute(row, (id, time, data)).unwrap();
        }
    }
}

fn ball(id: i64, from: u32, to: u32) -> Topic<'static> {
    let at = |i: u32| 1_000_000_000 + 10_000_000 * i64::from(i);
    let messages = (from..to).map(|i| (at(i) + 500, point(at(i), f64::from(i)))).collect();
    (id, "/ball/point", "geometry_msgs/msg/PointStamped", messages)
}

/// A message in little-endian CDR.
fn cdr(parts: &[&[u8]]) -> Vec<u8> {
    [&[0, 1, 0, 0], parts.concat().as_slice()].concat()
}

fn command(id: i64, name: &'static str, kind: &'static str) -> Topic<'static> {
    let messages = (0..20).map(|i| (2_000_000_000 + i * 5_000_000, cdr(&[&(i as f64 * 0.5).to_le_bytes()])));
    (id, name, kind, messages.collect())
}

fn topic(name: &str) -> ReadOptions {
    ReadOptions { topic: Some(name.into()), ..ReadOptions::default() }
}

#[test]
fn a_bag_reads_as_the_same_messages_in_an_mcap_file() {
    let folder = tempfile::tempdir().unwrap();
    let (bag, mcap) = (folder.path().join("a.db3"), folder.path().join("a.mcap"));
    write(&bag, SCHEMA_3, &[ball(4, 0, 50)]);
    std::fs::write(&mcap, crate::testing::bag(None, &[crate::testing::ball(50)])).unwrap();
    let (found, other) = (read(&bag, &ReadOptions::default()).unwrap(), read(&mcap, &ReadOptions::default()).unwrap());
    assert_eq!(found, other);
    // Nothing is written next to it.
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
    let Contents::Log(log) = contents(&bag).unwrap() else { panic!("a log") };
    assert_eq!((log.library.as_str(), log.topics[0].messages), ("rosbag2 sqlite3, version 3, humble", 50));
}

#[test]
fn parts_with_other_numbers_for_the_same_topic_follow_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let noise = |id| (id, "/chatter", "std_msgs/msg/String", vec![(5, cdr(&[&[1, 0, 0, 0, 0]]))]);
    write(&folder.path().join("b_0.db3"), SCHEMA_3, &[noise(1), ball(2, 0, 10)]);
    write(&folder.path().join("b_1.db3"), SCHEMA_3, &[ball(1, 10, 20), noise(7)]);
    write(&folder.path().join("whole.db3"), SCHEMA_3, &[ball(1, 0, 20)]);
    let whole = read(folder.path().join("whole.db3"), &ReadOptions::default()).unwrap();
    std::fs::remove_file(folder.path().join("whole.db3")).unwrap();
    assert_eq!(read(folder.path(), &ReadOptions::default()).unwrap(), whole);
    let packed = zstd::encode_all(std::fs::File::open(folder.path().join("b_1.db3")).unwrap(), 3).unwrap();
    std::fs::write(folder.path().join("b_1.db3.zstd"), packed).unwrap();
    std::fs::remove_file(folder.path().join("b_1.db3")).unwrap();
    assert_eq!(read(folder.path(), &ReadOptions::default()).unwrap(), whole);
}

#[test]
fn messages_that_are_compressed_one_by_one_and_old_schemas_read_alike() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.db3");
    write(&path, SCHEMA_3, &[ball(1, 0, 20)]);
    let plain = read(&path, &ReadOptions::default()).unwrap();
    let (id, name, kind, messages) = ball(1, 0, 20);
    let packed = messages.into_iter().map(|(time, data)| (time, zstd::encode_all(&data[..], 3).unwrap())).collect();
    let old = "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);
        CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT, offered_qos_profiles TEXT);";
    let other = folder.path().join("b.db3");
    write(&other, old, &[(id, name, kind, packed)]);
    assert_eq!(read(&other, &ReadOptions::default()).unwrap(), plain);
}

#[test]
fn a_log_that_was_left_unmerged_is_read_from_a_copy() {
    let folder = tempfile::tempdir().unwrap();
    let (path, copied) = (folder.path().join("a.db3"), folder.path().join("left"));
    std::fs::create_dir(&copied).unwrap();
    let bag = Connection::open(&path).unwrap();
    bag.pragma_update(None, "journal_mode", "wal").unwrap();
    bag.pragma_update(None, "wal_autocheckpoint", 0).unwrap();
    fill(&bag, SCHEMA_3, &[ball(1, 0, 20)]);
    // As after a kill: both files, and no index of the log.
    for suffix in ["", "-wal"] {
        std::fs::copy(folder.path().join(format!("a.db3{suffix}")), copied.join(format!("a.db3{suffix}"))).unwrap();
    }
    assert_eq!(read(copied.join("a.db3"), &ReadOptions::default()).unwrap().observation.len(), 20);
    assert_eq!(std::fs::read_dir(&copied).unwrap().count(), 2);
}

#[test]
fn numbers_of_any_type_are_columns_by_their_names() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.db3");
    let arm = (0..20).map(|i| {
        let ns = 2_000_000_000 + i * 5_000_000;
        (ns, joints(ns, &["elbow", "wrist"], &[i as f64, -(i as f64)], &[]))
    });
    let arm: Topic<'_> = (9, "/joint_states", "sensor_msgs/msg/JointState", arm.collect());
    write(&path, SCHEMA_3, &[command(1, "/u", "std_msgs/msg/Float64"), arm]);
    let channels = |name: &str| vec![tunenet_core::observation::Channel::from_header(name).unwrap()];
    let role = crate::Role::Driving;
    let input = ReadOptions { channels: channels("force_n"), role, ..topic("/u") };
    let found = read(&path, &input).unwrap().observation;
    assert_eq!((found.channels()[0].header().as_str(), found.row(3)[0], found.clock()[0]), ("force_n", 1.5, 2.0));
    let state = ReadOptions { channels: channels("wrist_rad"), ..ReadOptions::default() };
    assert_eq!(read(&path, &state).unwrap().observation.row(3), [-3.0]);
    let columns = vec![("z_m".to_owned(), "-data".to_owned())];
    let mapped = read(&path, &ReadOptions { columns, ..topic("/u") }).unwrap().observation;
    assert_eq!(mapped.row(4), [0.0, 0.0, -2.0]);
}

#[test]
fn a_type_without_a_definition_is_named_and_read_with_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.db3");
    write(&path, SCHEMA_3, &[command(1, "/status", "motor/msg/Status")]);
    let (message, hint) = error_text(&read(&path, &topic("/status")).unwrap_err());
    assert_eq!(message, "a.db3: topic `/status` carries `motor/Status`, which the log does not define");
    assert!(hint.contains("--msg Status.msg"), "{hint}");
    let definitions = vec![("Status".to_owned(), "float64 position".to_owned())];
    let columns = vec![("z_m".to_owned(), "position".to_owned())];
    let found = read(&path, &ReadOptions { columns, definitions, ..topic("/status") }).unwrap();
    assert_eq!(found.observation.len(), 20);
}

#[test]
fn other_databases_empty_bags_and_broken_ones_say_what_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.db3");
    let refused = |schema: &str| {
        std::fs::remove_file(&path).ok();
        write(&path, schema, &[]);
        error_text(&read(&path, &ReadOptions::default()).unwrap_err()).0
    };
    assert!(refused("CREATE TABLE cookies(id);").ends_with("found an SQLite database without the table `topics`"));
    let view =
        "CREATE TABLE topics(id, name, type); CREATE VIEW messages AS SELECT 1 AS topic_id, 2 AS timestamp, 3 AS data;";
    assert!(refused(view).ends_with("without the table `messages`"));
    assert!(refused(SCHEMA_3).ends_with("no topic carries positions, joints or bounces: the file has no topics"));
    std::fs::remove_file(&path).unwrap();
    write(&path, SCHEMA_3, &[ball(1, 0, 500)]);
    let bytes = std::fs::read(&path).unwrap();
    std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    let (message, _) = error_text(&read(&path, &ReadOptions::default()).unwrap_err());
    assert!(message.contains("broken") || message.contains("refuses"), "{message}");
    std::fs::write(&path, b"SQLite format 3\0").unwrap();
    assert!(read(&path, &ReadOptions::default()).is_err());
    std::fs::write(&path, b"").unwrap();
    let (message, _) = error_text(&read(&path, &ReadOptions::default()).unwrap_err());
    assert_eq!(message, "a.db3: expected a bag of ROS 2 in SQLite, found an empty one");
}

#[test]
fn definitions_of_implausible_length_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.db3");
    let bag = Connection::open(&path).unwrap();
    fill(&bag, SCHEMA_3, &[ball(1, 0, 10)]);
    let table = "CREATE TABLE message_definitions(topic_type TEXT, encoding TEXT, encoded_message_definition TEXT);
        WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < 20)
        INSERT INTO message_definitions SELECT 'a/T' || i, 'ros2msg', hex(zeroblob(524288)) FROM n;";
    bag.execute_batch(table).unwrap();
    drop(bag);
    let (message, _) = error_text(&read(&path, &ReadOptions::default()).unwrap_err());
    assert!(message.ends_with("expected at most 16777216 bytes, found more"), "{message}");
}

/// A `trajectory_msgs/JointTrajectory` of one point for each of two joints, in the same layout as a hand-written message.
fn way(ns: i64, q: f64) -> Vec<u8> {
    let word = |number: u32| number.to_le_bytes();
    let sec = word(u32::try_from(ns / 1_000_000_000).unwrap());
    let nanosec = word(u32::try_from(ns % 1_000_000_000).unwrap());
    let (hip, knee) = ([&word(4)[..], b"hip\0"].concat(), [&word(5)[..], b"knee\0", &[0; 3]].concat());
    let header = [&sec[..], &nanosec, &word(1), &[0; 4]].concat();
    let positions = [&word(2)[..], &q.to_le_bytes(), &(-q).to_le_bytes()].concat();
    let rest = [word(0), word(0), word(0), word(0), word(0)].concat();
    let names = [&word(2)[..], &hip, &knee].concat();
    // The counts of points and of positions are followed by numbers of eight bytes, counted from after the mark.
    assert_eq!((header.len() + names.len() + 8) % 8, 0);
    cdr(&[&header, &names, &word(1), &positions, &rest])
}

#[test]
fn the_points_of_a_trajectory_are_commands_by_the_names_of_joints() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.db3");
    let at = |i: i64| 1_000_000_000 + 20_000_000 * i;
    let commands = (0..30).map(|i| (at(i) + 900, way(at(i), 0.1 * i as f64))).collect();
    let states = (0..30)
        .map(|i| {
            let q = 0.01 * f64::from(i);
            (at(i.into()), joints(at(i.into()), &["hip", "knee"], &[q, -q], &[]))
        })
        .collect();
    let topics = [
        (1, "/controller/joint_trajectory", "trajectory_msgs/msg/JointTrajectory", commands),
        (2, "/joint_states", "sensor_msgs/msg/JointState", states),
    ];
    write(&path, SCHEMA_3, &topics);
    let knee = || vec![tunenet_core::observation::Channel::from_header("knee_rad").unwrap()];
    // What was measured is not looked for among commands.
    let measured = read(&path, &ReadOptions { channels: knee(), ..ReadOptions::default() }).unwrap().observation;
    assert!((measured.column(0).last().unwrap() + 0.29).abs() < 1e-12);
    let commands = ReadOptions { channels: knee(), ..topic("/controller/joint_trajectory") };
    let commanded = read(&path, &commands).unwrap().observation;
    assert!((commanded.column(0).last().unwrap() + 2.9).abs() < 1e-12);
    assert_eq!(commanded.clock(), measured.clock());
    let columns = ReadOptions { columns: vec![("knee_rad".into(), "position.knee".into())], ..commands };
    assert_eq!(read(&path, &columns).unwrap().observation, commanded);
    let Contents::Log(log) = contents(&path).unwrap() else { panic!("a log") };
    assert_eq!(log.topics[0].columns, ["position.hip", "position.knee"]);
}
