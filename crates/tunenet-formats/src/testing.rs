//! Files made in code for the tests of this folder.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::PathBuf;

use byteorder::BigEndian;
use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions};

use crate::read;
use crate::recording::{ReadOptions, Recording};
use crate::ros::cdr::{Header, JointState, OdometryStart, Point, PointStamped, Time, encode};
use crate::ros::stamps::split;
use crate::{Error, Result};

/// A folder that goes away with the test, and a file in it.
pub(crate) fn file(name: &str, bytes: impl AsRef<[u8]>) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    (folder, path)
}

/// What reading a file with these bytes gives.
pub(crate) fn read_as(name: &str, bytes: impl AsRef<[u8]>, options: &ReadOptions) -> Result<Recording> {
    let (_folder, path) = file(name, bytes);
    read(&path, options)
}

/// The error without its folder, and its hint.
pub(crate) fn error_text(error: &Error) -> (String, String) {
    let text = error.to_string();
    let at = text.find("/a.").map_or(0, |at| at + 1);
    (text[at..].to_owned(), error.hint().unwrap_or_default().to_owned())
}

/// One topic of a made file.
pub(crate) struct Made {
    pub topic: &'static str,
    pub schema: &'static str,
    /// The text of the schema.
    pub definition: &'static str,
    pub encoding: &'static str,
    /// Log time in ns and bytes.
    pub messages: Vec<(u64, Vec<u8>)>,
}

pub(crate) fn bag(compression: Option<Compression>, topics: &[Made]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let options = WriteOptions::new().compression(compression).chunk_size(Some(4096)).compression_threads(0);
    let mut writer = options.create(Cursor::new(&mut bytes)).unwrap();
    for Made { topic, schema, definition, encoding, messages } in topics {
        let schema = writer.add_schema(schema, "ros2msg", definition.as_bytes()).unwrap();
        let channel_id = writer.add_channel(schema, topic, encoding, &BTreeMap::new()).unwrap();
        for (sequence, (log_time, data)) in (0..).zip(messages) {
            let header = MessageHeader { channel_id, sequence, log_time: *log_time, publish_time: *log_time };
            writer.write_to_known_channel(&header, data).unwrap();
        }
    }
    writer.finish().unwrap();
    drop(writer);
    bytes
}

fn header(stamp_ns: i64) -> Header {
    let (sec, nanosec) = split(stamp_ns);
    Header { stamp: Time { sec: i32::try_from(sec).unwrap(), nanosec }, frame_id: "odd one".into() }
}

pub(crate) fn point(stamp_ns: i64, z: f64) -> Vec<u8> {
    encode(&PointStamped { header: header(stamp_ns), point: Point { x: 0.1, y: 0.2, z } }).unwrap()
}

pub(crate) fn point_big_endian(stamp_ns: i64, z: f64) -> Vec<u8> {
    let message = PointStamped { header: header(stamp_ns), point: Point { x: 0.1, y: 0.2, z } };
    [&[0, 0, 0, 0], cdr_encoding::to_vec::<_, BigEndian>(&message).unwrap().as_slice()].concat()
}

/// An odometry message with what follows the position: orientation, covariances and twist.
pub(crate) fn odometry(stamp_ns: i64, z: f64) -> Vec<u8> {
    let start = OdometryStart {
        header: header(stamp_ns),
        child_frame_id: "ball".into(),
        position: Point { x: 0.1, y: 0.2, z },
    };
    [encode(&start).unwrap(), vec![0; 8 * (4 + 36 + 6 + 36)]].concat()
}

pub(crate) fn joints(stamp_ns: i64, names: &[&str], position: &[f64], effort: &[f64]) -> Vec<u8> {
    let name = names.iter().map(|name| (*name).to_owned()).collect();
    let (position, effort) = (position.to_vec(), effort.to_vec());
    encode(&JointState { header: header(stamp_ns), name, position, velocity: Vec::new(), effort }).unwrap()
}

/// A topic of `count` messages, 10 ms apart from 1 s on.
pub(crate) fn made(
    topic: &'static str,
    schema: &'static str,
    count: u32,
    message: impl Fn(i64, f64) -> Vec<u8>,
) -> Made {
    let messages = (0..count).map(|i| {
        let ns = 1_000_000_000 + 10_000_000 * i64::from(i);
        (ns.unsigned_abs() + 500, message(ns, f64::from(i)))
    });
    Made { topic, schema, definition: "text", encoding: "cdr", messages: messages.collect() }
}

pub(crate) fn ball(count: u32) -> Made {
    made("/ball/point", "geometry_msgs/msg/PointStamped", count, point)
}

/// Rewrites the end of a Parquet file so that its first group says that it has so many rows.
#[cfg(feature = "logs")]
pub(crate) fn claim_rows(path: &std::path::Path, rows: i64) {
    use parquet::file::metadata::{ParquetMetaDataReader, ParquetMetaDataWriter};
    let bytes = std::fs::read(path).unwrap();
    let footer = u32::from_le_bytes(bytes[bytes.len() - 8..bytes.len() - 4].try_into().unwrap());
    let data = &bytes[..bytes.len() - 8 - usize::try_from(footer).unwrap()];
    let about = ParquetMetaDataReader::new().parse_and_finish(&std::fs::File::open(path).unwrap()).unwrap();
    let mut groups = about.row_groups().to_vec();
    groups[0] = groups[0].clone().into_builder().set_num_rows(rows).build().unwrap();
    let about = about.into_builder().set_row_groups(groups).build();
    let mut end = Vec::new();
    ParquetMetaDataWriter::new(&mut end, &about).finish().unwrap();
    std::fs::write(path, [data, &end].concat()).unwrap();
}
