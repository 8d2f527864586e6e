//! What a column's name says: the quantity and its unit.

pub(crate) use tunenet_core::observation::plain;
use tunenet_core::observation::{Channel, Kind};

/// A quantity that an observation can hold. Joints count from 1. The order is the order of an observation's channels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Quantity {
    Time,
    X,
    Y,
    Z,
    U,
    V,
    BounceNumber,
    BounceTime,
    Angle(u16),
    Speed(u16),
    Torque(u16),
    Current(u16),
    /// A channel of a custom simulator, by its number from 0 among those that are asked for.
    Own(u16),
}

/// What files and answers call this kind of observation: "positions", "bounce times".
#[must_use]
pub fn kind_name(kind: Kind) -> &'static str {
    match kind {
        Kind::EventTimes => "bounce times",
        other => other.name(),
    }
}

impl Quantity {
    /// Whose column it is; `None` for those that go with any kind.
    pub fn kind(self) -> Option<Kind> {
        match self {
            Self::Time => None,
            Self::X | Self::Y | Self::Z => Some(Kind::Positions),
            Self::U | Self::V => Some(Kind::Pixels),
            Self::BounceNumber | Self::BounceTime => Some(Kind::EventTimes),
            Self::Angle(_) | Self::Speed(_) | Self::Torque(_) | Self::Current(_) => Some(Kind::Joints),
            Self::Own(_) => Some(Kind::Other),
        }
    }

    /// Whether it is measured along an axis, which may point the other way; a clock and a count have no such.
    pub fn has_sign(self) -> bool {
        !matches!(self, Self::Time | Self::BounceNumber | Self::BounceTime)
    }

    /// Name and unit of the channel that it fills.
    pub fn channel(self) -> Channel {
        match self {
            Self::Time => Channel::new("t", "s"),
            Self::X => Channel::new("x", "m"),
            Self::Y => Channel::new("y", "m"),
            Self::Z => Channel::new("z", "m"),
            Self::U => Channel::new("u", "px"),
            Self::V => Channel::new("v", "px"),
            Self::BounceNumber => Channel::new("bounce_number", "1"),
            Self::BounceTime => Channel::new("bounce_time", "s"),
            Self::Angle(joint) => Channel::new(format!("q{joint}"), "rad"),
            Self::Speed(joint) => Channel::new(format!("dq{joint}"), "rad/s"),
            Self::Torque(joint) => Channel::new(format!("tau{joint}"), "N·m"),
            Self::Current(joint) => Channel::new(format!("i{joint}"), "A"),
            // Its name and unit stand in the layout.
            Self::Own(number) => Channel::new(format!("channel{}", number + 1), "1"),
        }
    }

    /// The header of its column.
    pub fn header(self) -> String {
        self.channel().header()
    }

    /// The units that are read, each with its scale. The first is the project's own.
    pub fn units(self) -> &'static [(&'static str, Scale)] {
        const TIME: &[(&str, Scale)] = &[
            ("s", Scale::Keep),
            ("sec", Scale::Keep),
            ("ms", Scale::Divide(1e3)),
            ("us", Scale::Divide(1e6)),
            ("µs", Scale::Divide(1e6)),
            ("ns", Scale::Divide(1e9)),
        ];
        const LENGTH: &[(&str, Scale)] = &[("m", Scale::Keep), ("cm", Scale::Divide(1e2)), ("mm", Scale::Divide(1e3))];
        const DEGREE: Scale = Scale::Times(std::f64::consts::PI / 180.0);
        match self {
            Self::Time | Self::BounceTime => TIME,
            Self::X | Self::Y | Self::Z => LENGTH,
            Self::U | Self::V => &[("px", Scale::Keep)],
            Self::BounceNumber => &[("number", Scale::Keep)],
            Self::Angle(_) => &[("rad", Scale::Keep), ("deg", DEGREE)],
            Self::Speed(_) => &[("rad_s", Scale::Keep), ("deg_s", DEGREE)],
            Self::Torque(_) => &[("nm", Scale::Keep), ("n_m", Scale::Keep)],
            Self::Current(_) => &[("a", Scale::Keep), ("ma", Scale::Divide(1e3))],
            Self::Own(_) => &[],
        }
    }
}

/// From the file's unit to the project's. Divisors, because 1e-3 has no exact double and 1e3 has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Scale {
    Keep,
    Divide(f64),
    Times(f64),
}

impl Scale {
    pub fn apply(self, value: f64) -> f64 {
        match self {
            Self::Keep => value,
            Self::Divide(by) => value / by,
            Self::Times(by) => value * by,
        }
    }
}

/// What a column's name says.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Meaning {
    Known(Quantity, Scale),
    /// The quantity is clear and its unit is not one that is read.
    WrongUnit(Quantity, String),
    Unknown,
}

pub(crate) fn meaning(name: &str) -> Meaning {
    let name = plain(name);
    if name == "bounce_number" {
        return Meaning::Known(Quantity::BounceNumber, Scale::Keep);
    }
    let (stem, unit) = match name.strip_prefix("bounce_time_") {
        Some(unit) => ("bounce_time", unit),
        None => match name.split_once('_') {
            Some(parts) => parts,
            None => return Meaning::Unknown,
        },
    };
    let Some(quantity) = quantity(stem) else { return Meaning::Unknown };
    match quantity.units().iter().find(|(known, _)| *known == abbreviated(unit)) {
        Some((_, scale)) => Meaning::Known(quantity, *scale),
        None => Meaning::WrongUnit(quantity, unit.to_owned()),
    }
}

/// A unit of time as we write it.
pub(crate) fn abbreviated(unit: &str) -> &str {
    match unit {
        "msec" | "msecs" | "millis" | "milliseconds" => "ms",
        "usec" | "usecs" | "micros" | "microseconds" => "us",
        "nsec" | "nsecs" | "nanos" | "nanoseconds" => "ns",
        other => other,
    }
}

fn quantity(stem: &str) -> Option<Quantity> {
    Some(match stem {
        "t" | "time" => Quantity::Time,
        "x" => Quantity::X,
        "y" => Quantity::Y,
        "z" => Quantity::Z,
        "u" => Quantity::U,
        "v" => Quantity::V,
        "bounce_time" => Quantity::BounceTime,
        _ => {
            let digits = stem.find(|c: char| c.is_ascii_digit())?;
            let joint = stem[digits..].parse().ok().filter(|joint| *joint > 0)?;
            match &stem[..digits] {
                "q" => Quantity::Angle(joint),
                "dq" => Quantity::Speed(joint),
                "tau" => Quantity::Torque(joint),
                "i" => Quantity::Current(joint),
                _ => return None,
            }
        }
    })
}

/// The quantity of a joint by its number.
pub(crate) type Family = fn(u16) -> Quantity;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_give_quantity_and_unit() {
        assert_eq!(meaning("t_s"), Meaning::Known(Quantity::Time, Scale::Keep));
        assert_eq!(meaning("Time (ms)"), Meaning::Known(Quantity::Time, Scale::Divide(1e3)));
        assert_eq!(meaning("time_µs"), Meaning::Known(Quantity::Time, Scale::Divide(1e6)));
        for name in ["time [msec]", "t_msec", "Time (ms)", "t [milliseconds]"] {
            assert_eq!(meaning(name), Meaning::Known(Quantity::Time, Scale::Divide(1e3)), "{name}");
        }
        assert_eq!(meaning("Z [cm]"), Meaning::Known(Quantity::Z, Scale::Divide(1e2)));
        assert_eq!(meaning("dq12_rad/s"), Meaning::Known(Quantity::Speed(12), Scale::Keep));
        assert_eq!(meaning("tau3_N·m"), Meaning::Known(Quantity::Torque(3), Scale::Keep));
        assert_eq!(meaning("i1_mA"), Meaning::Known(Quantity::Current(1), Scale::Divide(1e3)));
        assert_eq!(meaning("z_ft"), Meaning::WrongUnit(Quantity::Z, "ft".into()));
        for unknown in ["z", "height_m", "q0_rad", "q_rad", "qw", "", "i_des1", "q99999_rad"] {
            assert_eq!(meaning(unknown), Meaning::Unknown, "{unknown}");
        }
    }

    #[test]
    fn every_channel_is_found_again_under_its_own_header() {
        for quantity in [
            Quantity::Time,
            Quantity::X,
            Quantity::U,
            Quantity::BounceNumber,
            Quantity::BounceTime,
            Quantity::Angle(1),
            Quantity::Speed(2),
            Quantity::Torque(3),
            Quantity::Current(4),
        ] {
            assert_eq!(meaning(&quantity.header()), Meaning::Known(quantity, Scale::Keep), "{}", quantity.header());
        }
    }
}
