use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;
use trocar_base::warning::Warning;

use crate::estimate::Role;
use crate::whiteness::Whiteness;

/// `identification.json`: the parameters of a machine with their intervals, and the fits of the recordings.
#[derive(Debug, Serialize, JsonSchema)]
pub struct IdentificationFile<'a> {
    /// Version of trocar.
    pub(crate) trocar_version: &'static str,
    /// The identified machine.
    pub(crate) machine: &'static str,
    /// The warnings about the recordings.
    pub(crate) warnings: Vec<Warning>,
    /// The parameters by name.
    pub(crate) parameters: BTreeMap<&'static str, ParameterEntry>,
    /// The recordings: those for training first.
    pub(crate) fits: Vec<FitEntry<'a>>,
    /// The chosen structure.
    pub(crate) structure: &'static str,
    /// The compared structures.
    pub(crate) structures: Vec<StructureEntry>,
    /// The largest reading of the force sensor to which `force_scale` of a slave applies, in N; beyond it the slope is 1.
    pub(crate) force_scaled_up_to_n: Option<f64>,
    /// True if only ratios are known, so that all values are per kg of moving mass.
    pub(crate) only_ratios: bool,
    /// What the recordings leave open, in sentences.
    pub(crate) open: Vec<String>,
}

/// A parameter with its 95 % interval.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct ParameterEntry {
    /// The value.
    pub(crate) value: f64,
    /// Lower end of the interval; `None` if the recordings do not determine it.
    pub(crate) low: Option<f64>,
    /// Upper end of the interval; `None` if the recordings do not determine it.
    pub(crate) high: Option<f64>,
    /// The SI unit; `1` for a plain number.
    pub(crate) unit: String,
}

/// The simulation of a recording.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct FitEntry<'a> {
    /// The recording.
    pub(crate) recording: &'a str,
    /// Its part in the identification.
    pub(crate) role: Role,
    /// What the force sensor of a slave reads without a load in this recording, in N.
    pub(crate) sensor_zero_n: Option<f64>,
    /// `100 (1 - |simulated - slave| / |slave - mean|)` with 2-norms, in %; `None` if the simulation diverges.
    pub(crate) fit_percent: Option<f64>,
    /// The correlation of the error in time; `None` if it is undefined.
    pub(crate) whiteness: Option<Whiteness>,
}

/// A compared structure.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct StructureEntry {
    /// The structure.
    pub(crate) structure: &'static str,
    /// Mean fit on the last third of the training recordings after an estimation on the rest, in %; `None` if the
    /// simulation diverges.
    pub(crate) held_out_fit_percent: Option<f64>,
    /// Bayes' information criterion of a tissue, an arm or a master; the smallest is the best. It decides if the last third
    /// of a training recording has too little motion.
    pub(crate) bayes_information: Option<f64>,
}
