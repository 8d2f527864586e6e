//! The columns of a table, or the channels of a log, that a custom simulator predicts.

use std::path::Path;

use super::columns::{Header, Layout, Sign, Source};
use crate::findings;
use crate::quantity::{Meaning, Quantity, Scale, kind_name, meaning, plain};
use crate::recording::Recording;
use crate::shown::list;
use crate::{Error, Origin, Result};
use tunenet_core::observation::{Channel, Kind, Note, Observation};

/// How the columns of a table make a series on `channels`. `mapping` holds pairs (ours, theirs) that stand above the header.
pub(crate) fn layout(header: &Header<'_>, mapping: &[(String, String)], channels: &[Channel]) -> Result<Layout> {
    let mut clock = None;
    let mut values: Vec<Option<Source>> = vec![None; channels.len()];
    let cells = header.cells();
    for (ours, theirs) in mapping {
        let Some((quantity, scale)) = asked(ours, channels) else {
            let expected = format!("{} before the `=`", names(channels));
            return Err(tunenet_core::Error::Setting {
                origin: Origin::Flag,
                name: "columns",
                expected,
                found: format!("`{ours}`"),
            }
            .into());
        };
        let (column, sign) = header.column(theirs, quantity, || remedy(header, channels))?;
        if place(quantity, &mut clock, &mut values).replace(Source { column, scale, quantity, sign }).is_some() {
            let (expected, found) = (format!("`{ours}` once"), "it twice".into());
            return Err(tunenet_core::Error::Setting { origin: Origin::Flag, name: "columns", expected, found }.into());
        }
    }
    let mut notes = Vec::new();
    if header.named {
        let by_hand: Vec<usize> = clock.iter().chain(values.iter().flatten()).map(|source| source.column).collect();
        let mut ignored = Vec::new();
        for (column, cell) in cells.iter().enumerate().filter(|(i, cell)| !by_hand.contains(i) && !cell.text.is_empty())
        {
            match asked(cell.text, channels) {
                // The first column of a name counts, and one that was mapped by hand before it.
                Some((quantity, scale)) => {
                    place(quantity, &mut clock, &mut values).get_or_insert(Source {
                        column,
                        scale,
                        quantity,
                        sign: Sign::Kept,
                    });
                }
                None => ignored.push(cell.text),
            }
        }
        if !ignored.is_empty() {
            let text = format!("columns that the simulation does not name are ignored: {}", list(ignored, 12));
            notes.push(Note::new(
                findings::COLUMNS_IGNORED,
                text,
                "name them under `process.channels` where they matter",
            ));
        }
    }
    let absent = values.iter().position(Option::is_none).map(|i| channels[i].header());
    if let Some(absent) = if clock.is_none() { Some("t_s".to_owned()) } else { absent } {
        let expected = format!("expected a column `{absent}` ({} are what the simulation predicts)", names(channels));
        return header.refuse(None, format!("{expected}, found {}", header.found()), remedy(header, channels));
    }
    Ok(Layout { kind: Kind::Other, channels: channels.to_vec(), clock, values, notes }.with_conversions(header))
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

/// `t_s`, `angle_rad`.
fn names(channels: &[Channel]) -> String {
    let headers: Vec<String> = std::iter::once("t_s".to_owned()).chain(channels.iter().map(Channel::header)).collect();
    list(headers.iter().map(String::as_str), 12)
}

/// What to type: where as many columns are unknown as channels have none, they are paired in their order.
fn remedy(header: &Header<'_>, channels: &[Channel]) -> String {
    let cells = header.cells();
    let wanted: Vec<String> = std::iter::once("t_s".to_owned()).chain(channels.iter().map(Channel::header)).collect();
    let pairs: Vec<(String, String)> = if header.named {
        let known = |name: &str| header_of(name, channels);
        let missing = wanted.iter().filter(|ours| !cells.iter().any(|c| known(c.text).as_ref() == Some(*ours)));
        let strange = cells.iter().filter(|cell| !cell.text.is_empty() && known(cell.text).is_none());
        missing.cloned().zip(strange.map(|cell| cell.text.to_owned())).collect()
    } else {
        wanted.into_iter().zip((1..).map(|n: usize| n.to_string())).collect()
    };
    if pairs.is_empty() {
        return "add the column, or leave the channel out of `process.channels`".into();
    }
    let pairs: Vec<String> = pairs.into_iter().map(|(ours, theirs)| format!("{ours}={theirs}")).collect();
    let option = pairs.join(",");
    let quote = if option.contains([' ', '(', '[', '\'']) { "'" } else { "" };
    format!("say which column is which, for example `--columns {quote}{option}{quote}`")
}

/// `recording` with the channels that are asked for, and no others.
pub(crate) fn chosen(path: &Path, recording: Recording, channels: &[Channel]) -> Result<Recording> {
    let seen = &recording.observation;
    let refuse = |wanted: &str, found: &str| {
        let message = format!("expected the channels {wanted} of the simulation, found {found}");
        Err(Error::file(path, message, "choose another --topic, or convert the log into a CSV file with these columns"))
    };
    if seen.kind() == Kind::EventTimes {
        return refuse(&names(channels), kind_name(seen.kind()));
    }
    let columns: Option<Vec<usize>> =
        channels.iter().map(|wanted| seen.channels().iter().position(|channel| channel == wanted)).collect();
    let Some(columns) = columns else {
        return refuse(&names(channels), &names(seen.channels()));
    };
    let values = (0..seen.len()).flat_map(|i| columns.iter().map(move |c| seen.row(i)[*c])).collect();
    let observation = Observation::new(Kind::Other, channels.to_vec(), seen.clock().to_vec(), values)?;
    Ok(Recording { observation, notes: recording.notes })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{error_text, file};
    use crate::{ReadOptions, read, write_csv};

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

    #[test]
    fn foreign_names_go_through_the_mapping_that_is_proposed() {
        let (_folder, path) = file("a.csv", "stamp [s],theta\n0,1\n1,2\n2,3\n");
        let (message, hint) = error_text(&read(&path, &options(&["angle_rad"], &[])).unwrap_err());
        assert!(message.contains("expected a column `t_s` (`t_s`, `angle_rad` are what"), "{message}");
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
        assert!(message.contains("`angle_rad` is"), "{message}");
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
        let refused = read(&path, &options(&["angle_rad"], &[])).unwrap_err().to_string();
        assert!(refused.contains("expected the channels `t_s`, `angle_rad`"), "{refused}");
    }
}
