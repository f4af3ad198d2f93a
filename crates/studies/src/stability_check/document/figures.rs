use super::super::{StabilityStudy, Verdict};
use trocar_document::{Document, Figure};
use trocar_figures::{self as figures, AbsoluteView, AxisView, FigureError, HeatView, MapAxisView, MapView};
use trocar_stability::{AbsoluteOver, AbsolutePoint, Analysis, Axis, Population, Spacing, arm_impedance};

pub(super) fn add(study: &StabilityStudy, document: &mut Document<'_>) {
    let StabilityStudy { name, analysis, switching, response, .. } = study;
    document.figure("stability", map_figure(study));
    if !analysis.ports.is_empty() {
        document.figure("ports", figures::ports(name, &analysis.ports));
    }
    document.figure("loop", figures::loop_response(name, response));
    if let Some(measured) = &study.measured {
        document.figure("measured", figures::measured_loop(name, measured, response));
    }
    if let Ok(switching) = switching {
        let tick_s = switching.settings.of_loop.tick_s;
        document.figure("switching", figures::switching(name, &switching.by_dwell, tick_s));
    }
    if let Some(locus) = &study.locus {
        document.figure("locus", figures::locus(name, locus, analysis.settings.tick_s));
    }
    if let Some(z_width) = &study.z_width {
        document.figure("z_width", figures::z_width(name, z_width));
    }
    if let Some(population) = &study.population {
        document.figure("population", population_figure(name, population));
    }
    if let Some(absolute) = &study.absolute {
        document.figure("absolute", figures::absolute(&view(name, analysis, absolute)));
    }
}

fn population_figure(name: &str, population: &Population) -> Result<Figure<'static>, FigureError> {
    let map = &population.map;
    let values = |axis: &Axis| (0..axis.count).map(|index| axis.value(index)).collect::<Vec<f64>>();
    let axis = |axis: &Axis| AxisView { name: axis.parameter.caption(), log: axis.spacing == Spacing::Logarithmic };
    let shares: Vec<f64> = map.stable.iter().map(|&stable| 100.0 * f64::from(stable) / map.of as f64).collect();
    figures::heat_map(&HeatView {
        name,
        caption: "Share of the population that is stable (%)",
        axes: [axis(&map.x), axis(&map.y)],
        x: values(&map.x),
        y: values(&map.y),
        means: &shares,
    })
}

fn map_figure(study: &StabilityStudy) -> Result<Figure<'static>, FigureError> {
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
            Some(Verdict::Undecided) | None => None,
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

fn view(name: &str, analysis: &Analysis, absolute: &AbsoluteOver) -> AbsoluteView {
    let most = |point: &AbsolutePoint| point.bounded.most();
    AbsoluteView {
        name: name.to_owned(),
        caption: absolute.parameter.caption().to_owned(),
        values: absolute.points.iter().map(|point| point.value).collect(),
        llewellyn: absolute.points.iter().map(|point| point.min_llewellyn).collect(),
        needed: absolute.points.iter().map(|point| point.bounded.needed_damping().unwrap_or(f64::NAN)).collect(),
        of_arm: absolute
            .points
            .iter()
            .map(|point| most(point).map_or(f64::NAN, |at| arm_impedance(&analysis.settings.arm, at.frequency_hz).re))
            .collect(),
    }
}
