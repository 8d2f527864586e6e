//! One record: its length and checksum, then the request and its answer, all little-endian.
//!
//! | bytes | content |
//! |---|---|
//! | 4 | length of what follows the checksum |
//! | 8 | the first bytes of the SHA-256 of what follows |
//! | 8 each | variant, recording, samples, how many values the request has |
//! | 8 each | the bits of these values, then of the numbers of the answer |

use sha2::{Digest, Sha256};
use tunenet_core::observation::GREATEST;
use tunenet_core::tune::Request;

/// Length and checksum.
pub(super) const HEAD: usize = 4 + CHECKSUM;
const CHECKSUM: usize = 8;
/// Numbers before the values of a request.
const FIXED: usize = 4;

/// What a record says.
pub(super) struct Record {
    pub request: Request,
    /// Numbers of the answer, which are the last of the record.
    pub numbers: usize,
}

/// The bytes of a record; `None` where its length has no place in 4 bytes.
pub(super) fn encode(request: &Request, answer: &[f64]) -> Option<Vec<u8>> {
    let fixed = [request.variant, request.recording, request.samples, request.values.len()];
    let fixed = fixed.iter().map(|&number| number as u64);
    let all = fixed.chain(request.values.iter().copied()).chain(answer.iter().map(|value| value.to_bits()));
    let body: Vec<u8> = all.flat_map(u64::to_le_bytes).collect();
    let length = u32::try_from(body.len()).ok()?;
    Some([length.to_le_bytes().as_slice(), &checksum(&body), &body].concat())
}

/// The length of the body that follows this head.
pub(super) fn length(head: &[u8; HEAD]) -> u64 {
    u32::from_le_bytes([head[0], head[1], head[2], head[3]]).into()
}

/// Whether a body is as it was written.
pub(super) fn is_whole(head: &[u8; HEAD], body: &[u8]) -> bool {
    head[4..] == checksum(body)
}

/// What a body says, if it is the answer to a rollout of so many channels.
pub(super) fn decode(body: &[u8], channels: usize) -> Option<Record> {
    let mut numbers = words(body)?;
    let mut fixed = [0; FIXED];
    for number in &mut fixed {
        *number = usize::try_from(numbers.next()?).ok()?;
    }
    let [variant, recording, samples, count] = fixed;
    if numbers.len() != count.checked_add(samples.checked_mul(channels)?)? {
        return None;
    }
    let values = numbers.by_ref().take(count).collect();
    let all = numbers.len();
    let usable = numbers.map(f64::from_bits).all(|value| value.abs() <= GREATEST);
    usable.then_some(Record { request: Request { variant, recording, samples, values }, numbers: all })
}

/// The numbers of an answer.
pub(super) fn answer(bytes: &[u8]) -> Option<Vec<f64>> {
    Some(words(bytes)?.map(f64::from_bits).collect())
}

/// Bytes as whole numbers; `None` where they end within one.
fn words(bytes: &[u8]) -> Option<impl ExactSizeIterator<Item = u64>> {
    let (words, []) = bytes.as_chunks::<8>() else { return None };
    Some(words.iter().map(|word| u64::from_le_bytes(*word)))
}

fn checksum(body: &[u8]) -> [u8; CHECKSUM] {
    let hash = Sha256::digest(body);
    std::array::from_fn(|i| hash[i])
}
