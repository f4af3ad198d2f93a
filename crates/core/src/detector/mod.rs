//! Detection of ruptures: a distance, its CUSUM, and the arming, which the paper omits.

mod arming;
mod cusum;
mod distances;
mod hypotheses;

pub use arming::{AlarmConditions, ArmingSettings, Motion};
pub use cusum::CusumSettings;
pub use distances::{
    Adaptive, AnyDistance, Distance, DistanceKind, DistanceSettings, ForceDerivative, LikelihoodRatio, LinearFit,
    MAX_WINDOW_SAMPLES, MeanChange, MovingAverage, PageHinkley, ParameterChange, RateSettings, SquaredResidual,
    VarianceChange, WindowSettings, WindowedDerivative,
};
pub use hypotheses::Hypotheses;

use crate::error::{InvalidValue, require};
use crate::estimation::Estimate;
use crate::lane::{Lane, Mask};
use arming::Arming;
use cusum::Cusum;

crate::settings! {
    /// Settings of the detector.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct DetectorSettings in "detector." no DEFAULT {
        /// Accumulated distance.
        distance: DistanceSettings,
        /// Of the accumulated distance.
        cusum: CusumSettings (&distance),
        /// Conditions on an alarm.
        arming: ArmingSettings,
    }
    then Self::check_direction;
}

impl DetectorSettings {
    /// The paper's detector (4.6), with a cap of ten thresholds.
    #[must_use]
    pub fn for_kind(kind: DistanceKind, hypotheses: Hypotheses) -> Self {
        let (threshold, drift) = hypotheses.tuning(kind);
        Self {
            distance: DistanceSettings { kind, hypotheses, ..DistanceSettings::DEFAULT },
            cusum: CusumSettings { threshold, drift, cap: 10.0 * threshold },
            arming: ArmingSettings::default(),
        }
    }

    fn check_direction(&self) -> Result<(), InvalidValue> {
        let mean_n = self.distance.hypotheses.rupture_mean_n;
        let misses_drops = self.distance.kind.is_one_sided() && self.arming.drop_only && mean_n > 0.0;
        let requirement = "below 0 if detector.drop_only is true";
        require("detector.rupture_mean_n", mean_n, !misses_drops, requirement).map(drop)
    }
}

impl Default for DetectorSettings {
    fn default() -> Self {
        Self::for_kind(DistanceKind::SquaredResidual, Hypotheses::default())
    }
}

/// Inputs at one sample.
#[derive(Debug, Clone, Copy)]
pub struct DetectorInput<L: Lane> {
    /// `y_k`.
    pub force_n: L,
    /// `ŷ_k`.
    pub predicted_force_n: L,
    /// `e_k = y_k - ŷ_k`.
    pub residual_n: L,
    /// `H_k` (eq. 25): stiffness (N/m) and damping (N·s/m).
    pub correction: [L; 2],
    /// Below the contact.
    pub depth_m: L,
    /// Positive into the tissue.
    pub velocity_m_per_s: L,
    /// Lanes in contact.
    pub in_contact: L::Mask,
}

impl<L: Lane> DetectorInput<L> {
    /// The depth is measured from the contact.
    #[inline(always)]
    #[must_use]
    pub fn new(force_n: L, depth_m: L, velocity_m_per_s: L, estimate: &Estimate<L>) -> Self {
        Self {
            force_n,
            predicted_force_n: estimate.predicted_force_n,
            residual_n: estimate.residual_n,
            correction: estimate.correction,
            depth_m,
            velocity_m_per_s,
            in_contact: depth_m.gt(L::zero()),
        }
    }
}

/// Output at one sample.
#[derive(Debug, Clone, Copy)]
pub struct Decision<L: Lane> {
    /// `s_k`.
    pub distance: L,
    /// `g_k` before a reset.
    pub decision: L,
    /// Lanes with an alarm.
    pub alarm: L::Mask,
}

/// User-defined detectors implement it for `f64`.
pub trait Detector<L: Lane> {
    /// Processes one sample.
    fn update(&mut self, input: &DetectorInput<L>) -> Decision<L>;
}

#[cfg(feature = "alloc")]
impl<L: Lane, D: Detector<L> + ?Sized> Detector<L> for alloc::boxed::Box<D> {
    fn update(&mut self, input: &DetectorInput<L>) -> Decision<L> {
        (**self).update(input)
    }
}

/// A distance, its CUSUM, and the arming.
#[derive(Debug, Clone)]
pub struct CusumDetector<L: Lane, D = AnyDistance<L>> {
    distance: D,
    cusum: Cusum<L>,
    arming: Arming<L>,
}

impl<L: Lane> CusumDetector<L> {
    /// For samples `tick_s` apart.
    #[must_use]
    pub fn new(settings: &DetectorSettings, tick_s: f64) -> Self {
        Self::with_distance(AnyDistance::new(&settings.distance, tick_s), settings, tick_s)
    }

    /// Starts anew after a gap.
    pub fn restart(&mut self, settings: &DetectorSettings, tick_s: f64) {
        *self = Self::with_distance(self.distance.restarted(&settings.distance, tick_s), settings, tick_s);
    }
}

impl<L: Lane, D> CusumDetector<L, D> {
    /// With the given distance.
    #[must_use]
    pub fn with_distance(distance: D, settings: &DetectorSettings, tick_s: f64) -> Self {
        Self { distance, cusum: Cusum::new(&settings.cusum), arming: Arming::new(&settings.arming, tick_s) }
    }

    /// Per lane, to run several detectors on the same samples.
    #[must_use]
    pub fn with_thresholds(mut self, threshold: L, cap: L) -> Self {
        self.cusum.set_thresholds(threshold, cap);
        self
    }
}

impl<D: Distance<f64>> CusumDetector<f64, D> {
    /// True if the next sample can raise an alarm.
    #[inline(always)]
    #[must_use]
    pub fn is_armed(&self) -> bool {
        self.distance.is_ready().unwrap_or_else(|| self.arming.is_armed())
    }
}

impl<L: Lane, D: Distance<L>> CusumDetector<L, D> {
    /// On an alarm at the next sample, for any `g`.
    #[inline(always)]
    pub fn conditions(&self, input: &DetectorInput<L>) -> AlarmConditions<L> {
        let conditions = self.arming.conditions(input);
        let yes = L::Mask::splat(true);
        match self.distance.is_ready() {
            Some(armed) => AlarmConditions { armed, in_contact: yes, is_drop: yes, ..conditions },
            None => conditions,
        }
    }
}

impl<L: Lane, D: Distance<L>> Detector<L> for CusumDetector<L, D> {
    #[inline(always)]
    fn update(&mut self, input: &DetectorInput<L>) -> Decision<L> {
        let distance = self.distance.update(input);
        let (decision, above) =
            if self.distance.accumulates() { self.cusum.update(distance) } else { self.cusum.hold(distance) };
        let alarm = match self.distance.is_ready() {
            Some(_) if above.any() => above & self.conditions(input).all(),
            Some(_) => above,
            None => self.arming.update(above, input),
        };
        if alarm.any() {
            self.cusum.reset(alarm);
            self.distance.reset(alarm);
        }
        Decision { distance, decision, alarm }
    }
}

impl<D: crate::lane::Gather> crate::lane::Gather for CusumDetector<f64, D> {
    type Of<L: Lane> = CusumDetector<L, D::Of<L>>;

    fn gather<L: Lane>(all: [&Self; crate::lane::LANES]) -> Option<Self::Of<L>> {
        use crate::lane::{Gather, of_each};
        Some(CusumDetector {
            distance: D::gather(of_each!(all, |one| &one.distance))?,
            cusum: Gather::gather(of_each!(all, |one| &one.cusum))?,
            arming: Gather::gather(of_each!(all, |one| &one.arming))?,
        })
    }
}

impl<D: crate::lane::Stored> crate::lane::Stored for CusumDetector<f64, D> {
    fn numbers(&mut self, with: &mut dyn FnMut(&mut u64)) {
        let Self { distance, cusum, arming } = self;
        distance.numbers(with);
        cusum.numbers(with);
        arming.numbers(with);
    }
}

#[cfg(test)]
mod fixtures;

#[cfg(test)]
mod tests {
    use super::*;

    fn input(residual: f64, velocity: f64) -> DetectorInput<f64> {
        DetectorInput { velocity_m_per_s: velocity, ..fixtures::with_residual(residual) }
    }

    #[test]
    fn a_small_drop_takes_as_many_samples_as_the_drift_predicts() {
        // e² - ν = 0.0289 - 0.0202 = 0.0087 per sample, which exceeds γ = 0.0198 at the third.
        let mut detector = CusumDetector::new(&DetectorSettings::default(), 1e-3);
        assert!((0..1000).all(|_| !detector.update(&input(0.01, 0.01)).alarm));
        let alarms: Vec<u32> = (1..=10).filter(|_| detector.update(&input(-0.17, 0.01)).alarm).collect();
        assert_eq!(alarms, [3]);
    }

    /// True if a drop of 15 N raises an alarm at a depth (m) and a velocity (m/s).
    fn raises_alarm(arming: ArmingSettings, depth_m: f64, velocity: f64) -> bool {
        let settings = DetectorSettings { arming, ..DetectorSettings::default() };
        let mut detector = CusumDetector::new(&settings, 1e-3);
        for _ in 0..1000 {
            detector.update(&input(0.01, 0.01));
        }
        detector.update(&DetectorInput { depth_m, ..input(-15.0, velocity) }).alarm
    }

    #[test]
    fn a_drop_counts_only_during_the_configured_motion() {
        let of = |motion| {
            let arming = ArmingSettings { motion, ..ArmingSettings::default() };
            [-0.03, -0.001, 0.0, 0.0009, 0.0011].map(|velocity| raises_alarm(arming, 0.02, velocity))
        };
        assert_eq!(of(Motion::Any), [true; 5]);
        assert_eq!(of(Motion::NotWithdrawn), [false, true, true, true, true]);
        assert_eq!(of(Motion::Inserting), [false, false, false, false, true]);
    }

    #[test]
    fn the_paper_tuning_follows_from_its_variances() {
        let settings = DetectorSettings::default();
        assert!((settings.cusum.threshold - 1.98e-2).abs() < 1e-12);
        assert!((settings.cusum.drift - 2.02e-2).abs() < 1e-12);
    }

    #[test]
    fn the_likelihood_ratio_finds_a_lasting_drop_that_no_single_sample_shows() {
        let settings = DetectorSettings::for_kind(DistanceKind::LikelihoodRatio, Hypotheses::default());
        let mut detector = CusumDetector::new(&settings, 1e-3);
        assert!((0..1000).all(|_| !detector.update(&input(0.0, 0.01)).alarm));
        // n e² / (2 σ_0²) > 50 at e = -0.08 N holds above 6.25 samples.
        let alarms: Vec<u32> = (1..=30).filter(|_| detector.update(&input(-0.08, 0.01)).alarm).collect();
        assert_eq!(alarms, [7]);
    }

    #[test]
    fn page_hinkley_ignores_a_constant_offset() {
        let settings = DetectorSettings::for_kind(DistanceKind::PageHinkley, Hypotheses::default());
        let mut detector = CusumDetector::new(&settings, 1e-3);
        assert!((0..1000).all(|_| !detector.update(&input(-0.5, 0.01)).alarm));
        // 0.16 - 0.1 N per sample, minus the change of the mean, exceeds 0.1 N at the second.
        let alarms: Vec<u32> = (1..=30).filter(|_| detector.update(&input(-0.66, 0.01)).alarm).collect();
        assert_eq!(alarms, [2]);
    }

    #[test]
    fn every_distance_finds_a_drop_of_half_a_newton() {
        for kind in DistanceKind::ALL {
            let settings = DetectorSettings::for_kind(kind, Hypotheses::default());
            assert!((settings.cusum.cap / settings.cusum.threshold - 10.0).abs() < 1e-12, "{kind:?}");
            let mut detector = CusumDetector::new(&settings, 1e-3);
            let sample = |drop: f64| DetectorInput { correction: [drop / 0.02, 0.0], ..input(drop, 0.01) };
            let quiet = (0..500).filter(|_| detector.update(&sample(-0.001)).alarm).count();
            let found = (0..5).filter(|k| detector.update(&sample(-0.5 * f64::from(*k))).alarm).count();
            assert_eq!((quiet, found), (0, 1), "{kind:?}");
        }
    }

    #[test]
    fn a_positive_mean_of_a_one_sided_distance_is_refused_where_only_drops_count() {
        let refused = |kind, rupture_mean_n, drop_only| {
            let mut settings = DetectorSettings::for_kind(kind, Hypotheses { rupture_mean_n, ..Hypotheses::default() });
            settings.arming.drop_only = drop_only;
            settings.validate().err().map(|error| error.name)
        };
        assert_eq!(refused(DistanceKind::MeanChange, 0.2, true), Some("detector.rupture_mean_n"));
        assert_eq!(refused(DistanceKind::MeanChange, -0.2, true), None);
        assert_eq!(refused(DistanceKind::MeanChange, 0.2, false), None);
        assert_eq!(refused(DistanceKind::SquaredResidual, 0.2, true), None, "a square has no direction");
    }

    #[test]
    fn an_alarm_resets_the_decision_and_the_distance() {
        let mut detector = CusumDetector::<f64>::new(&DetectorSettings::default(), 1e-3);
        for _ in 0..200 {
            detector.update(&input(0.0, 0.01));
        }
        let ruptured = detector.update(&input(-0.5, 0.01));
        assert!(ruptured.alarm);
        assert!((ruptured.distance - 0.25).abs() < 1e-12, "{ruptured:?}");
        assert!((ruptured.decision - 0.198).abs() < 1e-9, "the decision is that before the reset: {ruptured:?}");
        assert_eq!(detector.update(&input(-0.1, 0.01)).decision, 0.0, "0.01 N² is below the drift");

        let settings = DetectorSettings::for_kind(DistanceKind::LikelihoodRatio, Hypotheses::default());
        let mut detector = CusumDetector::<f64>::new(&settings, 1e-3);
        for _ in 0..200 {
            detector.update(&input(0.0, 0.01));
        }
        assert!(detector.update(&input(-1.0, 0.01)).alarm);
        // e² / (2 σ_0²) of this sample alone: the window has forgotten the rupture.
        assert!((detector.update(&input(-0.1, 0.01)).distance - 12.5).abs() < 1e-9);
    }

    #[test]
    fn a_distance_that_arms_itself_needs_no_contact_and_no_settling_time() {
        let settings = DetectorSettings::for_kind(DistanceKind::WindowedDerivative, Hypotheses::default());
        let outside = |force_n: f64, velocity_m_per_s: f64| DetectorInput {
            force_n,
            depth_m: -1.0,
            in_contact: false,
            velocity_m_per_s,
            ..fixtures::QUIET
        };
        let run = |samples: u32, velocity_m_per_s: f64| {
            let mut detector = CusumDetector::<f64>::new(&settings, 1e-3);
            for k in 0..samples {
                let sample = outside(5.0 + 0.01 * f64::from(k % 2), velocity_m_per_s);
                assert!(!detector.update(&sample).alarm, "{k}");
                let conditions = detector.conditions(&sample);
                assert!(conditions.in_contact && conditions.is_drop);
            }
            detector.update(&outside(3.0, velocity_m_per_s)).alarm
        };
        assert!(run(100, 0.01));
        assert!(!run(30, 0.01), "within 50 ms the noise is not known");
        assert!(!run(100, -0.03), "the motion is required of every distance");
    }

    fn drop_in_noise(samples: u64, seed: u64) -> Vec<DetectorInput<f64>> {
        let mut noise = fixtures::Noise(seed);
        let sample = |k: u64| {
            let residual = 0.01 * noise.next() - if k % 400 == 350 { 0.6 } else { 0.0 };
            let force_n = 2.0 + 1e-3 * k as f64 + residual;
            DetectorInput {
                force_n,
                depth_m: 0.01 + 1e-5 * k as f64,
                correction: [residual / 0.02, 0.1 * residual],
                ..input(residual, 0.01)
            }
        };
        (0..samples).map(sample).collect()
    }

    #[test]
    fn a_gathered_detector_decides_like_the_detector_in_its_first_lane() {
        for kind in DistanceKind::ALL {
            let one = |mean: f64| {
                let hypotheses = Hypotheses { rupture_mean_n: mean, ..Hypotheses::default() };
                CusumDetector::<f64>::new(&DetectorSettings::for_kind(kind, hypotheses), 1e-3)
            };
            let (mut first, other) = (one(-0.3), one(-0.2));
            let all = [&first, &other, &other, &other, &other, &other, &other, &other];
            let mut gathered = <CusumDetector<f64> as crate::lane::Gather>::gather::<f64>(all).expect("alike");
            for input in drop_in_noise(800, 5) {
                let (a, b) = (first.update(&input), gathered.update(&input));
                assert_eq!((a.distance, a.decision, a.alarm), (b.distance, b.decision, b.alarm), "{kind:?}");
            }
        }
    }

    #[cfg(feature = "alloc")]
    #[test]
    fn a_detector_continues_from_its_stored_state() {
        use crate::lane::Stored;
        for kind in DistanceKind::ALL {
            let new = || CusumDetector::<f64>::new(&DetectorSettings::for_kind(kind, Hypotheses::default()), 1e-3);
            let samples = drop_in_noise(1600, 9);
            let mut used = new();
            for input in &samples[..700] {
                used.update(input);
            }
            let mut restored = new();
            restored.restore(&used.state()).expect("the same settings");
            for input in &samples[700..] {
                let (a, b) = (used.update(input), restored.update(input));
                assert_eq!((a.distance, a.decision, a.alarm), (b.distance, b.decision, b.alarm), "{kind:?}");
            }
        }
    }
}
