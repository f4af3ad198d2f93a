use schemars::Schema;
use serde_json::Value as Json;

use super::{Declaration, Metric};

/// Appends the unit to each metric's description.
pub fn with_units<Read>(metrics: &'static [Metric<Read>]) -> impl FnMut(&mut Schema) {
    move |schema| {
        let Some(properties) = schema.get_mut("properties") else { return };
        for Declaration { name, unit, .. } in metrics.iter().map(|metric| &metric.declaration) {
            let description = properties.get_mut(name).and_then(|property| property.get_mut("description"));
            if let (Some(Json::String(description)), false) = (description, unit.si() == "1") {
                description.push_str(&format!(" In {}.", unit.si()));
            }
        }
    }
}
