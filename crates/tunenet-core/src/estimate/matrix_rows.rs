//! A matrix as the list of its rows, for serialisation.

use nalgebra::DMatrix;
use serde::{Serialize, Serializer};

/// `matrix` as a list of rows.
pub(crate) fn rows<S: Serializer>(matrix: &DMatrix<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    list(matrix).serialize(serializer)
}

/// The same of one that may be absent.
#[expect(clippy::ref_option, reason = "the form that serde calls")]
pub(crate) fn rows_of_some<S: Serializer>(matrix: &Option<DMatrix<f64>>, serializer: S) -> Result<S::Ok, S::Error> {
    matrix.as_ref().map(list).serialize(serializer)
}

fn list(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_is_its_rows_and_what_is_not_finite_is_null() {
        let matrix = DMatrix::from_row_slice(2, 3, &[1.0, 2.0, 3.0, f64::NAN, f64::INFINITY, 6.0]);
        let mut json = Vec::new();
        rows(&matrix, &mut serde_json::Serializer::new(&mut json)).unwrap();
        assert_eq!(String::from_utf8(json).unwrap(), "[[1.0,2.0,3.0],[null,null,6.0]]");
    }
}
