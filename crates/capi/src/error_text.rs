use core::ffi::c_char;
use core::fmt::{self, Write};

/// The text ends with a NUL; a longer one is cut.
pub(crate) struct ErrorText {
    start: *mut c_char,
    free: usize,
}

impl ErrorText {
    /// Creates an empty text.
    ///
    /// # Safety
    /// `start` is null or points to `size` writable bytes.
    #[allow(unsafe_code, reason = "the buffer is the caller's")]
    pub(crate) unsafe fn new(start: *mut c_char, size: usize) -> Self {
        if start.is_null() || size == 0 {
            return Self { start, free: 0 };
        }
        // SAFETY: there is at least one byte.
        unsafe { start.write(0) };
        Self { start, free: size - 1 }
    }
}

impl Write for ErrorText {
    #[allow(unsafe_code, reason = "the buffer is the caller's")]
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let mut end = text.len().min(self.free);
        while !text.is_char_boundary(end) {
            end -= 1;
        }
        if end > 0 {
            // SAFETY: `free` bytes and one for the NUL are left after `start`, and `end <= free`.
            unsafe {
                self.start.copy_from_nonoverlapping(text.as_ptr().cast(), end);
                self.start = self.start.add(end);
                self.start.write(0);
            }
        }
        self.free = if end < text.len() { 0 } else { self.free - end };
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[allow(unsafe_code, reason = "the buffer is a pointer")]
    fn a_text_is_cut_between_characters_and_terminated() {
        let mut buffer = [0x55 as c_char; 8];
        // SAFETY: the buffer has 8 bytes, more than 6.
        let mut text = unsafe { ErrorText::new(buffer.as_mut_ptr(), 6) };
        assert!(text.write_str("abcdéef").is_ok());
        assert_eq!(buffer.map(|byte| byte as u8), *b"abcd\0\x55\x55\x55");
        // SAFETY: there is no buffer.
        let mut none = unsafe { ErrorText::new(core::ptr::null_mut(), 6) };
        assert!(none.write_str("nowhere").is_ok());
    }
}
