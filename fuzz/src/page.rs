//! Messages of a page.

pub fn message(content: &[u8]) {
    if let Ok(text) = std::str::from_utf8(content) {
        trocar::read_message(text);
    }
}
