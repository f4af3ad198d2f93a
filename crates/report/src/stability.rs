//! A stability analysis as JSON, CSV and figures.

use std::fmt::Write as _;

use serde_json::{Value as Json, json};

use super::Folder;
use super::absolute::{absolute_json, bounded_json};
use super::figures::{self, Figure, FigureError, MapAxisView, MapView};
use super::loop_verdict::loop_verdict_json;
use super::pictures::{Job, PictureError, draw};
use super::population::population_json;
use super::tables::shortest;
use super::z_width::z_width_json;
use trocar_lti::Complex64;
use trocar_stability::{Analysis, Axis, Limit, PortPoint, Spacing, StabilityMap, is_passive_impedance};
use trocar_studies::stability_check::{Check, StabilityStudy, Verdict};

/// Returns the word for a verdict.
pub(super) fn word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Decays => "decays",
        Verdict::Grows => "grows",
        Verdict::Undecided => "undecided",
    }
}

/// Returns `stability.json`: everything except the points of the map and the ports, which the CSV files hold. An undefined
/// value is `null`. A limit beyond the search range is `null` too, and `is_beyond_search` is true.
#[must_use]
pub fn stability_json(study: &StabilityStudy) -> String {
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
                    "simulated": word(d.simulated), "is_near_boundary": d.is_near_boundary,
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
    let mut of_loop = loop_verdict_json(verdict);
    of_loop["margins"]["jitter_ticks"] = json!(jitter_margin_ticks);
    of_loop["margins"]["jitter_s"] = json!(jitter_margin_ticks.map(|ticks| ticks as f64 * settings.tick_s));
    let mut document = json!({
        "trocar_version": env!("CARGO_PKG_VERSION"),
        "scenario": name,
        "warnings": study.warnings(),
    });
    let rest = json!({
        "z_width": study.z_width.as_ref().map(z_width_json),
        "population": study.population.as_ref().map(population_json),
        "limits": limits.iter().map(limit).collect::<Vec<_>>(),
        "sensitivities": sensitivities,
        "ports": {
            "is_absolutely_stable": all(ports, |point| point.is_absolutely_stable),
            "is_passive": all(ports, |point| point.is_passive),
            "hand_port_is_passive_in_free_motion": all(ports, |point| is_passive_impedance(point.hybrid.h[0][0])),
            "hand_port_is_passive_in_tissue": all(ports, |point| is_passive_impedance(point.transmitted)),
            "needle_port_is_passive": all(ports, |point| is_passive_impedance(point.hybrid.h[1][1])),
            "bounded": bounded_json(analysis, &study.bounded),
            "over": study.absolute.as_ref().map(absolute_json),
        },
        "sampled_data": sampled.map(|bound| json!({
            "min_damping_n_s_per_m": bound.min_damping_n_s_per_m,
            "damping_n_s_per_m": bound.damping_n_s_per_m,
            "is_passive": bound.is_passive(),
        })),
        "switching": super::switching::switching_object(study),
        "map": { "x": axis(&map.x), "y": axis(&map.y), "stable_share": map.stable_share() },
        "simulated": checked,
    });
    for part in [of_loop, rest] {
        if let (Json::Object(document), Json::Object(part)) = (&mut document, part) {
            document.extend(part);
        }
    }
    super::json::render(&document)
}

/// Returns whether a condition holds at every frequency, or `None` without frequencies.
pub(super) fn all(ports: &[PortPoint], holds: impl Fn(&PortPoint) -> bool) -> Option<bool> {
    (!ports.is_empty()).then(|| ports.iter().all(holds))
}

/// Returns `sensitivities.csv`: the relative change of each limit per relative change of each parameter.
#[must_use]
pub fn sensitivities_csv(analysis: &Analysis) -> String {
    let mut text = "limit,parameter,relative_sensitivity\n".to_owned();
    for s in &analysis.sensitivities {
        let value = s.relative.map_or(String::new(), shortest);
        let _ = writeln!(text, "{},{},{value}", s.limit.key(), s.parameter.key());
    }
    text
}

/// Returns `stability_map.csv`: a row per point, with the verdict of its simulated run, if any.
#[must_use]
pub fn map_csv(map: &StabilityMap, check: Option<&Check>) -> String {
    let (x, y) = (map.x.parameter.key(), map.y.parameter.key());
    let mut text = format!("{x},{y},stable{}\n", if check.is_some() { ",simulated" } else { "" });
    for row in 0..map.y.count {
        for column in 0..map.x.count {
            let (x, y) = (shortest(map.x.value(column)), shortest(map.y.value(row)));
            let _ = write!(text, "{x},{y},{}", u8::from(map.is_stable(column, row)));
            if let Some(check) = check {
                let verdict = check.simulated[row * map.x.count + column];
                let _ = write!(text, ",{}", verdict.map_or("", word));
            }
            text.push('\n');
        }
    }
    text
}

/// Returns `stability_boundary.csv`: the two ends of each segment of the boundary.
#[must_use]
pub fn boundary_csv(map: &StabilityMap) -> String {
    let (x, y) = (map.x.parameter.key(), map.y.parameter.key());
    let mut text = format!("{x}_from,{y}_from,{x}_to,{y}_to\n");
    for [from, to] in &map.boundary {
        let cells = [from.0, from.1, to.0, to.1].map(shortest);
        let _ = writeln!(text, "{}", cells.join(","));
    }
    text
}

/// Returns `ports.csv`: the two-port at each frequency.
#[must_use]
pub fn ports_csv(analysis: &Analysis) -> String {
    let mut text = "frequency_hz,h11_re,h11_im,h12_re,h12_im,h21_re,h21_im,h22_re,h22_im,llewellyn,absolutely_stable,\
                    passive,transmitted_re,transmitted_im,ideal_re,ideal_im,stiffest_re,stiffest_im\n"
        .to_owned();
    for point in &analysis.ports {
        let [[h11, h12], [h21, h22]] = point.hybrid.h;
        let parts = |values: &[Complex64]| {
            let cells: Vec<String> = values.iter().flat_map(|v| [shortest(v.re), shortest(v.im)]).collect();
            cells.join(",")
        };
        let llewellyn = point.hybrid.llewellyn();
        let _ = writeln!(
            text,
            "{},{},{},{},{},{},{}",
            shortest(point.frequency_hz),
            parts(&[h11, h12, h21, h22]),
            if llewellyn.is_finite() { shortest(llewellyn) } else { String::new() },
            u8::from(point.is_absolutely_stable),
            u8::from(point.is_passive),
            parts(&[point.transmitted, point.ideal]),
            point.hybrid.stiffest().map_or(",".into(), |stiffest| parts(&[stiffest])),
        );
    }
    text
}

/// Writes the figures `stability` (the map) and, if there is a two-port, `ports`.
///
/// # Errors
/// [`PictureError`].
pub fn stability_pictures(folder: &Folder, study: &StabilityStudy) -> Result<(), PictureError> {
    let mut jobs: Vec<Job<'_>> = vec![("stability", Box::new(|| map_figure(study)))];
    if !study.analysis.ports.is_empty() {
        jobs.push(("ports", Box::new(|| figures::ports(&study.name, &study.analysis.ports))));
    }
    draw(folder, jobs)
}

pub(super) fn map_figure(study: &StabilityStudy) -> Result<Figure<'static>, FigureError> {
    let StabilityStudy { analysis, map, check, .. } = study;
    let values = |axis: &Axis| -> Vec<f64> { (0..axis.count).map(|index| axis.value(index)).collect() };
    let (x_values, y_values) = (values(&map.x), values(&map.y));
    let view = |axis: &Axis, values| MapAxisView {
        caption: axis.parameter.caption(),
        values,
        is_logarithmic: axis.spacing == Spacing::Logarithmic,
        scenario_value: analysis.settings.get(axis.parameter),
    };
    let grew: Vec<Option<bool>> = check.as_ref().map_or(vec![], |check| {
        let grew = |verdict: &Option<Verdict>| match verdict {
            Some(Verdict::Decays) => Some(false),
            Some(Verdict::Grows) => Some(true),
            _ => None,
        };
        check.simulated.iter().map(grew).collect()
    });
    figures::stability_map(&MapView {
        name: &study.name,
        x: view(&map.x, &x_values),
        y: view(&map.y, &y_values),
        stable: &map.stable,
        boundary: &map.boundary,
        grew: &grew,
    })
}
