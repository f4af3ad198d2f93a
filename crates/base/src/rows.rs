use crate::large_pages::with_capacity;

/// Rows per block. Long columns begin at the same offset in a page, so alternate writes would evict each other from the
/// cache.
pub const AT_ONCE: usize = 64;

#[derive(Debug)]
pub struct Rows<const N: usize> {
    block: [[f64; AT_ONCE]; N],
    filled: usize,
    is_kept: [bool; N],
    columns: [Vec<f64>; N],
}

impl<const N: usize> Rows<N> {
    pub fn new(count: usize, is_kept: [bool; N]) -> Self {
        let columns = is_kept.map(|is_kept| if is_kept { with_capacity(count) } else { vec![] });
        Self { block: [[0.0; AT_ONCE]; N], filled: 0, is_kept, columns }
    }

    #[inline(always)]
    pub fn push(&mut self, row: [f64; N]) {
        // Shows the compiler that the index is within the block.
        let at = self.filled % AT_ONCE;
        self.block.iter_mut().zip(row).for_each(|(values, value)| values[at] = value);
        self.filled = at + 1;
        if self.filled == AT_ONCE {
            self.append();
        }
    }

    #[inline(never)]
    fn append(&mut self) {
        for ((column, values), _) in
            self.columns.iter_mut().zip(&self.block).zip(self.is_kept).filter(|(_, kept)| *kept)
        {
            column.extend_from_slice(&values[..self.filled]);
        }
        self.filled = 0;
    }

    pub fn into_columns(mut self) -> [Vec<f64>; N] {
        self.append();
        self.columns
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_columns_contain_the_rows() {
        for count in [0, 1, AT_ONCE - 1, AT_ONCE, AT_ONCE + 1, 3 * AT_ONCE + 7] {
            let mut rows = Rows::new(count, [true, false, true]);
            (0..count).for_each(|row| rows.push([row as f64, -1.0, 2.0 * row as f64]));
            let [first, dropped, last] = rows.into_columns();
            assert_eq!(first, (0..count).map(|row| row as f64).collect::<Vec<_>>());
            assert_eq!(last, first.iter().map(|value| 2.0 * value).collect::<Vec<_>>());
            assert!(dropped.is_empty());
        }
    }
}
