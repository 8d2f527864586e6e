//! A robot's way to a pose as an MCAP file.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

use mcap::McapError;
use mcap::records::MessageHeader;

use super::write::{into_io, log};
use crate::atomic::write_atomically;
use crate::ros::cdr::{Header, JointState, JointTrajectory, Time, TrajectoryPoint, encode};
use crate::ros::definitions::{JOINT_STATE, JOINT_TRAJECTORY};
use crate::ros::stamps::{split, to_ns};
use crate::{Error, Result};

/// Where the joints are at one instant of a way.
#[derive(Debug, Clone, PartialEq)]
pub struct JointPoint {
    /// Since the start, s; not negative.
    pub time_s: f64,
    /// Angles, rad.
    pub positions_rad: Vec<f64>,
    /// Their rates, rad/s.
    pub velocities_rad_s: Vec<f64>,
    /// The rates of these, rad/s².
    pub accelerations_rad_s2: Vec<f64>,
}

/// Writes a way of these joints as an MCAP file that Foxglove and ROS 2 tools open: the whole of it as one
/// `trajectory_msgs/msg/JointTrajectory` on `/joint_trajectory` at time 0, and every point of it as a
/// `sensor_msgs/msg/JointState` on `/joint_states`. `base` is the robot's link that stands still: the frame of all of them. The
/// same way gives the same bytes.
///
/// # Errors
/// [`Error::File`] where a point has not one angle, rate and acceleration for each joint, or times do not rise from 0 on within 68
/// years; [`Error::Io`] where the system refuses.
pub fn write_approach(base: &str, joints: &[String], points: &[JointPoint], path: impl AsRef<Path>) -> Result<()> {
    let path = path.as_ref();
    let mut stamps: Vec<(i32, u32, u64)> = Vec::with_capacity(points.len());
    for (i, point) in points.iter().enumerate() {
        let refuse = |message: String| Err(Error::file(path, message, "give another way"));
        let columns = [&point.positions_rad, &point.velocities_rad_s, &point.accelerations_rad_s2];
        if columns.iter().any(|v| v.len() != joints.len()) {
            return refuse(format!("point {}: expected {} joints, found another number", i + 1, joints.len()));
        }
        let stamp = to_ns(point.time_s).and_then(|ns| {
            let (sec, nanosec) = split(ns);
            Some((i32::try_from(sec).ok()?, nanosec, u64::try_from(ns).ok()?))
        });
        match stamp {
            Some(stamp) if stamps.last().is_none_or(|last| last.2 < stamp.2) => stamps.push(stamp),
            _ => return refuse(format!("point {}: expected a rising time from 0 on, found {}", i + 1, point.time_s)),
        }
    }
    write_atomically(path, |out| write(base, joints, points, &stamps, out).map_err(into_io))
}

fn write(
    base: &str,
    joints: &[String],
    points: &[JointPoint],
    stamps: &[(i32, u32, u64)],
    out: &mut dyn Write,
) -> std::result::Result<(), McapError> {
    let mut writer = log(out)?;
    let mut channel = |topic: &str, name: &str, definition: &str| {
        let schema = writer.add_schema(name, "ros2msg", definition.as_bytes())?;
        writer.add_channel(schema, topic, "cdr", &BTreeMap::new())
    };
    let whole = channel("/joint_trajectory", "trajectory_msgs/msg/JointTrajectory", JOINT_TRAJECTORY)?;
    let states = channel("/joint_states", "sensor_msgs/msg/JointState", JOINT_STATE)?;
    let header = |sec: i32, nanosec: u32| Header { stamp: Time { sec, nanosec }, frame_id: base.to_owned() };
    let point = |(point, (sec, nanosec, _)): (&JointPoint, &(i32, u32, u64))| TrajectoryPoint {
        positions: point.positions_rad.clone(),
        velocities: point.velocities_rad_s.clone(),
        accelerations: point.accelerations_rad_s2.clone(),
        effort: Vec::new(),
        time_from_start: Time { sec: *sec, nanosec: *nanosec },
    };
    let message = JointTrajectory {
        header: header(0, 0),
        joint_names: joints.to_vec(),
        points: points.iter().zip(stamps).map(point).collect(),
    };
    let at = |channel_id: u16, sequence: u32, time: u64| MessageHeader {
        channel_id,
        sequence,
        log_time: time,
        publish_time: time,
    };
    writer.write_to_known_channel(&at(whole, 0, 0), &encode(&message)?)?;
    for (i, (point, (sec, nanosec, time))) in points.iter().zip(stamps).enumerate() {
        let state = JointState {
            header: header(*sec, *nanosec),
            name: joints.to_vec(),
            position: point.positions_rad.clone(),
            velocity: point.velocities_rad_s.clone(),
            effort: Vec::new(),
        };
        let sequence = u32::try_from(i).unwrap_or(u32::MAX);
        writer.write_to_known_channel(&at(states, sequence, *time), &encode(&state)?)?;
    }
    writer.finish()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ReadOptions, read};

    fn point(time_s: f64, q: f64) -> JointPoint {
        JointPoint {
            time_s,
            positions_rad: vec![q, -q],
            velocities_rad_s: vec![1.0, -1.0],
            accelerations_rad_s2: vec![0.0; 2],
        }
    }

    #[test]
    fn the_states_are_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("approach.mcap");
        let joints = ["a".to_string(), "b".to_string()];
        let points = [point(0.0, 0.1), point(0.5, 0.6), point(1.0, 1.1)];
        write_approach("base", &joints, &points, &path).unwrap();
        let options = ReadOptions { topic: Some("/joint_states".into()), ..ReadOptions::default() };
        let seen = read(&path, &options).unwrap().observation;
        assert_eq!(seen.clock(), [0.0, 0.5, 1.0]);
        assert_eq!(seen.column(0).collect::<Vec<_>>(), [0.1, 0.6, 1.1]);
    }

    #[test]
    fn the_whole_way_is_one_message_of_plain_fields() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("approach.mcap");
        write_approach("base", &["a".to_string(), "b".to_string()], &[point(0.0, 0.25), point(0.5, 2.0)], &path)
            .unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let mut messages = mcap::MessageStream::new(&bytes).unwrap().map(|m| m.unwrap());
        let whole = messages.find(|m| m.channel.topic == "/joint_trajectory").unwrap();
        assert_eq!(whole.channel.schema.as_ref().unwrap().name, "trajectory_msgs/msg/JointTrajectory");
        // Mark, stamp, frame, two names, two points; then 2.0 is somewhere as eight bytes, and so is 0.5 s.
        let holds = |wanted: &[u8]| whole.data.windows(wanted.len()).any(|w| w == wanted);
        assert!(
            holds(&2.0_f64.to_le_bytes()) && holds(&500_000_000_u32.to_le_bytes()) && holds(b"base\0") && holds(b"a\0")
        );
    }

    #[test]
    fn a_way_that_stands_still_or_lacks_a_joint_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("approach.mcap");
        let joints = ["a".to_string(), "b".to_string()];
        let twice = write_approach("base", &joints, &[point(0.0, 0.1), point(0.0, 0.2)], &path).unwrap_err();
        assert!(twice.to_string().contains("point 2: expected a rising time"), "{twice}");
        let short = write_approach("base", &joints[..1], &[point(0.0, 0.1)], &path).unwrap_err();
        assert!(short.to_string().contains("point 1: expected 1 joints"), "{short}");
        assert!(!path.exists());
    }
}
