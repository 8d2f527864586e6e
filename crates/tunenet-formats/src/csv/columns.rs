//! How the columns of a table make an observation.

use std::collections::BTreeMap;
use std::path::Path;

use super::guess::guess;
use super::guess_joints::guess_joints;
use super::lines::{Cell, Line, Lines, cells};
use crate::findings;
use crate::quantity::{Family, Meaning, Quantity, Scale, kind_name, meaning};
use crate::ranges::written_out;
use crate::shown::list;
use crate::{Error, Origin, Result};
use tunenet_core::observation::{Channel, Kind, Note};

/// Rows that are examined to distinguish a count from a time, and the fewest that suffice.
const MOST_COUNTED: usize = 64;
const FEWEST_COUNTED: usize = 4;

/// Rows that are examined to distinguish a flag from a measurement.
const MOST_FLAGGED: usize = 10_000;

/// Where a channel comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Source {
    /// Which cell, from 0.
    pub column: usize,
    pub scale: Scale,
    pub quantity: Quantity,
    pub sign: Sign,
}

/// Whether the values of a column are taken as they are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sign {
    Kept,
    /// Its axis points the other way: `z_m=-z`.
    Negated,
}

impl Source {
    /// What a number in its cell stands for.
    pub fn value(&self, number: f64) -> f64 {
        match self.sign {
            Sign::Kept => self.scale.apply(number),
            Sign::Negated => -self.scale.apply(number),
        }
    }
}

/// How the columns of a table make an observation.
#[derive(Debug, Clone)]
pub(crate) struct Layout {
    pub kind: Kind,
    pub channels: Vec<Channel>,
    /// The clock; `None` for bounce times without a number.
    pub clock: Option<Source>,
    /// One for every channel; `None` is 0 throughout.
    pub values: Vec<Option<Source>>,
    pub notes: Vec<Note>,
}

impl Layout {
    /// The header under which a column is read.
    pub fn header(&self, source: &Source) -> String {
        match source.quantity {
            Quantity::Own(number) => self.channels[usize::from(number)].header(),
            known => known.header(),
        }
    }

    /// Adds a note on every column that is read in another unit than its own, or with the other sign.
    pub fn with_conversions(mut self, header: &Header<'_>) -> Self {
        let cells = header.cells();
        for source in self.clock.iter().chain(self.values.iter().flatten()) {
            let number = (source.column + 1).to_string();
            let theirs = if header.named { cells[source.column].text } else { &number };
            if source.scale != Scale::Keep {
                let text = format!("column `{theirs}` is converted to `{}`", self.header(source));
                self.notes.push(Note::new(findings::COLUMNS_CONVERTED, text, ""));
            }
            if source.sign == Sign::Negated {
                let text = format!("`{}` is column `{theirs}` with its sign reversed", self.header(source));
                self.notes.push(Note::new(findings::COLUMNS_NEGATED, text, ""));
            }
        }
        self
    }
}

/// The first line of a table.
#[derive(Debug)]
pub(crate) struct Header<'a> {
    pub path: &'a Path,
    pub line: &'a Line,
    pub separator: Option<char>,
    /// Whether the line holds names; otherwise it is the first sample.
    pub named: bool,
    /// The joints of the arm that the table should be about, where there is one.
    pub joints: &'a [String],
    /// The first rows, where they do not stand in a text.
    pub rows: Option<&'a [Vec<Option<f64>>]>,
}

impl Header<'_> {
    pub fn cells(&self) -> Vec<Cell<'_>> {
        cells(&self.line.text, self.separator)
    }

    /// Refuses the header, pointing at one of its columns or at all of it.
    pub fn refuse<T>(&self, column: Option<usize>, message: String, hint: impl Into<String>) -> Result<T> {
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

    /// The column that the user calls `theirs`: by its name, or by its number from 1, with a `-` before it where its axis points
    /// the other way, which no clock's does. `remedy` is what to try where it is none of these.
    pub fn column(&self, theirs: &str, quantity: Quantity, remedy: impl FnOnce() -> String) -> Result<(usize, Sign)> {
        let cells = self.cells();
        let names: Vec<&str> = cells.iter().map(|cell| if self.named { cell.text } else { "" }).collect();
        match found(theirs, &names) {
            Some((_, Sign::Negated)) if !quantity.has_sign() => self.refuse(
                None,
                format!("`{}` has no sign: expected a column without `-`, found `{theirs}`", quantity.header()),
                "leave the `-` out",
            ),
            Some((column, sign)) => self.refuse_twice(column).map(|()| (column, sign)),
            None => self.refuse(None, format!("`{theirs}` is not a column: found {}", self.found()), remedy()),
        }
    }

    /// Refuses a column that is used and has a name that another one has as well.
    ///
    /// # Errors
    /// [`Error::Text`] with the other one.
    pub fn refuse_twice(&self, column: usize) -> Result<()> {
        let cells = self.cells();
        let name = cells[column].text;
        let same = |(at, cell): &(usize, &Cell<'_>)| *at != column && cell.text == name;
        let Some((other, _)) = cells.iter().enumerate().find(same).filter(|_| self.named && !name.is_empty()) else {
            return Ok(());
        };
        let (first, second) = (column.min(other) + 1, column.max(other) + 1);
        let message = format!("expected one column `{name}`, found two: columns {first} and {second}");
        self.refuse(Some(other), message, "rename one of them, or leave it out")
    }

    /// What is there, for a person.
    pub fn found(&self) -> String {
        if self.named {
            list(self.cells().iter().map(|cell| cell.text).filter(|text| !text.is_empty()), 12)
        } else {
            format!("{} columns without names", self.cells().len())
        }
    }

    /// Whether it is a log of joints that is asked for, or that the names speak of.
    fn of_joints(&self) -> bool {
        let cells = self.cells();
        let names: Vec<&str> = cells.iter().map(|cell| cell.text).collect();
        !self.joints.is_empty()
            || self.named
                && guess(&names, &self.counting()).is_none()
                && guess_joints(&names, &[], &self.flags()).is_some()
    }

    /// The columns that count their rows from 0 or 1, by the first rows of the file; none where those are too few to decide.
    fn counting(&self) -> Vec<usize> {
        let rows = self.first_rows(MOST_COUNTED);
        if rows.len() < FEWEST_COUNTED {
            return Vec::new();
        }
        let from = |column: usize, start: f64| {
            (0u32..).zip(&rows).all(|(k, row)| row.get(column) == Some(&Some(f64::from(k) + start)))
        };
        (0..self.cells().len()).filter(|&column| from(column, 0.0) || from(column, 1.0)).collect()
    }

    /// The columns that hold nothing but 0 and 1, and some 1: whether a motor is on is no measurement of it.
    fn flags(&self) -> Vec<usize> {
        let rows = self.first_rows(MOST_FLAGGED);
        let of = |column: usize| rows.iter().map(move |row| row.get(column).copied().flatten());
        let flag = |column: &usize| {
            of(*column).all(|cell| matches!(cell, Some(0.0 | 1.0))) && of(*column).any(|cell| cell == Some(1.0))
        };
        (0..self.cells().len()).filter(flag).collect()
    }

    /// The numbers below the names, of `most` rows; none where the first line holds no names.
    fn first_rows(&self, most: usize) -> Vec<Vec<Option<f64>>> {
        let first = |mut lines: Lines| {
            // A line of names, and then what follows from them.
            let mut rows = Vec::new();
            lines.next().ok()??;
            while rows.len() < most
                && let Ok(Some(line)) = lines.next()
            {
                let numbers = cells(&line.text, self.separator);
                rows.push(numbers.iter().map(|cell| cell.text.parse::<f64>().ok()).collect::<Vec<_>>());
            }
            Some(rows)
        };
        if let Some(rows) = self.rows {
            return rows[..rows.len().min(most)].to_vec();
        }
        if !self.named {
            return Vec::new();
        }
        Lines::open(self.path).ok().and_then(first).unwrap_or_default()
    }

    /// What to type: the mapping that the names suggest, or an example of one.
    fn remedy(&self) -> String {
        let cells = self.cells();
        let names: Vec<&str> = cells.iter().map(|cell| cell.text).collect();
        if !self.named && !self.joints.is_empty() {
            let n = self.joints.len();
            return format!(
                "say which column is which, counted from 1, for example `--columns t_s=1,q1..{n}_rad=2..{},tau1..{n}_nm={}..{}`",
                n + 1,
                n + 2,
                2 * n + 1
            );
        }
        if let Some(option) =
            guess_joints(&names, self.joints, &self.flags()).filter(|_| self.named && self.of_joints())
        {
            return format!("try `{option}`; where another unit is meant, write it into our name: `q1_deg`, `t_ms`");
        }
        if !self.joints.is_empty() {
            return format!(
                "say which column is which joint's, as in `--columns t_s=time,q1..{0}_rad=pos_*,tau1..{0}_nm=effort_*`; joints are \
                 numbered as in the URDF: {1}",
                self.joints.len(),
                list(self.joints.iter().map(String::as_str), 12)
            );
        }
        if !self.named {
            let example = match names.len() {
                0 | 1 => "bounce_time_s=1",
                2 => "t_s=1,z_m=2",
                3 => "t_s=1,x_m=2,z_m=3",
                _ => "t_s=1,x_m=2,y_m=3,z_m=4",
            };
            return format!("say which column is which, counted from 1, for example `--columns {example}`");
        }
        match guess(&names, &self.counting()) {
            Some((option, false)) => format!("try `{option}`"),
            Some((option, true)) => {
                format!("try `{option}`; where another unit is meant, write it into our name: `t_ms`, `z_mm`")
            }
            None => {
                "say which column is which, as in `--columns t_s=time,z_m=height` for a file with `time` and `height`"
                    .into()
            }
        }
    }
}

/// The column among `names` that is called `theirs`: by its name, then by its number from 1, then by either with a `-` before it.
pub(crate) fn found(theirs: &str, names: &[&str]) -> Option<(usize, Sign)> {
    let column = |theirs: &str| {
        let by_name = names.iter().position(|name| !name.is_empty() && *name == theirs);
        let by_number = || theirs.parse::<usize>().ok().and_then(|n| n.checked_sub(1)).filter(|n| *n < names.len());
        by_name.or_else(by_number)
    };
    let negated = || Some((column(theirs.strip_prefix('-')?)?, Sign::Negated));
    column(theirs).map(|column| (column, Sign::Kept)).or_else(negated)
}

type Found = BTreeMap<Quantity, Source>;

/// How a table's columns make an observation. `mapping` holds pairs (ours, theirs) that stand above the header.
pub(crate) fn layout(header: &Header<'_>, mapping: &[(String, String)]) -> Result<Layout> {
    let mut notes = Vec::new();
    let mut found = mapped(header, mapping)?;
    let kinds_mapped: Vec<Kind> = kinds(&found);
    if header.named {
        named(header, &mut found, &mut notes);
    }
    let kind = match (kinds_mapped.as_slice(), kinds(&found).as_slice()) {
        ([kind], _) | ([], [kind]) => *kind,
        ([], []) if header.of_joints() => {
            let names = list(header.joints.iter().map(String::as_str), 12);
            let whose = if header.joints.is_empty() { String::new() } else { format!(" of the joints {names}") };
            let what = format!("columns `t_s`, `q1_rad`, … and `tau1_nm`, … or `i1_a`, …{whose}");
            return missing(header, &found, &what, None);
        }
        ([], []) => return missing(header, &found, "columns `t_s` and `z_m`, or `bounce_time_s`", None),
        ([], several) | (several, _) => {
            let names: Vec<&str> = several.iter().map(|kind| kind_name(*kind)).collect();
            let message = format!("expected columns of one kind, found those of {}", names.join(" and "));
            return header.refuse(None, message, header.remedy());
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
    let names: Vec<&str> = if header.named { cells.iter().map(|cell| cell.text).collect() } else { Vec::new() };
    for (ours, theirs) in &written_out(mapping, &names)? {
        let Meaning::Known(quantity, scale) = meaning(ours) else {
            return Err(tunenet_core::Error::Setting {
                origin: Origin::Flag,
                name: "columns",
                expected: "a name such as t_s, x_m, z_mm, u_px, bounce_time_s, q1_rad, dq1_rad_s, tau1_nm or i1_a before the `=`"
                    .into(),
                found: format!("`{ours}`"),
            }.into());
        };
        let (column, sign) = header.column(theirs, quantity, || header.remedy())?;
        if found.insert(quantity, Source { column, scale, quantity, sign }).is_some() {
            return Err(tunenet_core::Error::Setting {
                origin: Origin::Flag,
                name: "columns",
                expected: format!("`{}` once", quantity.header()),
                found: "it twice".into(),
            }
            .into());
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
        let source = Source { column, scale, quantity, sign: Sign::Kept };
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
        notes.push(Note::new(findings::COLUMNS_IGNORED, text, "map them with `--columns` where they matter"));
    }
    if !repeated.is_empty() {
        let text = format!("columns that repeat a quantity are ignored: {}", list(repeated, 12));
        notes.push(Note::new(findings::COLUMNS_REPEATED, text, "choose with `--columns`"));
    }
}

fn build(header: &Header<'_>, kind: Kind, found: &Found, mut notes: Vec<Note>) -> Result<Layout> {
    let need = |quantity: Quantity| match found.get(&quantity) {
        Some(source) => Ok(*source),
        None => missing(header, found, &format!("a column `{}`", quantity.header()), Some(quantity)),
    };
    let clock = match kind {
        Kind::EventTimes => found.get(&Quantity::BounceNumber).copied(),
        _ => Some(need(Quantity::Time)?),
    };
    let wanted: Vec<Quantity> = match kind {
        Kind::Positions => vec![Quantity::X, Quantity::Y, Quantity::Z],
        Kind::Pixels => vec![Quantity::U, Quantity::V],
        Kind::EventTimes => vec![Quantity::BounceTime],
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
        notes.push(Note::new(findings::COLUMNS_ABSENT, text, "name them with `--columns` where the file has them"));
    }
    let channels = wanted.iter().map(|quantity| quantity.channel()).collect();
    Ok(Layout { kind, channels, clock, values, notes }.with_conversions(header))
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
                "expected a column `{}`, since the joints go up to {joints}, found {}",
                absent.header(),
                header.found()
            );
            return header.refuse(None, message, header.remedy());
        }
    }
    Ok(())
}

/// A column is missing; where one has its name with another unit, that is what is said.
fn missing<T>(header: &Header<'_>, found: &Found, what: &str, quantity: Option<Quantity>) -> Result<T> {
    const PIXELS: [Quantity; 2] = [Quantity::U, Quantity::V];
    // A column `u_v` is a voltage unless the other columns are of a picture.
    let picture = PIXELS.iter().any(|pixel| found.contains_key(pixel));
    for (index, cell) in header.cells().iter().enumerate() {
        if let Meaning::WrongUnit(wrong, unit) = meaning(cell.text)
            && header.named
            && !found.contains_key(&wrong)
            && (picture || !PIXELS.contains(&wrong))
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
        format!("expected {what}, found {}", header.found())
    } else {
        format!("expected a header with {what}, found a line of numbers")
    };
    header.refuse(None, message, header.remedy())
}
