//! `certificate.json`: all that is needed to verify the certificates again.

use serde_json::{Value as Json, json};

use super::switching::{rows, seconds};
use trocar_sim::stability::{Certificate, Switching};

/// Returns `certificate.json`; `None` without a certificate.
///
/// Each certificate has its spaces with name and unit of each state in order and the scale of the states, its functions
/// `V = zᵀ P z` on scaled states, its maps on states, and its inequalities: sums of `factor · Mᵀ P M`, with `M` the
/// product of maps between scaled states, the first one applied last, that are positive definite. A map with a power is
/// raised to each power of the inequality's range.
#[must_use]
pub fn certificate_json(switching: &Switching) -> Option<String> {
    let shortest = switching.certificate.as_ref()?;
    let mut certificates = serde_json::Map::new();
    certificates.insert("shortest_dwell".into(), object(switching, shortest, None));
    if let Some(found) = &switching.at_refractory {
        certificates.insert("growth_at_refractory".into(), object(switching, found, None));
    }
    if let Some(reach) = &switching.reach {
        let bound = |value: f64, unit: &str| Some(json!({ "value": value, "unit": unit }));
        certificates.insert("needle".into(), object(switching, &reach.slave.1, bound(reach.slave.0, "m/m")));
        certificates.insert("feedback_force".into(), object(switching, &reach.force.1, bound(reach.force.0, "N/m")));
    }
    let (softest, stiffest) = switching.settings.stiffness_n_per_m;
    let whole = json!({
        "tick_s": switching.settings.of_loop.tick_s,
        "stiffness_n_per_m": [softest, stiffest],
        "damping_n_s_per_m": switching.settings.of_loop.damping_n_s_per_m,
        "delay_ticks": switching.settings.delay_ticks(),
        "certificates": certificates,
    });
    serde_json::to_string(&whole).ok().map(|text| text + "\n")
}

fn object(switching: &Switching, certificate: &Certificate, bound: Option<Json>) -> Json {
    let space = |place: usize| certificate.spaces[place].name.clone();
    let spaces: serde_json::Map<String, Json> = (certificate.spaces.iter())
        .map(|space| {
            let states: Vec<Json> =
                space.states.iter().map(|(name, unit)| json!({ "name": name, "unit": unit })).collect();
            (space.name.clone(), json!({ "states": states, "scale": rows(&space.scale) }))
        })
        .collect();
    let functions: Vec<Json> = (certificate.functions.iter())
        .map(|one| json!({ "name": one.name, "space": space(one.space), "p": rows(&one.matrix) }))
        .collect();
    let maps: Vec<Json> = (certificate.maps.iter())
        .map(|map| {
            json!({ "name": map.name, "from": space(map.from), "to": space(map.to), "matrix": rows(&map.matrix) })
        })
        .collect();
    let inequalities: Vec<Json> = (certificate.inequalities.iter())
        .map(|one| {
            let terms: Vec<Json> = (one.terms.iter())
                .map(|term| {
                    let maps: Vec<Json> =
                        (term.maps.iter()).map(|(map, is_power)| json!({ "map": map, "is_power": is_power })).collect();
                    json!({ "factor": term.factor, "function": term.function, "maps": maps })
                })
                .collect();
            let powers = one.powers.map(|(from, to)| [from, to]);
            json!({ "name": one.name, "rows": space(one.rows), "powers": powers, "terms": terms })
        })
        .collect();
    json!({
        "dwell_s": seconds(switching, certificate.dwell_ticks),
        "contraction": certificate.contraction,
        "bound": bound,
        "at_events": certificate.at_events,
        "spaces": spaces,
        "functions": functions,
        "maps": maps,
        "inequalities": inequalities,
    })
}
