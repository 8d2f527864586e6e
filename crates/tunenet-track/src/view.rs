//! A picture as the tracker sees it: rows of blue, green, red.

use opencv::core::{CV_8UC3, Mat, MatTraitConst, MatTraitConstManual};
use opencv::{Error, core::StsBadArg};

/// A picture of 8 bits in each of blue, green and red; the origin is the centre of its first pixel, `v` runs downwards.
#[derive(Debug, Clone, Copy)]
pub struct View<'a> {
    columns: usize,
    rows: usize,
    bytes: &'a [u8],
}

impl<'a> View<'a> {
    /// The picture in `mat`.
    ///
    /// # Errors
    /// Where it is empty, has other channels, or lies in memory with gaps.
    pub fn of(mat: &'a Mat) -> opencv::Result<Self> {
        let size = (usize::try_from(mat.cols()).ok(), usize::try_from(mat.rows()).ok());
        let (Some(columns @ 1..), Some(rows @ 1..)) = size else {
            return Err(Error::new(StsBadArg, "an empty picture"));
        };
        if mat.typ() != CV_8UC3 {
            return Err(Error::new(StsBadArg, "a picture without three channels of 8 bits"));
        }
        Ok(Self { columns, rows, bytes: mat.data_bytes()? })
    }

    /// Width, px, at least 1.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Height, px, at least 1.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// The pixel in this column and row.
    ///
    /// # Panics
    /// Where it lies outside.
    #[inline]
    #[must_use]
    pub fn pixel(&self, column: usize, row: usize) -> [u8; 3] {
        let at = 3 * (row * self.columns + column);
        let pixel = &self.bytes[at..at + 3];
        [pixel[0], pixel[1], pixel[2]]
    }

    /// So many pixels of a row, every `every`-th from `column` on.
    #[inline]
    pub(crate) fn thinned(
        &self,
        row: usize,
        column: usize,
        every: usize,
        count: usize,
    ) -> impl Iterator<Item = [u8; 3]> {
        let bytes = &self.bytes[3 * (row * self.columns + column)..3 * (row + 1) * self.columns];
        bytes.chunks(3 * every).take(count).map(|pixel| [pixel[0], pixel[1], pixel[2]])
    }

    /// Whether a point lies at least half a pixel within.
    #[inline]
    pub(crate) fn holds(&self, u: f64, v: f64) -> bool {
        u >= 0.0 && v >= 0.0 && u <= (self.columns - 1) as f64 && v <= (self.rows - 1) as f64
    }

    /// The colour at a point that the picture holds, bilinear between its four pixels.
    #[inline]
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the picture")]
    pub(crate) fn colour(&self, u: f64, v: f64) -> [f32; 3] {
        let (column, row) = (u as usize, v as usize);
        let (right, below) = ((column + 1).min(self.columns - 1), (row + 1).min(self.rows - 1));
        let (a, b) = ((u - column as f64) as f32, (v - row as f64) as f32);
        let [p, q] = [self.pixel(column, row), self.pixel(right, row)];
        let [r, s] = [self.pixel(column, below), self.pixel(right, below)];
        let between = |c: usize| {
            let [p, q, r, s] = [f32::from(p[c]), f32::from(q[c]), f32::from(r[c]), f32::from(s[c])];
            let (above, under) = (p + a * (q - p), r + a * (s - r));
            above + b * (under - above)
        };
        [between(0), between(1), between(2)]
    }
}
