mod adaptive;
mod force_derivative;
mod likelihood_ratio;
mod linear_fit;
mod mean_change;
mod moving_average;
mod page_hinkley;
mod parameter_change;
mod squared_residual;
mod tail;
mod variance_change;
mod windowed_derivative;

pub use adaptive::Adaptive;
pub use force_derivative::ForceDerivative;
pub use likelihood_ratio::{LikelihoodRatio, MAX_WINDOW_SAMPLES, WindowSettings};
pub use linear_fit::LinearFit;
pub use mean_change::MeanChange;
pub use moving_average::MovingAverage;
pub use page_hinkley::PageHinkley;
pub use parameter_change::ParameterChange;
pub use squared_residual::SquaredResidual;
pub use tail::RateSettings;
pub use variance_change::VarianceChange;
pub use windowed_derivative::WindowedDerivative;

use super::DetectorInput;
use super::hypotheses::Hypotheses;
use crate::lane::Lane;

/// User-defined distances implement it for `f64`.
pub trait Distance<L: Lane> {
    /// `s_k`.
    fn update(&mut self, input: &DetectorInput<L>) -> L;

    /// Discards earlier samples after an alarm.
    #[inline(always)]
    fn reset(&mut self, _mask: L::Mask) {}

    /// If false, `s_k - ν` is compared with the threshold.
    #[inline(always)]
    fn accumulates(&self) -> bool {
        true
    }

    /// Lanes in which a self-arming distance can judge a sample; otherwise `None`.
    #[inline(always)]
    fn is_ready(&self) -> Option<L::Mask> {
        None
    }
}

#[cfg(feature = "alloc")]
impl<L: Lane, D: Distance<L> + ?Sized> Distance<L> for alloc::boxed::Box<D> {
    fn update(&mut self, input: &DetectorInput<L>) -> L {
        (**self).update(input)
    }

    fn reset(&mut self, mask: L::Mask) {
        (**self).reset(mask);
    }

    fn accumulates(&self) -> bool {
        (**self).accumulates()
    }

    fn is_ready(&self) -> Option<L::Mask> {
        (**self).is_ready()
    }
}

trait BuiltIn {
    const UNIT: &'static str;
    const ACCUMULATES: bool = true;
    const IS_ONE_SIDED: bool = false;
    const IS_BASELINE: bool = false;
    const WAITS_FOR: Option<&'static str> = None;

    fn tuning(hypotheses: &Hypotheses) -> (f64, f64);

    fn new(settings: &DistanceSettings, tick_s: f64) -> Self;

    fn restarted(&self, settings: &DistanceSettings, tick_s: f64) -> Self
    where
        Self: Sized,
    {
        Self::new(settings, tick_s)
    }
}

crate::registry! {
    /// Distance: e², eq. 22, eq. 23, the parameters of eq. 26, the derivative, the likelihood ratio, Page-Hinkley,
    /// adaptive (needs no settings and no contact position), or a baseline: moving average, windowed derivative, linear
    /// fit.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum DistanceKind at "detector.distance" = SquaredResidual;
    /// Any built-in distance.
    pub enum AnyDistance<L> by (each, of_kind) stored;

    "squared-residual" => SquaredResidual = squared_residual::SquaredResidual,
    "mean-change" => MeanChange = mean_change::MeanChange,
    "variance-change" => VarianceChange = variance_change::VarianceChange,
    "parameter-change" => ParameterChange = parameter_change::ParameterChange,
    "force-derivative" => ForceDerivative = force_derivative::ForceDerivative,
    "likelihood-ratio" => LikelihoodRatio = likelihood_ratio::LikelihoodRatio,
    "page-hinkley" => PageHinkley = page_hinkley::PageHinkley,
    "adaptive" => Adaptive = adaptive::Adaptive,
    "moving-average" => MovingAverage = moving_average::MovingAverage,
    "windowed-derivative" => WindowedDerivative = windowed_derivative::WindowedDerivative,
    "linear-fit" => LinearFit = linear_fit::LinearFit,
}

crate::settings! {
    /// All are valid for every kind, because a study compares all kinds.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct DistanceSettings in "detector." {
        /// Kind of distance.
        kind: DistanceKind,
        /// Compared hypotheses.
        hypotheses: Hypotheses,
        /// Window of the likelihood ratio.
        window: WindowSettings,
        /// Of the adaptive distance.
        rate: RateSettings,
    }
}

impl DistanceKind {
    /// True if accumulated (eq. 27).
    #[must_use]
    pub fn accumulates(self) -> bool {
        of_kind!(self, Part => Part::<f64>::ACCUMULATES)
    }

    /// True if only a shift with the sign of `m_1` counts.
    #[must_use]
    pub fn is_one_sided(self) -> bool {
        of_kind!(self, Part => Part::<f64>::IS_ONE_SIDED)
    }

    /// True without a model of the tissue.
    #[must_use]
    pub fn is_baseline(self) -> bool {
        of_kind!(self, Part => Part::<f64>::IS_BASELINE)
    }

    /// What a self-arming distance waits for.
    #[must_use]
    pub fn waits_for(self) -> Option<&'static str> {
        of_kind!(self, Part => Part::<f64>::WAITS_FOR)
    }

    /// Unit of distance, threshold and drift.
    #[must_use]
    pub fn unit(self) -> &'static str {
        of_kind!(self, Part => Part::<f64>::UNIT)
    }
}

impl Hypotheses {
    /// γ and ν in the distance's unit: ν is halfway between the hypotheses, γ one sample's contribution after the
    /// change.
    #[must_use]
    pub fn tuning(&self, kind: DistanceKind) -> (f64, f64) {
        of_kind!(kind, Part => Part::<f64>::tuning(self))
    }
}

impl<L: Lane> AnyDistance<L> {
    /// For samples `tick_s` apart.
    #[must_use]
    pub fn new(settings: &DistanceSettings, tick_s: f64) -> Self {
        of_kind!(settings.kind, Part => <Part<L> as BuiltIn>::new(settings, tick_s).into())
    }

    /// Starts anew after a gap; the adaptive distance keeps the sensor's offset.
    #[must_use]
    pub fn restarted(&self, settings: &DistanceSettings, tick_s: f64) -> Self {
        each!(self, distance => distance.restarted(settings, tick_s).into())
    }
}

impl<L: Lane> Distance<L> for AnyDistance<L> {
    #[inline(always)]
    fn update(&mut self, input: &DetectorInput<L>) -> L {
        each!(self, distance => distance.update(input))
    }

    #[inline(always)]
    fn reset(&mut self, mask: L::Mask) {
        each!(self, distance => distance.reset(mask));
    }

    #[inline(always)]
    fn accumulates(&self) -> bool {
        each!(self, distance => distance.accumulates())
    }

    #[inline(always)]
    fn is_ready(&self) -> Option<L::Mask> {
        each!(self, distance => distance.is_ready())
    }
}

impl DistanceSettings {
    /// [`Hypotheses::tuning`] of the kind.
    #[must_use]
    pub fn tuning(&self) -> (f64, f64) {
        self.hypotheses.tuning(self.kind)
    }
}

/// `powi` is not in `core`.
fn square(x: f64) -> f64 {
    x * x
}

#[cfg(test)]
mod tests {
    use super::super::fixtures::QUIET;
    use super::*;

    fn input(residual_n: f64, predicted_force_n: f64) -> DetectorInput<f64> {
        DetectorInput { force_n: predicted_force_n + residual_n, predicted_force_n, residual_n, ..QUIET }
    }

    fn log_density(e: f64, mean: f64, std: f64) -> f64 {
        -(e - mean).powi(2) / (2.0 * std * std) - std.ln()
    }

    #[test]
    fn eq_22_and_23_are_the_log_likelihood_ratios_of_eq_20() {
        for e in [-0.4, -0.07, 0.0, 0.03, 0.2] {
            let distance = |kind| {
                let settings = DistanceSettings { kind, ..DistanceSettings::DEFAULT };
                AnyDistance::<f64>::new(&settings, 1e-3).update(&input(e, 0.0))
            };
            let mean = log_density(e, -0.2, 0.02) - log_density(e, 0.0, 0.02);
            let variance = log_density(e, 0.0, 0.2) - log_density(e, 0.0, 0.02);
            assert!((distance(DistanceKind::MeanChange) - mean).abs() < 1e-9);
            assert!((distance(DistanceKind::VarianceChange) - variance).abs() < 1e-9);
        }
    }

    fn first(kind: DistanceKind, hypotheses: Hypotheses, residual_n: f64) -> f64 {
        let settings = DistanceSettings { kind, hypotheses, ..DistanceSettings::DEFAULT };
        AnyDistance::<f64>::new(&settings, 1e-3).update(&input(residual_n, 5.0))
    }

    #[test]
    fn one_sample_of_a_rupture_adds_the_threshold() {
        let hypotheses =
            Hypotheses { quiet_std_n: 0.03, rupture_std_n: 0.4, rupture_mean_n: -0.5, ..Hypotheses::DEFAULT };
        for (kind, residual_n) in [
            (DistanceKind::SquaredResidual, 0.4),
            (DistanceKind::VarianceChange, 0.4),
            (DistanceKind::MeanChange, -0.5),
            (DistanceKind::LikelihoodRatio, -0.5),
            (DistanceKind::ForceDerivative, 0.4),
            (DistanceKind::MovingAverage, 0.4),
            (DistanceKind::LinearFit, 0.4),
        ] {
            let settings = DistanceSettings { kind, hypotheses, ..DistanceSettings::DEFAULT };
            let (threshold, drift) = settings.tuning();
            let added = if kind.is_baseline() { residual_n * residual_n } else { first(kind, hypotheses, residual_n) };
            assert!((added - drift - threshold).abs() < 1e-9 * threshold, "{kind:?}: {added} {drift} {threshold}");
        }
    }

    #[test]
    fn a_sample_without_a_rupture_subtracts_the_threshold() {
        let hypotheses =
            Hypotheses { quiet_std_n: 0.03, rupture_std_n: 0.4, rupture_mean_n: -0.5, ..Hypotheses::DEFAULT };
        for (kind, residual_n) in [(DistanceKind::SquaredResidual, 0.03), (DistanceKind::MeanChange, 0.0)] {
            let (threshold, drift) = hypotheses.tuning(kind);
            assert!((first(kind, hypotheses, residual_n) - drift + threshold).abs() < 1e-9 * threshold, "{kind:?}");
        }
    }

    #[test]
    fn a_rupture_that_shifts_by_its_mean_adds_the_threshold() {
        let hypotheses = Hypotheses { rupture_mean_n: -0.5, stiffness_change_n_per_m: 30.0, ..Hypotheses::DEFAULT };
        let (threshold, drift) = hypotheses.tuning(DistanceKind::PageHinkley);
        assert_eq!((threshold, drift), (0.25, 0.25), "half of the shift");
        let (threshold, drift) = hypotheses.tuning(DistanceKind::ParameterChange);
        assert_eq!((threshold, drift), (0.5, 0.5), "half of the relative correction");
        for kind in [DistanceKind::Adaptive, DistanceKind::WindowedDerivative] {
            assert_eq!(hypotheses.tuning(kind), (7.0, 0.0), "multiples of the noise: {kind:?}");
        }
    }

    #[test]
    fn a_distance_accumulates_unless_it_has_a_window() {
        for kind in DistanceKind::ALL {
            let has_window = matches!(
                kind,
                DistanceKind::LikelihoodRatio | DistanceKind::Adaptive | DistanceKind::WindowedDerivative
            );
            let settings = DistanceSettings { kind, ..DistanceSettings::DEFAULT };
            let distance = AnyDistance::<f64>::new(&settings, 1e-3);
            assert_eq!((kind.accumulates(), distance.accumulates()), (!has_window, !has_window), "{kind:?}");
            let arms_itself = matches!(kind, DistanceKind::Adaptive | DistanceKind::WindowedDerivative);
            assert_eq!(
                (kind.waits_for().is_some(), distance.is_ready().is_some()),
                (arms_itself, arms_itself),
                "{kind:?}"
            );
            let has_direction = matches!(kind, DistanceKind::MeanChange | DistanceKind::PageHinkley);
            assert_eq!(kind.is_one_sided(), has_direction, "{kind:?}");
        }
    }

    #[cfg(feature = "alloc")]
    #[test]
    fn a_boxed_distance_behaves_like_the_distance_in_it() {
        use alloc::boxed::Box;
        let mut boxed: Box<dyn Distance<f64>> = Box::new(PageHinkley::<f64>::new(&DistanceSettings::DEFAULT, 1e-3));
        let at = |boxed: &mut Box<dyn Distance<f64>>, residual_n| boxed.update(&input(residual_n, 5.0));
        assert_eq!([at(&mut boxed, 1.0), at(&mut boxed, 0.0)], [0.0, 0.5]);
        boxed.reset(true);
        assert_eq!(at(&mut boxed, -4.0), 0.0, "the mean begins anew");
        assert!(boxed.accumulates() && boxed.is_ready().is_none());
        let derivative = WindowedDerivative::<f64>::new(&DistanceSettings::DEFAULT, 1e-3);
        let boxed: Box<dyn Distance<f64>> = Box::new(derivative);
        assert!(!boxed.accumulates() && boxed.is_ready() == Some(false));
    }
}
