//! The columns of a table, or the channels of a log, that a custom simulator predicts.

use std::path::Path;

use super::columns::{Header, Layout, Sign, Source};
use crate::findings;
use crate::quantity::{Meaning, Quantity, Scale, kind_name, meaning, plain};
use crate::recording::{ReadOptions, Recording, Role};
use crate::shown::list;
use crate::{Error, Origin, Result};
use tunenet_core::observation::{Channel, Kind, Note, Observation};

/// How the columns of a table make a series on the channels of `options`, whose mapping stands above the header.
pub(crate) fn layout(header: &Header<'_>, options: &ReadOptions) -> Result<Layout> {
    let ReadOptions { columns: mapping, channels, role, others, .. } = options;
    let of_input = |name: &str| *role != Role::Driving && is_other(name, others);
    let mut clock = None;
    let mut values: Vec<Option<Source>> = vec![None; channels.len()];
    let cells = header.cells();
    for (ours, theirs) in mapping {
        let Some((quantity, scale)) = asked(ours, channels) else {
            if of_input(ours) {
                continue;
            }
            let mut all = channels.clone();
            all.extend(others.iter().filter(|_| *role != Role::Driving).cloned());
            let expected = format!("{} before the `=`", names(&all));
            return Err(tunenet_core::Error::Setting {
                origin: Origin::Flag,
                name: "columns",
                expected,
                found: format!("`{ours}`"),
            }
            .into());
        };
        let (column, sign) = header.column(theirs, quantity, || remedy(header, options))?;
        if place(quantity, &mut clock, &mut values).replace(Source { column, scale, quantity, sign }).is_some() {
            let (expected, found) = (format!("`{ours}` once"), "it twice".into());
            return Err(tunenet_core::Error::Setting { origin: Origin::Flag, name: "columns", expected, found }.into());
        }
    }
    let mut notes = Vec::new();
    let mapped_inputs: Vec<&str> =
        mapping.iter().filter(|(ours, _)| of_input(ours)).map(|(_, theirs)| theirs.trim_start_matches('-')).collect();
    let is_mapped = |column: usize, name: &str| {
        mapped_inputs.iter().any(|theirs| *theirs == name || theirs.parse() == Ok(column + 1))
    };
    if header.named {
        let by_hand: Vec<usize> = clock.iter().chain(values.iter().flatten()).map(|source| source.column).collect();
        let (mut ignored, mut repeated) = (Vec::new(), Vec::new());
        for (column, cell) in cells.iter().enumerate().filter(|(i, cell)| !by_hand.contains(i) && !cell.text.is_empty())
        {
            match asked(cell.text, channels) {
                // The first column counts, and one that was mapped by hand before it.
                Some((quantity, scale)) => {
                    let place = place(quantity, &mut clock, &mut values);
                    match place {
                        Some(other) if by_hand.contains(&other.column) => {}
                        Some(_) => repeated.push(cell.text),
                        None => {
                            header.refuse_twice(column)?;
                            *place = Some(Source { column, scale, quantity, sign: Sign::Kept });
                        }
                    }
                }
                None if of_input(cell.text) || is_mapped(column, cell.text) => {}
                None => ignored.push(cell.text),
            }
        }
        if !repeated.is_empty() {
            let text = format!("columns that repeat a quantity are ignored: {}", list(repeated, 12));
            notes.push(Note::new(findings::COLUMNS_REPEATED, text, "choose with `--columns`"));
        }
        // Reading what is predicted says so already.
        if !ignored.is_empty() && *role == Role::Predicted {
            let text = format!("columns that the simulation does not name are ignored: {}", list(ignored, 12));
            let remedy = if others.is_empty() {
                "name them in the simulation file where they matter"
            } else {
                "name them in the simulation file where they matter: what is predicted among its channels, and what drives it with `column` in the table of an input"
            };
            notes.push(Note::new(findings::COLUMNS_IGNORED, text, remedy));
        }
    }
    let absent = values.iter().position(Option::is_none).map(|i| channels[i].header());
    if let Some(absent) = if clock.is_none() { Some("t_s".to_owned()) } else { absent } {
        if let Some((column, message)) = in_another_unit(header, &absent, channels) {
            let unit = channels.iter().find(|channel| channel.header() == absent).map_or("1", |channel| &channel.unit);
            let hint = format!(
                "convert its numbers to {unit}; if they are in {unit} already, `--columns {absent}={}`",
                cells[column].text
            );
            return header.refuse(Some(column), message, hint);
        }
        let what = match role {
            Role::Predicted => format!("{} are the time and what the simulation predicts", names(channels)),
            Role::Driving if clock.is_none() => {
                let inputs: Vec<String> = channels.iter().map(Channel::header).collect();
                format!("the times of the input {}", list(inputs.iter().map(String::as_str), 12))
            }
            Role::Driving => "an input of the simulation".to_owned(),
            Role::Starting => "where the simulation starts".to_owned(),
        };
        let expected = format!("expected a column `{absent}` ({what})");
        return header.refuse(None, format!("{expected}, found {}", header.found()), remedy(header, options));
    }
    Ok(Layout { kind: Kind::Other, channels: channels.clone(), clock, values, notes }.with_conversions(header))
}

/// Whether a name means one of the channels in the other role.
fn is_other(name: &str, others: &[Channel]) -> bool {
    others.iter().any(|other| other.name == name) || matches!(asked(name, others), Some((Quantity::Own(_), _)))
}

/// The column that has the name of the missing channel in a unit that is not converted, and what is wrong with it.
fn in_another_unit(header: &Header<'_>, absent: &str, channels: &[Channel]) -> Option<(usize, String)> {
    let channel = channels.iter().find(|channel| channel.header() == absent).filter(|_| header.named)?;
    let unit = |name: &str| other_unit(name, channel);
    let (column, unit) = header.cells().iter().enumerate().find_map(|(i, cell)| Some((i, unit(cell.text)?)))?;
    let unit = Channel::from_header(&format!("x_{unit}")).map_or(unit, |other| other.unit);
    Some((column, format!("expected `{absent}` in {}, found the column in {unit}", channel.unit)))
}

/// The unit at the end of a name that is otherwise that of the channel.
fn other_unit(name: &str, channel: &Channel) -> Option<String> {
    let name = plain(name);
    let unit = name.strip_prefix(channel.name.as_str())?.strip_prefix('_')?;
    (!unit.contains('_') && unit.len() <= 4).then(|| unit.to_owned())
}

/// Whether a column of this name is the channel, in its unit or in another.
pub(crate) fn is_meant(name: &str, channel: &Channel) -> bool {
    scale_of(name, channel).is_some() || other_unit(name, channel).is_some()
}

/// How the numbers of a column that `--columns` maps to `ours` become those of the channel: the name has its unit, or another.
/// `None` where it does not name the channel.
pub(crate) fn scale_of(ours: &str, channel: &Channel) -> Option<Scale> {
    match asked(ours, std::slice::from_ref(channel))? {
        (Quantity::Own(_), scale) => Some(scale),
        _ => None,
    }
}

/// Where a quantity's source is kept.
fn place<'a>(
    quantity: Quantity,
    clock: &'a mut Option<Source>,
    values: &'a mut [Option<Source>],
) -> &'a mut Option<Source> {
    match quantity {
        Quantity::Own(number) => &mut values[usize::from(number)],
        _ => clock,
    }
}

/// What a column of this name is: the clock, or a channel, in a unit that is read as its own.
fn asked(name: &str, channels: &[Channel]) -> Option<(Quantity, Scale)> {
    if let Meaning::Known(Quantity::Time, scale) = meaning(name) {
        return Some((Quantity::Time, scale));
    }
    let name = plain(name);
    for (number, channel) in (0..).zip(channels) {
        let own = Quantity::Own(number);
        if name == channel.header() || channel.unit == "1" && name == format!("{}_1", channel.name) {
            return Some((own, Scale::Keep));
        }
        let unit = name.strip_prefix(channel.name.as_str()).and_then(|rest| rest.strip_prefix('_'));
        let scale = unit.and_then(|unit| conversions(&channel.unit).iter().find(|(known, _)| *known == unit));
        if let Some((_, scale)) = scale {
            return Some((own, *scale));
        }
    }
    None
}

/// The units that are read as `unit`, as everywhere else.
fn conversions(unit: &str) -> &'static [(&'static str, Scale)] {
    match unit {
        "m" => Quantity::X.units(),
        "s" => Quantity::Time.units(),
        "rad" => Quantity::Angle(1).units(),
        "rad/s" => Quantity::Speed(1).units(),
        "N·m" => Quantity::Torque(1).units(),
        "A" => Quantity::Current(1).units(),
        _ => &[],
    }
}

/// The header under which a column of this name is read, `None` where none of `channels` is meant.
pub(crate) fn header_of(name: &str, channels: &[Channel]) -> Option<String> {
    match asked(name, channels)? {
        (Quantity::Own(number), _) => Some(channels[usize::from(number)].header()),
        (known, _) => Some(known.header()),
    }
}

/// The input that a column of this name is, under the name that a simulation file has for it.
pub(crate) fn input_of(name: &str, inputs: &[Channel]) -> Option<String> {
    let plain = inputs.iter().find(|input| input.name == name).map(|input| input.name.clone());
    plain.or_else(|| is_other(name, inputs).then(|| header_of(name, inputs)).flatten())
}

/// `t_s`, `angle_rad`.
fn names(channels: &[Channel]) -> String {
    let mut headers = vec!["t_s".to_owned()];
    for header in channels.iter().map(Channel::header) {
        if !headers.contains(&header) {
            headers.push(header);
        }
    }
    list(headers.iter().map(String::as_str), 12)
}

/// What to type: where as many columns are unknown as channels have none, they are paired in their order.
fn remedy(header: &Header<'_>, options: &ReadOptions) -> String {
    let ReadOptions { channels, others, role, .. } = options;
    let cells = header.cells();
    // Where inputs stand under other names too, a name without unit may be one of them.
    let inputs_lack = !others.is_empty() && header.named && !cells.iter().any(|cell| is_other(cell.text, others));
    let mut open: Vec<String> = Vec::new();
    let wanted: Vec<String> = std::iter::once("t_s".to_owned()).chain(channels.iter().map(Channel::header)).collect();
    let pairs: Vec<(String, String)> = if header.named {
        let known = |name: &str| header_of(name, channels);
        let mapped = |ours: &String| {
            options.columns.iter().any(|(of_ours, _)| of_ours == ours || known(of_ours).as_ref() == Some(ours))
        };
        let missing = wanted.iter().filter(|ours| !cells.iter().any(|c| known(c.text).as_ref() == Some(*ours)));
        let missing: Vec<&String> = missing.filter(|ours| !mapped(ours)).collect();
        // What has the other role is no proposal.
        let mut strange: Vec<&str> = cells.iter().map(|cell| cell.text).filter(|text| !text.is_empty()).collect();
        let taken = |text: &str| options.columns.iter().any(|(_, theirs)| theirs.trim_start_matches('-') == text);
        strange.retain(|text| known(text).is_none() && !is_other(text, others) && !taken(text));
        let mut pairs = Vec::new();
        for &ours in &missing {
            let fits =
                |theirs: &&str| !contradicts(ours, theirs) && (!inputs_lack || ours == "t_s" || has_unit(theirs));
            let Some(place) = strange.iter().position(fits) else { continue };
            pairs.push((ours.clone(), strange.remove(place).to_owned()));
        }
        if inputs_lack && missing.len() > pairs.len() {
            open.extend(missing.into_iter().filter(|ours| pairs.iter().all(|(paired, _)| paired != *ours)).cloned());
        }
        pairs
    } else {
        wanted.into_iter().zip((1..).map(|n: usize| n.to_string())).collect()
    };
    let other_units = other_units(&pairs, &open, channels);
    let pairs: Vec<(String, String)> =
        pairs.into_iter().map(|(ours, theirs)| (in_unit_of(&theirs, ours, channels), theirs)).collect();
    if !open.is_empty() {
        let pairs = pairs.iter().map(|(ours, theirs)| format!("{ours}={theirs}"));
        let open = open.iter().map(|ours| format!("{ours}=NAME"));
        let pairs = pairs.chain(open).collect::<Vec<_>>().join(",");
        return format!("say which column is which: `--columns {pairs}`{other_units}");
    }
    if pairs.is_empty() {
        return match role {
            Role::Predicted => "add the column, or leave the channel out of the simulation file".into(),
            Role::Driving => "add the column, or say which it is, with `column` in the input's table".into(),
            Role::Starting => {
                let name = channels.first().map_or_else(|| "NAME".to_owned(), Channel::header);
                format!("add the column, or start at a number: `--set start.{name}=0.1`")
            }
        };
    }
    let is_clock = |ours: &str| matches!(meaning(ours), Meaning::Known(Quantity::Time, _));
    let clock = pairs.iter().find(|(ours, _)| *role == Role::Driving && header.named && is_clock(ours));
    let own_clock = clock.map_or_else(String::new, |(_, theirs)| {
        format!("of an input in a file of its own, write `time_column = {theirs:?}` into its table; otherwise ")
    });
    let pairs: Vec<String> = pairs.iter().map(|(ours, theirs)| format!("{ours}={theirs}")).collect();
    let option = pairs.join(",");
    let quote = if option.contains([' ', '(', '[', '\'']) { "'" } else { "" };
    format!("{own_clock}say which column is which, for example `--columns {quote}{option}{quote}`{other_units}")
}

/// The units in which a column of this header may stand, each with how it is read; the header is the clock's or a channel's.
fn units_of(header: &str, channels: &[Channel]) -> &'static [(&'static str, Scale)] {
    match channels.iter().find(|channel| channel.header() == header) {
        Some(channel) => conversions(&channel.unit),
        None => Quantity::Time.units(),
    }
}

/// The header `ours` without its unit.
fn stem<'a>(ours: &'a str, channels: &'a [Channel]) -> &'a str {
    channels.iter().find(|channel| channel.header() == ours).map_or("t", |channel| &channel.name)
}

/// `ours` in the unit that the name of the column ends in, where that is read: `angle_rad` is `angle_deg` for `theta_deg`.
pub(crate) fn in_unit_of(theirs: &str, ours: String, channels: &[Channel]) -> String {
    let theirs = plain(theirs);
    let ending = |unit: &&str| theirs.ends_with(&format!("_{unit}"));
    let units = units_of(&ours, channels).iter().filter(|(_, scale)| *scale != Scale::Keep);
    let unit = units.map(|(unit, _)| *unit).filter(ending).max_by_key(|unit| unit.len());
    unit.map(|unit| format!("{}_{unit}", stem(&ours, channels))).unwrap_or(ours)
}

/// That a name may have another unit: of what is `open`, and of `pairs` whose column names none.
fn other_units(pairs: &[(String, String)], open: &[String], channels: &[Channel]) -> String {
    let unstated = pairs.iter().filter(|(_, theirs)| !has_unit(&plain(theirs))).map(|(ours, _)| ours);
    let other = |ours: &String| {
        let unit = units_of(ours, channels).iter().find(|(_, scale)| *scale != Scale::Keep)?.0;
        Some(format!("`{}_{unit}`", stem(ours, channels)))
    };
    match unstated.chain(open).filter_map(other).take(2).collect::<Vec<_>>() {
        names if names.is_empty() => String::new(),
        names => format!("; where another unit is meant, write it into our name: {}", names.join(", ")),
    }
}

/// Whether a name ends in a unit.
fn has_unit(theirs: &str) -> bool {
    Channel::from_header(theirs).is_some()
}

/// What stands in names of commands, and of what else than positions a message of joints holds.
const NO_POSITIONS: [&str; 4] = ["velocity.", "effort.", "action.", "command."];

/// Whether both names end in units of different quantities, or the other one is no position: the one is no proposal for the other.
fn contradicts(ours: &str, theirs: &str) -> bool {
    let position = Channel::from_header(ours).is_some_and(|own| ["rad", "m"].contains(&own.unit.as_str()));
    let goal = |name: &str| name.contains("goal");
    if position && (NO_POSITIONS.iter().any(|head| theirs.starts_with(head)) || goal(theirs) && !goal(ours)) {
        return true;
    }
    let (Some(own), Some(other)) = (Channel::from_header(ours), Channel::from_header(theirs)) else { return false };
    let converted = conversions(&own.unit).iter().any(|(known, _)| theirs.ends_with(&format!("_{known}")));
    own.unit != other.unit && !converted
}

/// Which channel of `seen` is the one that is `wanted`, by its name and unit or by the name that `options` have for it, and how its
/// numbers are read.
pub(crate) fn column_of(seen: &Observation, wanted: &Channel, options: &ReadOptions) -> Option<(usize, Scale)> {
    let theirs = options.columns.iter().find_map(|(ours, theirs)| Some((theirs, scale_of(ours, wanted)?)));
    let is = |channel: &Channel| match theirs {
        Some((theirs, _)) => channel.name == *theirs || channel.header() == *theirs,
        None => channel == wanted,
    };
    Some((seen.channels().iter().position(is)?, theirs.map_or(Scale::Keep, |(_, scale)| scale)))
}

/// `recording` with the channels that are asked for, and no others.
pub(crate) fn chosen(path: &Path, recording: Recording, options: &ReadOptions) -> Result<Recording> {
    let (seen, channels) = (&recording.observation, &options.channels);
    let (what, hint) = match options.role {
        Role::Driving => ("input", "say which topic and channel it is, with `topic` and `column` in the input's table"),
        Role::Predicted | Role::Starting => {
            ("channels", "choose another --topic, or convert the log into a CSV file with these columns")
        }
    };
    let refuse = |wanted: &str, found: &str| {
        let message = format!("expected the {what} {wanted} of the simulation, found {found}");
        Err(Error::file(path, message, hint))
    };
    if seen.kind() == Kind::EventTimes {
        return refuse(&names(channels), kind_name(seen.kind()));
    }
    let columns: Option<Vec<(usize, Scale)>> = channels.iter().map(|wanted| column_of(seen, wanted, options)).collect();
    let Some(columns) = columns else {
        return refuse(&names(channels), &names(seen.channels()));
    };
    let values = (0..seen.len()).flat_map(|i| columns.iter().map(move |(c, scale)| scale.apply(seen.row(i)[*c])));
    let values = values.collect();
    let observation = Observation::new(Kind::Other, channels.clone(), seen.clock().to_vec(), values)?;
    // What the messages do not carry was not asked for.
    let mut notes: Vec<Note> =
        recording.notes.into_iter().filter(|note| note.kind != findings::JOINTS_ABSENT).collect();
    for (wanted, (column, _)) in channels.iter().zip(&columns).filter(|(_, (_, scale))| *scale != Scale::Keep) {
        let text = format!("column `{}` is converted to `{}`", seen.channels()[*column].header(), wanted.header());
        notes.push(Note::new(findings::COLUMNS_CONVERTED, text, ""));
    }
    Ok(Recording { observation, notes })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{error_text, file};
    use crate::{read, write_csv};

    fn options(channels: &[&str], columns: &[(&str, &str)]) -> ReadOptions {
        ReadOptions {
            channels: channels.iter().map(|header| Channel::from_header(header).unwrap()).collect(),
            columns: columns.iter().map(|(a, b)| ((*a).to_owned(), (*b).to_owned())).collect(),
            ..ReadOptions::default()
        }
    }

    #[test]
    fn columns_are_found_by_the_names_of_the_simulation() {
        let (_folder, path) = file("a.csv", "t_ms,angle_deg,other,slip_1\n0,180,7,1\n500,0,7,2\n1000,90,7,3\n");
        let found = read(&path, &options(&["slip_1", "angle_rad"], &[])).unwrap();
        let seen = found.observation;
        assert_eq!((seen.kind(), seen.clock()), (Kind::Other, &[0.0, 0.5, 1.0][..]));
        assert_eq!(seen.row(0), [1.0, std::f64::consts::PI]);
        let kinds: Vec<_> = found.notes.iter().map(|note| note.kind).collect();
        assert_eq!(kinds, [findings::COLUMNS_IGNORED, findings::COLUMNS_CONVERTED, findings::COLUMNS_CONVERTED]);
    }

    /// A column that an input is mapped to is used, however it is named.
    #[test]
    fn a_column_that_is_mapped_to_an_input_is_not_ignored() {
        let (_folder, path) = file("a.csv", "t_s,angle_rad,u,rest\n0,1,5,0\n1,2,5,0\n2,3,5,0\n");
        let of = |mapped: &str| {
            let asked = options(&["angle_rad"], &[("volt_v", mapped)]);
            let asked = ReadOptions { others: vec![Channel::from_header("volt_v").unwrap()], ..asked };
            let notes = read(&path, &asked).unwrap().notes;
            notes.into_iter().find(|note| note.kind == findings::COLUMNS_IGNORED).unwrap().text
        };
        assert!(
            of("u").ends_with("ignored: `rest`") && of("3").ends_with("ignored: `rest`"),
            "{} {}",
            of("u"),
            of("3")
        );
        assert!(of("rest").ends_with("ignored: `u`"));
    }

    /// What bears a unit of another quantity is proposed for nothing; a unit that is converted is.
    #[test]
    fn a_unit_of_another_quantity_is_no_proposal() {
        let hint = |text: &str, wanted: &str| {
            let (_folder, path) = file("a.csv", text);
            error_text(&read(&path, &options(&[wanted], &[])).unwrap_err()).1
        };
        let without = hint("t_s,volt_v\n0,1\n1,2\n2,3\n", "angle_rad");
        assert!(!without.contains("volt_v"), "{without}");
        let second = hint("t_s,volt_v,theta_deg\n0,1,1\n1,2,1\n2,3,1\n", "angle_rad");
        // In the unit of its name: as `angle_rad`, degrees would be read as radians.
        assert!(second.ends_with("`--columns angle_deg=theta_deg`"), "{second}");
        let unstated = hint("time,theta\n0,1\n1,2\n2,3\n", "angle_rad");
        let said = "`--columns t_s=time,angle_rad=theta`; where another unit is meant, write it into our name: `t_ms`, `angle_deg`";
        assert!(unstated.ends_with(said), "{unstated}");
        let milli = hint("t_s,volt_mv\n0,1\n1,2\n2,3\n", "volt_v");
        assert!(
            milli.contains("convert its numbers to V; if they are in V already, `--columns volt_v=volt_mv`"),
            "{milli}"
        );
    }

    /// An input's own file has a clock of its own.
    #[test]
    fn the_clock_of_an_input_is_named_in_its_table() {
        let (_folder, path) = file("a.csv", "stamp,cmd\n0,1\n1,2\n2,3\n");
        let asked = ReadOptions { role: Role::Driving, ..options(&["volt_v"], &[("volt_v", "cmd")]) };
        let (_, hint) = error_text(&read(&path, &asked).unwrap_err());
        assert!(hint.contains("`time_column = \"stamp\"`"), "{hint}");
    }

    #[test]
    fn foreign_names_go_through_the_mapping_that_is_proposed() {
        let (_folder, path) = file("a.csv", "stamp [s],theta\n0,1\n1,2\n2,3\n");
        let (message, hint) = error_text(&read(&path, &options(&["angle_rad"], &[])).unwrap_err());
        assert!(message.contains("expected a column `t_s` (`t_s`, `angle_rad` are the time and"), "{message}");
        assert!(hint.contains("`--columns 't_s=stamp [s],angle_rad=theta'`"), "{hint}");
        let mapped = options(&["angle_rad"], &[("t_s", "stamp [s]"), ("angle_rad", "theta")]);
        assert_eq!(read(&path, &mapped).unwrap().observation.values(), [1.0, 2.0, 3.0]);
        let wrong = options(&["angle_rad"], &[("z_m", "theta")]);
        assert!(read(&path, &wrong).unwrap_err().to_string().contains("`t_s`, `angle_rad` before the `=`"));
    }

    #[test]
    fn a_broken_cell_is_reported_under_the_channels_name() {
        let (_folder, path) = file("a.csv", "t_s,angle_rad\n0,1\n1,x\n2,3\n");
        let (message, _) = error_text(&read(&path, &options(&["angle_rad"], &[])).unwrap_err());
        assert!(message.contains("`angle_rad`: expected a number"), "{message}");
    }

    #[test]
    fn what_is_written_is_read_again_bit_for_bit() {
        let channels = ["z_m", "slip_1", "rate_rad_s2"].map(|header| Channel::from_header(header).unwrap()).to_vec();
        let values: Vec<f64> = (0..9).map(|i| (f64::from(i) + 0.1).sqrt()).collect();
        let seen = Observation::new(Kind::Other, channels.clone(), vec![0.0, 0.1, 0.3], values).unwrap();
        let (_folder, path) = file("a.csv", "");
        write_csv(&seen, &path).unwrap();
        let read = read(&path, &ReadOptions { channels, ..ReadOptions::default() }).unwrap();
        assert_eq!(read.observation, seen);
    }

    #[test]
    fn a_log_gives_the_channels_that_are_asked_for() {
        let seen = Observation::positions(vec![0.0, 0.5, 1.0], &[[1.0, 2.0, 3.0]; 3]).unwrap();
        let (_folder, path) = file("a.mcap", "");
        crate::write_mcap(&seen, &path).unwrap();
        assert_eq!(read(&path, &options(&["z_m"], &[])).unwrap().observation.values(), [3.0; 3]);
        let in_mm = read(&path, &options(&["height_m"], &[("height_mm", "z")])).unwrap();
        assert_eq!(in_mm.observation.values(), [3.0 / 1e3; 3]);
        assert_eq!(in_mm.notes[0].kind, findings::COLUMNS_CONVERTED);
        let refused = read(&path, &options(&["angle_rad"], &[])).unwrap_err().to_string();
        assert!(refused.contains("expected the channels `t_s`, `angle_rad`"), "{refused}");
    }
}
