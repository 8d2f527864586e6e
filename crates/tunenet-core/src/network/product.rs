//! Matrix product with reverse-mode derivatives, on the thread that asks for it.
//!
//! The largest product here is some 50 × 2100 × 32. candle's own product hands it to a pool of threads, which costs more
//! than it saves, takes cores from parallel rollouts and leaves the order of sums to the number of threads; and its
//! way back also differentiates by the observations. So on a CPU a custom operation of candle's calls nalgebra.

use candle_core::{CpuStorage, CustomOp2, Layout, Shape, Tensor};
use nalgebra::{DMatrixView, DMatrixViewMut, Dyn, RealField};

/// What the left factor is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Left {
    /// Data: no derivative is required.
    Data,
    /// The output of a layer.
    Features,
}

/// `a b`, shapes `[m, k]` and `[k, n]`, either of them possibly a transposed view.
pub(super) fn product(a: &Tensor, b: &Tensor, left: Left) -> candle_core::Result<Tensor> {
    if a.device().is_cpu() { a.apply_op2(b, Product { left }) } else { a.matmul(b) }
}

struct Product {
    left: Left,
}

impl CustomOp2 for Product {
    fn name(&self) -> &'static str {
        "product"
    }

    fn cpu_fwd(
        &self,
        a: &CpuStorage,
        a_layout: &Layout,
        b: &CpuStorage,
        b_layout: &Layout,
    ) -> candle_core::Result<(CpuStorage, Shape)> {
        let shape = shape(a_layout, b_layout)?;
        let storage = match (a, b) {
            (CpuStorage::F32(a), CpuStorage::F32(b)) => {
                CpuStorage::F32(multiply(shape, (a, a_layout), (b, b_layout), 0.0))
            }
            (CpuStorage::F64(a), CpuStorage::F64(b)) => {
                CpuStorage::F64(multiply(shape, (a, a_layout), (b, b_layout), 0.0))
            }
            _ => candle_core::bail!("a product of numbers of one precision, single or double"),
        };
        Ok((storage, shape.into()))
    }

    /// `∂/∂a = g bᵀ`, `∂/∂b = aᵀ g`.
    fn bwd(
        &self,
        a: &Tensor,
        b: &Tensor,
        _product: &Tensor,
        gradient: &Tensor,
    ) -> candle_core::Result<(Option<Tensor>, Option<Tensor>)> {
        // Detached: no second derivative is required.
        let (a, b) = (a.detach(), b.detach());
        let by_a = match self.left {
            Left::Data => None,
            Left::Features => Some(product(gradient, &b.t()?, Left::Data)?),
        };
        Ok((by_a, Some(product(&a.t()?, gradient, Left::Data)?)))
    }
}

/// Rows and columns of the product.
fn shape(a: &Layout, b: &Layout) -> candle_core::Result<(usize, usize)> {
    let ((rows, inner), (expected, columns)) = (a.shape().dims2()?, b.shape().dims2()?);
    if inner != expected {
        candle_core::bail!("{inner} numbers for weights of {expected}");
    }
    Ok((rows, columns))
}

/// Up to this many rows, columns or numbers between them, packing a matrix costs more than multiplying it.
const THIN: usize = 8;

fn multiply<T: RealField + Copy>(
    (rows, columns): (usize, usize),
    a: (&[T], &Layout),
    b: (&[T], &Layout),
    zero: T,
) -> Vec<T> {
    let mut product = vec![zero; rows * columns];
    let inner = a.1.dims()[1];
    if rows.min(columns).min(inner) > THIN {
        // What is row by row to candle is the transpose to nalgebra: productᵀ = bᵀ aᵀ.
        let mut product = DMatrixViewMut::from_slice(&mut product, columns, rows);
        product.gemm(T::one(), &transposed(b), &transposed(a), zero);
    } else if columns > 0 {
        add_thin(&mut product, columns, a, b);
    }
    product
}

fn transposed<'a, T: RealField>((values, layout): (&'a [T], &Layout)) -> DMatrixView<'a, T, Dyn, Dyn> {
    let (dims, stride) = (layout.dims(), layout.stride());
    DMatrixView::from_slice_with_strides(&values[layout.start_offset()..], dims[1], dims[0], stride[1], stride[0])
}

/// `product ← product + a b`, row by row.
fn add_thin<T: RealField + Copy>(
    product: &mut [T],
    columns: usize,
    (a, a_layout): (&[T], &Layout),
    (b, b_layout): (&[T], &Layout),
) {
    let (a, b) = (&a[a_layout.start_offset()..], &b[b_layout.start_offset()..]);
    let (a_stride, b_stride) = (a_layout.stride(), b_layout.stride());
    for (i, row) in product.chunks_exact_mut(columns).enumerate() {
        for k in 0..a_layout.dims()[1] {
            let factor = a[i * a_stride[0] + k * a_stride[1]];
            let line = &b[k * b_stride[0]..];
            // Contiguous numbers are multiplied several at once.
            if b_stride[1] == 1 {
                for (entry, b) in row.iter_mut().zip(&line[..columns]) {
                    *entry += factor * *b;
                }
            } else {
                for (entry, b) in row.iter_mut().zip(line.iter().step_by(b_stride[1])) {
                    *entry += factor * *b;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use candle_core::{DType, Device, Var};

    use super::*;

    fn matrix(rows: usize, columns: usize, start: f64) -> Tensor {
        let numbers: Vec<f64> = (0..rows * columns).map(|i| (start + i as f64).sin()).collect();
        Tensor::from_vec(numbers, (rows, columns), &Device::Cpu).unwrap()
    }

    fn largest_difference(a: &Tensor, b: &Tensor) -> f64 {
        assert_eq!(a.dims(), b.dims());
        let off = (a.to_dtype(DType::F64).unwrap() - b.to_dtype(DType::F64).unwrap()).unwrap();
        off.abs().unwrap().max_all().unwrap().to_scalar().unwrap()
    }

    #[test]
    fn products_equal_those_of_candle() {
        for (m, k, n) in [(1, 1, 1), (3, 7, 2), (50, 130, 32), (1, 64, 32), (50, 32, 1), (9, 9, 9), (40, 3, 20)] {
            let contiguous = (matrix(m, k, 0.1), matrix(k, n, 0.7));
            let transposed = (matrix(k, m, 0.3).t().unwrap(), matrix(n, k, 0.9).t().unwrap());
            let part = (matrix(m, k + 3, 0.2).narrow(1, 2, k).unwrap(), matrix(k, n, 0.4));
            for (a, b) in [contiguous, transposed, part] {
                let expected = a.contiguous().unwrap().matmul(&b.contiguous().unwrap()).unwrap();
                assert!(largest_difference(&product(&a, &b, Left::Data).unwrap(), &expected) < 1e-12);
                let single = |x: &Tensor| x.to_dtype(DType::F32).unwrap();
                assert!(largest_difference(&product(&single(&a), &single(&b), Left::Data).unwrap(), &expected) < 1e-4);
            }
        }
    }

    #[test]
    fn derivatives_equal_those_of_candle() {
        for (m, k, n) in [(50, 130, 32), (1, 64, 32), (50, 32, 1), (9, 9, 9)] {
            let [a, b] = [matrix(m, k, 0.1), matrix(k, n, 0.7)].map(|x| Var::from_tensor(&x).unwrap());
            let derivatives = |product: Tensor| product.sin().unwrap().sum_all().unwrap().backward().unwrap();
            let expected = derivatives(a.matmul(&b).unwrap());
            let found = derivatives(product(&a, &b, Left::Features).unwrap());
            for factor in [&a, &b] {
                assert!(largest_difference(found.get(factor).unwrap(), expected.get(factor).unwrap()) < 1e-12);
            }
            let found = derivatives(product(&a, &b, Left::Data).unwrap());
            assert!(found.get(&a).is_none());
            assert!(largest_difference(found.get(&b).unwrap(), expected.get(&b).unwrap()) < 1e-12);
        }
    }

    #[test]
    fn factors_that_do_not_fit_are_refused() {
        assert!(product(&matrix(2, 3, 0.0), &matrix(4, 2, 0.0), Left::Data).is_err());
        let single = matrix(3, 2, 0.0).to_dtype(DType::F32).unwrap();
        assert!(product(&matrix(2, 3, 0.0), &single, Left::Data).is_err());
    }
}
