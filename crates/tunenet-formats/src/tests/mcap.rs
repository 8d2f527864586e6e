//! MCAP files.

use mcap::Compression;

use crate::mcap::reader::messages;
use crate::testing::{Made, bag, ball, error_text, file, joints, made, odometry, point, point_big_endian, read_as};
use crate::{ReadOptions, Recording};
use tunenet_core::observation::{Channel, Kind};

fn good(topics: &[Made]) -> Recording {
    read_as("a.mcap", bag(Some(Compression::Zstd), topics), &ReadOptions::default()).unwrap()
}

fn bad(topics: &[Made]) -> (String, String) {
    error_text(&read_as("a.mcap", bag(Some(Compression::Zstd), topics), &ReadOptions::default()).unwrap_err())
}

fn asked(topics: &[Made], topic: &str) -> crate::Result<Recording> {
    let options = ReadOptions { topic: Some(topic.into()), ..ReadOptions::default() };
    read_as("a.mcap", bag(None, topics), &options)
}

fn json(topic: &'static str, texts: &[String]) -> Made {
    let messages =
        (0..).zip(texts).map(|(i, text)| (1_000_000_000 + i * 10_000_000, text.clone().into_bytes())).collect();
    Made { topic, schema: "any.Name", definition: "text", encoding: "json", messages }
}

fn chatter() -> Made {
    made("/chatter", "std_msgs/msg/String", 5, |_, _| vec![0, 1, 0, 0, 1, 0, 0, 0, 0])
}

#[test]
fn every_compression_reads_alike() {
    let plain = read_as("a.mcap", bag(None, &[ball(500)]), &ReadOptions::default()).unwrap();
    assert_eq!(plain.observation.len(), 500);
    assert_eq!(plain.observation.row(3), [0.1, 0.2, 3.0]);
    assert_eq!(plain.observation.clock()[3].to_bits(), 1.03f64.to_bits());
    assert_eq!(plain.notes, []);
    for compression in [Compression::Zstd, Compression::Lz4] {
        let other = read_as("a.mcap", bag(Some(compression), &[ball(500)]), &ReadOptions::default()).unwrap();
        assert_eq!(other, plain);
    }
    // For any name.
    assert_eq!(read_as("a.csv", bag(None, &[ball(500)]), &ReadOptions::default()).unwrap(), plain);
}

#[test]
fn every_message_type_reads_alike() {
    let expected = good(&[ball(20)]).observation;
    let big = made("/b", "geometry_msgs/msg/PointStamped", 20, point_big_endian);
    let pose = made("/p", "geometry_msgs/msg/PoseStamped", 20, |ns, z| [point(ns, z), vec![0; 32]].concat());
    let odometry = made("/o", "nav_msgs/msg/Odometry", 20, odometry);
    for made in [big, pose, odometry] {
        assert_eq!(good(&[made]).observation, expected);
    }
    let texts: Vec<String> = (0..20)
        .map(|i| {
            let nsec = i * 10_000_000;
            format!(r#"{{"timestamp":{{"sec":1,"nsec":{nsec}}},"pose":{{"position":{{"x":0.1,"y":0.2,"z":{i}}}}}}}"#)
        })
        .collect();
    assert_eq!(good(&[json("/j", &texts)]).observation, expected);
}

#[test]
fn joints_are_matched_by_name() {
    let turned = made("/joint_states", "sensor_msgs/msg/JointState", 10, |ns, z| {
        let even = (z % 2.0) == 0.0;
        if even {
            joints(ns, &["a", "b"], &[z, 5.0], &[1.0, 2.0])
        } else {
            joints(ns, &["b", "a"], &[5.0, z], &[2.0, 1.0])
        }
    });
    let found = good(&[turned]);
    assert_eq!(found.observation.kind(), Kind::Joints);
    assert!((0..10).all(|i| found.observation.row(i) == [i as f64, 5.0, 1.0, 2.0]));
    assert_eq!(found.notes[0].text, "joints 1 to 2 are `a`, `b`");
    let silent = made("/joint_states", "sensor_msgs/msg/JointState", 10, |ns, z| joints(ns, &["a"], &[z], &[]));
    let found = good(&[silent]);
    assert_eq!(found.observation.channels().len(), 1);
    assert_eq!(found.notes[1].text, "the messages carry no velocity and no effort");
}

/// As columns of a simulated robot, joints come in any order; of messages in parts, the other columns are named.
#[test]
fn columns_of_joints_are_matched_by_name() {
    let turned = made("/joint_states", "sensor_msgs/msg/JointState", 10, |ns, z| {
        if (z % 2.0) == 0.0 { joints(ns, &["a", "b"], &[z, 5.0], &[]) } else { joints(ns, &["b", "a"], &[5.0, z], &[]) }
    });
    let options = |headers: &[&str]| ReadOptions {
        channels: headers.iter().map(|header| Channel::from_header(header).unwrap()).collect(),
        ..ReadOptions::default()
    };
    let read = |made: Made, headers: &[&str]| read_as("a.mcap", bag(None, &[made]), &options(headers));
    let found = read(turned, &["a_rad", "b_rad"]).unwrap();
    assert!(
        (0..10).all(|i| found.observation.row(i) == [i as f64, 5.0]) && found.notes.is_empty(),
        "{:?}",
        found.notes
    );
    let parts = || {
        made("/joint_states", "sensor_msgs/msg/JointState", 10, |ns, z| {
            if (z % 2.0) == 0.0 { joints(ns, &["a", "b"], &[z, 5.0], &[]) } else { joints(ns, &["finger"], &[z], &[]) }
        })
    };
    let found = read(parts(), &["a_rad"]).unwrap();
    assert_eq!(found.observation.len(), 5);
    let text =
        "5 messages of `/joint_states` left out that lack columns of the first message; they have `position.finger`";
    assert!(found.notes.iter().any(|note| note.text == text), "{:?}", found.notes);
    let (message, _) = error_text(&read(parts(), &["a_rad", "finger_m"]).unwrap_err());
    let expected =
        "expected messages of `/joint_states` with `position.a`, `position.finger`, found none that has all of them";
    assert_eq!(message, format!("a.mcap: {expected}"));
    // Another program's messages may come first.
    let first = made("/joint_states", "sensor_msgs/msg/JointState", 10, |ns, z| {
        if (z % 2.0) == 0.0 { joints(ns, &["finger"], &[z], &[]) } else { joints(ns, &["a", "b"], &[z, 5.0], &[]) }
    });
    assert_eq!(read(first, &["a_rad"]).unwrap().observation.column(0).collect::<Vec<_>>(), [1.0, 3.0, 5.0, 7.0, 9.0]);
}

#[test]
fn the_topic_is_the_only_usable_one_or_asked_for() {
    assert_eq!(good(&[chatter(), ball(20)]).observation.len(), 20);
    let several = || [chatter(), ball(20), made("/cam/odom", "nav_msgs/msg/Odometry", 54, odometry)];
    assert_eq!(asked(&several(), "/cam/odom").unwrap().observation.len(), 54);
    let usable = "usable are `/ball/point` (PointStamped, 20 messages), `/cam/odom` (Odometry, 54 messages); 1 more carry \
                  nothing to use";
    assert_eq!(
        bad(&several()),
        (format!("a.mcap: several topics can be used: {usable}"), "try `--topic /ball/point`".into())
    );
    let (message, hint) = error_text(&asked(&several(), "/ball/pos").unwrap_err());
    assert_eq!(message, format!("a.mcap: topic `/ball/pos` is not there: {usable}"));
    assert_eq!(hint, "try `--topic /ball/point`");
    let (message, _) = error_text(&asked(&several(), "/chatter").unwrap_err());
    assert_eq!(message, "a.mcap: topic `/chatter` carries no positions, joints or bounces");
}

#[test]
fn a_file_without_a_usable_topic_says_what_is_there() {
    let other = made("/log", "rcl_interfaces/msg/Log", 2, |_, _| vec![0; 8]);
    let (message, hint) = bad(&[chatter(), other]);
    assert_eq!(
        message,
        "a.mcap: no topic carries positions, joints or bounces: found `/chatter` (String, 5 messages), `/log` (Log, 2 messages)"
    );
    assert_eq!(hint, "record PointStamped, PoseStamped, Odometry or JointState in CDR or JSON");
    let wrong = Made { encoding: "wrong_format", ..ball(3) };
    assert_eq!(
        bad(&[wrong]).0,
        "a.mcap: no topic carries positions, joints or bounces: found `/ball/point` (PointStamped, 3 messages); \
         `/ball/point` has the message encoding `wrong_format`: \
         expected `cdr` or `json`"
    );
    let narrow = "geometry_msgs/Point point\n====\nMSG: geometry_msgs/Point\nfloat32 x\nfloat32 y\nfloat32 z\n";
    assert_eq!(
        bad(&[Made { definition: narrow, ..ball(3) }]).0,
        "a.mcap: no topic carries positions, joints or bounces: found `/ball/point` (PointStamped, 3 messages); \
         `/ball/point` defines geometry_msgs/Point as `float32 x, float32 y, float32 z`: \
         expected `float64 x, float64 y, float64 z`"
    );
    assert_eq!(bad(&[]).0, "a.mcap: no topic carries positions, joints or bounces: the file has no topics");
    assert_eq!(
        bad(&[ball(0)]).0,
        "a.mcap: no topic carries positions, joints or bounces: found `/ball/point` (PointStamped, 0 messages)"
    );
    assert_eq!(bad(&[ball(2)]).0, "a.mcap: expected at least 3 samples of `/ball/point`, found 2");
}

#[test]
fn a_cut_recording_says_how_much_was_there() {
    let whole = bag(Some(Compression::Zstd), &[ball(500)]);
    let (_folder, path) = file("a.mcap", &whole[..whole.len() / 2]);
    let readable = messages(&path).unwrap().flatten().count();
    assert!(readable > 0 && readable < 500, "{readable}");
    let error = crate::read(&path, &ReadOptions::default()).unwrap_err();
    let (message, hint) = error_text(&error);
    assert_eq!(message, format!("a.mcap: the recording is cut off: {readable} messages could be read before"));
    assert!(hint.starts_with("try `mcap recover ") && hint.contains("`, which keeps what can be read; "), "{hint}");
    let error = read_as("a.mcap", &whole[..5], &ReadOptions::default()).unwrap_err();
    assert_eq!(error_text(&error).0, "a.mcap: the file ends after 5 bytes, in the middle of its first mark");
    let error = read_as("a.mcap", "", &ReadOptions::default()).unwrap_err();
    assert_eq!(error_text(&error).0, "a.mcap: expected an MCAP file, found an empty one");
    let error = read_as("a.mcap", "t_s,z_m\n", &ReadOptions::default()).unwrap_err();
    assert_eq!(error_text(&error).0, "a.mcap: expected the mark of an MCAP file at its start, found other bytes");
}

#[test]
fn a_damaged_chunk_is_noticed() {
    let mut bytes = bag(None, &[ball(200)]);
    let at = bytes.windows(8).position(|w| w == 50.0f64.to_le_bytes()).unwrap();
    bytes[at] ^= 1;
    let (message, _) = error_text(&read_as("a.mcap", bytes, &ReadOptions::default()).unwrap_err());
    assert!(message.starts_with("a.mcap: chunk CRC failed (expected "), "{message}");
    assert!(message.ends_with("messages could be read before"), "{message}");
}

#[test]
fn a_bad_message_is_numbered() {
    let mut cut = ball(20);
    cut.messages[7].1.truncate(20);
    assert_eq!(
        bad(&[cut]).0,
        "a.mcap: message 8 of `/ball/point` cannot be used: 20 bytes do not fit its type: unexpected end of input"
    );
    let gaps = made("/ball/point", "geometry_msgs/msg/PointStamped", 20, |ns, z| {
        point(ns, if z < 2.0 { f64::NAN } else { z })
    });
    assert_eq!(
        bad(&[gaps]).0,
        "a.mcap: 2 of 20 messages of `/ball/point` hold numbers that are not finite, the first is message 1"
    );
    let few = made("/ball/point", "geometry_msgs/msg/PointStamped", 200, |ns, z| {
        point(ns, if z < 1.0 { f64::NAN } else { z })
    });
    let found = good(&[few]);
    assert_eq!(found.observation.len(), 199);
    assert_eq!(found.notes[0].text, "1 sample left out for a number that is not finite");
}

#[test]
fn stamps_rule_where_they_are_set_and_rise() {
    let unset = made("/ball/point", "geometry_msgs/msg/PointStamped", 20, |_, z| point(0, z));
    let found = good(&[unset]);
    assert_eq!(found.observation.clock()[1].to_bits(), 1.010_000_5f64.to_bits());
    assert_eq!(found.notes[0].text, "the stamps of `/ball/point` are not set: the times of recording are used");
    let mut falling = ball(20);
    falling.messages[7].1 = point(1, 7.0);
    falling.messages[8].1 = point(2, 8.0);
    let found = good(&[falling]);
    assert_eq!(found.observation.len(), 20);
    assert_eq!(found.notes[0].text, "the stamps of `/ball/point` do not rise: the times of recording are used");
    let mut hiccup = ball(300);
    hiccup.messages[7].1 = point(1, 7.0);
    let found = good(&[hiccup]);
    assert_eq!(found.observation.len(), 299);
    assert_eq!(found.notes[0].text, "1 sample of `/ball/point` left out whose time does not rise");
    let mut twice = ball(20);
    twice.messages = twice.messages.into_iter().flat_map(|m| [m.clone(), m]).collect();
    let found = good(&[twice]);
    assert_eq!(found.observation.len(), 20);
    assert_eq!(found.notes[0].text, "20 samples of `/ball/point` left out that repeat the one before");
    let mut lost = ball(20);
    lost.messages = lost.messages.into_iter().rev().collect();
    assert_eq!(
        bad(&[lost]).0,
        "a.mcap: the time of `/ball/point` does not rise at 19 of 20 messages: expected more than 1.19 s at message 2, found \
         1.18 s"
    );
}

#[test]
fn columns_that_a_topic_does_not_have_are_refused() {
    let options = ReadOptions { columns: vec![("t_s".into(), "1".into())], topic: None, ..ReadOptions::default() };
    let error = read_as("a.mcap", bag(None, &[ball(3)]), &options).unwrap_err().to_string();
    let expected = "`columns`: expected numbers of `/ball/point` (`point.x`, `point.y`, `point.z`), found `1`";
    assert!(error.starts_with(expected), "{error}");
}
