use super::FigureError;
use trocar_document::figure::{
    Axis, BLACK, Entry, Figure, GREY, Panel, Point, Row, Sample, Stroke, VERMILION, WHITE, X_TICKS, Y_TICKS, extent,
};

pub type Interval = (f64, [f64; 2]);

#[derive(Clone, Debug)]
pub struct DesignView {
    pub name: String,
    pub training: Option<(f64, f64)>,
    /// On other patients.
    pub validation: Option<(Interval, Interval)>,
    pub is_chosen: bool,
}

#[derive(Clone, Debug)]
pub struct ShippedView {
    pub name: String,
    /// On other patients.
    pub at: (f64, f64),
    pub is_feasible: bool,
}

#[derive(Clone, Debug)]
pub struct ParetoView {
    pub captions: (String, String),
    pub designs: Vec<DesignView>,
    pub shipped: Vec<ShippedView>,
}

const DOT: f64 = 6.5;
const DESIGN: Stroke = Stroke::solid(BLACK, DOT);
const CHOSEN: Stroke = Stroke::solid(VERMILION, DOT);
const FEASIBLE: Stroke = Stroke::solid(GREY, DOT);
const INFEASIBLE: Stroke = Stroke::solid(GREY.pale(0.4), DOT);
const INSIDE: Stroke = Stroke::solid(WHITE, 0.6 * DOT);

/// Height of a plane in points, the distance of a name above its dot as a share of it, and beside the lines of an interval
/// as a share of the width.
const HEIGHT: f64 = 190.0;
const ABOVE: f64 = 0.045;
const BESIDE: f64 = 0.015;

/// Height of a line of text and mean width of a character, in points.
const LINE_HEIGHT: f64 = 8.0;
const CHARACTER: f64 = 3.9;

/// Width of a plane in points, alone or beside another one.
const WIDTHS: [f64; 2] = [420.0, 180.0];

/// Distances of a name from its dot, in the order in which they are tried, as multiples of the smallest one.
const DISTANCES: [f64; 10] = [1.0, -1.0, 2.0, -2.0, 3.0, -3.0, 4.0, -4.0, 5.0, -5.0];

/// Draws a plane for each pair of objectives, two beside each other. The values on other patients are filled dots with
/// intervals, the values in the search hollow ones.
pub fn pareto(name: &str, views: &[ParetoView]) -> Result<Figure<'static>, FigureError> {
    if views.is_empty() || views.iter().all(|view| view.designs.is_empty() && view.shipped.is_empty()) {
        return Err(FigureError::Empty { figure: "front" });
    }
    let width = WIDTHS[usize::from(views.len() > 1)];
    let panels: Vec<Panel<'static>> = views.iter().map(|view| panel(view, width)).collect();
    let rows = panels.chunks(2).map(|panels| Row { title: None, height: HEIGHT, panels: panels.to_vec() });
    let mut legend: Vec<Entry> = vec![
        (Sample::Dot(CHOSEN), "the knee, on other patients".to_owned()),
        (Sample::Dot(DESIGN), "other designs (95 % intervals); hollow: in the search".to_owned()),
        (Sample::Dot(FEASIBLE), "shipped strategies".to_owned()),
    ];
    if views.iter().flat_map(|view| &view.shipped).any(|shipped| !shipped.is_feasible) {
        legend.push((Sample::Dot(INFEASIBLE), "shipped, outside a constraint".to_owned()));
    }
    Ok(Figure { name: name.to_owned(), legend, rows: rows.collect() })
}

fn panel(view: &ParetoView, width: f64) -> Panel<'static> {
    let of_designs = |pick: fn((f64, f64)) -> f64, of: fn(&(Interval, Interval)) -> &Interval| {
        let training = view.designs.iter().filter_map(move |design| design.training.map(pick));
        let validation = view.designs.iter().filter_map(|design| design.validation.as_ref());
        training.chain(validation.flat_map(move |both| of(both).1)).collect::<Vec<f64>>()
    };
    let xs = of_designs(|at| at.0, |both| &both.0).into_iter().chain(view.shipped.iter().map(|shipped| shipped.at.0));
    let ys = of_designs(|at| at.1, |both| &both.1).into_iter().chain(view.shipped.iter().map(|shipped| shipped.at.1));
    let axis = |values: Option<(f64, f64)>, ticks| Axis::padded(values.unwrap_or((0.0, 1.0)), ticks);
    let (x, y) = (axis(extent(xs), X_TICKS), axis(extent(ys), Y_TICKS));
    let (above, beside) = (ABOVE * (y.high - y.low), BESIDE * (x.high - x.low));
    let mut panel = Panel::new(x, view.captions.0.clone(), y, view.captions.1.clone());
    let dot = |at: Point, stroke: Stroke| (vec![at], stroke);
    for ShippedView { at, is_feasible, .. } in &view.shipped {
        panel.curves.push(dot(*at, if *is_feasible { FEASIBLE } else { INFEASIBLE }));
    }
    for DesignView { name, training, validation, is_chosen } in &view.designs {
        let stroke = if *is_chosen { CHOSEN } else { DESIGN };
        let thin = Stroke { width: 0.8, ..stroke };
        if let (Some(from), Some(((x, _), (y, _)))) = (training, validation) {
            panel.curves.push((vec![*from, (*x, *y)], Stroke { color: GREY.pale(0.5), ..thin }));
        }
        if let Some(at) = training {
            panel.curves.extend([dot(*at, stroke), dot(*at, INSIDE)]);
        }
        if let Some(((x, x_ends), (y, y_ends))) = validation {
            panel.curves.push((vec![(x_ends[0], *y), (x_ends[1], *y)], thin));
            panel.curves.push((vec![(*x, y_ends[0]), (*x, y_ends[1])], thin));
            panel.curves.push(dot((*x, *y), stroke));
            panel.notes.push(((*x + beside, *y + above), name.clone()));
        }
    }
    for ShippedView { name, at, .. } in &view.shipped {
        place_name(&mut panel, name, *at, (above, width));
    }
    panel
}

/// Places the name of a dot where it overlaps no other name, and connects it with its dot unless it is next to it.
fn place_name(panel: &mut Panel<'static>, name: &str, (x, y): Point, (above, width): (f64, f64)) {
    let per_point = (panel.x.high - panel.x.low) / width;
    let half = |name: &str| 0.5 * CHARACTER * name.chars().count() as f64 * per_point;
    let line = LINE_HEIGHT / HEIGHT * (panel.y.high - panel.y.low);
    let x_name = x.min(panel.x.high - half(name)).max(panel.x.low + half(name));
    let is_free = |y_name: f64| {
        let overlaps = |((other_x, other_y), other): &(Point, String)| {
            (other_y - y_name).abs() < line && (other_x - x_name).abs() < half(name) + half(other)
        };
        (panel.y.low + line..panel.y.high).contains(&y_name) && !panel.notes.iter().any(overlaps)
    };
    let distance = DISTANCES.into_iter().find(|distance| is_free(y + distance * above)).unwrap_or(DISTANCES[0]);
    let y_name = y + distance * above;
    if distance.abs() > 1.0 {
        panel.curves.push((vec![(x, y), (x_name, y_name)], Stroke::solid(GREY.pale(0.5), 0.4)));
    }
    panel.notes.push(((x_name, y_name), name.to_owned()));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn designs_have_hollow_and_filled_dots_and_strategies_their_names() {
        let view = ParetoView {
            captions: ("excess (mm)".into(), "noticed (%)".into()),
            designs: vec![DesignView {
                name: "01".into(),
                training: Some((1.0, 90.0)),
                validation: Some(((1.5, [1.2, 1.8]), (85.0, [80.0, 88.0]))),
                is_chosen: true,
            }],
            shipped: vec![ShippedView { name: "cue".into(), at: (4.0, 70.0), is_feasible: false }],
        };
        let figure = pareto("liver", std::slice::from_ref(&view)).expect("drawn");
        let panel = &figure.rows[0].panels[0];
        let dots: Vec<(Point, Stroke)> = panel
            .curves
            .iter()
            .filter(|(points, _)| points.len() == 1)
            .map(|(points, stroke)| (points[0], *stroke))
            .collect();
        assert_eq!(
            dots,
            [((4.0, 70.0), INFEASIBLE), ((1.0, 90.0), CHOSEN), ((1.0, 90.0), INSIDE), ((1.5, 85.0), CHOSEN)]
        );
        assert_eq!(panel.notes.iter().map(|(_, name)| name.as_str()).collect::<Vec<_>>(), ["01", "cue"]);
        assert!(panel.x.low < 1.0 && panel.x.high > 4.0 && panel.y.low < 70.0 && panel.y.high > 90.0);
        assert_eq!(figure.legend.len(), 4);
        assert!(matches!(pareto("", &[]), Err(FigureError::Empty { .. })));
    }

    #[test]
    fn names_of_close_strategies_do_not_overlap_and_stay_in_the_plane() {
        let at = |k: usize| (0.1 * k as f64, 90.0 + 0.5 * k as f64);
        let names = ["freeze-clutch", "freeze-until-load", "freeze-fade", "freeze-still", "designed"];
        let shipped = names.into_iter().enumerate();
        let shipped = shipped.map(|(k, name)| ShippedView { name: name.into(), at: at(k), is_feasible: true });
        let far = ShippedView { name: "snap".into(), at: (8.0, 30.0), is_feasible: true };
        let view = ParetoView {
            captions: (String::new(), String::new()),
            designs: vec![],
            shipped: shipped.chain([far]).collect(),
        };
        let figure = pareto("", &[view]).expect("drawn");
        let panel = &figure.rows[0].panels[0];
        let heights: Vec<f64> = panel.notes[..names.len()].iter().map(|((_, y), _)| *y).collect();
        let line = LINE_HEIGHT / HEIGHT * (panel.y.high - panel.y.low);
        for (k, y) in heights.iter().enumerate() {
            assert!(heights[..k].iter().all(|other| (other - y).abs() >= line), "{heights:?}");
            assert!(*y > panel.y.low && *y < panel.y.high, "{heights:?}");
        }
        assert!(panel.notes[0].0.0 > panel.x.low);
    }
}
