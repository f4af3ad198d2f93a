use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};

use crate::ScenarioError;

/// The message with its line underlined, styled for a terminal. Further errors follow.
pub fn underlined(error: &ScenarioError) -> String {
    let all: Vec<String> = std::iter::once(error).chain(&error.others).map(single).collect();
    all.join("\n")
}

fn single(error: &ScenarioError) -> String {
    let mut group =
        Level::ERROR.primary_title(error.message.as_str()).elements(Vec::<annotate_snippets::Element<'_>>::new());
    if let Some(place) = &error.place {
        let span = clamped(&place.text, place.span.clone());
        let snippet = Snippet::source(&*place.text).path(&*place.file).annotation(AnnotationKind::Primary.span(span));
        group = group.element(snippet);
    }
    if let Some(remedy) = &error.remedy {
        group = group.element(Level::HELP.message(remedy.as_str()));
    }
    Renderer::styled().render(&[group])
}

fn clamped(text: &str, span: std::ops::Range<usize>) -> std::ops::Range<usize> {
    let inside = |mut at: usize| {
        at = at.min(text.len());
        while !text.is_char_boundary(at) {
            at -= 1;
        }
        at
    };
    let start = inside(span.start);
    start..inside(span.end).max(start)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Place;

    #[test]
    fn the_line_is_underlined_and_the_remedy_is_given() {
        let place = Place { file: "a.toml".into(), text: "[slave]\nvelocity_gain = -2\n".into(), span: 24..26 };
        let error = ScenarioError::new("slave.velocity_gain is -2").at(Some(place)).remedy("use 15");
        let shown = anstream::adapter::strip_str(&underlined(&error)).to_string();
        assert!(shown.contains("a.toml:2:17"), "{shown}");
        assert!(shown.contains("^^"), "{shown}");
        assert!(shown.contains("help: use 15"), "{shown}");
    }

    #[test]
    fn a_span_beyond_the_text_is_clamped() {
        let place = Place { file: "a.toml".into(), text: "µ".into(), span: 1..90 };
        assert!(underlined(&ScenarioError::new("no").at(Some(place))).contains("no"));
    }
}
