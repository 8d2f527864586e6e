//! MATLAB files made by hand.

use std::io::Write as _;

use crate::testing::{error_text, file};
use crate::{ReadOptions, read};

fn element(kind: u32, data: &[u8]) -> Vec<u8> {
    let mut bytes = [kind.to_le_bytes(), u32::try_from(data.len()).unwrap().to_le_bytes()].concat();
    bytes.extend(data);
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    bytes
}

/// A variable of a class; its numbers by columns, as elements of a type.
fn variable(name: &str, class: u32, size: [u32; 2], numbers: &[u8]) -> Vec<u8> {
    let flags = [class.to_le_bytes(), [0; 4]].concat();
    let size = size.map(u32::to_le_bytes).concat();
    element(14, &[element(6, &flags), element(5, &size), element(1, name.as_bytes()), numbers.to_vec()].concat())
}

fn doubles(values: &[f64]) -> Vec<u8> {
    element(9, &values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>())
}

fn whole(variables: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = b"MATLAB 5.0 MAT-file, by hand".to_vec();
    bytes.resize(124, b' ');
    bytes.extend([0, 1, b'I', b'M']);
    bytes.extend(variables.concat());
    bytes
}

fn packed(variable: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
    encoder.write_all(variable).unwrap();
    let data = encoder.finish().unwrap();
    [&15u32.to_le_bytes()[..], &u32::try_from(data.len()).unwrap().to_le_bytes(), &data].concat()
}

#[test]
fn variables_read_as_the_columns_of_a_text_do() {
    let (_folder, path) = file("a.csv", "t_s,z_m\n0.0,1.0\n0.1,0.5\n0.25,4\n");
    let expected = read(&path, &ReadOptions::default()).unwrap();
    let times = variable("t_s", 6, [3, 1], &doubles(&[0.0, 0.1, 0.25]));
    // A list may be a row as well as a column.
    let heights = variable("z_m", 6, [1, 3], &doubles(&[1.0, 0.5, 4.0]));
    let text = variable("note", 4, [1, 2], &element(4, &[104, 0, 105, 0]));
    let bytes = whole(&[packed(&times), heights, text]);
    let (_folder, path) = file("a.mat", &bytes);
    let mut found = read(&path, &ReadOptions::default()).unwrap();
    let left_out = found.notes.pop().unwrap().text;
    assert_eq!(left_out, "arrays that are no columns of numbers with 3 rows: `note`: expected numbers, found a text");
    assert_eq!(found, expected);
    for end in [40, 127, 130, 150, bytes.len() - 60] {
        let (_folder, path) = file("a.mat", &bytes[..end]);
        assert!(read(&path, &ReadOptions::default()).is_err(), "{end}");
    }
}

#[test]
fn matrices_are_read_by_columns_and_small_numbers_from_their_mark() {
    let table = variable("log", 6, [3, 2], &doubles(&[0.0, 0.5, 1.0, 7.0, 8.0, 9.0]));
    // Three unsigned bytes, which stand in the mark itself.
    let short = [(2u32 | 3 << 16).to_le_bytes(), [4, 5, 6, 0]].concat();
    let (_folder, path) = file("a.mat", whole(&[table, variable("z", 9, [3, 1], &short)]));
    let columns = [("t_s", "log.0"), ("x_m", "log.1"), ("z_m", "z")];
    let columns = columns.iter().map(|(a, b)| ((*a).to_owned(), (*b).to_owned())).collect();
    let seen = read(&path, &ReadOptions { columns, ..ReadOptions::default() }).unwrap().observation;
    assert_eq!((seen.clock(), seen.row(1)), (&[0.0, 0.5, 1.0][..], &[8.0, 0.0, 5.0][..]));
}

#[test]
fn what_is_no_table_says_why() {
    let refused = |variables: &[Vec<u8>]| {
        let (_folder, path) = file("a.mat", whole(variables));
        error_text(&read(&path, &ReadOptions::default()).unwrap_err()).0
    };
    let why = refused(&[variable("log", 2, [1, 1], &[])]);
    assert!(why.contains("found none") && why.contains("log"), "{why}");
    let huge = variable("big", 6, [u32::MAX, u32::MAX], &doubles(&[1.0]));
    assert!(refused(&[huge]).starts_with("a.mat: expected arrays of numbers with 3 rows or more, found none"));
    let mut other = whole(&[]);
    other[126] = b'?';
    let (_folder, path) = file("a.mat", &other);
    let (message, _) = error_text(&read(&path, &ReadOptions::default()).unwrap_err());
    assert_eq!(message, "a.mat: the MATLAB file is cut off or broken: its header states no byte order");
}
