use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser};
use schemars::JsonSchema;
use serde_json::Value as Json;

use super::check::CheckedFile;
use super::error::Failure;
use super::scenarios::ShippedScenario;
use super::terminal;
use trocar_detect::calibration::CalibrationFile;
use trocar_detect::document::{DetectionFile, DetectionsFile, SignalsFile};
use trocar_document::{schema_of, to_json};
use trocar_identify::IdentificationFile;
use trocar_link::LinkFile;
use trocar_report::Manifest as FilesManifest;
use trocar_scenario::json_schema;
use trocar_studies::compare::{ComparisonFile, PaperFile, StrategiesFile};
use trocar_studies::design::{DesignResultFile, design_schema};
use trocar_studies::roc::RocFile;
use trocar_studies::run::RunFile;
use trocar_studies::stability_check::{CertificateFile, StabilityFile};
use trocar_studies::sweep::{Manifest, SweepFile, sweep_schema};

const EXAMPLES: &str = "\
Examples:
  trocar schema > trocar.schema.json
  trocar schema stability";

/// Name, description and schema.
type FileKind = (&'static str, &'static str, fn() -> Json);

/// The first one is the default.
const KINDS: &[FileKind] = &[
    (SCENARIO, "Scenario files", json_schema),
    ("sweep-file", "Sweep files", sweep_schema),
    ("design-file", "Design files", design_schema),
    ("run", "summary.json of `trocar run`; --json prints a list for several scenarios", schema_of::<RunFile<'_>>),
    (
        "comparison",
        "comparison.json of `trocar compare` and `trocar strategies --schemes`",
        schema_of::<ComparisonFile<'_>>,
    ),
    ("strategies", "strategies.json of `trocar strategies`", schema_of::<StrategiesFile<'_>>),
    ("paper", "paper.json of `trocar paper`", schema_of::<PaperFile<'_>>),
    ("detection", "detection.json of `trocar detect`", schema_of::<DetectionFile<'_>>),
    ("detections", "detections.json of `trocar detect` with several recordings", schema_of::<DetectionsFile<'_>>),
    ("signals", "The output of `trocar detect --list --json`; a list for several files", schema_of::<SignalsFile<'_>>),
    ("calibration", "calibration.json of `trocar calibrate`", schema_of::<CalibrationFile<'_>>),
    ("identification", "identification.json of `trocar identify`", schema_of::<IdentificationFile<'_>>),
    ("roc", "roc.json of `trocar roc`", schema_of::<RocFile<'_>>),
    ("sweep", "summary.json of `trocar sweep`", schema_of::<SweepFile<'_>>),
    ("design", "design.json of `trocar design`", schema_of::<DesignResultFile<'_>>),
    ("manifest", "manifest.json of `trocar sweep`", schema_of::<SweepManifestFile>),
    ("files", "manifest.json of the other commands", schema_of::<FilesManifest>),
    ("stability", "stability.json of `trocar stability`", schema_of::<StabilityFile<'_>>),
    ("certificate", "certificate.json of `trocar stability`", schema_of::<CertificateFile>),
    ("link", "summary.json of `trocar link`", schema_of::<LinkFile<'_>>),
    ("check", "The output of `trocar check --json`", schema_of::<Vec<CheckedFile<'_>>>),
    ("scenarios", "The output of `trocar scenarios --json`", schema_of::<Vec<ShippedScenario>>),
];

const SCENARIO: &str = "scenario";

/// `manifest.json` of a sweep.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "describes a file")]
struct SweepManifestFile {
    #[schemars(flatten)]
    files: FilesManifest,
    #[schemars(flatten)]
    sweep: Manifest,
}

/// Print the JSON Schema of a kind of file.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct SchemaArgs {
    /// The kind of file [default: scenario]
    #[arg(value_name = "KIND", default_value = SCENARIO, hide_default_value = true, value_parser = kinds())]
    kind: String,
}

fn kinds() -> PossibleValuesParser {
    PossibleValuesParser::new(KINDS.iter().map(|(name, files, _)| PossibleValue::new(*name).help(*files)))
}

pub(super) fn run(args: &SchemaArgs) -> Result<(), Failure> {
    let Some((name, _, schema)) = KINDS.iter().find(|(name, ..)| *name == args.kind) else { return Ok(()) };
    let mut schema = schema();
    schema["title"] = format!("trocar {name}").into();
    terminal::print(&to_json(&schema))
}
