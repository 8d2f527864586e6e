//! Arrays made in code, as NumPy writes them.

use std::io::Write as _;

use crate::testing::{error_text, file};
use crate::{ReadOptions, read};

/// An array with this header and these bytes.
fn array(descr: &str, fortran: bool, shape: &str, bytes: &[u8]) -> Vec<u8> {
    let order = if fortran { "True" } else { "False" };
    let mut header = format!("{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}, }}");
    while (header.len() + 11) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    let length = u16::try_from(header.len()).unwrap().to_le_bytes();
    [b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), bytes].concat()
}

fn doubles(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

fn archive(entries: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let mut writer = zip::ZipWriter::new(&mut bytes);
    for (name, data) in entries {
        let stored = zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
        writer.start_file(*name, stored).unwrap();
        writer.write_all(data).unwrap();
    }
    writer.finish().unwrap();
    bytes.into_inner()
}

fn options(columns: &[(&str, &str)]) -> ReadOptions {
    let columns = columns.iter().map(|(a, b)| ((*a).to_owned(), (*b).to_owned())).collect();
    ReadOptions { columns, ..ReadOptions::default() }
}

#[test]
fn arrays_by_name_read_as_the_columns_of_a_text_do() {
    let (times, heights) = ([0.0, 0.1, 0.1 + 0.2], [1.0, 0.9, 1.0 / 3.0]);
    let rows: Vec<String> = times.iter().zip(heights).map(|(t, z)| format!("{t:?},{z:?}")).collect();
    let text = rows.join("\n");
    let (_folder, path) = file("a.csv", format!("t_s,z_m\n{text}"));
    let expected = read(&path, &ReadOptions::default()).unwrap();
    let bytes = archive(&[
        ("t_s.npy", array("'<f8'", false, "(3,)", &doubles(&times))),
        ("z_m.npy", array("'<f8'", false, "(3,)", &doubles(&heights))),
        ("note.npy", array("'<U4'", false, "(3,)", &[0; 48])),
        ("other.npy", array("'<f8'", false, "(1,)", &doubles(&[7.0]))),
    ]);
    let (_folder, path) = file("a.npz", bytes);
    let mut found = read(&path, &ReadOptions::default()).unwrap();
    let left_out = found.notes.pop().unwrap().text;
    assert_eq!(
        left_out,
        "arrays that are no columns of numbers with 3 rows: `note`: expected numbers, found the type `<U4`; `other`: 1 row"
    );
    assert_eq!(found, expected);
}

/// The crate that unpacks keeps the last member of a name.
#[test]
fn arrays_of_one_name_are_refused() {
    let column = |values: [f64; 3]| array("'<f8'", false, "(3,)", &doubles(&values));
    let mut bytes =
        archive(&[("t_s.npy", column([0.0, 1.0, 2.0])), ("z_m.npy", column([1.0; 3])), ("z_n.npy", column([2.0; 3]))]);
    for at in 0..bytes.len() - 7 {
        if &bytes[at..at + 7] == b"z_n.npy" {
            bytes[at + 2] = b'm';
        }
    }
    let (_folder, path) = file("a.npz", bytes);
    let (message, _) = error_text(&read(&path, &ReadOptions::default()).unwrap_err());
    assert_eq!(message, "a.npz: expected arrays of different names, found 3 arrays of 2 names");
}

/// Why an array is no column is said where it is missing, too.
#[test]
fn a_missing_column_is_named_with_what_the_file_holds_of_it() {
    let bytes = archive(&[
        ("t_s.npy", array("'<f8'", false, "(3,)", &doubles(&[0.0, 1.0, 2.0]))),
        ("x_m.npy", array("'<f8'", false, "(3,)", &doubles(&[0.0, 1.0, 2.0]))),
        ("z_m.npy", array("'<f8'", false, "(4,)", &doubles(&[0.0, 1.0, 2.0, 3.0]))),
    ]);
    let (_folder, path) = file("a.npz", bytes);
    let channels = vec![tunenet_core::observation::Channel::new("z", "m")];
    let refused = read(&path, &ReadOptions { channels, ..ReadOptions::default() }).unwrap_err();
    let (message, _) = error_text(&refused);
    assert!(
        message.contains("expected a column `z_m`") && message.ends_with("with 3 rows: `z_m`: 4 rows"),
        "{message}"
    );
}

#[test]
fn an_array_without_names_is_read_by_the_numbers_of_its_columns() {
    let rows = [0.0, 1.0, 0.5, 2.0, 1.0, 4.0];
    let columns = [0.0, 0.5, 1.0, 1.0, 2.0, 4.0];
    let read_as = |bytes: Vec<u8>, options: &ReadOptions| {
        let (_folder, path) = file("a.npy", bytes);
        read(&path, options)
    };
    let mapped = options(&[("t_s", "1"), ("z_m", "-2")]);
    let found = read_as(array("'<f8'", false, "(3, 2)", &doubles(&rows)), &mapped).unwrap();
    assert_eq!(found.observation.column(2).collect::<Vec<_>>(), [-1.0, -2.0, -4.0]);
    assert_eq!(read_as(array("'<f8'", true, "(3, 2)", &doubles(&columns)), &mapped).unwrap(), found);
    let big: Vec<u8> = rows.iter().flat_map(|value| value.to_be_bytes()).collect();
    assert_eq!(read_as(array("'>f8'", false, "(3, 2)", &big), &mapped).unwrap(), found);
    let (message, hint) =
        error_text(&read_as(array("'<f8'", false, "(3, 2)", &doubles(&rows)), &options(&[])).unwrap_err());
    assert!(message.contains("expected") && hint.contains("`--columns t_s=1,z_m=2`"), "{message} {hint}");
    let records = array("[('t_s', '<f8'), ('z_m', '<f8')]", false, "(3,)", &doubles(&rows));
    assert_eq!(read_as(records, &options(&[])).unwrap().observation.column(2).collect::<Vec<_>>(), [1.0, 2.0, 4.0]);
}

#[test]
fn half_precision_is_read_in_both_byte_orders() {
    for (kind, bytes) in
        [("'<f2'", [0x00, 0x3c, 0x00, 0xc0, 0x00, 0x38]), ("'>f2'", [0x3c, 0x00, 0xc0, 0x00, 0x38, 0x00])]
    {
        let times = array("'<f8'", false, "(3,)", &doubles(&[0.0, 0.5, 1.0]));
        let (_folder, path) =
            file("a.npz", archive(&[("t_s.npy", times), ("z_m.npy", array(kind, false, "(3,)", &bytes))]));
        let found = read(&path, &ReadOptions::default()).unwrap().observation;
        assert_eq!(found.column(2).collect::<Vec<_>>(), [1.0, -2.0, 0.5], "{kind}");
    }
}

#[test]
fn broken_arrays_say_what_is_wrong() {
    let refused = |bytes: Vec<u8>| {
        let (_folder, path) = file("a.npy", bytes);
        error_text(&read(&path, &ReadOptions::default()).unwrap_err()).0
    };
    assert!(
        refused(array("'<f8'", false, "(3, 2)", &[0; 8])).contains("the array is cut off: expected 6 numbers, found 0")
    );
    assert!(refused(array("'<f8'", false, "(999999999999, 2)", &[])).contains("expected at most 40000000 numbers"));
    // No row of it takes a byte, so that it may promise any number of them.
    for fortran in [false, true] {
        let empty = array("'<f8'", fortran, "(18446744073709551615, 0)", &[]);
        assert!(refused(empty).contains("expected at least one column, found the shape [18446744073709551615, 0]"));
    }
    assert!(refused(array("'<c16'", false, "(3,)", &[])).contains("found the type `<c16`"));
    assert!(refused(array("'<f8'", false, "(3, 2, 2)", &[])).contains("found 3 dimensions"));
    assert!(refused(array("'O'", false, "(3,)", &[])).contains("expected numbers, found the type `O`"));
    assert!(refused(b"\x93NUMPY".to_vec()).contains("the array is cut off"));
    let rows = doubles(&[0.0, 1.0, 2.0]);
    let column = |name: &'static str| (name, array("'<f8'", false, "(3,)", &rows));
    let bytes = archive(&[
        column("t_s.npy"),
        column("z_m.npy"),
        ("a.npy", array("'<f8'", false, "(18446744073709551615, 0)", &[])),
        ("b.npy", array("'<f8'", false, "(18446744073709551615, 0)", &[])),
    ]);
    let (_folder, path) = file("a.npz", bytes);
    assert_eq!(read(&path, &ReadOptions::default()).unwrap().observation.len(), 3);
    let (_folder, path) = file("a.npz", &archive(&[("z.npy", array("'<f8'", false, "(3,)", &[0; 24]))])[..60]);
    assert!(read(&path, &ReadOptions::default()).is_err());
}
