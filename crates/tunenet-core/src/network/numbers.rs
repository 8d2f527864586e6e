//! The numbers of a tensor, on the CPU and in single precision.

use std::ops::Range;

use candle_core::{CpuStorage, Layout};

/// In single precision, in which the network learns.
#[expect(clippy::cast_possible_truncation, reason = "losing digits is the point")]
pub(super) fn single(number: f64) -> f32 {
    number as f32
}

/// Where contiguous numbers stand.
pub(super) fn range(layout: &Layout) -> candle_core::Result<Range<usize>> {
    match layout.contiguous_offsets() {
        Some((start, end)) => Ok(start..end),
        None => candle_core::bail!("an operation in place needs contiguous numbers"),
    }
}

/// What an operation reads.
pub(super) fn slice<'a>(storage: &'a CpuStorage, layout: &Layout) -> candle_core::Result<&'a [f32]> {
    Ok(&storage.as_slice::<f32>()?[range(layout)?])
}

/// What an operation writes.
pub(super) fn slice_mut<'a>(storage: &'a mut CpuStorage, layout: &Layout) -> candle_core::Result<&'a mut [f32]> {
    match storage {
        CpuStorage::F32(values) => Ok(&mut values[range(layout)?]),
        _ => candle_core::bail!("an operation in place needs single precision"),
    }
}
