//! Messages in JSON: the ROS shapes, Foxglove's, and flat ones.

use serde_json::{Map, Value};

use super::message::{Decoded, JointMessage, NOTHING, Sample};
use super::stamps::{joined, to_ns};

/// What a JSON message says: `{header: {stamp: {sec, nanosec}}, point: {x, y, z}}`, a `pose.position`, Foxglove's
/// `{timestamp: {sec, nsec}, pose: {position}}`, flat `{x, y, z}`, joints as in `sensor_msgs/JointState`, or
/// `{timestamp, bounce}`.
pub(crate) fn decode(data: &[u8]) -> std::result::Result<Decoded, String> {
    let value: Value = serde_json::from_slice(data).map_err(|e| format!("expected JSON: {e}"))?;
    let Value::Object(message) = &value else { return Err("expected a JSON object".into()) };
    let stamp_ns = stamp(message);
    if let Some(number) = message.get("bounce").and_then(Value::as_f64) {
        return Ok(Decoded { stamp_ns, sample: Sample::Bounce(number) });
    }
    if let Some(names) = message.get("name").and_then(Value::as_array) {
        return Ok(Decoded { stamp_ns, sample: Sample::Joints(joints(message, names)?) });
    }
    let places = ["/point", "/pose/position", "/pose/pose/position", "/position", ""];
    match places.iter().find_map(|place| position(value.pointer(place)?)) {
        Some(position) => Ok(Decoded { stamp_ns, sample: Sample::Position(position) }),
        None => Err(NOTHING.into()),
    }
}

fn position(at: &Value) -> Option<[f64; 3]> {
    let axis = |name| at.get(name).and_then(Value::as_f64);
    Some([axis("x")?, axis("y")?, axis("z")?])
}

fn stamp(message: &Map<String, Value>) -> Option<i64> {
    let header = message.get("header").and_then(|header| header.get("stamp"));
    match header.or_else(|| message.get("timestamp")).or_else(|| message.get("stamp"))? {
        Value::Object(stamp) => {
            let rest = ["nanosec", "nsec", "nsecs"].iter().find_map(|name| stamp.get(*name)?.as_i64()).unwrap_or(0);
            let sec = ["sec", "secs"].iter().find_map(|name| stamp.get(*name)?.as_i64())?;
            joined(sec, rest)
        }
        Value::Number(seconds) => to_ns(seconds.as_f64()?),
        _ => None,
    }
}

fn joints(message: &Map<String, Value>, names: &[Value]) -> std::result::Result<JointMessage, String> {
    let name = names.iter().map(|name| name.as_str().map(str::to_owned)).collect::<Option<Vec<_>>>();
    let numbers = |key: &str| match message.get(key) {
        None | Some(Value::Null) => Ok(Vec::new()),
        // JSON has no NaN; writers put null where a joint's effort is unknown.
        Some(Value::Array(values)) => Ok(values.iter().map(|value| value.as_f64().unwrap_or(f64::NAN)).collect()),
        Some(_) => Err(format!("expected numbers in `{key}`")),
    };
    Ok(JointMessage {
        name: name.ok_or("expected joint names as text")?,
        position: numbers("position")?,
        velocity: numbers("velocity")?,
        effort: numbers("effort")?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shape_of_a_position_is_read() {
        let stamped = Decoded { stamp_ns: Some(1_500_000_000), sample: Sample::Position([1.0, 2.0, 3.0]) };
        for text in [
            r#"{"header":{"stamp":{"sec":1,"nanosec":500000000}},"point":{"x":1,"y":2,"z":3}}"#,
            r#"{"header":{"stamp":{"sec":1,"nsec":500000000}},"pose":{"position":{"x":1,"y":2,"z":3}}}"#,
            r#"{"header":{"stamp":{"sec":1,"nanosec":500000000}},"pose":{"pose":{"position":{"x":1,"y":2,"z":3}}}}"#,
            r#"{"timestamp":{"sec":1,"nsec":500000000},"pose":{"position":{"x":1,"y":2,"z":3}}}"#,
            r#"{"timestamp":1.5,"x":1,"y":2,"z":3}"#,
        ] {
            assert_eq!(decode(text.as_bytes()), Ok(stamped.clone()), "{text}");
        }
        let flat = Decoded { stamp_ns: None, sample: Sample::Position([1.0, 2.0, 3.0]) };
        assert_eq!(decode(br#"{"x":1,"y":2,"z":3}"#), Ok(flat));
    }

    #[test]
    fn other_messages_say_what_they_lack() {
        assert_eq!(decode(br#"{"data":"hello"}"#).unwrap_err(), "carries no positions, joints or bounces");
        assert_eq!(decode(b"[1]").unwrap_err(), "expected a JSON object");
        assert!(decode(b"{").unwrap_err().starts_with("expected JSON: "));
    }

    #[test]
    fn unknown_efforts_are_nan() {
        let found = decode(br#"{"name":["a"],"position":[1.5],"effort":[null]}"#).unwrap();
        let Sample::Joints(joints) = found.sample else { panic!("joints") };
        assert_eq!((joints.position, joints.velocity.len()), (vec![1.5], 0));
        assert!(joints.effort[0].is_nan());
    }
}
