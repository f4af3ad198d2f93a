use super::FigureError;
use trocar_document::figure::{
    Axis, Figure, GREY, Panel, Row, SKY, Sample, Series, Stroke, VERMILION, X_TICKS, Y_TICKS, extent,
};

/// Absolute stability over a parameter. Values that are not finite are not drawn.
#[derive(Clone, Debug)]
pub struct AbsoluteView {
    pub name: String,
    pub caption: String,
    /// Increasing.
    pub values: Vec<f64>,
    pub llewellyn: Vec<f64>,
    /// The needed damping of the hand in N·s/m.
    pub needed: Vec<f64>,
    /// The damping of the scenario's arm in N·s/m at the frequency of the needed damping.
    pub of_arm: Vec<f64>,
}

pub fn absolute(view: &AbsoluteView) -> Result<Figure<'static>, FigureError> {
    let Some((low, high)) = extent(view.values.iter().copied()) else {
        return Err(FigureError::Empty { figure: "absolute" });
    };
    let columns = [("llewellyn", &view.llewellyn), ("needed", &view.needed), ("of_arm", &view.of_arm)];
    super::check("absolute", "values", view.values.len(), &columns.map(|(name, values)| (name, values.len())))?;
    let (llewellyn, needed) = (Stroke::solid(VERMILION, 1.2), Stroke::solid(SKY, 1.2));
    let of_arm = Stroke { dashes: &[5.0, 3.0], ..Stroke::solid(GREY, 1.2) };
    let trace = |values: &[f64], stroke: Stroke| {
        let points = view.values.iter().zip(values).filter(|(_, value)| value.is_finite());
        let (x, y): (Vec<f64>, Vec<f64>) = points.map(|(x, y)| (*x, *y)).unzip();
        (!x.is_empty()).then(|| Series::new(x, y, stroke))
    };
    let axis = |columns: &[&[f64]], bound: f64| {
        let values = columns.iter().flat_map(|values| values.iter().copied());
        let (low, high) = extent(values.chain([0.0, bound])).unwrap_or((0.0, 1.0));
        Axis::exact((low, high), Y_TICKS)
    };
    let x = || Axis::exact((low, high), X_TICKS);
    let bound = Stroke::solid(GREY, 0.8);
    let above = Panel {
        series: trace(&view.llewellyn, llewellyn)
            .into_iter()
            .chain(trace(&vec![1.0; view.values.len()], bound))
            .collect(),
        ..Panel::new(x(), "", axis(&[&view.llewellyn], 1.0), "Llewellyn's parameter")
    };
    let below = Panel {
        series: trace(&view.of_arm, of_arm).into_iter().chain(trace(&view.needed, needed)).collect(),
        ..Panel::new(x(), &view.caption, axis(&[&view.needed, &view.of_arm], 1.0), "Damping of the hand (N·s/m)")
    };
    let legend = vec![
        (Sample::Line(llewellyn), "smallest over the frequencies; absolutely stable from 1 on".to_owned()),
        (Sample::Line(needed), "damping that every hand needs".to_owned()),
        (Sample::Line(of_arm), "damping of the scenario's arm there".to_owned()),
    ];
    Ok(Figure { name: view.name.clone(), legend, rows: vec![Row::of(120.0, above), Row::of(140.0, below)] })
}
