/// Minimum size in bytes, as in numpy.
const LARGE: usize = 4 << 20;

/// Mapping a long column in pages of 4 KB takes longer than most computations on it.
pub fn with_capacity<T>(count: usize) -> Vec<T> {
    let column = Vec::with_capacity(count);
    request_large_pages(&column);
    column
}

pub fn copy_of<T: Copy>(values: &[T]) -> Vec<T> {
    let mut copy = with_capacity(values.len());
    copy.extend_from_slice(values);
    copy
}

#[cfg(target_os = "linux")]
#[allow(unsafe_code, reason = "a system call")]
fn request_large_pages<T>(column: &Vec<T>) {
    const PAGE: usize = 1 << 16;
    let length = column.capacity() * size_of::<T>();
    let skipped = column.as_ptr().align_offset(PAGE).saturating_mul(size_of::<T>());
    if length >= LARGE && skipped < length {
        // SAFETY: the range lies within the vector's memory. The advice changes neither its content nor its owner; a
        // system without large pages returns an error, which has no effect.
        unsafe {
            let begin = column.as_ptr().cast_mut().cast::<u8>().add(skipped);
            libc::madvise(begin.cast(), length - skipped, libc::MADV_HUGEPAGE);
        }
    }
}

#[cfg(not(target_os = "linux"))]
fn request_large_pages<T>(_column: &Vec<T>) {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_column_has_its_capacity_and_its_values() {
        let column: Vec<f64> = with_capacity(1 << 20);
        assert!(column.is_empty() && column.capacity() >= 1 << 20);
        let values: Vec<f64> = (0..1 << 20).map(f64::from).collect();
        assert_eq!(copy_of(&values), values);
        assert!(copy_of::<u8>(&[]).is_empty());
    }
}
