use super::DetectArgs;
use super::inputs::given;
use crate::cli::error::Failure;
use crate::cli::{recorded, terminal};
use trocar_detect::document::signals_document;
use trocar_document::to_json;
use trocar_report::document_text;
use trocar_scenario::recording_signals;

pub(super) fn run(args: &DetectArgs) -> Result<(), Failure> {
    let mut objects = vec![];
    for (index, recording) in given(args)?.iter().enumerate() {
        let mut values = recorded::load(recording, &args.settings(Some(recording)))?;
        let signals = recording_signals(&mut values).map_err(recorded::placed(recording))?;
        let document = signals_document(recording, &signals);
        if args.output.json {
            objects.push(document.json);
        } else {
            let gap = if index == 0 { "" } else { "\n" };
            terminal::print(&format!("{gap}{}", document_text(&document, false)))?;
        }
    }
    if args.output.json {
        // Print the signals of one recording as an object, and of several as a list.
        let document = if objects.len() == 1 { objects.remove(0) } else { objects.into() };
        terminal::print(&to_json(&document))?;
    }
    Ok(())
}
