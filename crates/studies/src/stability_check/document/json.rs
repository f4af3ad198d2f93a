//! `stability.json`.

use serde_json::{Value as Json, json};

use super::{absolute, population, switching, z_width};
use crate::stability_check::StabilityStudy;
use trocar_stability::{Analysis, Axis, Limit, PortPoint, Spacing, is_passive_impedance};

/// Everything except the points of the map and the ports, which are data. An undefined value is `null`. A limit beyond the search
/// range is `null` too, and `is_beyond_search` is true.
pub(super) fn json(study: &StabilityStudy) -> Json {
    let StabilityStudy { name, verdict, analysis, map, check, .. } = study;
    let Analysis { settings, jitter_margin_ticks, limits, sensitivities, ports, sampled, .. } = analysis;
    let limit = |limit: &Limit| {
        let largest = limit.largest();
        json!({
            "parameter": limit.parameter.key(),
            "value": limit.value,
            "largest_stable": largest.filter(|largest| largest.is_finite()),
            "is_beyond_search": largest.is_some_and(f64::is_infinite),
            "searched_to": limit.search.high,
            "stable_ranges": limit.stable,
        })
    };
    let axis = |axis: &Axis| {
        let spacing = if axis.spacing == Spacing::Linear { "linear" } else { "log" };
        let (low, high, count) = (axis.low, axis.high, axis.count);
        let (key, value) = (axis.parameter.key(), settings.get(axis.parameter));
        json!({ "parameter": key, "value": value, "low": low, "high": high, "count": count, "spacing": spacing })
    };
    let sensitivities: Vec<Json> = sensitivities
        .iter()
        .map(|s| json!({ "limit": s.limit.key(), "parameter": s.parameter.key(), "relative": s.relative }))
        .collect();
    let checked = check.as_ref().map(|check| {
        let disagreements: Vec<Json> = check
            .disagreements
            .iter()
            .map(|d| {
                json!({
                    "x": d.x, "y": d.y, "analytic_stable": d.analytic_stable,
                    "simulated": d.simulated.word(), "is_near_boundary": d.is_near_boundary,
                })
            })
            .collect();
        json!({
            "runs": check.simulated.iter().flatten().count(),
            "judged": check.judged,
            "agreement": check.agreement(),
            "disagreements": disagreements,
        })
    });
    let mut of_loop = verdict.json();
    of_loop["margins"]["jitter_ticks"] = json!(jitter_margin_ticks);
    of_loop["margins"]["jitter_s"] = json!(jitter_margin_ticks.map(|ticks| ticks as f64 * settings.tick_s));
    let mut document = json!({
        "trocar_version": env!("CARGO_PKG_VERSION"),
        "scenario": name,
        "warnings": study.warnings(),
    });
    let rest = json!({
        "z_width": study.z_width.as_ref().map(z_width::json),
        "population": study.population.as_ref().map(population::json),
        "limits": limits.iter().map(limit).collect::<Vec<_>>(),
        "sensitivities": sensitivities,
        "ports": {
            "is_absolutely_stable": all(ports, |point| point.is_absolutely_stable),
            "is_passive": all(ports, |point| point.is_passive),
            "hand_port_is_passive_in_free_motion": all(ports, |point| is_passive_impedance(point.hybrid.h[0][0])),
            "hand_port_is_passive_in_tissue": all(ports, |point| is_passive_impedance(point.transmitted)),
            "needle_port_is_passive": all(ports, |point| is_passive_impedance(point.hybrid.h[1][1])),
            "bounded": absolute::bounded_json(analysis, &study.bounded),
            "over": study.absolute.as_ref().map(absolute::json),
        },
        "sampled_data": sampled.map(|bound| json!({
            "min_damping_n_s_per_m": bound.min_damping_n_s_per_m,
            "damping_n_s_per_m": bound.damping_n_s_per_m,
            "is_passive": bound.is_passive(),
        })),
        "switching": switching::json(study),
        "map": { "x": axis(&map.x), "y": axis(&map.y), "stable_share": map.stable_share() },
        "simulated": checked,
    });
    for part in [of_loop, rest] {
        if let (Json::Object(document), Json::Object(part)) = (&mut document, part) {
            document.extend(part);
        }
    }
    document
}

/// True if a condition holds at every frequency; `None` without frequencies.
pub(super) fn all(ports: &[PortPoint], holds: impl Fn(&PortPoint) -> bool) -> Option<bool> {
    (!ports.is_empty()).then(|| ports.iter().all(holds))
}
