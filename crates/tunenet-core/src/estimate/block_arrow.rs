//! Bordered block-diagonal solve by the Schur complement (Golub and Van Loan 2013, section 4.5; Triggs et al. 2000): the
//! parameters that recordings share are the border, the nuisance parameters of each recording a block.

use nalgebra::{DMatrix, DVector};

/// Normal equations: shared parameters, and for each recording its nuisance parameters with their coupling to the shared ones.
pub(crate) struct Arrow {
    /// Shape `[shared, shared]`.
    pub shared: DMatrix<f64>,
    /// Shape `[shared]`.
    pub right: DVector<f64>,
    /// One for each recording.
    pub blocks: Vec<Block>,
}

/// One recording's part.
pub(crate) struct Block {
    /// Which shared parameters it depends on; the others (another object's) do not touch it.
    pub indices: Vec<usize>,
    /// Shape `[indices, nuisances]`.
    pub coupling: DMatrix<f64>,
    /// Shape `[nuisances, nuisances]`.
    pub nuisances: DMatrix<f64>,
    /// Shape `[nuisances]`.
    pub nuisance_right: DVector<f64>,
}

impl Block {
    /// `whole[indices, indices] -= part`.
    fn take(&self, whole: &mut DMatrix<f64>, part: &DMatrix<f64>) {
        for (i, &row) in self.indices.iter().enumerate() {
            for (j, &column) in self.indices.iter().enumerate() {
                whole[(row, column)] -= part[(i, j)];
            }
        }
    }
}

impl Arrow {
    /// Empty equations for `shared` parameters, with room for `recordings` blocks.
    pub fn new(shared: usize, recordings: usize) -> Self {
        Self {
            shared: DMatrix::zeros(shared, shared),
            right: DVector::zeros(shared),
            blocks: Vec::with_capacity(recordings),
        }
    }

    /// Keeps shared parameter `i` where it is.
    pub fn hold(&mut self, i: usize) {
        self.shared.row_mut(i).fill(0.0);
        self.shared.column_mut(i).fill(0.0);
        self.shared[(i, i)] = 1.0;
        self.right[i] = 0.0;
        for block in &mut self.blocks {
            if let Some(row) = block.indices.iter().position(|&index| index == i) {
                block.coupling.row_mut(row).fill(0.0);
            }
        }
    }

    /// The damped step: first the shared parameters from the Schur complement, then the nuisance parameters of each recording.
    pub fn solve(&self, damping: f64) -> (DVector<f64>, Vec<DVector<f64>>) {
        let damped = |m: &DMatrix<f64>| {
            let mut m = m.clone();
            for i in 0..m.nrows() {
                m[(i, i)] += damping * m[(i, i)] + f64::MIN_POSITIVE.sqrt();
            }
            m
        };
        let mut schur = damped(&self.shared);
        let mut right = self.right.clone();
        let inverses: Vec<DMatrix<f64>> = self.blocks.iter().map(|b| inverse(damped(&b.nuisances))).collect();
        for (block, inverse) in self.blocks.iter().zip(&inverses) {
            let through = &block.coupling * inverse;
            block.take(&mut schur, &(&through * block.coupling.transpose()));
            let known = &through * &block.nuisance_right;
            block.indices.iter().zip(known.iter()).for_each(|(&index, known)| right[index] -= known);
        }
        let shared = inverse(schur) * right;
        let nuisances = |(block, inverse): (&Block, &DMatrix<f64>)| {
            let near = DVector::from_iterator(block.indices.len(), block.indices.iter().map(|&index| shared[index]));
            inverse * (&block.nuisance_right - block.coupling.transpose() * near)
        };
        let nuisances = self.blocks.iter().zip(&inverses).map(nuisances).collect();
        (shared, nuisances)
    }

    /// The equations of the shared parameters alone, the nuisance parameters eliminated.
    pub fn reduced(&self) -> (DMatrix<f64>, DVector<f64>) {
        let (mut schur, mut right) = (self.shared.clone(), self.right.clone());
        for block in &self.blocks {
            let through = &block.coupling * inverse(block.nuisances.clone());
            block.take(&mut schur, &(&through * block.coupling.transpose()));
            let known = &through * &block.nuisance_right;
            block.indices.iter().zip(known.iter()).for_each(|(&index, known)| right[index] -= known);
        }
        (schur, right)
    }

    /// Covariance of the shared parameters, the nuisance parameters marginalised. One without influence gets an infinite
    /// variance.
    pub fn covariance(&self) -> DMatrix<f64> {
        let (mut schur, _) = self.reduced();
        let dead: Vec<bool> =
            (0..schur.nrows()).map(|i| schur[(i, i)] <= 1e-9 * self.shared[(i, i)].max(1e-12)).collect();
        for i in (0..schur.nrows()).filter(|&i| dead[i]) {
            schur.row_mut(i).fill(0.0);
            schur.column_mut(i).fill(0.0);
            schur[(i, i)] = 1.0;
        }
        let mut covariance = inverse(schur);
        for i in (0..covariance.nrows()).filter(|&i| dead[i]) {
            covariance[(i, i)] = f64::INFINITY;
        }
        covariance
    }
}

/// The inverse of a symmetric positive matrix, scaled to a unit diagonal first; its pseudo-inverse where it is singular.
pub(crate) fn inverse(m: DMatrix<f64>) -> DMatrix<f64> {
    let n = m.nrows();
    if n == 0 {
        return m;
    }
    let scale = DVector::from_fn(n, |i, _| m[(i, i)].max(f64::MIN_POSITIVE).sqrt().recip());
    let scaled = DMatrix::from_fn(n, n, |i, j| m[(i, j)] * scale[i] * scale[j]);
    let inverted = scaled.clone().cholesky().map(|c| c.inverse()).or_else(|| {
        // The decomposition never ends on what is not finite.
        scaled.iter().all(|v| v.is_finite()).then(|| scaled.pseudo_inverse(1e-12).ok()).flatten()
    });
    inverted.map_or_else(|| DMatrix::zeros(n, n), |v| DMatrix::from_fn(n, n, |i, j| v[(i, j)] * scale[i] * scale[j]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same equations written out in full: two shared parameters, of which each of two recordings touches one.
    #[test]
    fn elimination_equals_the_whole_system() {
        let mut arrow = Arrow::new(2, 2);
        arrow.shared = DMatrix::from_row_slice(2, 2, &[9.0, 1.0, 1.0, 7.0]);
        arrow.right = DVector::from_row_slice(&[1.0, -2.0]);
        for (index, coupling, nuisances, right) in [(0, 1.5, 4.0, 0.3), (1, -0.5, 3.0, 0.7)] {
            arrow.blocks.push(Block {
                indices: vec![index],
                coupling: DMatrix::from_element(1, 1, coupling),
                nuisances: DMatrix::from_element(1, 1, nuisances),
                nuisance_right: DVector::from_element(1, right),
            });
        }
        #[rustfmt::skip]
        let whole = DMatrix::from_row_slice(4, 4, &[
            9.0, 1.0, 1.5, 0.0,
            1.0, 7.0, 0.0, -0.5,
            1.5, 0.0, 4.0, 0.0,
            0.0, -0.5, 0.0, 3.0,
        ]);
        let all = whole.clone().lu().solve(&DVector::from_row_slice(&[1.0, -2.0, 0.3, 0.7])).unwrap();
        let (shared, nuisances) = arrow.solve(0.0);
        let found = [shared[0], shared[1], nuisances[0][0], nuisances[1][0]];
        assert!(found.iter().zip(all.iter()).all(|(a, b)| (a - b).abs() < 1e-14), "{found:?} {all}");
        let covariance = whole.try_inverse().unwrap();
        assert!((arrow.covariance() - covariance.view((0, 0), (2, 2))).norm() < 1e-14);
    }
}
