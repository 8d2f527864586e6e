//! Files made in code.

use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use parquet::data_type::{ByteArrayType, DoubleType, FixedLenByteArray, FixedLenByteArrayType, Int32Type, Int64Type};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;

use super::*;
use crate::testing::{claim_rows, error_text, file};
use crate::{Contents, ReadOptions, contents, read};

/// Times, heights, some of them missing, an instant in ns, and a text that is no number; in groups of three rows.
fn made(path: &Path, times: &[f64], heights: &[Option<f64>]) {
    let schema = "message log { required double t_s; optional double z_m; \
                  required int64 stamp (TIMESTAMP(NANOS, true)); required binary note (UTF8); }";
    let (schema, properties) =
        (Arc::new(parse_message_type(schema).unwrap()), Arc::new(WriterProperties::builder().build()));
    let mut writer = SerializedFileWriter::new(File::create(path).unwrap(), schema, properties).unwrap();
    for (times, heights) in times.chunks(3).zip(heights.chunks(3)) {
        let mut group = writer.next_row_group().unwrap();
        let mut column = group.next_column().unwrap().unwrap();
        column.typed::<DoubleType>().write_batch(times, None, None).unwrap();
        column.close().unwrap();
        let (levels, values): (Vec<i16>, Vec<f64>) =
            (heights.iter().map(|z| i16::from(z.is_some())).collect(), heights.iter().copied().flatten().collect());
        let mut column = group.next_column().unwrap().unwrap();
        column.typed::<DoubleType>().write_batch(&values, Some(&levels), None).unwrap();
        column.close().unwrap();
        let stamps: Vec<i64> = (1_700_000_000_000_000_001..).take(times.len()).collect();
        let mut column = group.next_column().unwrap().unwrap();
        column.typed::<Int64Type>().write_batch(&stamps, None, None).unwrap();
        column.close().unwrap();
        let notes = vec!["a".into(); times.len()];
        let mut column = group.next_column().unwrap().unwrap();
        column.typed::<ByteArrayType>().write_batch(&notes, None, None).unwrap();
        column.close().unwrap();
        group.close().unwrap();
    }
    writer.close().unwrap();
}

/// Rows are those of the file after any others: the next ones, earlier ones, or the same again.
#[test]
fn rows_are_the_same_in_any_order_of_reading() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    let times: Vec<f64> = (0..9).map(f64::from).collect();
    let heights: Vec<Option<f64>> = (0..9).map(|i| (i != 4).then_some(f64::from(i) * 0.5)).collect();
    made(&path, &times, &heights);
    let table = Parquet::open(&path).unwrap();
    let column = table.column("z_m").unwrap().clone();
    for (group, rows) in [(1, 0..1), (1, 2..3), (1, 0..3), (0, 1..2), (1, 1..2), (0, 0..2), (2, 2..3)] {
        let found = table.numbers_of(group, &column, &rows).unwrap().values;
        let expected: Vec<f64> = rows.map(|row| heights[3 * group + row].unwrap_or(f64::NAN)).collect();
        assert!(found.iter().zip(&expected).all(|(a, b)| a.to_bits() == b.to_bits()), "{found:?} {expected:?}");
    }
    assert!(table.numbers_of(1, &column, &(2..5)).is_err());
    assert_eq!(table.numbers_of(1, &column, &(2..3)).unwrap().values, [2.5]);
}

#[test]
fn a_table_reads_as_the_same_numbers_in_a_text() {
    let times: Vec<f64> = (0..7).map(|i| f64::from(i) / 30.0).collect();
    let heights: Vec<f64> = times.iter().map(|t| (t + 0.1).sqrt()).collect();
    let rows: Vec<String> = times.iter().zip(&heights).map(|(t, z)| format!("{t:?},{z:?}")).collect();
    let text = rows.join("\n");
    let (folder, path) = file("a.csv", format!("t_s,z_m\n{text}"));
    let expected = read(&path, &ReadOptions::default()).unwrap().observation;
    let path = folder.path().join("a.parquet");
    made(&path, &times, &heights.iter().map(|z| Some(*z)).collect::<Vec<_>>());
    assert_eq!(read(&path, &ReadOptions::default()).unwrap().observation, expected);
    let Contents::Table(table) = contents(&path).unwrap() else { panic!("a table") };
    assert_eq!((table.rows, table.samples, table.columns.len()), (7, 7, 3));
}

#[test]
fn missing_numbers_and_instants_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    made(&path, &[0.0, 1.0, 2.0, 3.0, 4.0], &[Some(1.0), None, Some(3.0), Some(4.0), Some(5.0)]);
    let found = read(&path, &ReadOptions::default()).unwrap();
    assert_eq!(found.observation.clock(), [0.0, 2.0, 3.0, 4.0]);
    let sheet = Parquet::open(&path).unwrap().sheet().unwrap();
    assert_eq!(sheet.names, ["t_s", "z_m", "stamp_s"]);
    assert_eq!(sheet.notes[0].text, "columns that hold no numbers are left out: `note`");
    assert_eq!(sheet.values[2].to_bits(), 1_700_000_000.000_000_001_f64.to_bits());
}

/// What follows the columns of times and decimals is written by pyarrow in this form.
#[test]
fn decimals_and_half_precision_are_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    let schema = "message log { required double t_s; required int32 j_rad (DECIMAL(6, 2)); \
                  required fixed_len_byte_array(2) h_rad (FLOAT16); required fixed_len_byte_array(9) d_rad (DECIMAL(20, 3)); }";
    let schema = Arc::new(parse_message_type(schema).unwrap());
    let properties = Arc::new(WriterProperties::builder().build());
    let mut writer = SerializedFileWriter::new(File::create(&path).unwrap(), schema, properties).unwrap();
    let mut group = writer.next_row_group().unwrap();
    let mut column = group.next_column().unwrap().unwrap();
    column.typed::<DoubleType>().write_batch(&[0.0, 1.0, 2.0], None, None).unwrap();
    column.close().unwrap();
    let mut column = group.next_column().unwrap().unwrap();
    column.typed::<Int32Type>().write_batch(&[150, -25, 0], None, None).unwrap();
    column.close().unwrap();
    let bytes = |rows: [&[u8]; 3]| rows.map(|row| FixedLenByteArray::from(row.to_vec()));
    let mut column = group.next_column().unwrap().unwrap();
    let halves = bytes([&[0x00, 0x3c], &[0x00, 0xc0], &[0x00, 0x00]]);
    column.typed::<FixedLenByteArrayType>().write_batch(&halves, None, None).unwrap();
    column.close().unwrap();
    let mut column = group.next_column().unwrap().unwrap();
    let decimals = bytes([&[0, 0, 0, 0, 0, 0, 0, 0x03, 0xe8], &[0xff; 9], &[0; 9]]);
    column.typed::<FixedLenByteArrayType>().write_batch(&decimals, None, None).unwrap();
    column.close().unwrap();
    group.close().unwrap();
    writer.close().unwrap();
    let sheet = Parquet::open(&path).unwrap().sheet().unwrap();
    assert_eq!(sheet.names, ["t_s", "j_rad", "h_rad", "d_rad"]);
    assert_eq!(sheet.values, [0.0, 1.5, 1.0, 1.0, 1.0, -0.25, -2.0, -0.001, 2.0, 0.0, 0.0, 0.0]);
    assert!(sheet.notes.is_empty());
}

/// The crate names the codec by a feature of its own build; a file says it in its footer, where a single byte states it.
#[test]
fn a_compression_that_is_not_read_is_named_with_the_way_out() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    made(&path, &[0.0, 1.0, 2.0], &[Some(1.0), Some(2.0), Some(3.0)]);
    let mut bytes = std::fs::read(&path).unwrap();
    // In the compact protocol of Thrift: the path `t_s` in a list of texts, and the next field, a whole number in zigzag.
    let at = bytes.windows(6).rposition(|w| w == [0x18, 0x03, b't', b'_', b's', 0x15]).unwrap() + 6;
    assert_eq!(bytes[at], 0, "uncompressed");
    bytes[at] = 8;
    std::fs::write(&path, bytes).unwrap();
    let (message, hint) = error_text(&read(&path, &ReadOptions::default()).unwrap_err());
    let wanted = "a.parquet: column `t_s` is compressed with BROTLI: expected no compression, snappy, gzip or zstd";
    assert!(message == wanted && hint.contains("compression='zstd'"), "{message} {hint}");
}

#[test]
fn broken_files_say_so() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    made(&path, &[0.0, 1.0, 2.0], &[Some(1.0), Some(2.0), Some(3.0)]);
    let bytes = std::fs::read(&path).unwrap();
    std::fs::write(&path, &bytes[..bytes.len() - 9]).unwrap();
    let (message, _) = error_text(&read(&path, &ReadOptions::default()).unwrap_err());
    assert!(message.starts_with("a.parquet: the Parquet file is cut off or broken"), "{message}");
    std::fs::write(&path, b"PAR1").unwrap();
    assert!(read(&path, &ReadOptions::default()).unwrap_err().to_string().contains("cut off or broken"));
}

#[test]
fn the_number_of_rows_that_a_file_states_is_not_trusted() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    made(&path, &[0.0, 1.0, 2.0], &[Some(1.0), Some(2.0), Some(3.0)]);
    claim_rows(&path, i64::MAX);
    let (message, _) = error_text(&read(&path, &ReadOptions::default()).unwrap_err());
    assert!(message.contains("column `t_s`: expected 9223372036854775807 rows in group 0, found 3"), "{message}");
    // Without a column of numbers nothing is read that could contradict it.
    let schema = Arc::new(parse_message_type("message log { required binary note (UTF8); }").unwrap());
    let properties = Arc::new(WriterProperties::builder().build());
    let mut writer = SerializedFileWriter::new(File::create(&path).unwrap(), schema, properties).unwrap();
    let mut group = writer.next_row_group().unwrap();
    let mut column = group.next_column().unwrap().unwrap();
    column.typed::<ByteArrayType>().write_batch(&["a".into()], None, None).unwrap();
    column.close().unwrap();
    group.close().unwrap();
    writer.close().unwrap();
    claim_rows(&path, i64::MAX);
    assert_eq!(Parquet::open(&path).unwrap().sheet().unwrap().values.len(), 0);
    assert!(read(&path, &ReadOptions::default()).is_err());
}
