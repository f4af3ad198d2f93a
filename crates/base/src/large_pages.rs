//! Long columns in large pages.

/// Smallest size in bytes for which large pages are requested, as numpy does.
const LARGE: usize = 4 << 20;

/// An empty vector with capacity for `count` values, in large pages where the system has them on request.
///
/// In pages of 4 KB, the system takes longer to give a long column its pages than most computations to fill them.
#[must_use]
pub fn with_capacity<T>(count: usize) -> Vec<T> {
    let column = Vec::with_capacity(count);
    request_large_pages(&column);
    column
}

/// A copy of values in a vector of [`with_capacity`].
#[must_use]
pub fn copy_of<T: Copy>(values: &[T]) -> Vec<T> {
    let mut copy = with_capacity(values.len());
    copy.extend_from_slice(values);
    copy
}

#[cfg(target_os = "linux")]
#[allow(unsafe_code, reason = "a system call")]
fn request_large_pages<T>(column: &Vec<T>) {
    /// Multiple of the size of a page on every machine.
    const PAGE: usize = 1 << 16;
    let length = column.capacity() * size_of::<T>();
    let skipped = column.as_ptr().align_offset(PAGE).saturating_mul(size_of::<T>());
    if length >= LARGE && skipped < length {
        // SAFETY: the range is within the vector's own memory, and the advice changes neither its content nor its owner. A system
        // without large pages refuses, and nothing changes.
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
    fn a_long_column_has_room_and_its_values() {
        let column: Vec<f64> = with_capacity(1 << 20);
        assert!(column.is_empty() && column.capacity() >= 1 << 20);
        let values: Vec<f64> = (0..1 << 20).map(f64::from).collect();
        assert_eq!(copy_of(&values), values);
        assert!(copy_of::<u8>(&[]).is_empty());
    }
}
