//! The message definitions that go into an MCAP file, so that other programs can read it without ROS.

/// What `std_msgs/Header` needs, after the fields of a message that has one.
macro_rules! header {
    () => {
        "\
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"
    };
}

/// `geometry_msgs/msg/PointStamped` with all that it needs, in the form of `ros2msg` schemas.
pub(crate) const POINT_STAMPED: &str = concat!(
    "\
std_msgs/Header header
geometry_msgs/Point point
",
    header!(),
    "\
================================================================================
MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
"
);

/// `sensor_msgs/msg/JointState` with all that it needs.
pub(crate) const JOINT_STATE: &str = concat!(
    "\
std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
",
    header!()
);

/// `trajectory_msgs/msg/JointTrajectory` with all that it needs.
pub(crate) const JOINT_TRAJECTORY: &str = concat!(
    "\
std_msgs/Header header
string[] joint_names
trajectory_msgs/JointTrajectoryPoint[] points
",
    header!(),
    "\
================================================================================
MSG: trajectory_msgs/JointTrajectoryPoint
float64[] positions
float64[] velocities
float64[] accelerations
float64[] effort
builtin_interfaces/Duration time_from_start
================================================================================
MSG: builtin_interfaces/Duration
int32 sec
uint32 nanosec
"
);

/// The impact of a ball, as a JSON schema.
pub(crate) const BOUNCE: &str = r#"{
  "$schema": "https://json-schema.org/draft/2020-12/schema",
  "title": "tunenet.Bounce",
  "description": "The impact of a ball on a surface",
  "type": "object",
  "properties": {
    "timestamp": {
      "title": "time",
      "description": "When it happened",
      "type": "object",
      "properties": {
        "sec": { "type": "integer" },
        "nsec": { "type": "integer", "minimum": 0 }
      },
      "required": ["sec", "nsec"]
    },
    "bounce": { "type": "number", "description": "Number of the impact, from 0" }
  },
  "required": ["timestamp", "bounce"]
}
"#;
