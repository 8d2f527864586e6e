//! Files measured by others, in the folder that `TUNENET_MEASURED` names.

use std::path::{Path, PathBuf};

use crate::findings;
use crate::{Contents, ReadOptions, contents, read};
use tunenet_core::observation::Kind;

/// The files of a folder by ending, or `None` where there are none to test with.
fn measured(folder: &str, ending: &str) -> Option<Vec<PathBuf>> {
    let Some(root) = std::env::var_os("TUNENET_MEASURED") else {
        eprintln!("skipped: TUNENET_MEASURED does not name a folder of measured files");
        return None;
    };
    let folder = Path::new(&root).join(folder);
    let Ok(entries) = std::fs::read_dir(&folder) else {
        eprintln!("skipped: {} is not there", folder.display());
        return None;
    };
    let mut paths: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    paths.retain(|path| path.extension().is_some_and(|e| e == ending));
    paths.sort();
    Some(paths)
}

#[test]
fn every_flight_is_read() {
    for path in measured("tt-flights", "csv").unwrap_or_default() {
        let found = read(&path, &ReadOptions::default()).unwrap();
        assert_eq!(found.observation.kind(), Kind::Positions, "{}", path.display());
    }
}

#[test]
fn every_bounce_list_is_read() {
    for path in measured("bounce-acoustic", "csv").unwrap_or_default() {
        let found = read(&path, &ReadOptions::default()).unwrap();
        assert_eq!(found.observation.kind(), Kind::EventTimes, "{}", path.display());
        assert!(found.observation.len() >= 5, "{}: {}", path.display(), found.observation.len());
    }
}

#[test]
fn every_toss_is_read_and_its_other_columns_noted() {
    for path in measured("cube-tosses", "csv").unwrap_or_default() {
        let found = read(&path, &ReadOptions::default()).unwrap();
        assert_eq!(found.notes[0].kind, findings::COLUMNS_IGNORED);
    }
}

#[test]
fn every_bag_is_counted_and_refused_with_a_reason() {
    let Some(paths) = measured("mcap-rosbag2", "mcap") else { return };
    let expected = [
        ("multiple_files_0", 1324),
        ("multiple_files_1", 1324),
        ("multiple_files_2", 529),
        ("wbag_0", 1246),
        ("wbag_1", 1240),
        ("wbag_2", 1240),
        ("wbag_3", 1240),
        ("wbag_4", 1108),
        ("talker", 20),
        ("cdr_test_0", 7),
        ("only_services", 12),
    ];
    for path in paths {
        let Contents::Log(log) = contents(&path).unwrap() else { panic!("{}", path.display()) };
        assert_eq!(log.ended, None, "{}", path.display());
        let count: u64 = log.topics.iter().map(|topic| topic.messages).sum();
        let stem = path.file_stem().unwrap().to_string_lossy();
        if let Some((_, expected)) = expected.iter().find(|(name, _)| *name == stem) {
            assert_eq!(count, *expected, "{stem}");
        }
        let error = read(&path, &ReadOptions::default()).unwrap_err().to_string();
        eprintln!("{}", &error[error.rfind('/').map_or(0, |_| error.find(&*stem).unwrap_or(0))..]);
        assert!(error.contains("no topic carries positions, joints or bounces: "), "{error}");
        if stem == "wrong_rmw_test_0" {
            assert!(error.contains("message encoding `wrong_format`"), "{error}");
        }
    }
}

/// A file or folder of public recordings.
#[cfg(feature = "logs")]
fn place(path: &str) -> Option<PathBuf> {
    let place = std::env::var_os("TUNENET_MEASURED").map(|root| Path::new(&root).join(path)).filter(|p| p.exists());
    if place.is_none() {
        eprintln!("skipped: TUNENET_MEASURED names no folder with {path}");
    }
    place
}

/// Counts as `sqlite3` counts rows.
#[cfg(feature = "logs")]
#[test]
fn bags_of_others_are_counted_and_read() {
    let splits = "rosbag2-splits/rosbag2_py/test/resources/sqlite3";
    for (path, expected) in [
        (format!("{splits}/wbag"), 6074),
        (format!("{splits}/reindex_test_bags/multiple_files"), 3177),
        (format!("{splits}/talker"), 20),
        ("rosbag2-splits/ros2bag/test/resources/empty_bag".into(), 0),
        ("rosbag2-alltypes".into(), 188),
        ("rosbag2-ur10/ur10_exciting_trajectory.db3".into(), 3441),
    ] {
        let Some(path) = place(&path) else { return };
        let before = std::fs::read_dir(path.parent().unwrap()).unwrap().count();
        let Contents::Log(log) = contents(&path).unwrap() else { panic!("{}", path.display()) };
        assert_eq!(log.topics.iter().map(|topic| topic.messages).sum::<u64>(), expected, "{}", path.display());
        assert_eq!((log.ended, std::fs::read_dir(path.parent().unwrap()).unwrap().count()), (None, before));
    }
    for (name, joints, samples) in [
        ("ur10_exciting_trajectory", 6, 3441),
        ("panda_exciting_trajectory", 7, 727),
        ("validation_trajectory", 6, 3441),
    ] {
        let Some(path) = place(&format!("rosbag2-ur10/{name}.db3")) else { return };
        let seen = read(&path, &ReadOptions::default()).unwrap().observation;
        assert_eq!((seen.kind(), seen.len()), (Kind::Joints, samples), "{name}");
        assert_eq!(seen.channels().iter().filter(|channel| channel.name.starts_with("tau")).count(), joints, "{name}");
    }
}

#[cfg(feature = "logs")]
#[test]
fn numbers_and_unknown_types_of_bags_of_others_are_named() {
    let Some(path) = place("rosbag2-odrive/rosbag2_2024_08_22-12_20_42") else { return };
    let Contents::Log(log) = contents(&path).unwrap() else { panic!("a log") };
    let undefined: Vec<&str> = log.topics.iter().filter_map(|topic| topic.undefined.as_deref()).collect();
    assert!(undefined.contains(&"odrive_can/ControllerStatus"), "{undefined:?}");
    let Some(path) = place("rosbag2-turtlesim/subset") else { return };
    let Contents::Log(log) = contents(&path).unwrap() else { panic!("a log") };
    let command = log.topics.iter().find(|topic| topic.schema == "geometry_msgs/msg/Twist").unwrap();
    assert_eq!(command.columns[..3], ["linear.x", "linear.y", "linear.z"]);
    let pose = log.topics.iter().find(|topic| topic.schema == "turtlesim/msg/Pose").unwrap();
    assert_eq!(pose.undefined.as_deref(), Some("turtlesim/Pose"));
    let definition = "float32 x\nfloat32 y\nfloat32 theta\nfloat32 linear_velocity\nfloat32 angular_velocity";
    let options = ReadOptions {
        topic: Some(pose.name.clone()),
        definitions: vec![("Pose".into(), definition.into())],
        columns: vec![("x_m".into(), "x".into()), ("z_m".into(), "y".into())],
        ..ReadOptions::default()
    };
    assert_eq!(read(&path, &options).unwrap().observation.len() as u64, pose.messages);
}

#[cfg(feature = "logs")]
#[test]
fn data_sets_of_others_are_listed_and_read() {
    let count = |path: &str| {
        let Contents::Episodes(found) = contents(place(path)?).unwrap() else { panic!("{path}") };
        Some((found.episodes.len(), found.episodes.iter().filter_map(|e| e.frames).sum::<u64>(), found))
    };
    // 4 and 6 episodes by their README; degrees for each unit by the quantum of the encoders.
    let Some((episodes, frames, arm)) = count("lerobot-v3-so101") else { return };
    assert_eq!((episodes, frames), (4, 1492));
    let proposed: Vec<f64> = arm
        .columns
        .iter()
        .filter(|c| !c.name.starts_with("action."))
        .take(5)
        .map(|c| c.proposed.as_deref().unwrap().trim_end_matches("deg").parse().unwrap())
        .collect();
    for (found, expected) in proposed.iter().zip([1.120, 1.012, 0.969, 1.005, 1.685]) {
        assert!((found - expected).abs() < 1e-3, "{proposed:?}");
    }
    let Some((episodes, _, _)) = count("lerobot-v3-so101-still") else { return };
    assert_eq!(episodes, 6);
    let Some((episodes, frames, humanoid)) = count("lerobot-v21-g1") else { return };
    assert_eq!((episodes, frames, humanoid.columns.len()), (3, 479 + 393 + 410, 52));
    assert_eq!(humanoid.notes[0].kind, findings::EPISODES_MISSING);
    let Some(path) = place("lerobot-v3-so101-still").map(|folder| folder.join("episode_4")) else { return };
    let channels = vec![tunenet_core::observation::Channel::from_header("j2_rad").unwrap()];
    let options =
        ReadOptions { channels, units: vec![crate::UnitRule::parse("rad").unwrap()], ..ReadOptions::default() };
    let found = read(&path, &options).unwrap();
    assert_eq!(found.observation.len(), 90);
    assert!(found.notes.iter().any(|note| note.kind == findings::STATE_CONSTANT));
    let Some(path) = place("lfs-pointer") else { return };
    let error = read(&path, &ReadOptions::default()).unwrap_err();
    assert!(error.hint().unwrap().contains("git lfs pull"), "{error}");
}

#[cfg(feature = "logs")]
#[test]
fn demonstrations_of_others_are_listed_and_read() {
    let Some(path) = place("hdf5-indy7/annotated.hdf5") else { return };
    let Contents::Episodes(found) = contents(&path).unwrap() else { panic!("episodes") };
    // 335 steps in 8 demonstrations, as its attribute `total` says.
    assert_eq!((found.episodes.len(), found.episodes.iter().filter_map(|e| e.frames).sum::<u64>()), (8, 335));
    assert!(found.notes.iter().any(|note| note.kind == findings::ACTIONS_OTHER));
    let joint = ReadOptions {
        channels: vec![tunenet_core::observation::Channel::from_header("q_rad").unwrap()],
        columns: vec![("q_rad".into(), "obs.joint_pos.2".into())],
        units: vec![crate::UnitRule::parse("rad").unwrap()],
        ..ReadOptions::default()
    };
    assert!(read(path.join("demo_0"), &joint).unwrap_err().hint().unwrap().contains("--rate HZ"));
    let timed = ReadOptions { rate_hz: Some(20.0), ..joint };
    assert_eq!(read(path.join("demo_0"), &timed).unwrap().observation.len(), 36);
    let Some(path) = place("hdf5-indy7/episode_0.hdf5") else { return };
    let error = read(&path, &ReadOptions::default()).unwrap_err();
    assert!(error.to_string().contains("`timestamp` does not rise"), "{error}");
    let columns = vec![("z_m".into(), "end_position.2".into())];
    let units = vec![crate::UnitRule::parse("end_position.2=m").unwrap()];
    let options = ReadOptions { columns, units, rate_hz: Some(10.0), ..ReadOptions::default() };
    let found = read(&path, &options).unwrap();
    assert_eq!(found.observation.kind(), Kind::Positions);
}

#[test]
fn foreign_tables_are_read_with_columns() {
    let read_with = |folder: &str, ending: &str, stem: &str, columns: &str| {
        let paths = measured(folder, ending).unwrap_or_default();
        let path = paths.into_iter().find(|path| path.file_stem().is_some_and(|name| name == stem))?;
        let pairs = columns.split(',').filter_map(|pair| pair.split_once('='));
        let columns = pairs.map(|(ours, theirs)| (ours.to_owned(), theirs.to_owned())).collect();
        Some(read(&path, &ReadOptions { columns, topic: None, ..ReadOptions::default() }))
    };
    if let Some(found) = read_with("three-balls", "txt", "red_ball", "t_s=t,x_m=x,z_m=y") {
        assert_eq!(found.unwrap().observation.kind(), Kind::Positions);
    }
    let pendulum = "control_method_ilqr_data_measured";
    let columns = "t_s=time,q1_rad=position,dq1_rad_s=velocity,tau1_nm=torque";
    if let Some(found) = read_with("pendulum-dfki", "csv", pendulum, columns) {
        assert_eq!(found.unwrap().observation.channels().len(), 3);
    }
    let loaded = "ur-20_02_19_14harm50secLoad";
    let joints: Vec<String> = (1..=6).map(|j| format!("q{j}_rad={},i{j}_a={}", j + 1, j + 13)).collect();
    let columns = format!("t_s=1,{}", joints.join(","));
    if let Some(found) = read_with("ur10e-payload", "csv", loaded, &columns) {
        assert_eq!(found.unwrap().observation.channels().len(), 12);
    }
    // Its second to tenth lines are garbage.
    if let Some(found) = read_with("ur10e-payload", "csv", "ur-20_02_19_15harm50secLoad", &columns) {
        let error = found.unwrap_err();
        eprintln!("{error}\n{:?}", error.hint());
        assert!(
            error.to_string().contains(":2:1: the time falls: expected more than 3047.693, found -0.1231"),
            "{error}"
        );
    }
}
