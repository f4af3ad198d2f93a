use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};
use thiserror::Error;

use super::description::describe;
use super::variables::Model;
use super::version::Version;
use trocar_scenario::{Scenario, ScenarioError, Source, Values};

/// Description and library compute it from the scenario.
pub fn token(model: Model, scenario: &str) -> String {
    let hash = Sha256::new().chain_update(model.identifier()).chain_update([0]).chain_update(scenario).finalize();
    let mut text = String::from("{");
    for (place, byte) in hash.iter().take(16).enumerate() {
        if [4, 6, 8, 10].contains(&place) {
            text.push('-');
        }
        let _ = write!(text, "{byte:02x}");
    }
    text + "}"
}

#[derive(Debug, Error)]
pub enum UnitError {
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    #[error("{}: {source}", path.display())]
    File {
        /// A file of the scenario.
        path: PathBuf,
        source: std::io::Error,
    },
    #[error("{0} on a rig; export the simulation instead, without --rig")]
    Rig(#[from] trocar_core::error::InvalidValue),
}

const PAGE: &str = "<!DOCTYPE html><html lang=\"en\"><meta charset=\"utf-8\"><title>trocar</title>\n\
    <p>This unit was written by <code>trocar export fmu</code>. Its scenario is in <code>resources</code>, and runs with \
    <code>trocar run</code> too. The source of its library is the package <code>trocar-fmu</code> of trocar, of the version in \
    <code>modelDescription.xml</code>: <code>cargo build --release</code> builds it.\n\
    <p>A step from t to t + h reads the inputs of t; after it, the outputs are those of the last tick before t + h. A step is a \
    whole number of ticks. Parameters are the keys of scenarios, with their values as defaults. What is derived from a changed \
    parameter, and is not changed itself, follows it.\n";

/// The licences are not included.
#[derive(Debug)]
pub struct Unit {
    pub files: Vec<(String, Vec<u8>)>,
}

impl Unit {
    /// `library` is for this machine.
    pub fn new(
        source: &Source,
        settings: &[String],
        which: (Model, Version),
        library: Vec<u8>,
    ) -> Result<Self, UnitError> {
        Self::of_changed(source, &[settings], which, library)
    }

    /// The lists of settings apply one after another.
    pub fn of_changed(
        source: &Source,
        settings: &[&[String]],
        (model, version): (Model, Version),
        library: Vec<u8>,
    ) -> Result<Self, UnitError> {
        let mut values = Values::load_changed(source, settings)?;
        let mut files = vec![];
        for (path, content) in values.take_files() {
            let bytes = std::fs::read(&content).map_err(|source| UnitError::File { path: content, source })?;
            files.push((format!("resources/{path}"), bytes));
        }
        let text = values.to_toml();
        let scenario = Scenario::load_changed(source, settings)?;
        if model == Model::Rig {
            scenario.rig_settings().validate()?;
        }
        files.push((format!("resources/{}", model.file()), text.clone().into_bytes()));
        let variables = model.variables(&scenario);
        let description = describe(model, version, &scenario, &variables, &token(model, &text));
        files.push(("modelDescription.xml".into(), description.into_bytes()));
        files.push(("documentation/index.html".into(), PAGE.into()));
        let name = Path::new(model.identifier()).with_extension(std::env::consts::DLL_EXTENSION);
        files.push((format!("binaries/{}/{}", version.platform(), name.display()), library));
        Ok(Self { files })
    }
}
