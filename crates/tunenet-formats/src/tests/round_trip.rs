//! What is written is read back with the same bits, and no bytes whatsoever end the program.

use mcap::Compression;
use proptest::prelude::*;

use crate::testing::{bag, ball, file, joints, made};
use crate::{ReadOptions, contents, read, write_csv, write_mcap};
use tunenet_core::observation::{Channel, Kind, Observation};

fn clock() -> impl Strategy<Value = Vec<f64>> {
    (-5.0f64..1e9, prop::collection::vec(1e-3f64..10.0, 3..20)).prop_map(|(start, steps)| {
        steps
            .iter()
            .scan(start, |t, d| {
                *t += d;
                Some(*t)
            })
            .collect()
    })
}

/// A clock of whole nanoseconds.
fn ticks() -> impl Strategy<Value = Vec<f64>> {
    (-5_000_000_000i64..2_000_000_000, prop::collection::vec(1i64..3_000_000_000, 3..20)).prop_map(|(start, steps)| {
        steps
            .iter()
            .scan(start, |t, d| {
                *t += d;
                Some(*t as f64 / 1e9)
            })
            .collect()
    })
}

/// Every number that an observation may hold: what is larger is folded back, its bits kept.
fn any_finite() -> impl Strategy<Value = f64> {
    let finite = any::<f64>().prop_filter("finite", |value| value.is_finite());
    // Positions lie within 1e8 m.
    finite.prop_map(|value| if value.abs() > 1e8 { value % 1e8 } else { value })
}

fn filled(kind: Kind, clock: Vec<f64>, draw: &[f64]) -> Observation {
    let channels = match kind {
        Kind::Positions => Channel::positions(),
        Kind::Pixels => vec![Channel::new("u", "px"), Channel::new("v", "px")],
        _ => ["q1", "q2", "dq1", "dq2", "tau1", "tau2"]
            .iter()
            .map(|name| {
                let unit = if name.starts_with('q') {
                    "rad"
                } else if name.starts_with('d') {
                    "rad/s"
                } else {
                    "N·m"
                };
                Channel::new(*name, unit)
            })
            .collect(),
    };
    let values = draw.iter().copied().cycle().take(clock.len() * channels.len()).collect();
    Observation::new(kind, channels, clock, values).unwrap()
}

fn same_bits(a: &Observation, b: &Observation) -> bool {
    let bits = |o: &Observation| o.clock().iter().chain(o.values()).map(|v| v.to_bits()).collect::<Vec<_>>();
    a.kind() == b.kind() && a.channels() == b.channels() && bits(a) == bits(b)
}

fn back(name: &str, write: impl FnOnce(&std::path::Path) -> crate::Result<()>) -> Observation {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    write(&path).unwrap();
    read(&path, &ReadOptions::default()).unwrap().observation
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn csv_keeps_every_bit(clock in clock(), draw in prop::collection::vec(any_finite(), 1..40), which in 0usize..3) {
        let kind = [Kind::Positions, Kind::Pixels, Kind::Joints][which];
        let seen = filled(kind, clock, &draw);
        prop_assert!(same_bits(&back("a.csv", |path| write_csv(&seen, path)), &seen));
    }

    #[test]
    fn csv_keeps_every_bounce(times in clock(), skip in 0usize..3) {
        let numbers = (0..times.len()).map(|i| (if i >= 2 { i + skip } else { i }) as f64).collect();
        let seen = Observation::new(Kind::EventTimes, vec![Channel::new("bounce_time", "s")], numbers, times).unwrap();
        prop_assert!(same_bits(&back("a.csv", |path| write_csv(&seen, path)), &seen));
    }

    #[test]
    fn mcap_keeps_every_bit(clock in ticks(), draw in prop::collection::vec(any_finite(), 1..40), which in 0usize..2) {
        let seen = filled([Kind::Positions, Kind::Joints][which], clock, &draw);
        prop_assert!(same_bits(&back("a.mcap", |path| write_mcap(&seen, path)), &seen));
    }

    #[test]
    fn mcap_keeps_every_bounce(times in ticks(), skip in 0usize..3) {
        let numbers = (0..times.len()).map(|i| (if i >= 2 { i + skip } else { i }) as f64).collect();
        let seen = Observation::new(Kind::EventTimes, vec![Channel::new("bounce_time", "s")], numbers, times).unwrap();
        prop_assert!(same_bits(&back("a.mcap", |path| write_mcap(&seen, path)), &seen));
    }

    #[test]
    fn random_text_never_panics(text in "[-0-9.,;\tteznamsq_bounci1 \"\r\n#µ]{0,200}") {
        let (_folder, path) = file("a.csv", format!("t_s,z_m\n{text}"));
        read(&path, &ReadOptions::default()).ok();
        contents(&path).ok();
        std::fs::write(&path, &text).unwrap();
        read(&path, &ReadOptions::default()).ok();
        contents(&path).ok();
    }

    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..300), mark in any::<bool>()) {
        let bytes = if mark { [mcap::MAGIC, &bytes].concat() } else { bytes };
        let (_folder, path) = file("a.csv", bytes);
        read(&path, &ReadOptions::default()).ok();
        contents(&path).ok();
    }

    #[test]
    fn a_damaged_mcap_file_never_panics(
        cut in 0.0f64..1.0,
        flips in prop::collection::vec((0.0f64..1.0, any::<u8>()), 0..4),
        which in 0usize..3,
    ) {
        let compression = [None, Some(Compression::Zstd), Some(Compression::Lz4)][which];
        let arm = made("/j", "sensor_msgs/msg/JointState", 5, |ns, z| joints(ns, &["a", "b"], &[z, z], &[]));
        let mut bytes = bag(compression, &[ball(40), arm]);
        for (at, with) in flips {
            let at = (at * bytes.len() as f64).floor();
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an index")]
            let at = at as usize;
            bytes[at] ^= with;
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an index")]
        let cut = (cut * 2.0 * bytes.len() as f64) as usize;
        bytes.truncate(cut);
        let (_folder, path) = file("a.mcap", bytes);
        contents(&path).ok();
        read(&path, &ReadOptions { topic: Some("/j".into()), ..ReadOptions::default() }).ok();
        read(&path, &ReadOptions { topic: Some("/ball/point".into()), ..ReadOptions::default() }).ok();
    }
}

#[test]
fn csv_is_written_under_the_headers_that_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.csv");
    let text = |observation: &Observation| {
        write_csv(observation, &path).unwrap();
        std::fs::read_to_string(&path).unwrap()
    };
    let ball =
        Observation::positions(vec![0.0, 0.1, 0.2], &[[0.0, 0.0, 1.0], [0.0, -0.0, 1e-9], [1e30, 0.0, 0.1]]).unwrap();
    assert_eq!(text(&ball), "t_s,x_m,y_m,z_m\n0.0,0.0,0.0,1.0\n0.1,0.0,-0.0,1e-9\n0.2,1e30,0.0,0.1\n");
    assert_eq!(
        text(&Observation::event_times("bounce_time", vec![0.5, 1.0, 1.4]).unwrap()),
        "bounce_time_s\n0.5\n1.0\n1.4\n"
    );
    let arm = filled(Kind::Joints, vec![0.0, 1.0, 2.0], &[1.0]);
    assert!(text(&arm).starts_with("t_s,q1_rad,q2_rad,dq1_rad_s,dq2_rad_s,tau1_nm,tau2_nm\n"));
}

#[test]
fn mcap_is_what_other_programs_expect() {
    let folder = tempfile::tempdir().unwrap();
    let (one, two) = (folder.path().join("1.mcap"), folder.path().join("2.mcap"));
    let seen = Observation::positions(vec![-0.5, 0.0, 0.5], &[[1.0, 2.0, 3.0]; 3]).unwrap();
    write_mcap(&seen, &one).unwrap();
    write_mcap(&seen, &two).unwrap();
    let bytes = std::fs::read(&one).unwrap();
    assert_eq!(bytes, std::fs::read(&two).unwrap());
    let all: Vec<_> = mcap::MessageStream::new(&bytes).unwrap().collect::<Result<_, _>>().unwrap();
    assert_eq!(all.iter().map(|message| message.log_time).collect::<Vec<_>>(), [0, 500_000_000, 1_000_000_000]);
    let channel = &all[0].channel;
    let schema = channel.schema.as_ref().unwrap();
    assert_eq!((channel.topic.as_str(), channel.message_encoding.as_str()), ("/ball/point", "cdr"));
    assert_eq!((schema.name.as_str(), schema.encoding.as_str()), ("geometry_msgs/msg/PointStamped", "ros2msg"));
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    assert_eq!(summary.stats.unwrap().message_count, 3);
    assert_eq!(summary.chunk_indexes[0].compression, "zstd");
    let crate::Contents::Log(log) = contents(&one).unwrap() else { panic!("a log") };
    assert_eq!((log.profile.as_str(), log.library.as_str()), ("ros2", "tunenet"));
}

#[test]
fn what_has_no_message_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let refused = |observation: &Observation| crate::testing::error_text(&write_mcap(observation, &path).unwrap_err());
    let expected = "expected positions, bounce times, or joint angles, velocities and torques";
    let pixels = filled(Kind::Pixels, vec![0.0, 1.0, 2.0], &[1.0]);
    assert_eq!(refused(&pixels), (format!("a.mcap: {expected}, found pixels"), "write a `.csv` file instead".into()));
    let current = vec![Channel::new("i1", "A")];
    let current = Observation::new(Kind::Joints, current, vec![0.0, 1.0, 2.0], vec![0.0; 3]).unwrap();
    assert_eq!(refused(&current).0, format!("a.mcap: {expected}, found `i1`"));
    let dense = filled(Kind::Positions, vec![0.0, 1e-10, 2e-10], &[1.0]);
    assert_eq!(
        refused(&dense).0,
        "a.mcap: the time of sample 2: expected a whole nanosecond more than the one before, found 1e-10 s"
    );
    let late = filled(Kind::Positions, vec![0.0, 1.0, 1e10], &[1.0]);
    assert_eq!(
        refused(&late).0,
        "a.mcap: the time of sample 3: expected a time within 68 years of 0, found 10000000000.0 s"
    );
    assert!(!path.exists());
}
