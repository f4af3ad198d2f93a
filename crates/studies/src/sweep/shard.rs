use std::ops::Range;
use std::str::FromStr;

/// Part `index` of `count`, both from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    index: u64,
    count: u64,
}

impl Shard {
    pub const WHOLE: Self = Self { index: 1, count: 1 };

    pub fn is_whole(&self) -> bool {
        self.count == 1
    }

    /// Consecutive shards leave no gap.
    pub fn range(&self, packs: u64) -> Range<u64> {
        let end = |index: u64| (u128::from(packs) * u128::from(index) / u128::from(self.count)) as u64;
        end(self.index - 1)..end(self.index)
    }

    pub fn folder(&self) -> String {
        format!("shard-{}-of-{}", self.index, self.count)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let must = || "must be i/n with 1 <= i <= n <= 1000000, as in 3/8".to_owned();
        let (index, count) = text.split_once('/').ok_or_else(must)?;
        let (index, count) = (index.parse().map_err(|_| must())?, count.parse().map_err(|_| must())?);
        if (1..=count).contains(&index) && count <= 1_000_000 { Ok(Self { index, count }) } else { Err(must()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_disjoint_and_complete() {
        for packs in [0, 1, 5, 125_000] {
            for count in [1, 2, 3, 8, 1000] {
                let mut next = 0;
                for index in 1..=count {
                    let range = Shard { index, count }.range(packs);
                    assert_eq!(range.start, next);
                    next = range.end;
                }
                assert_eq!(next, packs);
            }
        }
    }

    #[test]
    fn invalid_shards_are_rejected() {
        assert_eq!("2/4".parse(), Ok(Shard { index: 2, count: 4 }));
        for wrong in ["", "1", "0/2", "3/2", "1/0", "-1/2", "1/2/3", "a/b", "1/1000001"] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
    }
}
