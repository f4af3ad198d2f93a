use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use trocar_base::names;

#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    pub file: Arc<str>,
    pub text: Arc<str>,
    /// Byte range.
    pub span: Range<usize>,
}

impl Place {
    /// Counts from 1.
    pub fn line_and_column(&self) -> (usize, usize) {
        let before = self.text.get(..self.span.start).unwrap_or(&self.text);
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().unwrap_or_default().chars().count() + 1;
        (line, column)
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct ScenarioError {
    /// With the value and the allowed range.
    pub message: String,
    pub place: Option<Place>,
    pub remedy: Option<String>,
    pub others: Box<[ScenarioError]>,
}

impl ScenarioError {
    /// Long words of the message are shortened.
    pub fn new(message: impl Into<String>) -> Self {
        let message = names::with_short_words(&message.into()).into_owned();
        Self { message, place: None, remedy: None, others: Box::default() }
    }

    pub fn at(mut self, place: Option<Place>) -> Self {
        self.place = place;
        self
    }

    /// Sorted by place: at most 20, because one mistake can cause many.
    pub(super) fn all(errors: Vec<Self>) -> Result<(), Self> {
        Self::all_by(errors, |error| error.place.as_ref(), |error| error)
    }

    /// As [`Self::all`], with errors that `error` creates for those that are shown.
    pub(super) fn all_by<T>(
        mut refused: Vec<T>,
        place: impl Fn(&T) -> Option<&Place>,
        error: impl Fn(T) -> Self,
    ) -> Result<(), Self> {
        const MAX_ERRORS: usize = 20;
        let file = |refused: &T| place(refused).map(|place| place.file.clone());
        for of_file in refused.chunk_by_mut(|a, b| file(a) == file(b)) {
            of_file.sort_by_key(|refused| place(refused).map(|place| place.span.start));
        }
        let omitted = refused.len().saturating_sub(MAX_ERRORS);
        refused.truncate(MAX_ERRORS);
        let mut errors: Vec<Self> = refused.into_iter().map(error).collect();
        if omitted > 0 {
            errors.push(Self::new(format!("and {omitted} more")));
        }
        let mut errors = errors.into_iter();
        let Some(first) = errors.next() else { return Ok(()) };
        Err(Self { others: errors.collect(), ..first })
    }

    pub fn remedy(mut self, remedy: impl Into<String>) -> Self {
        self.remedy = Some(names::with_short_words(&remedy.into()).into_owned());
        self
    }
}

impl fmt::Display for ScenarioError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(place) = &self.place {
            let (line, column) = place.line_and_column();
            write!(f, "{}:{line}:{column}: ", place.file)?;
        }
        f.write_str(&self.message)?;
        if let Some(remedy) = &self.remedy {
            write!(f, "; {remedy}")?;
        }
        self.others.iter().try_for_each(|other| write!(f, "\n{other}"))
    }
}

impl std::error::Error for ScenarioError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_and_columns_are_counted_as_in_an_editor() {
        let place = Place { file: "a.toml".into(), text: "x = 1\nµ = 2\n".into(), span: 9..11 };
        assert_eq!(place.line_and_column(), (2, 3));
        let error = ScenarioError::new("no").at(Some(place)).remedy("do");
        assert_eq!(error.to_string(), "a.toml:2:3: no; do");
    }
}
