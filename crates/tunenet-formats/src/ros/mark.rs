//! The four bytes before every message in CDR, which say how its numbers are written.

use crate::format::{WITH_LOGS, ZSTD};

/// In which order the bytes of a number stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Order {
    Big,
    Little,
}

/// What the mark of a message says, and the bytes behind it.
pub(super) fn body(data: &[u8]) -> std::result::Result<(Order, &[u8]), String> {
    if data.starts_with(ZSTD) {
        return Err(format!("is compressed with zstd, message by message: {WITH_LOGS}"));
    }
    let (mark, body) = data.split_at_checked(4).ok_or_else(|| format!("expected CDR, found {} bytes", data.len()))?;
    match (mark[0], mark[1]) {
        (0, 0) => Ok((Order::Big, body)),
        (0, 1) => Ok((Order::Little, body)),
        (first, second) => Err(format!("expected plain CDR (00 00 or 00 01), found {first:02x} {second:02x}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mark_says_the_order_of_bytes() {
        assert_eq!(body(&[0, 0, 9, 9, 1]), Ok((Order::Big, &[1][..])));
        assert_eq!(body(&[0, 1, 0, 0]), Ok((Order::Little, &[][..])));
        assert_eq!(body(&[0, 1, 0]).unwrap_err(), "expected CDR, found 3 bytes");
        assert_eq!(body(&[0, 7, 0, 0]).unwrap_err(), "expected plain CDR (00 00 or 00 01), found 00 07");
        let compressed = body(&[0x28, 0xb5, 0x2f, 0xfd, 0x24, 0x85]).unwrap_err();
        assert!(compressed.contains("compressed with zstd") && compressed.contains("feature `logs`"), "{compressed}");
    }
}
