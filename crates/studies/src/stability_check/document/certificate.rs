//! `certificate.json`: all that is needed to verify the certificates again.

use serde_json::{Value as Json, json};

use super::switching::{rows, seconds};
use trocar_stability::{Certificate, KeptGap, StateMap, StateSpace, Switching};

/// Returns `certificate.json`; `None` without a certificate.
///
/// Each certificate has its spaces with name and unit of each state in order and the scale of the states, its functions
/// `V = zᵀ P z` on scaled states, its maps on states, and its inequalities: sums of `factor · Mᵀ P M`, with `M` the
/// product of maps between scaled states, the first one applied last, that are positive definite. A map with a power is
/// raised to each power of the inequality's range. That of a kept gap has no functions: see [`kept_gap`].
pub(super) fn certificate_json(switching: &Switching) -> Option<String> {
    let mut certificates = serde_json::Map::new();
    match (&switching.certificate, &switching.kept_gap) {
        (Some(shortest), _) => {
            certificates.insert("shortest_dwell".into(), object(switching, shortest, None));
        }
        (None, Some(found)) => {
            certificates.insert("kept_gap".into(), kept_gap(switching, found));
        }
        (None, None) => return None,
    }
    if let Some(found) = &switching.at_refractory {
        certificates.insert("growth_at_refractory".into(), object(switching, found, None));
    }
    if let Some(reach) = &switching.reach {
        let bounds = [("needle", &reach.slave, "m/m"), ("feedback_force", &reach.force, "N/m")];
        for (name, (value, certificate), unit) in bounds {
            if let Some(certificate) = certificate {
                let bound = Some(json!({ "value": value, "unit": unit }));
                certificates.insert(name.into(), object(switching, certificate, bound));
            }
        }
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

/// Spaces by name, with their states and scale, and maps.
fn spaces_and_maps(spaces: &[StateSpace], maps: &[StateMap]) -> (Json, Json) {
    let named: serde_json::Map<String, Json> = (spaces.iter())
        .map(|space| {
            let states: Vec<Json> =
                space.states.iter().map(|(name, unit)| json!({ "name": name, "unit": unit })).collect();
            (space.name.clone(), json!({ "states": states, "scale": rows(&space.scale) }))
        })
        .collect();
    let name = |place: usize| &spaces[place].name;
    let maps = maps.iter().map(
        |map| json!({ "name": map.name, "from": name(map.from), "to": name(map.to), "matrix": rows(&map.matrix) }),
    );
    (named.into(), maps.collect())
}

/// The proof for a kept gap: the states at a release are `along · gap`, each within `rest · |gap|`, all scaled.
fn kept_gap(switching: &Switching, found: &KeptGap) -> Json {
    let phases = switching.phases;
    let (spaces, maps) = spaces_and_maps(&found.spaces, &found.maps);
    json!({
        "dwell_s": seconds(switching, found.dwell_ticks),
        "dwell_ticks": [found.dwell_ticks, phases.refractory],
        "growth": [found.growth_after(found.dwell_ticks), found.growth_after(phases.refractory)],
        "held_ticks": [phases.held.0, phases.held.1],
        "blend_ticks": phases.blend,
        "ticks": found.ticks,
        "along": found.along,
        "rest": found.rest,
        "spaces": spaces,
        "maps": maps,
    })
}

fn object(switching: &Switching, certificate: &Certificate, bound: Option<Json>) -> Json {
    let space = |place: usize| certificate.spaces[place].name.clone();
    let (spaces, maps) = spaces_and_maps(&certificate.spaces, &certificate.maps);
    let functions: Vec<Json> = (certificate.functions.iter())
        .map(|one| json!({ "name": one.name, "space": space(one.space), "p": rows(&one.matrix) }))
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
