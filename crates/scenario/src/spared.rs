use super::error::ScenarioError;
use super::keys::nearest_of;
use super::scenario::Scenario;
use super::values::Values;
use trocar_core::settings::{ActsFor, KeySource as _};

const LAYERED: ActsFor = ActsFor::new("tissue.kind", &["layers", "tearing"]);

trocar_core::settings! {
    /// The aim of the insertion.
    #[derive(Debug, Clone, PartialEq)]
    pub struct AimSettings in "tissue." no const {
        /// Name of a layer that the needle must not rupture. No warning is given if it and the layers below stay whole.
        spared_layer: Option<String> for (LAYERED),
    }
}

pub(super) fn check_spared(values: &mut Values, scenario: &Scenario) -> Result<(), ScenarioError> {
    let Some(name) = AimSettings::read(values)?.spared_layer else { return Ok(()) };
    let layers = scenario.rupturing_layers();
    if layers.is_empty() || layers.contains(&name.as_str()) {
        return Ok(());
    }
    let path = AimSettings::KEYS[0].path;
    let error = values.error(path, format!("{path} is {name:?}, and no layer of this name ruptures"));
    let known = format!("the layers that rupture are {}", layers.join(", "));
    let near = nearest_of(&name, layers.iter().map(|&layer| layer.to_owned()));
    Err(error.remedy(near.map_or(known, |near| format!("did you mean {near}?"))))
}

impl Scenario {
    /// All above `tissue.spared_layer`, from the surface down.
    pub fn layers_to_rupture(&self) -> Vec<&str> {
        let spared = self.values().optional_word(AimSettings::KEYS[0].path);
        self.rupturing_layers().into_iter().take_while(|layer| Some(*layer) != spared).collect()
    }
}
