//! Files made in code.

use hdf5_pure::{AttrValue, DatatypeByteOrder, FileBuilder, FloatingPointLayout};

use crate::testing::{error_text, file};
use crate::{Contents, ReadOptions, UnitRule, contents, contents_with, episodes, findings, read};
use tunenet_core::observation::Channel;

const ROWS: u64 = 40;

/// Angles of two joints, and commands that these follow, or steps of an end effector.
fn angles(offset: f64) -> Vec<f64> {
    (0..ROWS).flat_map(|k| [(k as f64 * 0.1).sin(), (k as f64 * 0.07).cos()]).map(|q| q + offset).collect()
}

/// Demonstrations as robomimic stores them.
fn demonstrations(path: &std::path::Path, environment: &str, steps: bool) {
    let mut file = FileBuilder::new();
    let mut data = file.create_group("data");
    data.set_attr("env_args", AttrValue::String(environment.into()));
    for demo in ["demo_10", "demo_2"] {
        let mut group = data.create_group(demo);
        let actions = if steps { angles(0.0).iter().map(|q| 5.0 + q * 0.01).collect() } else { angles(0.02) };
        group.create_dataset("actions").with_f64_data(&actions).with_shape(&[ROWS, 2]);
        let mut obs = group.create_group("obs");
        obs.create_dataset("joint_pos").with_f64_data(&angles(0.0)).with_shape(&[ROWS, 2]);
        group.add_group(obs.finish());
        data.add_group(group.finish());
    }
    file.add_group(data.finish());
    let empty = file.create_group("cameras").finish();
    file.add_group(empty);
    file.write(path).unwrap();
}

fn options(rate_hz: Option<f64>) -> ReadOptions {
    ReadOptions {
        channels: vec![Channel::from_header("elbow_rad").unwrap()],
        columns: vec![("elbow_rad".into(), "obs.joint_pos.1".into())],
        units: vec![UnitRule::parse("obs.joint_pos.*=rad").unwrap()],
        rate_hz,
        ..ReadOptions::default()
    }
}

#[test]
fn demonstrations_are_episodes_in_the_order_of_their_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.hdf5");
    demonstrations(&path, "{}", false);
    let Contents::Episodes(found) = contents(&path).unwrap() else { panic!("episodes") };
    let names: Vec<&str> = found.episodes.iter().map(|episode| episode.name.as_str()).collect();
    assert_eq!((names, found.episodes[0].frames), (vec!["demo_2", "demo_10"], Some(ROWS)));
    assert!(found.lacks_clock);
    let Contents::Episodes(timed) = contents_with(&path, &options(Some(20.0))).unwrap() else { panic!("episodes") };
    assert!(!timed.lacks_clock);
    assert_eq!(found.notes.iter().map(|note| note.kind).collect::<Vec<_>>(), [findings::GROUPS_EMPTY]);
    let Contents::Episodes(one) = contents(path.join("demo_10")).unwrap() else { panic!("episodes") };
    assert_eq!((one.episodes.len(), one.episodes[0].name.as_str(), one.notes.len()), (1, "demo_10", 0));
    let (message, _) = error_text(&contents(path.join("demo_3")).unwrap_err());
    assert!(message.contains("expected an episode that is there (`demo_2`, `demo_10`), found `demo_3`"), "{message}");
    let seen = read(path.join("demo_10"), &options(Some(20.0))).unwrap().observation;
    assert_eq!(
        (seen.len() as u64, seen.clock()[3].to_bits(), seen.row(5)[0].to_bits()),
        (ROWS, (3.0f64 / 20.0).to_bits(), (5.0f64 * 0.07).cos().to_bits())
    );
}

#[test]
fn episodes_of_one_name_in_different_groups_are_distinguished() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.hdf5");
    let mut file = FileBuilder::new();
    for (top, offset) in [("left", 0.0), ("right", 1.0)] {
        let mut data = file.create_group(top);
        let mut group = data.create_group("demo_0");
        group.create_dataset("q").with_f64_data(&angles(offset)).with_shape(&[ROWS, 2]);
        data.add_group(group.finish());
        file.add_group(data.finish());
    }
    file.write(&path).unwrap();
    let all = episodes(&path, None).unwrap().unwrap();
    assert_eq!(all, [path.join("left.demo_0"), path.join("right.demo_0")]);
    let flat = ReadOptions {
        columns: vec![("elbow_rad".into(), "q.1".into())],
        units: vec![UnitRule::parse("rad").unwrap()],
        ..options(Some(20.0))
    };
    let first = |path: &std::path::PathBuf| read(path, &flat).unwrap().observation.row(0)[0];
    assert_eq!([first(&all[0]), first(&all[1])], [1.0, 2.0]);
}

#[test]
fn the_time_base_and_units_are_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.hdf5");
    demonstrations(&path, "{}", false);
    let (message, hint) = error_text(&read(path.join("demo_2"), &options(None)).unwrap_err());
    assert!(message.contains("no array of times and no rate") && hint.contains("`--rate HZ`"), "{message} {hint}");
    let unstated = ReadOptions { units: Vec::new(), ..options(Some(20.0)) };
    let (message, _) = error_text(&read(path.join("demo_2"), &unstated).unwrap_err());
    assert!(message.contains("the unit of `obs.joint_pos.1` is not stated"), "{message}");
    let (message, hint) = error_text(&read(&path, &options(None)).unwrap_err());
    assert!(
        message.contains("expected one recording, found 2 episodes") && hint.contains("demo_2"),
        "{message} {hint}"
    );
    demonstrations(&path, r#"{"env_kwargs": {"control_freq": 20}}"#, false);
    assert_eq!(read(path.join("demo_2"), &options(None)).unwrap().observation.clock()[20], 1.0);
}

#[test]
fn actions_that_are_no_joint_angles_are_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.hdf5");
    let noticed = || {
        let Contents::Episodes(found) = contents(&path).unwrap() else { panic!("episodes") };
        found.notes.into_iter().find(|note| note.kind == findings::ACTIONS_OTHER).map(|note| note.text)
    };
    demonstrations(&path, "{}", false);
    assert_eq!(noticed(), None);
    demonstrations(&path, "{}", true);
    assert!(noticed().unwrap().ends_with("they do not follow the joints"));
    demonstrations(&path, r#"{"env_name": "Reach-IK-Rel-v0"}"#, false);
    assert!(noticed().unwrap().ends_with("its `env_args` name a controller of the end effector"));
}

#[test]
fn a_flat_file_with_times_reads_as_a_text_and_other_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.h5");
    let times: Vec<f64> = (0..ROWS).map(|k| k as f64 / 30.0).collect();
    let mut file = FileBuilder::new();
    file.create_dataset("t_s").with_f64_data(&times).with_shape(&[ROWS]);
    file.create_dataset("qpos").with_f64_data(&angles(0.0)).with_shape(&[ROWS, 2]);
    file.write(&path).unwrap();
    let flat = ReadOptions {
        columns: vec![("elbow_rad".into(), "qpos.0".into())],
        units: vec![UnitRule::parse("qpos.0=rad").unwrap()],
        ..options(None)
    };
    let seen = read(&path, &flat).unwrap().observation;
    assert_eq!((seen.clock(), seen.row(7)[0].to_bits()), (&times[..], (7.0f64 * 0.1).sin().to_bits()));
    let bytes = std::fs::read(&path).unwrap();
    std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    assert!(read(&path, &flat).is_err());
}

fn half_type() -> hdf5_pure::Datatype {
    let layout = FloatingPointLayout {
        bit_offset: 0,
        bit_precision: 16,
        exponent_location: 10,
        exponent_size: 5,
        mantissa_location: 0,
        mantissa_size: 10,
        exponent_bias: 15,
    };
    hdf5_pure::Datatype::FloatingPoint { size: 2, byte_order: DatatypeByteOrder::LittleEndian, layout }
}

#[test]
fn half_precision_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.hdf5");
    let mut file = FileBuilder::new();
    let halves: Vec<u8> = (0..ROWS).flat_map(|k| if k % 2 == 0 { [0x00, 0x3c] } else { [0x00, 0xc0] }).collect();
    file.create_dataset("q").with_raw_data(half_type(), halves, ROWS).with_shape(&[ROWS]);
    file.write(&path).unwrap();
    let options = ReadOptions {
        columns: vec![("elbow_rad".into(), "q".into())],
        units: vec![UnitRule::parse("rad").unwrap()],
        ..options(Some(20.0))
    };
    let seen = read(&path, &options).unwrap().observation;
    assert_eq!([seen.row(0)[0], seen.row(1)[0]], [1.0, -2.0]);
}

#[test]
fn arrays_that_are_no_columns_are_named_where_there_are_no_others() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.hdf5");
    let mut file = FileBuilder::new();
    file.create_dataset("note").with_u8_data(&[1, 2]).with_shape(&[2]);
    file.write(&path).unwrap();
    let (message, _) = error_text(&contents(&path).unwrap_err());
    let wanted = "a.hdf5: expected arrays with a row for each instant, found none in 0 groups; arrays are left out: `note` (no rows of numbers)";
    assert_eq!(message, wanted);
    let large = super::shape::NoColumns::Large(14_000_000_000).to_string();
    assert_eq!(large, "14000000000 numbers, more than 40000000");
}

#[test]
fn a_matlab_file_says_how_it_becomes_columns() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mat");
    let text = "MATLAB 7.3 MAT-file, Platform: GLNXA64";
    std::fs::write(&path, [text.as_bytes(), &[0; 600]].concat()).unwrap();
    let (message, hint) = error_text(&read(&path, &ReadOptions::default()).unwrap_err());
    assert_eq!(message, "a.mat: expected a recording, found a MATLAB file (version 7.3)");
    assert!(hint.contains("h5py") && hint.contains("numpy.savez") && hint.contains("writetable"), "{hint}");
}

/// A file of h5py with `observations/qpos`, a soft link in each of its groups and, in the newer form, one into another file.
#[test]
fn links_are_named_in_both_forms_of_a_group() {
    let (_folder, path) = file("a.hdf5", include_bytes!("testdata/links_new.hdf5"));
    let Contents::Episodes(found) = contents(&path).unwrap() else { panic!("episodes") };
    let text = "links are not followed: `action` (`/observations/qpos`), `far` (`x.hdf5 /a`), `observations.alias` (`/observations/qpos`)";
    assert_eq!(found.notes.iter().map(|note| note.text.as_str()).collect::<Vec<_>>(), [text]);
    let (_folder, path) = file("a.hdf5", include_bytes!("testdata/links_old.hdf5"));
    let (message, hint) = error_text(&contents(&path).unwrap_err());
    let wanted = "a.hdf5: expected arrays and groups in `/`, found a link, which is not followed: `action` (`/observations/qpos`), \
                  `far` (`/x`), `observations.alias` (`/observations/qpos`)";
    assert!(message == wanted && hint.contains("file.copy"), "{message}");
}

/// Any byte may be wrong: the search for links ends.
#[test]
fn broken_links_end_the_search() {
    for bytes in [&include_bytes!("testdata/links_new.hdf5")[..], include_bytes!("testdata/links_old.hdf5")] {
        let (_folder, path) = file("a.hdf5", bytes);
        let opened = hdf5_pure::File::open_streaming(&path).unwrap();
        for at in (0..bytes.len().min(2_000)).step_by(3) {
            let mut broken = bytes.to_vec();
            broken[at] = 0xff;
            std::fs::write(&path, broken).unwrap();
            drop(super::links::links(&path, opened.superblock(), "/"));
        }
    }
}
