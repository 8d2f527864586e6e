//! Static partition of numbered, independent pieces of work into equal shards.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::{Error, Origin, Result};

/// Share `index` of `count`, from 0: written `2/8`.
///
/// What a piece is drawn from depends on the seed and the piece's own number, never on the shard: shares of any count put
/// together are the whole work, bit for bit.
///
/// ```
/// use tunenet_core::network::Shard;
/// let shard: Shard = "1/3".parse()?;
/// assert_eq!(shard.block(10), 4..7);
/// assert_eq!((0..10).filter(|&piece| shard.takes(piece)).collect::<Vec<_>>(), [1, 4, 7]);
/// # Ok::<(), tunenet_core::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Shard {
    index: u32,
    count: u32,
}

impl Shard {
    /// The greatest number of shares.
    pub const MOST: u32 = 1_000_000;

    /// Share `index` of `count`.
    ///
    /// # Errors
    /// [`Error::Setting`] where `index` is not below `count`, or `count` is 0 or above [`Self::MOST`].
    pub fn new(index: u32, count: u32) -> Result<Self> {
        let refuse = |expected: String| {
            let found = format!("`{index}/{count}`");
            Err(Error::Setting { origin: Origin::Caller, name: "shard", expected, found })
        };
        if count == 0 || count > Self::MOST {
            return refuse(format!("1 to {} shards", Self::MOST));
        }
        if index >= count {
            return refuse(format!("a shard from 0/{count} to {}/{count}", count - 1));
        }
        Ok(Self { index, count })
    }

    /// Which, from 0.
    #[must_use]
    pub fn index(self) -> u32 {
        self.index
    }

    /// Of how many.
    #[must_use]
    pub fn count(self) -> u32 {
        self.count
    }

    /// A block of `total` pieces: those of all shards, one after the other, are the whole, and differ by at most one piece
    /// in length.
    #[must_use]
    pub fn block(self, total: u64) -> Range<u64> {
        let [index, count] = [self.index, self.count].map(u64::from);
        let (each, rest) = (total / count, total % count);
        let start = |index: u64| index * each + index.min(rest);
        start(index)..start(index + 1)
    }

    /// Whether piece `number`, from 0, is this shard's, where they are dealt out one by one.
    #[must_use]
    pub fn takes(self, number: u64) -> bool {
        number % u64::from(self.count) == u64::from(self.index)
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, to: &mut fmt::Formatter) -> fmt::Result {
        write!(to, "{}/{}", self.index, self.count)
    }
}

impl FromStr for Shard {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let number = |text: &str| text.trim().parse().ok();
        if let Some((Some(index), Some(count))) = text.split_once('/').map(|(i, n)| (number(i), number(n))) {
            return Self::new(index, count);
        }
        let (expected, found) = ("i/n with i from 0 to n − 1, such as 0/4".into(), format!("`{text}`"));
        Err(Error::Setting { origin: Origin::Caller, name: "shard", expected, found })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_the_whole_and_nearly_equal() {
        for total in [0, 1, 2, 7, 16, 800, 1_000_003] {
            for count in [1, 2, 3, 7, 64] {
                let shards: Vec<Shard> = (0..count).map(|index| Shard::new(index, count).unwrap()).collect();
                let mut end = 0;
                for shard in &shards {
                    let block = shard.block(total);
                    assert_eq!(block.start, end);
                    end = block.end;
                    let length = block.end - block.start;
                    let each = total / u64::from(count);
                    assert!(length == each || length == each + 1);
                }
                assert_eq!(end, total);
                for number in 0..total.min(100) {
                    assert_eq!(shards.iter().filter(|s| s.takes(number)).count(), 1);
                }
            }
        }
    }

    #[test]
    fn what_is_no_share_is_refused() {
        for text in ["4/4", "0/0", "-1/4", "1", "a/b", "", "1/2/3", "0/1000001", "1.0/4"] {
            let refused = text.parse::<Shard>().unwrap_err().to_string();
            assert!(refused.starts_with("`shard`: expected ") && refused.contains(text), "{refused}");
        }
        assert_eq!("3/4".parse::<Shard>().unwrap().to_string(), "3/4");
    }
}
