//! What the optimiser and the intervals need to know about a machine.

/// A model with unknowns that recordings determine by least squares.
pub(crate) trait System: Clone {
    /// The values of all unknowns and constants.
    type Model: Clone;
    /// An unknown of the model.
    type Unknown: Copy + PartialEq;

    /// Returns the value of an unknown.
    fn value(unknown: Self::Unknown, model: &Self::Model) -> f64;

    /// Sets the value of an unknown.
    fn set(unknown: Self::Unknown, model: &mut Self::Model, value: f64);

    /// Returns true if the unknown is never negative.
    fn is_positive(&self, unknown: Self::Unknown) -> bool;

    /// Returns the errors of a model, relative to the motion or force of each recording. A simulation that diverges has
    /// errors of 1 at every sample. The optimiser then rejects the step.
    fn errors(&self, model: &Self::Model) -> Vec<f64>;

    /// Returns the number of errors of each recording.
    fn lengths(&self) -> Vec<usize>;

    /// Returns the expected value and its standard deviation of an unknown that may be negative, as its coordinate;
    /// `None` for an unknown whose coordinate is its logarithm.
    fn expected(&self, unknown: Self::Unknown) -> Option<(f64, f64)>;

    /// Returns the standard deviation of an unknown's prior; `None` without a prior.
    fn prior_sd(&self, unknown: Self::Unknown) -> Option<f64>;
}

/// Returns the errors of one recording times a factor, or errors of 1 if the simulation diverged.
pub(crate) fn relative_errors<'a>(
    simulated: Option<Vec<f64>>,
    measured: &'a [f64],
    factor: f64,
) -> impl Iterator<Item = f64> + use<'a> {
    (0..measured.len()).map(move |k| simulated.as_ref().map_or(1.0, |simulated| factor * (simulated[k] - measured[k])))
}
