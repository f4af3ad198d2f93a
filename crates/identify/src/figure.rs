use trocar_document::figure::{
    Axis, COMPUTED, Figure, Panel, Row, Sample, Series, Stroke, TISSUE, X_TICKS, Y_TICKS, extent,
};

pub(crate) struct Traces<'a> {
    pub(crate) recording: &'a str,
    pub(crate) fit_percent: Option<f64>,
    pub(crate) time_s: Vec<f64>,
    pub(crate) measured: (&'a [f64], &'static str),
    /// `None` if the simulation diverges.
    pub(crate) simulated: (Option<&'a [f64]>, &'static str),
    pub(crate) further: Option<(&'a [f64], Stroke, &'static str)>,
    pub(crate) factor: f64,
    pub(crate) captions: [&'static str; 2],
}

impl Traces<'_> {
    pub(crate) fn figure(&self) -> Figure<'static> {
        let Self { time_s, measured: (measured, of_measured), simulated: (simulated, of_simulated), .. } = self;
        let simulated = simulated.map_or_else(|| vec![f64::NAN; time_s.len()], <[f64]>::to_vec);
        let error: Vec<f64> = simulated.iter().zip(*measured).map(|(a, b)| a - b).collect();
        let lines: Vec<(&[f64], Stroke, &str)> = self
            .further
            .into_iter()
            .chain([(*measured, TISSUE, *of_measured), (simulated.as_slice(), COMPUTED, *of_simulated)])
            .collect();
        let time = Axis::exact((0.0, time_s.last().copied().unwrap_or(1.0)), X_TICKS);
        let series = |values: &[f64], stroke| Series::new(time_s.clone(), values.to_vec(), stroke).times(self.factor);
        let all = self.axis(lines.iter().flat_map(|(values, ..)| *values));
        let above = Panel {
            series: lines.iter().map(|(values, stroke, _)| series(values, *stroke)).collect(),
            legend: lines.iter().map(|(_, stroke, name)| (Sample::Line(*stroke), (*name).to_owned())).collect(),
            ..Panel::over_time(time.clone(), all, self.captions[0])
        };
        let below = Panel {
            series: vec![series(&error, COMPUTED)],
            ..Panel::over_time(time, self.axis(error.iter()), self.captions[1])
        };
        let fit = self.fit_percent.map_or_else(String::new, |percent| format!(", fit {percent:.1} %"));
        Figure {
            name: format!("{}{fit}", self.recording),
            legend: vec![],
            rows: vec![Row::of(140.0, above), Row::of(95.0, below)],
        }
    }

    fn axis<'a>(&self, values: impl Iterator<Item = &'a f64>) -> Axis {
        Axis::padded(extent(values.map(|value| self.factor * value)).unwrap_or((0.0, 1.0)), Y_TICKS - 1)
    }
}
