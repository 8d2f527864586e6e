//! Matrix products on the thread that asks for them.
//!
//! The largest product here is some 50 × 2100 × 32: handing it to other threads costs more than it saves, takes cores from
//! the rollouts beside it, and would leave the order of sums to the number of threads. candle's own product reads
//! `/proc/cpuinfo` every time to count the cores, which takes longer than most of these products; so nalgebra does them.

use candle_core::{CpuStorage, CustomOp2, InplaceOp3, Layout, Shape, Tensor};
use nalgebra::{DMatrixView, DMatrixViewMut, Dyn, RealField};

/// `a b`, shapes `[m, k]` and `[k, n]`, either of them possibly a transposed view.
pub(super) fn product(a: &Tensor, b: &Tensor) -> candle_core::Result<Tensor> {
    a.apply_op2_no_bwd(b, &Product)
}

/// `sum ← keep · sum + a b`, `sum` being contiguous.
pub(super) fn product_into(sum: &Tensor, a: &Tensor, b: &Tensor, keep: f32) -> candle_core::Result<()> {
    sum.inplace_op3(a, b, &Into { keep })
}

struct Product;

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
        let numbers = shape.0 * shape.1;
        let storage = match (a, b) {
            (CpuStorage::F32(a), CpuStorage::F32(b)) => {
                let mut product = vec![0.0; numbers];
                multiply(&mut product, shape, (a, a_layout), (b, b_layout), 0.0);
                CpuStorage::F32(product)
            }
            (CpuStorage::F64(a), CpuStorage::F64(b)) => {
                let mut product = vec![0.0; numbers];
                multiply(&mut product, shape, (a, a_layout), (b, b_layout), 0.0);
                CpuStorage::F64(product)
            }
            _ => candle_core::bail!("a product of numbers of one precision, single or double"),
        };
        Ok((storage, shape.into()))
    }
}

struct Into {
    keep: f32,
}

impl InplaceOp3 for Into {
    fn name(&self) -> &'static str {
        "product-into"
    }

    fn cpu_fwd(
        &self,
        sum: &mut CpuStorage,
        sum_layout: &Layout,
        a: &CpuStorage,
        a_layout: &Layout,
        b: &CpuStorage,
        b_layout: &Layout,
    ) -> candle_core::Result<()> {
        let shape = shape(a_layout, b_layout)?;
        let Some((start, end)) = sum_layout.contiguous_offsets().filter(|_| sum_layout.dims() == [shape.0, shape.1])
        else {
            candle_core::bail!("a sum of shape {:?} for a product of {shape:?}", sum_layout.shape());
        };
        match (sum, a, b) {
            (CpuStorage::F32(sum), CpuStorage::F32(a), CpuStorage::F32(b)) => {
                multiply(&mut sum[start..end], shape, (a, a_layout), (b, b_layout), self.keep);
            }
            (CpuStorage::F64(sum), CpuStorage::F64(a), CpuStorage::F64(b)) => {
                multiply(&mut sum[start..end], shape, (a, a_layout), (b, b_layout), self.keep.into());
            }
            _ => candle_core::bail!("a sum of products of one precision, single or double"),
        }
        Ok(())
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

/// `product ← keep · product + a b`, row by row.
fn multiply<T: RealField + Copy>(
    product: &mut [T],
    (rows, columns): (usize, usize),
    a: (&[T], &Layout),
    b: (&[T], &Layout),
    keep: T,
) {
    let inner = a.1.dims()[1];
    if rows.min(columns).min(inner) > THIN {
        // What is row by row to candle is the transpose to nalgebra: productᵀ = bᵀ aᵀ.
        let mut product = DMatrixViewMut::from_slice(product, columns, rows);
        product.gemm(T::one(), &transposed(b), &transposed(a), keep);
    } else if columns > 0 {
        multiply_thin(product, columns, a, b, keep);
    }
}

fn transposed<'a, T: RealField>((values, layout): (&'a [T], &Layout)) -> DMatrixView<'a, T, Dyn, Dyn> {
    let (dims, stride) = (layout.dims(), layout.stride());
    let values = &values[layout.start_offset()..];
    DMatrixView::from_slice_with_strides(values, dims[1], dims[0], stride[1], stride[0])
}

fn multiply_thin<T: RealField + Copy>(
    product: &mut [T],
    columns: usize,
    (a, a_layout): (&[T], &Layout),
    (b, b_layout): (&[T], &Layout),
    keep: T,
) {
    let (a, b) = (&a[a_layout.start_offset()..], &b[b_layout.start_offset()..]);
    let (a_stride, b_stride) = (a_layout.stride(), b_layout.stride());
    for (i, row) in product.chunks_exact_mut(columns).enumerate() {
        for entry in row.iter_mut() {
            *entry = if keep == T::zero() { T::zero() } else { keep * *entry };
        }
        for k in 0..a_layout.dims()[1] {
            let factor = a[i * a_stride[0] + k * a_stride[1]];
            let line = &b[k * b_stride[0]..];
            // Side by side, they are multiplied several at once.
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
    use candle_core::{DType, Device};

    use super::*;

    fn matrix(rows: usize, columns: usize, start: f64) -> Tensor {
        let numbers: Vec<f64> = (0..rows * columns).map(|i| (start + i as f64).sin()).collect();
        Tensor::from_vec(numbers, (rows, columns), &Device::Cpu).unwrap()
    }

    /// Sum by sum, by hand.
    fn plain(a: &Tensor, b: &Tensor) -> Vec<Vec<f64>> {
        let (a, b) = (a.to_vec2::<f64>().unwrap(), b.to_vec2::<f64>().unwrap());
        let entry = |row: &[f64], column: usize| row.iter().zip(&b).map(|(x, line)| x * line[column]).sum();
        a.iter().map(|row| (0..b[0].len()).map(|column| entry(row, column)).collect()).collect()
    }

    fn close(found: &Tensor, expected: &[Vec<f64>], tolerance: f64) {
        let found = found.to_dtype(DType::F64).unwrap().to_vec2::<f64>().unwrap();
        assert_eq!((found.len(), found[0].len()), (expected.len(), expected[0].len()));
        for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
            assert!((found - expected).abs() < tolerance, "{found} for {expected}");
        }
    }

    #[test]
    fn products_of_small_large_and_transposed_matrices() {
        for (m, k, n) in [(1, 1, 1), (3, 7, 2), (50, 130, 32), (1, 64, 32), (50, 32, 1), (9, 9, 9), (40, 3, 20)] {
            let (a, b) = (matrix(m, k, 0.1), matrix(k, n, 0.7));
            close(&product(&a, &b).unwrap(), &plain(&a, &b), 1e-12);
            let (at, bt) = (matrix(k, m, 0.3).t().unwrap(), matrix(n, k, 0.9).t().unwrap());
            close(&product(&at, &bt).unwrap(), &plain(&at, &bt), 1e-12);
            let single = |x: &Tensor| x.to_dtype(DType::F32).unwrap();
            close(&product(&single(&a), &single(&b)).unwrap(), &plain(&a, &b), 1e-4);
        }
    }

    #[test]
    fn a_part_of_a_matrix_is_a_factor_too() {
        let (a, b) = (matrix(6, 9, 0.2).narrow(1, 2, 4).unwrap(), matrix(4, 5, 0.4));
        close(&product(&a, &b).unwrap(), &plain(&a.contiguous().unwrap(), &b), 1e-12);
    }

    #[test]
    fn sums_keep_what_was_there() {
        let (a, b) = (matrix(4, 6, 0.1), matrix(6, 3, 0.2));
        let single = |x: &Tensor| x.to_dtype(DType::F32).unwrap();
        let sum = Tensor::ones((4, 3), DType::F32, &Device::Cpu).unwrap();
        product_into(&sum, &single(&a), &single(&b), 1.0).unwrap();
        let expected: Vec<Vec<f64>> = plain(&a, &b).iter().map(|row| row.iter().map(|x| x + 1.0).collect()).collect();
        close(&sum, &expected, 1e-5);
        product_into(&sum, &single(&a), &single(&b), 0.0).unwrap();
        close(&sum, &plain(&a, &b), 1e-5);
    }

    #[test]
    fn factors_that_do_not_fit_are_refused() {
        assert!(product(&matrix(2, 3, 0.0), &matrix(4, 2, 0.0)).is_err());
        let sum = Tensor::zeros((2, 2), DType::F32, &Device::Cpu).unwrap();
        let single = |x: Tensor| x.to_dtype(DType::F32).unwrap();
        assert!(product_into(&sum, &single(matrix(2, 3, 0.0)), &single(matrix(3, 3, 0.0)), 1.0).is_err());
    }
}
