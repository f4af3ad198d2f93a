pub(crate) trait System: Clone {
    type Model: Clone;
    type Unknown: Copy + PartialEq;

    fn value(unknown: Self::Unknown, model: &Self::Model) -> f64;

    fn set(unknown: Self::Unknown, model: &mut Self::Model, value: f64);

    fn is_positive(&self, unknown: Self::Unknown) -> bool;

    /// Relative to the motion or force of each recording. A simulation that diverges has errors of 1, so the optimiser
    /// rejects the step.
    fn errors(&self, model: &Self::Model) -> Vec<f64>;

    fn lengths(&self) -> Vec<usize>;

    /// Expected value and standard deviation, which scale the coordinate; `None` if the coordinate is the logarithm.
    fn expected(&self, unknown: Self::Unknown) -> Option<(f64, f64)>;

    /// `None` without a prior.
    fn prior_sd(&self, unknown: Self::Unknown) -> Option<f64>;
}

/// Errors of 1 if the simulation diverged.
pub(crate) fn relative_errors<'a>(
    simulated: Option<Vec<f64>>,
    measured: &'a [f64],
    factor: f64,
) -> impl Iterator<Item = f64> + use<'a> {
    (0..measured.len()).map(move |k| simulated.as_ref().map_or(1.0, |simulated| factor * (simulated[k] - measured[k])))
}
