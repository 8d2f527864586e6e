//! What a column of a table means: its name gives the quantity and the unit.

use std::collections::BTreeMap;
use std::path::Path;

use super::lines::{Cell, Line, cells};
use super::{Note, list};
use crate::observation::{Channel, Kind};
use crate::{Error, Result};

/// A quantity that an observation can hold. Joints count from 1. The order is the order of an observation's channels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Quantity {
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
}

impl Quantity {
    /// Whose column it is; `None` for those that go with any kind.
    fn kind(self) -> Option<Kind> {
        match self {
            Self::Time => None,
            Self::X | Self::Y | Self::Z => Some(Kind::Positions),
            Self::U | Self::V => Some(Kind::Pixels),
            Self::BounceNumber | Self::BounceTime => Some(Kind::BounceTimes),
            Self::Angle(_) | Self::Speed(_) | Self::Torque(_) | Self::Current(_) => Some(Kind::Joints),
        }
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
        }
    }

    /// The header of its column.
    pub fn header(self) -> String {
        header(&self.channel())
    }

    /// The units that are read, each with its scale. The first is the project's own.
    fn units(self) -> &'static [(&'static str, Scale)] {
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
        }
    }
}

/// The header of a channel's column: `z_m`, `dq1_rad_s`.
pub(super) fn header(channel: &Channel) -> String {
    match channel.unit.as_str() {
        "1" => channel.name.clone(),
        "N·m" => format!("{}_nm", channel.name),
        unit => format!("{}_{}", channel.name, plain(unit)),
    }
}

/// Lower case, with every run of other signs as one `_`: "Time (s)" is `time_s`, "rad/s" is `rad_s`.
fn plain(name: &str) -> String {
    let name = name.to_lowercase().replace('μ', "µ");
    name.split(|c: char| !c.is_alphanumeric()).filter(|part| !part.is_empty()).collect::<Vec<_>>().join("_")
}

/// From the file's unit to the project's. Divisors, because 1e-3 has no exact double and 1e3 has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Scale {
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
pub(super) enum Meaning {
    Known(Quantity, Scale),
    /// The quantity is clear and its unit is not one that is read.
    WrongUnit(Quantity, String),
    Unknown,
}

pub(super) fn meaning(name: &str) -> Meaning {
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
    match quantity.units().iter().find(|(known, _)| *known == unit) {
        Some((_, scale)) => Meaning::Known(quantity, *scale),
        None => Meaning::WrongUnit(quantity, unit.to_owned()),
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

/// Where a channel comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Source {
    /// Which cell, from 0.
    pub column: usize,
    pub scale: Scale,
    pub quantity: Quantity,
}

/// How the columns of a table make an observation.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    pub kind: Kind,
    pub channels: Vec<Channel>,
    /// The clock; `None` for bounce times without a number.
    pub clock: Option<Source>,
    /// One for every channel; `None` is 0 throughout.
    pub values: Vec<Option<Source>>,
    pub notes: Vec<Note>,
}

/// The first line of a table.
#[derive(Debug)]
pub(super) struct Header<'a> {
    pub path: &'a Path,
    pub line: &'a Line,
    pub separator: Option<char>,
    /// Whether the line holds names; otherwise it is the first sample.
    pub named: bool,
}

impl Header<'_> {
    fn cells(&self) -> Vec<Cell<'_>> {
        cells(&self.line.text, self.separator)
    }

    /// Refuses the header, pointing at one of its columns or at all of it.
    fn refuse<T>(&self, column: Option<usize>, message: String, hint: impl Into<String>) -> Result<T> {
        let (column, width) = match column {
            Some(index) => self.cells()[index].place(&self.line.text),
            None => (1, self.line.text.chars().count().max(1)),
        };
        Err(Error::Text {
            path: self.path.into(),
            line: self.line.number,
            column,
            width,
            source_line: self.line.text.clone(),
            message,
            hint: hint.into(),
        })
    }

    /// What is there, for a person.
    fn found(&self) -> String {
        if self.named {
            list(self.cells().iter().map(|cell| cell.text).filter(|text| !text.is_empty()), 12)
        } else {
            format!("{} columns without names", self.cells().len())
        }
    }

    /// An example of `--columns` with two of the file's own columns.
    fn example(&self) -> String {
        if !self.named {
            return "say which column is which, counted from 1, for example `--columns t_s=1,z_m=2`".into();
        }
        let cells = self.cells();
        let clock = cells.iter().find(|c| plain(c.text).starts_with('t') && !plain(c.text).starts_with("tau"));
        let clock = clock.map_or("time", |c| c.text);
        let other = cells.iter().map(|c| c.text).find(|text| *text != clock && !text.is_empty()).unwrap_or("height");
        format!("say which column is which, for example `--columns t_s={clock},z_m={other}`")
    }
}

type Found = BTreeMap<Quantity, Source>;

/// The quantity of a joint by its number.
pub(super) type Family = fn(u16) -> Quantity;

/// How a table's columns make an observation. `mapping` holds pairs (ours, theirs) that stand above the header.
pub(super) fn layout(header: &Header<'_>, mapping: &[(String, String)]) -> Result<Layout> {
    let mut notes = Vec::new();
    let mut found = mapped(header, mapping)?;
    let kinds_mapped: Vec<Kind> = kinds(&found);
    if header.named {
        named(header, &mut found, &mut notes);
    }
    let kind = match (kinds_mapped.as_slice(), kinds(&found).as_slice()) {
        ([kind], _) | ([], [kind]) => *kind,
        ([], []) => return missing(header, &found, "`z_m`, `u_px` and `v_px`, `bounce_time_s`, or `q1_rad`", None),
        ([], several) | (several, _) => {
            let names: Vec<&str> = several.iter().map(|kind| kind.name()).collect();
            let message = format!("expected columns of one kind, found those of {}", names.join(" and "));
            return header.refuse(None, message, header.example());
        }
    };
    build(header, kind, &found, notes)
}

fn kinds(found: &Found) -> Vec<Kind> {
    let mut kinds: Vec<Kind> = found.keys().filter_map(|quantity| quantity.kind()).collect();
    kinds.dedup();
    kinds
}

fn mapped(header: &Header<'_>, mapping: &[(String, String)]) -> Result<Found> {
    let mut found = Found::new();
    let cells = header.cells();
    for (ours, theirs) in mapping {
        let Meaning::Known(quantity, scale) = meaning(ours) else {
            return Err(Error::Setting {
                name: "columns",
                expected: "a name such as t_s, x_m, z_mm, u_px, bounce_time_s, q1_rad, dq1_rad_s, tau1_nm or i1_a before the `=`"
                    .into(),
                found: format!("`{ours}`"),
            });
        };
        let by_name = cells.iter().position(|cell| header.named && cell.text == theirs);
        let by_number = || theirs.parse::<usize>().ok().and_then(|n| n.checked_sub(1)).filter(|n| *n < cells.len());
        let Some(column) = by_name.or_else(by_number) else {
            return header.refuse(
                None,
                format!("`{theirs}` is not a column: found {}", header.found()),
                header.example(),
            );
        };
        if found.insert(quantity, Source { column, scale, quantity }).is_some() {
            return Err(Error::Setting {
                name: "columns",
                expected: format!("`{}` once", quantity.header()),
                found: "it twice".into(),
            });
        }
    }
    Ok(found)
}

/// Adds what the header itself names, where `--columns` has not said otherwise.
fn named(header: &Header<'_>, found: &mut Found, notes: &mut Vec<Note>) {
    let cells = header.cells();
    let by_hand: Vec<usize> = found.values().map(|source| source.column).collect();
    let settled: Vec<Quantity> = found.keys().copied().collect();
    let (mut ignored, mut repeated) = (Vec::new(), Vec::new());
    for (column, cell) in cells.iter().enumerate() {
        if by_hand.contains(&column) || cell.text.is_empty() {
            continue;
        }
        let Meaning::Known(quantity, scale) = meaning(cell.text) else {
            ignored.push(cell.text);
            continue;
        };
        let source = Source { column, scale, quantity };
        match found.get(&quantity) {
            None => {
                found.insert(quantity, source);
            }
            // The same quantity in two units: the project's own unit needs no conversion.
            Some(other) if scale == Scale::Keep && other.scale != Scale::Keep && !settled.contains(&quantity) => {
                repeated.push(cells[other.column].text);
                found.insert(quantity, source);
            }
            Some(_) => repeated.push(cell.text),
        }
    }
    if !ignored.is_empty() {
        let text = format!("columns without a known name are ignored: {}", list(ignored, 12));
        notes.push(Note::new("columns.ignored", text, "map them with `--columns` where they matter"));
    }
    if !repeated.is_empty() {
        let text = format!("columns that repeat a quantity are ignored: {}", list(repeated, 12));
        notes.push(Note::new("columns.repeated", text, "choose with `--columns`"));
    }
}

fn build(header: &Header<'_>, kind: Kind, found: &Found, mut notes: Vec<Note>) -> Result<Layout> {
    let need = |quantity: Quantity| match found.get(&quantity) {
        Some(source) => Ok(*source),
        None => missing(header, found, &format!("`{}`", quantity.header()), Some(quantity)),
    };
    let clock = match kind {
        Kind::BounceTimes => found.get(&Quantity::BounceNumber).copied(),
        _ => Some(need(Quantity::Time)?),
    };
    let wanted: Vec<Quantity> = match kind {
        Kind::Positions => vec![Quantity::X, Quantity::Y, Quantity::Z],
        Kind::Pixels => vec![Quantity::U, Quantity::V],
        Kind::BounceTimes => vec![Quantity::BounceTime],
        _ => found.keys().copied().filter(|quantity| quantity.kind() == Some(Kind::Joints)).collect(),
    };
    let mut values = Vec::new();
    let mut absent = Vec::new();
    for &quantity in &wanted {
        if matches!(quantity, Quantity::X | Quantity::Y) && !found.contains_key(&quantity) {
            absent.push(quantity.header());
            values.push(None);
        } else {
            values.push(Some(need(quantity)?));
        }
    }
    if kind == Kind::Joints {
        joints_agree(header, &wanted)?;
    }
    if !absent.is_empty() {
        let text = format!("no column {}: taken as 0", list(absent.iter().map(String::as_str), 2));
        notes.push(Note::new("columns.absent", text, "name them with `--columns` where the file has them"));
    }
    let cells = header.cells();
    for source in clock.iter().chain(values.iter().flatten()).filter(|source| source.scale != Scale::Keep) {
        let theirs = if header.named { cells[source.column].text.to_owned() } else { format!("{}", source.column + 1) };
        let text = format!("column `{theirs}` is converted to `{}`", source.quantity.header());
        notes.push(Note::new("columns.converted", text, ""));
    }
    let channels = wanted.iter().map(|quantity| quantity.channel()).collect();
    Ok(Layout { kind, channels, clock, values, notes })
}

/// Every quantity must cover the same joints, from 1 on without a gap.
fn joints_agree(header: &Header<'_>, wanted: &[Quantity]) -> Result<()> {
    let joint = |quantity: &Quantity| match quantity {
        Quantity::Angle(j) | Quantity::Speed(j) | Quantity::Torque(j) | Quantity::Current(j) => *j,
        _ => 0,
    };
    let joints = wanted.iter().map(joint).max().unwrap_or(0);
    let families: [Family; 4] = [Quantity::Angle, Quantity::Speed, Quantity::Torque, Quantity::Current];
    for family in families {
        let present = (1..=joints).filter(|j| wanted.contains(&family(*j))).count();
        if present == 0 {
            continue;
        }
        if let Some(absent) = (1..=joints).map(family).find(|quantity| !wanted.contains(quantity)) {
            let message = format!(
                "column `{}` is missing: the joints go up to {joints}, found {}",
                absent.header(),
                header.found()
            );
            return header.refuse(None, message, header.example());
        }
    }
    Ok(())
}

/// A column is missing; where one has its name with another unit, that is what is said.
fn missing<T>(header: &Header<'_>, found: &Found, what: &str, quantity: Option<Quantity>) -> Result<T> {
    for (index, cell) in header.cells().iter().enumerate() {
        if let Meaning::WrongUnit(wrong, unit) = meaning(cell.text)
            && header.named
            && !found.contains_key(&wrong)
            && quantity.is_none_or(|quantity| quantity == wrong)
        {
            let units = list(wrong.units().iter().map(|(unit, _)| *unit), 6);
            let message = format!("the unit of `{}` is not known: expected {units}, found `{unit}`", cell.text);
            let hint =
                format!("convert the numbers and name the column `{}`, or map it with `--columns`", wrong.header());
            return header.refuse(Some(index), message, hint);
        }
    }
    let message = if header.named {
        format!("column {what} is missing: found {}", header.found())
    } else {
        format!("expected a header with {what}, found a line of numbers")
    };
    header.refuse(None, message, header.example())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_give_quantity_and_unit() {
        assert_eq!(meaning("t_s"), Meaning::Known(Quantity::Time, Scale::Keep));
        assert_eq!(meaning("Time (ms)"), Meaning::Known(Quantity::Time, Scale::Divide(1e3)));
        assert_eq!(meaning("time_µs"), Meaning::Known(Quantity::Time, Scale::Divide(1e6)));
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
