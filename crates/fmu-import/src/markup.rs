//! Checks XML before a library reads it: the time of the library grows with the square of the number of attributes of an
//! element and of namespaces, and its memory with the number of attributes.

/// Counts the attributes of XML that arrives in pieces.
#[derive(Debug)]
pub(crate) struct Markup {
    most: usize,
    is_tag: bool,
    quote: Option<u8>,
    /// Number of attributes of the present element.
    of_element: usize,
    attributes: usize,
    namespaces: usize,
    /// Number of bytes of the word `xmlns` that were read; `None` inside of other words.
    matched: Option<usize>,
}

/// The word that declares a namespace.
const NAMESPACE: &[u8] = b"xmlns";

impl Markup {
    /// Creates a check that an element has at most `most` attributes.
    #[must_use]
    pub(crate) fn new(most: usize) -> Self {
        Self { most, is_tag: false, quote: None, of_element: 0, attributes: 0, namespaces: 0, matched: None }
    }

    /// Reads the next bytes; `None` if an element has too many attributes.
    #[must_use]
    pub(crate) fn push(&mut self, bytes: &[u8]) -> Option<()> {
        for &byte in bytes {
            match (self.quote, byte) {
                (Some(quote), _) if byte == quote => self.quote = None,
                (Some(_), _) => {}
                (None, b'<') => (self.is_tag, self.of_element) = (true, 0),
                (None, b'>') => self.is_tag = false,
                (None, b'"' | b'\'') if self.is_tag => self.quote = Some(byte),
                // Also attributes without quotes count.
                (None, b'=') if self.is_tag => {
                    self.of_element += 1;
                    self.attributes += 1;
                }
                _ => {}
            }
            if self.is_tag && self.quote.is_none() {
                self.matched = match self.matched {
                    _ if byte.is_ascii_whitespace() => Some(0),
                    Some(matched) if NAMESPACE.get(matched) == Some(&byte) => Some(matched + 1),
                    _ => None,
                };
                self.namespaces += usize::from(self.matched == Some(NAMESPACE.len()));
            }
            if self.of_element > self.most {
                return None;
            }
        }
        Some(())
    }

    /// The number of attributes of all elements.
    #[must_use]
    pub(crate) fn attributes(&self) -> usize {
        self.attributes
    }

    /// The number of declarations of namespaces.
    #[must_use]
    pub(crate) fn namespaces(&self) -> usize {
        self.namespaces
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_element_with_many_attributes_is_refused() {
        let element = |count: usize| format!("<a>b=c{}</a><d {}/>", "=".repeat(1000), "e='>' ".repeat(count));
        assert!(Markup::new(20).push(element(20).as_bytes()).is_some());
        assert!(Markup::new(20).push(element(21).as_bytes()).is_none());
    }

    #[test]
    fn attributes_and_namespaces_are_counted_across_pieces() {
        let text = "<a xmlns='u' xmlns:b=\"xmlns\" c='xmlns'>xmlns <d exmlns='' xml=''/></a>";
        for size in 1..9 {
            let mut markup = Markup::new(9);
            text.as_bytes().chunks(size).for_each(|piece| markup.push(piece).expect("few"));
            assert_eq!((markup.attributes(), markup.namespaces()), (5, 2), "{size}");
        }
    }
}
