use std::panic::AssertUnwindSafe;

use super::controls;
use super::frame::{frame, picture, table};
use super::map::mapped;
use super::pair::{Pair, PairMaker, SCHEMES};
use super::protocol::{Export, File, Request, ServerMessage, Show};
use super::push::Push;
use super::state::{Catalogue, StateError};
use trocar_report::ColumnFormat;
use trocar_report::draw::FigureWidth;
use trocar_studies::compare::NoiseCheck;
use trocar_studies::run::{run, trace_table};

pub(super) struct Page {
    maker: PairMaker,
    shown: Option<(Show, Pair)>,
    /// `None` before they are complete.
    noise: Option<Vec<NoiseCheck>>,
    push: Option<Push>,
}

impl Page {
    pub(super) fn new(catalogue: Catalogue) -> Self {
        Self { maker: PairMaker::new(catalogue), shown: None, noise: None, push: None }
    }

    /// `None` if there is nothing to answer. `clock` returns the time in s.
    pub(super) fn answer(&mut self, request: Request, clock: &dyn Fn() -> f64) -> Option<ServerMessage> {
        let id = request.id();
        or_panicked(id, || self.answer_or_panic(request, clock).map(|answer| or_refused(id, answer)))
    }

    fn answer_or_panic(
        &mut self,
        request: Request,
        clock: &dyn Fn() -> f64,
    ) -> Option<Result<ServerMessage, StateError>> {
        match request {
            Request::Open { id, scenario } => Some(controls::values(id, &scenario, &mut self.maker)),
            Request::Show(show) => Some(self.show(show, clock)),
            Request::Noise { id } => self.noise(id),
            Request::Map(request) => Some(mapped(&request, &mut self.maker)),
            Request::Export(export) => Some(self.export(&export)),
            Request::Push { id, state, augmented } => {
                let begun = Push::begin(id, (&state, augmented), &mut self.maker, clock());
                Some(begun.map(|(push, opening)| {
                    self.push = Some(push);
                    opening
                }))
            }
            Request::Aim { id, m } => {
                let mut push = self.push.take_if(|push| push.id == id)?;
                push.aim(m);
                match push.moved(clock()) {
                    Ok(Some(moved)) => {
                        self.push = Some(push);
                        Some(Ok(moved))
                    }
                    Ok(None) => Some(push.result()),
                    Err(error) => Some(Err(error)),
                }
            }
            Request::Stop { id } => {
                let push = self.push.take_if(|push| push.id == id)?;
                Some(push.result())
            }
        }
    }

    fn show(&mut self, show: Show, clock: &dyn Fn() -> f64) -> Result<ServerMessage, StateError> {
        let began_s = clock();
        let same = |shown: &(Show, Pair)| shown.0.state == show.state;
        let pair = match self.shown.take().filter(same) {
            Some((_, pair)) => pair,
            None => {
                self.noise = None;
                self.maker.run(&show.state)?
            }
        };
        let frame = frame(&pair, self.noise.as_deref().unwrap_or_default(), &show, &|| clock() - began_s);
        self.shown = Some((show, pair));
        Ok(ServerMessage::Frame(frame?))
    }

    /// Completes the table of the last pair.
    fn noise(&mut self, id: u32) -> Option<Result<ServerMessage, StateError>> {
        let (_, pair) = self.shown.as_ref().filter(|(show, _)| show.id == id && self.noise.is_none())?;
        // Not repeated after a failure.
        let noise = self.noise.insert(vec![]);
        Some(pair.in_noise().map_err(StateError::from).map(|checks| {
            *noise = checks;
            let table = table(&pair.runs, noise);
            ServerMessage::json(&serde_json::json!({ "type": "table", "id": id, "table": table }))
        }))
    }

    fn export(&mut self, export: &Export) -> Result<ServerMessage, StateError> {
        let scenario = self.maker.written(&export.state, export.augmented)?;
        let which = usize::from(export.augmented);
        // All files of a scenario can be saved into one folder.
        let name = &scenario.name;
        let name = if name.ends_with(SCHEMES[which]) { name.clone() } else { format!("{name}_{}", SCHEMES[which]) };
        let (extension, content) = match export.file {
            File::Toml => ("toml", scenario.echo()),
            File::Csv => {
                let run = run(scenario)?;
                let mut bytes = vec![];
                // Writing to memory does not fail; the CSV is ASCII.
                let _ = ColumnFormat::Csv.write(&trace_table(&run.trace, |_| true), &mut bytes);
                ("csv", String::from_utf8(bytes).unwrap_or_default())
            }
            File::Png => {
                let width = export.width.as_deref().map_or(Ok(FigureWidth::default()), str::parse);
                let width = width.map_err(StateError::Width)?;
                let pair = self.maker.run(&export.state)?;
                let file = (export.id, format!("{name}.png"));
                return Ok(ServerMessage::Frame(picture(&pair.runs, which, file, (export.window, width))?));
            }
        };
        Ok(ServerMessage::json(&serde_json::json!({
            "type": "file",
            "id": export.id,
            "name": format!("{name}.{extension}"),
            "content": content,
        })))
    }
}

fn or_refused(id: u32, answer: Result<ServerMessage, StateError>) -> ServerMessage {
    answer.unwrap_or_else(|reason| ServerMessage::refused_for(id, &reason, &reason.reasons()))
}

/// A panic becomes a refusal, and the next request computes everything anew.
fn or_panicked(id: u32, answer: impl FnOnce() -> Option<ServerMessage>) -> Option<ServerMessage> {
    // A panic leaves the state of the last complete answer, or a state that is computed again.
    std::panic::catch_unwind(AssertUnwindSafe(answer)).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
        let text = text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
        let reason = format!(
            "trocar failed with these values because of an internal error: {text}. Use other values, and please \
             report the error with the link of this page."
        );
        Some(ServerMessage::refused(id, &reason))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::explore::state::State;

    fn message(answer: Option<ServerMessage>) -> serde_json::Value {
        let Some(ServerMessage::Text(text)) = answer else { panic!("a text") };
        serde_json::from_str(&text).expect("JSON")
    }

    #[test]
    fn a_page_gets_an_error_after_a_panic_and_continues() {
        let mut page = Page::new(Catalogue::new(None));
        let show = |id| {
            let state = State { scenario: "builtin:layers/skin-augmented.toml".into(), ..State::default() };
            Request::Show(Show { id, state, points: 400, window: Default::default() })
        };
        let refused = message(page.answer(show(7), &|| panic!("no such lane")));
        assert_eq!((&refused["type"], &refused["id"]), (&"refused".into(), &7.into()));
        assert!(refused["message"].as_str().is_some_and(|text| text.contains("no such lane")), "{refused}");
        assert!(matches!(page.answer(show(8), &|| 0.0), Some(ServerMessage::Frame(_))));
        assert_eq!(message(page.answer(Request::Noise { id: 8 }, &|| 0.0))["type"], "table");
        assert!(page.answer(Request::Noise { id: 8 }, &|| 0.0).is_none(), "it is complete");
        assert!(page.answer(Request::Aim { id: 8, m: 0.01 }, &|| 0.0).is_none(), "there is no insertion");
    }
}
