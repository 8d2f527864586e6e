//! An observation as an MCAP file.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{Compression, McapError, WriteOptions, Writer};

use crate::atomic::write_atomically;
use crate::ros::cdr::{Header, JointState, Point, PointStamped, Time, encode};
use crate::ros::definitions::{BOUNCE, JOINT_STATE, POINT_STAMPED};
use crate::ros::stamps::{split, to_ns};
use crate::{Error, Result};
use tunenet_core::observation::{Kind, Observation};

/// Writes `observation` as an MCAP file that Foxglove and ROS 2 tools open.
///
/// Positions become `geometry_msgs/msg/PointStamped` on `/ball/point`, joints `sensor_msgs/msg/JointState` on
/// `/joint_states` (joints named `joint1`, …), bounce times JSON on `/ball/bounce`. Times are whole nanoseconds: a clock
/// that counts them comes back with the same bits, any other within 0.5 ns; values always come back with the same bits.
/// The same observation gives the same bytes. The file is replaced in one step.
///
/// # Errors
/// [`Error::File`] where the observation has no such message (pixels, motor currents, other series), or where its clock
/// leaves ±68 years or has two samples within one nanosecond. [`Error::Io`] where the system refuses.
pub fn write_mcap(observation: &Observation, path: impl AsRef<Path>) -> Result<()> {
    let path = path.as_ref();
    let plan = plan(observation, path)?;
    let stamps = stamps(observation, path)?;
    write_atomically(path, |out| write(observation, &plan, &stamps, out).map_err(into_io))
}

/// Which message carries which channel.
enum Plan {
    Point,
    Bounce,
    /// Names, and for position, velocity and effort the channels of the joints, empty where there are none.
    Joints(Vec<String>, [Vec<usize>; 3]),
}

fn plan(observation: &Observation, path: &Path) -> Result<Plan> {
    let refuse = |what: &str| {
        let message =
            format!("expected positions, bounce times, or joint angles, velocities and torques, found {what}");
        Err(Error::file(path, message, "write a `.csv` file instead"))
    };
    match observation.kind() {
        Kind::Positions if observation.channels().len() == 3 => Ok(Plan::Point),
        Kind::EventTimes => Ok(Plan::Bounce),
        Kind::Joints => {
            let mut families: [Vec<usize>; 3] = Default::default();
            for (index, channel) in observation.channels().iter().enumerate() {
                let name = channel.name.trim_end_matches(|c: char| c.is_ascii_digit());
                let family = match name {
                    "q" => &mut families[0],
                    "dq" => &mut families[1],
                    "tau" => &mut families[2],
                    _ => return refuse(&format!("`{}`", channel.name)),
                };
                family.push(index);
                if channel.name != format!("{name}{}", family.len()) {
                    return refuse(&format!("`{}` out of order", channel.name));
                }
            }
            let joints = families.iter().map(Vec::len).max().unwrap_or(0);
            if families.iter().any(|family| !family.is_empty() && family.len() != joints) {
                return refuse("quantities of different joints");
            }
            Ok(Plan::Joints((1..=joints).map(|joint| format!("joint{joint}")).collect(), families))
        }
        other => refuse(other.name()),
    }
}

/// The clock in ns, or the times of the impacts.
fn stamps(observation: &Observation, path: &Path) -> Result<Vec<i64>> {
    let times = if observation.kind() == Kind::EventTimes { observation.values() } else { observation.clock() };
    let mut stamps: Vec<i64> = Vec::with_capacity(times.len());
    for (i, time) in times.iter().enumerate() {
        let refuse = |expected: &str| {
            let message = format!("the time of sample {}: expected {expected}, found {time:?} s", i + 1);
            Err(Error::file(path, message, "write a `.csv` file instead"))
        };
        let stamp = to_ns(*time).filter(|stamp| i32::try_from(split(*stamp).0).is_ok());
        let Some(stamp) = stamp else { return refuse("a time within 68 years of 0") };
        if stamps.last().is_some_and(|last| *last >= stamp) {
            return refuse("a whole nanosecond more than the one before");
        }
        stamps.push(stamp);
    }
    Ok(stamps)
}

/// A log to be written: one thread, so that the bytes do not depend on the machine; and no seeking, so that any writer will do.
pub(super) fn log(out: &mut dyn Write) -> std::result::Result<Writer<NoSeek<&mut dyn Write>>, McapError> {
    let options = WriteOptions::new().profile("ros2").library("tunenet").compression(Some(Compression::Zstd));
    options.compression_threads(0).disable_seeking(true).create(NoSeek::new(out))
}

fn write(
    observation: &Observation,
    plan: &Plan,
    stamps: &[i64],
    out: &mut dyn Write,
) -> std::result::Result<(), McapError> {
    let mut writer = log(out)?;
    let channel_id = channel(&mut writer, plan)?;
    // Log times cannot be negative: a clock that starts before 0 is logged from 0 on.
    let shift = stamps.first().map_or(0, |first| first.min(&0).unsigned_abs());
    for (sample, stamp) in stamps.iter().enumerate() {
        let data = message(observation, plan, sample, *stamp)?;
        let log_time = stamp.saturating_add_unsigned(shift).unsigned_abs();
        let sequence = u32::try_from(sample).unwrap_or(u32::MAX);
        writer
            .write_to_known_channel(&MessageHeader { channel_id, sequence, log_time, publish_time: log_time }, &data)?;
    }
    writer.finish()?;
    Ok(())
}

fn channel<W: Write + std::io::Seek>(writer: &mut Writer<W>, plan: &Plan) -> std::result::Result<u16, McapError> {
    let (topic, name, schema, text, encoding) = match plan {
        Plan::Point => ("/ball/point", "geometry_msgs/msg/PointStamped", "ros2msg", POINT_STAMPED, "cdr"),
        Plan::Joints(..) => ("/joint_states", "sensor_msgs/msg/JointState", "ros2msg", JOINT_STATE, "cdr"),
        Plan::Bounce => ("/ball/bounce", "tunenet.Bounce", "jsonschema", BOUNCE, "json"),
    };
    let schema_id = writer.add_schema(name, schema, text.as_bytes())?;
    writer.add_channel(schema_id, topic, encoding, &BTreeMap::new())
}

fn message(observation: &Observation, plan: &Plan, sample: usize, stamp: i64) -> std::io::Result<Vec<u8>> {
    let row = observation.row(sample);
    let (sec, nanosec) = split(stamp);
    let header = |frame: &str| -> std::io::Result<Header> {
        let sec = i32::try_from(sec).map_err(std::io::Error::other)?;
        Ok(Header { stamp: Time { sec, nanosec }, frame_id: frame.into() })
    };
    match plan {
        Plan::Point => {
            encode(&PointStamped { header: header("world")?, point: Point { x: row[0], y: row[1], z: row[2] } })
        }
        Plan::Joints(name, families) => {
            let [position, velocity, effort] =
                families.each_ref().map(|family| family.iter().map(|i| row[*i]).collect());
            encode(&JointState { header: header("")?, name: name.clone(), position, velocity, effort })
        }
        Plan::Bounce => {
            let message = serde_json::json!({
                "timestamp": { "sec": sec, "nsec": nanosec },
                "bounce": observation.clock()[sample],
            });
            Ok(message.to_string().into_bytes())
        }
    }
}

pub(super) fn into_io(error: McapError) -> std::io::Error {
    match error {
        McapError::Io(error) => error,
        other => std::io::Error::other(other),
    }
}
