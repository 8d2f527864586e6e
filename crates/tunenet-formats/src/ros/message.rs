//! The fields of a message, in any encoding.

use std::hash::{DefaultHasher, Hash, Hasher};

use tunenet_core::observation::Kind;

use super::numbers::Numbers;

/// Why a message of another kind cannot be used.
pub(crate) const NOTHING: &str = "carries no positions, joints or bounces";

/// Why a message of numbers is not used by itself.
pub(crate) const NUMBERS: &str = "carries numbers, which `--columns` has to name";

/// One message of a kind that an observation can be made of.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Decoded {
    /// The stamp in its header, in ns.
    pub stamp_ns: Option<i64>,
    pub sample: Sample,
}

impl Decoded {
    /// The numbers of a message of joints, by their names; those of each point of a way, of which the first that has numbers has
    /// names. No rows for any other.
    pub fn into_rows(self) -> Vec<Numbers> {
        let (joints, points) = match self.sample {
            Sample::Joints(JointMessage { name, position, velocity, effort }) => {
                (name, vec![(0, [position, velocity, effort])])
            }
            Sample::Way(Way { name, points }) => (name, points),
            Sample::Position(_) | Sample::Bounce(_) | Sample::Numbers(_) => return Vec::new(),
        };
        // Not the names themselves: a way may have a million points and long names.
        let mut hasher = DefaultHasher::new();
        joints.hash(&mut hasher);
        let mut known = false;
        let row = |(after_ns, arrays): (i64, [Vec<f64>; 3])| {
            let mut row = Numbers { stamp_ns: self.stamp_ns, after_ns, ..Numbers::default() };
            row.layout.extend(hasher.finish().to_le_bytes());
            for (array, values) in ["position", "velocity", "effort"].into_iter().zip(arrays) {
                let fits = values.len() == joints.len();
                row.layout.push(u8::from(fits));
                if fits && !known {
                    row.names.extend(joints.iter().map(|joint| format!("{array}.{joint}")));
                }
                if fits {
                    row.values.extend(values);
                }
            }
            known |= !row.names.is_empty();
            row
        };
        points.into_iter().map(row).collect()
    }
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Sample {
    /// x, y, z in m.
    Position([f64; 3]),
    Joints(JointMessage),
    /// The number of an impact; its time is the stamp.
    Bounce(f64),
    Way(Way),
    /// Numbers of a message of another type.
    Numbers(Numbers),
}

impl Sample {
    pub fn kind(&self) -> Kind {
        match self {
            Self::Position(_) => Kind::Positions,
            Self::Joints(_) | Self::Way(_) => Kind::Joints,
            Self::Bounce(_) => Kind::EventTimes,
            Self::Numbers(_) => Kind::Other,
        }
    }
}

/// The points of a way, and whose joints they are.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Way {
    pub name: Vec<String>,
    /// The time after the stamp, in ns; positions, velocities and efforts, as in a [`JointMessage`].
    pub points: Vec<(i64, [Vec<f64>; 3])>,
}

/// Joints by name; each array is as long as `name` or empty.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct JointMessage {
    pub name: Vec<String>,
    /// rad.
    pub position: Vec<f64>,
    /// rad/s.
    pub velocity: Vec<f64>,
    /// N·m.
    pub effort: Vec<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_point_of_a_way_is_a_row_of_named_numbers() {
        let point = |after: i64, q: f64| (after, [vec![q, -q], Vec::new(), vec![0.5; 3]]);
        let way = Way { name: vec!["hip".into(), "knee".into()], points: vec![point(0, 0.1), point(20, 0.2)] };
        let rows = Decoded { stamp_ns: Some(7), sample: Sample::Way(way) }.into_rows();
        assert_eq!(rows.len(), 2);
        assert_eq!(rows[0].names, ["position.hip", "position.knee"]);
        assert_eq!((rows[1].stamp_ns, rows[1].after_ns, &rows[1].values[..]), (Some(7), 20, &[0.2, -0.2][..]));
        assert_eq!(rows[0].layout, rows[1].layout);
    }
}
