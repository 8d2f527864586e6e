//! Text tables.

use crate::findings;
use crate::testing::{error_text, read_as};
use crate::{ReadOptions, Recording, UnitRule};
use tunenet_core::finding::FindingKind;
use tunenet_core::observation::Kind;

fn good(text: impl AsRef<[u8]>) -> Recording {
    read_as("a.csv", text, &ReadOptions::default()).unwrap()
}

fn bad(text: impl AsRef<[u8]>) -> (String, String) {
    error_text(&read_as("a.csv", text, &ReadOptions::default()).unwrap_err())
}

fn mapped(text: &str, columns: &[(&str, &str)]) -> crate::Result<Recording> {
    let columns = columns.iter().map(|(ours, theirs)| ((*ours).to_owned(), (*theirs).to_owned())).collect();
    read_as("a.csv", text, &ReadOptions { columns, topic: None, ..ReadOptions::default() })
}

fn kinds(recording: &Recording) -> Vec<FindingKind> {
    recording.notes.iter().map(|note| note.kind).collect()
}

#[test]
fn every_kind_is_found_from_its_columns() {
    let ball = good("t_s,x_m,y_m,z_m\n0,1,2,3\n0.1,1,2,3.5\n0.2,1,2,4\n");
    assert_eq!((ball.observation.kind(), ball.observation.row(1)), (Kind::Positions, &[1.0, 2.0, 3.5][..]));
    assert_eq!(ball.notes, []);
    assert_eq!(good("t_s,u_px,v_px\n0,1,2\n1,1,2\n2,1,2").observation.kind(), Kind::Pixels);
    let bounces = good("bounce_time_s\n0.4\n1.3\n2.1\n").observation;
    assert_eq!(
        (bounces.kind(), bounces.clock(), bounces.values()),
        (Kind::EventTimes, &[0.0, 1.0, 2.0][..], &[0.4, 1.3, 2.1][..])
    );
    let joints = good("t_s,tau1_nm,q1_rad,i1_a\n0,1,2,3\n1,1,2,3\n2,1,2,3").observation;
    let names: Vec<&str> = joints.channels().iter().map(|c| c.name.as_str()).collect();
    assert_eq!((joints.kind(), names, joints.row(0)), (Kind::Joints, vec!["q1", "tau1", "i1"], &[2.0, 1.0, 3.0][..]));
}

#[test]
fn a_height_alone_is_a_fall_straight_down() {
    let found = good("t_s,z_m\n0,3\n0.1,2\n0.2,1\n");
    assert_eq!(found.observation.row(0), [0.0, 0.0, 3.0]);
    assert_eq!(found.notes[0].text, "no column `x_m`, `y_m`: taken as 0");
}

#[test]
fn foreign_writing_is_read() {
    let expected = good("t_s,z_m\n0,3\n0.5,2\n1,1\n").observation;
    for text in [
        "\u{feff}t_s,z_m\r\n0,3\r\n0.5,2\r\n1,1\r\n",
        "t_s;z_m\n0;3\n0,5;2\n1;1\n",
        "t_s\tz_m\n0\t3\n0,5\t2,0\n1\t1\n",
        "t_s;z_m\r\n0;3\r\n0,5;2,0\r\n1;1\r\n",
        "# a comment\n\n\"t_s\", \"z_m\"\n0, \"3\"\n0.5,2\n\n1,1",
        "Time (s),Z [m]\n0,3\n0.5,2\n1,1\n",
        "t_ms,z_cm\n0,300\n500,200\n1000,100\n",
        "t_s,z_m,,\n0,3,,\n0.5,2,,\n1,1,,\n",
    ] {
        assert_eq!(good(text).observation, expected, "{text}");
    }
    assert_eq!(good(b"t_\xb5s,z_m,H\xf6he\n0,3,9\n500000,2,9\n1000000,1,9\n").observation, expected);
    let converted = good("t_ms,z_cm\n0,300\n500,200\n1000,100\n");
    assert_eq!(converted.notes[1].text, "column `t_ms` is converted to `t_s`");
    assert_eq!(good("bounce_time_s\n0,4\n1,3\n2,1\n").observation.values(), [0.4, 1.3, 2.1]);
    let degrees = good("t_s,q1_deg\n0,180\n1,90\n2,0").observation;
    assert_eq!(degrees.row(0), [std::f64::consts::PI]);
}

#[test]
fn foreign_columns_are_mapped() {
    let expected = good("t_s,z_m\n0,3\n0.5,2\n1,1\n").observation;
    let named = "time,height,other\n0,3,9\n0.5,2,9\n1,1,9\n";
    assert_eq!(mapped(named, &[("t_s", "time"), ("z_m", "height")]).unwrap().observation, expected);
    assert_eq!(mapped(named, &[("t_s", "1"), ("z_m", "2")]).unwrap().observation, expected);
    let numbers = "0,3000\n0.5,2000\n1,1000\n";
    assert_eq!(mapped(numbers, &[("t_s", "1"), ("z_mm", "2")]).unwrap().observation, expected);
}

#[test]
fn a_mapping_that_fits_nothing_is_refused() {
    let text = "time,height\n0,3\n0.5,2\n1,1\n";
    let (message, hint) = error_text(&mapped(text, &[("t_s", "clock"), ("z_m", "height")]).unwrap_err());
    assert_eq!(message, "a.csv:1:1: `clock` is not a column: found `time`, `height`");
    assert!(hint.starts_with("try `--columns t_s=time,z_m=height`"), "{hint}");
    let (message, _) = error_text(&mapped(text, &[("height", "height")]).unwrap_err());
    assert!(message.starts_with("`columns`: expected a name such as t_s, x_m"), "{message}");
    assert!(message.ends_with("found `height`"), "{message}");
    let (message, _) = error_text(&mapped(text, &[("t_s", "time"), ("t_ms", "time")]).unwrap_err());
    assert_eq!(message, "`columns`: expected `t_s` once, found it twice");
}

#[test]
fn what_is_ignored_is_noted() {
    let found = good("t_s,t_ms,z_m,qw,z_m\n0,0,3,1,3\n0.5,500,2,1,2\n1,1000,1,1,1\n");
    assert_eq!(kinds(&found), [findings::COLUMNS_IGNORED, findings::COLUMNS_REPEATED, findings::COLUMNS_ABSENT]);
    assert_eq!(found.notes[0].text, "columns without a known name are ignored: `qw`");
    assert_eq!(found.notes[1].text, "columns that repeat a quantity are ignored: `t_ms`, `z_m`");
    let found = good("t_s,z_m\n0,3\n0.1,\n0.5,2\n0.5,2\n1,1\n");
    assert_eq!(found.observation.len(), 3);
    assert_eq!(found.notes[1].text, "1 sample left out for an empty cell, the first at line 3");
    assert_eq!(found.notes[2].text, "1 sample left out that repeat the line before");
}

#[test]
fn bounce_lists_end_where_they_cannot_be_counted() {
    let zeros = good("bounce_time_s\n0.4\n1.3\n2.1\n0\n0.000\n");
    assert_eq!(zeros.observation.len(), 3);
    assert_eq!(zeros.notes[0].kind, findings::BOUNCES_TRAILING_ZERO);
    assert_eq!(zeros.notes[0].text, "2 samples of 0 at the end left out, from line 5 on");
    let missed = good("bounce_time_s\n0\n1\n1.9\n3.5\n4.2\n");
    assert_eq!(missed.observation.values(), [0.0, 1.0, 1.9]);
    assert_eq!(missed.notes[0].kind, findings::BOUNCES_MISSED);
    assert_eq!(
        missed.notes[0].text,
        "the interval before line 5 is 1.6000 s after one of 0.9000 s, so a click was missed or false: that time and \
         the 1 after it are excluded"
    );
    assert!(good("bounce_time_s\n0\n1\n1.9\n3.5\n").notes[0].text.ends_with(": that time is excluded"));
    let numbered = good("bounce_number,bounce_time_s\n0,0\n1,1\n2,1.9\n4,3.5\n");
    assert_eq!((numbered.observation.clock(), numbered.notes.len()), (&[0.0, 1.0, 2.0, 4.0][..], 0));
    let (message, _) = bad("bounce_time_s\n0.5\n1\n1.1\n2.0\n");
    assert_eq!(
        message,
        "a.csv: expected at least 3 impacts in a row, found 2 before the missed or false click at line 4"
    );
    let (message, _) = bad("bounce_time_s\n0.5\n0\n1.1\n2.0\n");
    assert_eq!(message, "a.csv:3:1: the bounce time falls: expected more than 0.5, found 0 before further times");
    let (message, _) = bad("bounce_time_s\n0.5\n0.4\n1.1\n");
    assert_eq!(message, "a.csv:3:1: the bounce time falls: expected more than 0.5, found 0.4");
    let (message, _) = bad("bounce_number,bounce_time_s\n1,0.5\n1,0.9\n2,1.1\n");
    assert_eq!(message, "a.csv:3:1: the bounce number falls: expected more than 1.0, found 1.0");
}

#[test]
fn rounded_stamps_may_repeat_now_and_then() {
    let rows = |repeat: usize| {
        let lines = (0..40).map(|i| format!("{},{i}.5", if i % repeat == repeat - 1 { i - 1 } else { i }));
        format!("t_s,z_m\n{}\n", lines.collect::<Vec<_>>().join("\n"))
    };
    let found = good(rows(30));
    assert_eq!(found.observation.len(), 39);
    assert_eq!(found.notes[1].text, "1 sample left out at the time of the sample before, the first at line 31");
    let (message, hint) = bad(rows(4));
    assert_eq!(message, "a.csv:5:1: the time repeats: expected more than 2.0, found 2.0");
    assert_eq!(hint, "write the time with more digits, or keep one line for each time");
}

#[test]
fn every_bad_table_says_what_and_where() {
    let example =
        "say which column is which, as in `--columns t_s=time,z_m=height` for a file with `time` and `height`";
    let no_header = "give a file with a header, such as `t_s,x_m,y_m,z_m` of a ball or `t_s,elbow_goal_rad,elbow_rad` of a robot, and one sample \
        a line";
    for (text, message, hint) in [
        ("", "a.csv: expected a table, found an empty file", no_header),
        ("\n\n", "a.csv: expected a table, found blank lines and comments alone", no_header),
        (
            "t_s,z_m\n",
            "a.csv:1:1: expected samples after the header, found none",
            "record again, or give the file that holds the samples",
        ),
        ("t,h\n0,1\n", "a.csv:1:1: expected columns `t_s` and `z_m`, or `bounce_time_s`, found `t`, `h`", example),
        (
            "t,z_m\n0,1\n",
            "a.csv:1:1: expected a column `t_s`, found `t`, `z_m`",
            "try `--columns t_s=t`; where another unit is meant, write it into our name: `t_ms`, `z_mm`",
        ),
        ("t_s,x_m\n0,1\n", "a.csv:1:1: expected a column `z_m`, found `t_s`, `x_m`", example),
        (
            "0,1\n1,2\n",
            "a.csv:1:1: expected a header with columns `t_s` and `z_m`, or `bounce_time_s`, found a line of numbers",
            "say which column is which, counted from 1, for example `--columns t_s=1,z_m=2`",
        ),
        (
            "t_s,z_ft\n0,1\n",
            "a.csv:1:5: the unit of `z_ft` is not known: expected `m`, `cm`, `mm`, found `ft`",
            "convert the numbers and name the column `z_m`, or map it with `--columns`",
        ),
        (
            "t_min,z_m\n0,1\n",
            "a.csv:1:1: the unit of `t_min` is not known: expected `s`, `sec`, `ms`, `us`, `µs`, `ns`, found `min`",
            "convert the numbers and name the column `t_s`, or map it with `--columns`",
        ),
        (
            "t_s,z_m,u_px,v_px\n0,1,2,3\n",
            "a.csv:1:1: expected columns of one kind, found those of positions and pixels",
            example,
        ),
        (
            "t_s,q1_rad,q2_rad,tau2_nm\n0,1,2,3\n",
            "a.csv:1:1: expected a column `tau1_nm`, since the joints go up to 2, found `t_s`, `q1_rad`, `q2_rad`, `tau2_nm`",
            example,
        ),
        (
            "t_s,z_m\n0,1\n0.15,0.6b31\n1,2\n2,x\n",
            "a.csv:3:6: `z_m`: expected a number, found `0.6b31`",
            "correct the cell, or empty it to leave the sample out; also line 5",
        ),
        (
            "t_s,z_m\n0,NaN\n",
            "a.csv:2:3: `z_m`: expected a finite number, found `NaN`",
            "correct the cell, or empty it to leave the sample out",
        ),
        (
            "t_s,z_m\n0,-inf\n",
            "a.csv:2:3: `z_m`: expected a finite number, found `-inf`",
            "correct the cell, or empty it to leave the sample out",
        ),
        ("t_s,x_m,z_m\n0,1,2\n1,2\n", "a.csv:3:3: expected 3 cells, found 2", "complete or delete the line"),
        ("t_s,z_m\n0,1\n1,2,3\n", "a.csv:3:5: expected 2 cells, found 3", "complete or delete the line"),
        (
            "t_s,z_m\n0,1\n2,2\n1.5,3\n",
            "a.csv:4:1: the time falls: expected more than 2.0, found 1.5",
            "sort the lines by time, or delete this one",
        ),
        (
            "t_s,z_m\n0,1\n2,2\n2,3\n",
            "a.csv:4:1: the time repeats: expected more than 2.0, found 2.0",
            "write the time with more digits, or keep one line for each time",
        ),
        ("t_s,z_m\n0,1\n2,2\n", "a.csv: expected at least 3 samples, found 2", "record for longer"),
        (
            "t_s,z_m\n0,1\n\0\n",
            "a.csv: expected text, found a zero byte in line 3",
            "give a recording, or write the line again",
        ),
    ] {
        assert_eq!(bad(text), (message.to_owned(), hint.to_owned()), "{text:?}");
    }
    let (message, hint) = bad(b"\xff\xfet\0_\0s\0");
    assert_eq!(message, "a.csv: expected UTF-8 text, found UTF-16");
    assert_eq!(hint, "save it as UTF-8, or convert it: `iconv -f UTF-16 -t UTF-8 a.csv > utf8_a.csv`");
    let (message, _) = bad("t_s,z_m\r0,1\r1,2\r2,3\r");
    assert_eq!(message, "a.csv: expected a line feed at the end of each line, found only carriage returns");
    let (message, _) = bad(vec![b'x'; 2 << 20]);
    assert_eq!(message, "a.csv: line 1 is longer than 1048576 bytes");
}

#[test]
fn one_outlier_in_time_does_not_condemn_the_rest() {
    let (message, hint) = bad("t_s,z_m\n0,1\n-5,1\n2.7e154,9\n0.01,1\n0.02,1\n0.03,1\n");
    assert_eq!(message, "a.csv:3:1: the time falls: expected more than 0.0, found -5.0");
    assert_eq!(hint, "sort the lines by time, or delete this one; also line 4");
    let (message, hint) = bad("t_s,z_m\n0,1\n0.01,1\n20,9\n0.02,1\n0.03,1\n");
    assert_eq!(message, "a.csv:4:1: the time leaps: expected less than 0.02, the time after it, found 20.0");
    assert_eq!(hint, "correct the time, or delete the line");
}

#[test]
fn an_error_carries_the_line_itself() {
    let error = read_as("a.csv", "t_s,z_m\n0,1\n0.15,0.6b31\n", &ReadOptions::default()).unwrap_err();
    let crate::Error::Text { line, column, width, source_line, .. } = error else { panic!("{error}") };
    assert_eq!((line, column, width, source_line.as_str()), (3, 6, 6, "0.15,0.6b31"));
}

#[test]
fn a_folder_and_a_missing_file_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let error = crate::read(folder.path(), &ReadOptions::default()).unwrap_err();
    assert!(
        error
            .to_string()
            .ends_with(": expected a recording, found a folder that holds none (ROS 2 bag, LeRobot data set)"),
        "{error}"
    );
    let missing = folder.path().join("a.csv");
    let error = crate::read(&missing, &ReadOptions::default()).unwrap_err();
    assert_eq!(error_text(&error).0, "a.csv: no such file");
}

#[test]
fn a_topic_of_a_table_is_refused() {
    let options = ReadOptions { topic: Some("/a".into()), ..ReadOptions::default() };
    let error = read_as("a.csv", "t_s,z_m\n", &options).unwrap_err().to_string();
    assert!(
        error.starts_with("`topic`: expected a log with topics (MCAP, ROS 2 bag), found the text file "),
        "{error}"
    );
}

#[test]
fn a_minus_reverses_the_sign_of_a_column() {
    let mapped = |pairs: &[(&str, &str)]| ReadOptions {
        columns: pairs.iter().map(|(ours, theirs)| ((*ours).into(), (*theirs).into())).collect(),
        ..ReadOptions::default()
    };
    let table = "t_s,depth,-odd\n0,1.5,3\n1,2.5,4\n2,3.5,5\n";
    for (theirs, heights) in [("-depth", [-1.5, -2.5, -3.5]), ("-2", [-1.5, -2.5, -3.5]), ("-odd", [3.0, 4.0, 5.0])] {
        let recording = read_as("a.csv", table, &mapped(&[("z_m", theirs)])).unwrap();
        assert_eq!(recording.observation.column(2).collect::<Vec<_>>(), heights, "{theirs}");
        let negated = recording.notes.iter().any(|note| note.kind == crate::findings::COLUMNS_NEGATED);
        assert_eq!(negated, theirs != "-odd", "{theirs}");
    }
    let centimetres = read_as("a.csv", table, &mapped(&[("z_cm", "-depth")])).unwrap();
    assert_eq!(centimetres.observation.column(2).collect::<Vec<_>>(), [-0.015, -0.025, -0.035]);
    let clock = read_as("a.csv", table, &mapped(&[("t_s", "-t_s"), ("z_m", "depth")])).unwrap_err();
    assert_eq!(error_text(&clock).0, "a.csv:1:1: `t_s` has no sign: expected a column without `-`, found `-t_s`");
}

/// Whether a motor is on is no torque of it.
#[test]
fn a_flag_is_not_proposed_as_a_torque() {
    let table = |flags: [u8; 4]| {
        let rows = flags.iter().enumerate().map(|(i, flag)| format!("0.{i},{flag},0.{i}5\n"));
        format!("t_s,torque_on,position_rad\n{}", rows.collect::<String>())
    };
    let hint = |flags| error_text(&read_as("a.csv", table(flags), &ReadOptions::default()).unwrap_err()).1;
    assert!(hint([1, 1, 2, 1]).contains("tau1_nm=torque_on"), "{}", hint([1, 1, 2, 1]));
    for flags in [[1, 1, 1, 1], [0, 1, 0, 1]] {
        assert!(!hint(flags).contains("torque_on"), "{}", hint(flags));
    }
}

#[test]
fn units_and_rates_of_other_files_are_refused_instead_of_ignored() {
    let text = "t_s,z_m\n0,1\n1,2\n2,3\n";
    let refused = |options: &ReadOptions| read_as("a.csv", text, options).unwrap_err().to_string();
    let units = ReadOptions { units: vec![UnitRule::parse("deg").unwrap()], ..ReadOptions::default() };
    let message = refused(&units);
    assert!(message.starts_with("`units`: expected a data set of LeRobot or an HDF5 file"), "{message}");
    assert!(message.contains("found the text file"), "{message}");
    let message = refused(&ReadOptions { rate_hz: Some(20.0), ..ReadOptions::default() });
    assert!(message.starts_with("`rate`: expected an HDF5 file"), "{message}");
}
