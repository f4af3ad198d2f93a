use super::FigureError;
use trocar_document::figure::{
    Axis, BLACK, Entry, Figure, GREY, GUIDE, Panel, Point, Row, Sample, Stroke, VERMILION, extent,
};

#[derive(Clone, Copy, Debug)]
pub struct StrategyView<'a> {
    pub name: &'a str,
    /// Number of ruptures as a share of the number without a strategy.
    pub reached: Option<f64>,
    /// 0 to 1.
    pub noticed: Option<f64>,
    pub excess_m: Option<f64>,
    /// Excess advance in m that one rupture in twenty exceeds.
    pub high_excess_m: Option<f64>,
    /// Mean, at the end of the insertion.
    pub final_excess_m: Option<f64>,
    /// True if the strategy reaches the ruptures and its runs settle.
    pub is_compared: bool,
    pub is_on_front: bool,
}

const FRONT: Stroke = Stroke::solid(VERMILION, 6.0);
const COMPARED: Stroke = Stroke::solid(BLACK, 6.0);
const OTHER: Stroke = Stroke::solid(GREY.pale(0.4), 6.0);

const TICKS: usize = 3;

/// Draws a row per strategy, from the top down, with panels for the reached and the noticed share of the ruptures, the
/// excess (the line ends at the value that one rupture in twenty exceeds), and the excess at the end of the insertion.
pub fn strategies(name: &str, views: &[StrategyView<'_>]) -> Result<Figure<'static>, FigureError> {
    if views.is_empty() {
        return Err(FigureError::Empty { figure: "strategies" });
    }
    let y = || Axis::of_names(views.iter().map(|view| view.name.to_owned()));
    let at = |index: usize| -(index as f64);
    let dot = |view: &StrategyView<'_>| match (view.is_on_front, view.is_compared) {
        (true, _) => FRONT,
        (_, true) => COMPARED,
        _ => OTHER,
    };
    let panel = |axis: Axis, caption: &str, value: &dyn Fn(&StrategyView<'_>) -> Option<f64>| {
        let mut panel = Panel::new(axis, caption, y(), "");
        let point = |(index, view): (usize, &StrategyView<'_>)| {
            value(view).map(|value| -> (Vec<Point>, Stroke) { (vec![(value, at(index))], dot(view)) })
        };
        // A guide through the value without a strategy, the first row.
        let guide = value(&views[0]).map(|value| (vec![(value, panel.y.low), (value, panel.y.high)], GUIDE));
        panel.curves.extend(guide);
        panel.curves.extend(views.iter().enumerate().filter_map(point));
        panel
    };
    let share = |share: Option<f64>| share.map(|share| 100.0 * share);
    let mm = |metres: Option<f64>| metres.map(|metres| 1e3 * metres);
    let of_shares = || Axis::exact((-4.0, 108.0), TICKS);
    let high = views.iter().filter_map(|view| mm(view.high_excess_m.or(view.excess_m))).fold(0.0, f64::max);
    let ends = extent(views.iter().filter_map(|view| mm(view.final_excess_m)).chain([0.0])).unwrap_or((-1.0, 1.0));
    let mut excess =
        panel(Axis::exact((-0.04 * high, 1.08 * high), TICKS), "Excess, mean and 95 % (mm)", &|view| mm(view.excess_m));
    excess.curves.extend(views.iter().enumerate().filter_map(|(index, view)| {
        let (from, to) = mm(view.excess_m).zip(mm(view.high_excess_m))?;
        Some((vec![(from, at(index)), (to, at(index))], Stroke { width: 1.4, ..dot(view) }))
    }));
    let rows = [
        [
            panel(of_shares(), "Ruptures reached (%)", &|view| share(view.reached)),
            panel(of_shares(), "Ruptures noticed (%)", &|view| share(view.noticed)),
        ],
        [excess, panel(Axis::padded(ends, TICKS), "Final excess (mm)", &|view| mm(view.final_excess_m))],
    ];
    let height = 13.0 * views.len() as f64;
    let mut legend: Vec<Entry> = vec![
        (Sample::Dot(FRONT), "Pareto front of excess and noticed ruptures".to_owned()),
        (Sample::Dot(COMPARED), "other strategies".to_owned()),
    ];
    if views.iter().any(|view| !view.is_compared) {
        legend.push((Sample::Dot(OTHER), "not compared: fewer ruptures, or runs that do not settle".to_owned()));
    }
    legend.push((Sample::Line(GUIDE), views[0].name.to_owned()));
    Ok(Figure {
        name: name.to_owned(),
        legend,
        rows: rows.map(|panels| Row { title: None, height, panels: panels.into() }).into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_strategy_has_one_row_and_its_values_in_all_panels() {
        let view = |name, excess_m, reached, is_on_front| StrategyView {
            name,
            reached: Some(reached),
            noticed: Some(0.5),
            excess_m: Some(excess_m),
            high_excess_m: Some(2.0 * excess_m),
            final_excess_m: Some(-0.03),
            is_compared: reached > 0.9,
            is_on_front,
        };
        let views = [view("none", 5e-3, 1.0, true), view("cue", 5e-3, 1.0, false), view("clutch", 0.0, 0.6, false)];
        let figure = strategies("skin", &views).expect("drawn");
        let panels: Vec<&Panel<'_>> = figure.rows.iter().flat_map(|row| &row.panels).collect();
        let dots = |panel: usize| {
            let dots = panels[panel].curves.iter().filter(|(points, _)| points.len() == 1);
            dots.map(|(points, stroke)| (points[0].0, points[0].1, stroke.color)).collect::<Vec<_>>()
        };
        let colors = [VERMILION, BLACK, OTHER.color];
        for (panel, values) in [[100.0, 100.0, 60.0], [50.0; 3], [5.0, 5.0, 0.0], [-30.0; 3]].iter().enumerate() {
            let expected: Vec<_> = (0..3).map(|index| (values[index], -(index as f64), colors[index])).collect();
            assert_eq!(dots(panel), expected, "panel {panel}");
            let lines = panels[panel].y.all_ticks();
            assert_eq!(lines.iter().map(|(_, name)| name.as_str()).collect::<Vec<_>>(), ["none", "cue", "clutch"]);
        }
        assert!(matches!(strategies("", &[]), Err(FigureError::Empty { .. })));
    }
}
