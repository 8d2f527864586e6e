//! ROS 2 messages in CDR: four bytes that say the byte order, then the fields, each aligned to its size.

use byteorder::{BigEndian, LittleEndian};
use serde::{Deserialize, Serialize};

use super::mark::{Order, body};
use super::message::{Decoded, JointMessage, Sample, Way};
use super::stamps::joined;

/// The mark of plain CDR, little-endian, as ROS 2 writes it before every message.
pub(crate) const LITTLE_ENDIAN: [u8; 4] = [0, 1, 0, 0];

/// `builtin_interfaces/msg/Time`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Time {
    pub sec: i32,
    pub nanosec: u32,
}

/// `std_msgs/msg/Header`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Header {
    pub stamp: Time,
    pub frame_id: String,
}

/// `geometry_msgs/msg/Point`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Point {
    pub x: f64,
    pub y: f64,
    pub z: f64,
}

/// `geometry_msgs/msg/PointStamped`; `PoseStamped` begins in the same way, and its orientation is not needed.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct PointStamped {
    pub header: Header,
    pub point: Point,
}

/// How `nav_msgs/msg/Odometry` begins; its orientation, covariance and twist are not needed.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct OdometryStart {
    pub header: Header,
    pub child_frame_id: String,
    pub position: Point,
}

/// `sensor_msgs/msg/JointState`. Each array is as long as `name`, or empty where the quantity is not known.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct JointState {
    pub header: Header,
    pub name: Vec<String>,
    pub position: Vec<f64>,
    pub velocity: Vec<f64>,
    pub effort: Vec<f64>,
}

/// `trajectory_msgs/msg/JointTrajectoryPoint`. Its time is a `builtin_interfaces/msg/Duration`, which is written as a time is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct TrajectoryPoint {
    pub positions: Vec<f64>,
    pub velocities: Vec<f64>,
    pub accelerations: Vec<f64>,
    pub effort: Vec<f64>,
    pub time_from_start: Time,
}

/// `trajectory_msgs/msg/JointTrajectory`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct JointTrajectory {
    pub header: Header,
    pub joint_names: Vec<String>,
    pub points: Vec<TrajectoryPoint>,
}

/// The message types that are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Type {
    /// `PointStamped` and `PoseStamped`.
    Point,
    Odometry,
    JointState,
    JointTrajectory,
}

impl Type {
    /// By schema name, with or without the `/msg/` of ROS 2.
    pub fn of(schema: &str) -> Option<Self> {
        match schema.replace("/msg/", "/").as_str() {
            "geometry_msgs/PointStamped" | "geometry_msgs/PoseStamped" => Some(Self::Point),
            "nav_msgs/Odometry" => Some(Self::Odometry),
            "sensor_msgs/JointState" => Some(Self::JointState),
            "trajectory_msgs/JointTrajectory" => Some(Self::JointTrajectory),
            _ => None,
        }
    }
}

/// A message in CDR, or what is wrong with its bytes.
pub(crate) fn decode(kind: Type, data: &[u8]) -> std::result::Result<Decoded, String> {
    let (header, sample) = match kind {
        Type::Point => {
            let (PointStamped { header, point }, _) = fields(data)?;
            (header, Sample::Position([point.x, point.y, point.z]))
        }
        Type::Odometry => {
            let (OdometryStart { header, position, .. }, _) = fields(data)?;
            (header, Sample::Position([position.x, position.y, position.z]))
        }
        Type::JointState => {
            let (JointState { header, name, position, velocity, effort }, _) = fields(data)?;
            (header, Sample::Joints(JointMessage { name, position, velocity, effort }))
        }
        Type::JointTrajectory => {
            let (JointTrajectory { header, joint_names, points }, _) = fields(data)?;
            let point = |TrajectoryPoint { positions, velocities, effort, time_from_start, .. }| {
                let Time { sec, nanosec } = time_from_start;
                (joined(i64::from(sec), i64::from(nanosec)).unwrap_or(i64::MAX), [positions, velocities, effort])
            };
            let points = points.into_iter().map(point).collect();
            (header, Sample::Way(Way { name: joint_names, points }))
        }
    };
    let Time { sec, nanosec } = header.stamp;
    Ok(Decoded { stamp_ns: joined(i64::from(sec), i64::from(nanosec)), sample })
}

/// The fields at the start of a message, and the bytes after them.
pub(crate) fn fields<T: for<'a> Deserialize<'a>>(data: &[u8]) -> std::result::Result<(T, &[u8]), String> {
    let (order, body) = body(data)?;
    let read = match order {
        Order::Big => cdr_encoding::from_bytes::<T, BigEndian>(body),
        Order::Little => cdr_encoding::from_bytes::<T, LittleEndian>(body),
    };
    let (fields, used) = read.map_err(|e| format!("{} bytes do not fit its type: {e}", data.len()))?;
    Ok((fields, &body[used..]))
}

/// A message as little-endian CDR, mark included.
pub(crate) fn encode<T: Serialize>(message: &T) -> std::io::Result<Vec<u8>> {
    let body = cdr_encoding::to_vec::<T, LittleEndian>(message).map_err(std::io::Error::other)?;
    Ok([LITTLE_ENDIAN.as_slice(), &body].concat())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_byte_orders_read_alike() {
        let header = Header { stamp: Time { sec: -1, nanosec: 500_000_000 }, frame_id: "odd".into() };
        let message = PointStamped { header, point: Point { x: 1.5, y: -2.0, z: 0.1 } };
        let big = [&[0, 0, 0, 0], cdr_encoding::to_vec::<_, BigEndian>(&message).unwrap().as_slice()].concat();
        let little = encode(&message).unwrap();
        assert_ne!(big, little);
        let expected = Decoded { stamp_ns: Some(-500_000_000), sample: Sample::Position([1.5, -2.0, 0.1]) };
        assert_eq!(decode(Type::Point, &big), Ok(expected.clone()));
        assert_eq!(decode(Type::Point, &little), Ok(expected));
    }

    /// The bytes as the standard lays them out: time, string with its length and closing 0, then 8-byte alignment
    /// counted from after the mark.
    #[test]
    fn validate_layout_by_hand() {
        let message = PointStamped {
            header: Header { stamp: Time { sec: 1, nanosec: 2 }, frame_id: "map".into() },
            point: Point { x: 1.0, y: 2.0, z: 3.0 },
        };
        let mut expected = vec![0, 1, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 4, 0, 0, 0, b'm', b'a', b'p', 0];
        for value in [1.0f64, 2.0, 3.0] {
            expected.extend(value.to_le_bytes());
        }
        assert_eq!(encode(&message).unwrap(), expected);
    }

    #[test]
    fn wrong_bytes_say_so() {
        assert_eq!(decode(Type::Point, &[0, 1]).unwrap_err(), "expected CDR, found 2 bytes");
        assert_eq!(
            decode(Type::Point, &[0, 7, 0, 0, 1]).unwrap_err(),
            "expected plain CDR (00 00 or 00 01), found 00 07"
        );
        assert_eq!(
            decode(Type::JointState, &[0, 1, 0, 0, 1]).unwrap_err(),
            "5 bytes do not fit its type: unexpected end of input"
        );
    }
}
