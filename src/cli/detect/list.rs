//! The signals of recordings.

use super::DetectArgs;
use super::inputs::given;
use crate::cli::error::CliError;
use crate::cli::{recorded, terminal};
use trocar_report::{signals_object, signals_text, to_json};
use trocar_scenario::recording_signals;

pub(super) fn run(args: &DetectArgs) -> Result<(), CliError> {
    let mut objects = vec![];
    for (index, recording) in given(args)?.iter().enumerate() {
        let mut values = recorded::load(recording, &args.settings(Some(recording)))?;
        let signals = recording_signals(&mut values).map_err(recorded::placed(recording))?;
        if args.output.json {
            objects.push(signals_object(recording, &signals));
        } else {
            let gap = if index == 0 { "" } else { "\n" };
            terminal::print(&format!("{gap}{}", signals_text(recording, &signals)))?;
        }
    }
    if args.output.json {
        // One document: the signals of one recording, or a list of several.
        let document = if objects.len() == 1 { objects.remove(0) } else { objects.into() };
        terminal::print(&to_json(&document))?;
    }
    Ok(())
}
