//! The keys of what leads to an alarm: sensor, estimator, detector.

use super::{DISTANCES, PARAMETERS, key};
use crate::detection::{ArmingSettings, Hypotheses, WINDOW_SAMPLES};
use crate::estimation::{Forgetting, FrictionShape, MAX_FORGETTING_FACTOR};
use crate::scenario::keys::{Fallback, Key};
use crate::scenario::value::{Kind, Range as R, Value};
use Fallback::{Derived, Unset};
use Kind::{Choice, Flag, Number, Whole};

pub(super) const KEYS: &[Key] = &[
    // sensor
    key("sensor.force_bias_n", Number(R::ANY), number!(0.0), "What the force reading adds to every force."),
    key(
        "sensor.force_bandwidth_hz",
        Number(R::NON_NEGATIVE),
        number!(0.0),
        "First-order bandwidth of the force reading, ahead of its noise; 0: no lag.",
    ),
    key(
        "sensor.force_noise_std_n",
        Number(R::NON_NEGATIVE),
        number!(0.0),
        "Standard deviation of the white noise on the force.",
    ),
    key(
        "sensor.force_resolution_n",
        Number(R::NON_NEGATIVE),
        number!(0.0),
        "Step of the force reading; 0 reads exactly.",
    ),
    key(
        "sensor.force_range_n",
        Number(R::POSITIVE),
        Unset,
        "Greatest force reading, either way: beyond it readings are clipped; without a limit when not given.",
    ),
    key(
        "sensor.position_resolution_m",
        Number(R::NON_NEGATIVE),
        number!(0.0),
        "Step of the slave's encoder; above 0 the velocity is estimated by a Kalman filter.",
    ),
    key(
        "sensor.acceleration_std_m_per_s2",
        Number(R::POSITIVE),
        number!(0.5),
        "Acceleration that the Kalman filter expects.",
    ),
    // estimator
    key(
        "estimator.parameters",
        Choice(PARAMETERS),
        word!("stiffness-and-damping"),
        "K and B; K alone, as the paper tries in 3.2.1; with friction; mu, lambda and n of eq. 2; or with and without \
         friction, the smaller error counting.",
    ),
    key(
        "estimator.friction_speed_m_per_s",
        Number(R::POSITIVE),
        number!(FrictionShape::DEFAULT.speed_m_per_s),
        "Speed at which half of the friction acts.",
    ),
    key(
        "estimator.friction_length_m",
        Number(R::POSITIVE),
        number!(FrictionShape::DEFAULT.length_m),
        "Depth at which as much of an error is put down to the stiffness as to friction.",
    ),
    key(
        "estimator.forgetting",
        Choice(&["resetting", "exponential"]),
        word!("resetting"),
        "Restore the whole gain at reset_threshold (eq. 17), or forget a little with each correction.",
    ),
    key(
        "estimator.forgetting_factor",
        Number(R::stated(0.0, MAX_FORGETTING_FACTOR, "from 0 to 0.99999, a memory of 1e5 corrections")),
        number!(Forgetting::DEFAULT_FACTOR),
        "How much everything older counts after a correction, for exponential.",
    ),
    key(
        "estimator.normalisation",
        Number(R::NON_NEGATIVE),
        number!(1e6),
        "beta of eq. 14 in 1/m²: the gain no longer depends on depths beyond 1/sqrt(beta); 0: constant weighting.",
    ),
    key(
        "estimator.initial_gain",
        Number(R::POSITIVE),
        Derived("10 times the normalisation, or 1e4 without one"),
        "F_0 of eq. 13, times the identity.",
    ),
    key(
        "estimator.reset_threshold",
        Number(R::POSITIVE),
        Derived("2/initial_gain + 10/normalisation (ten full corrections), or 2/initial_gain + 5e-4 without one"),
        "alpha_0 of eq. 17, at which F_0 is restored.",
    ),
    key(
        "estimator.dead_zone_n",
        Number(R::NON_NEGATIVE),
        number!(0.03),
        "N_0 of eq. 15: smaller errors teach nothing.",
    ),
    key("estimator.contact_m", Number(R::ANY), number!(0.0), "Where the estimator takes the tissue to begin."),
    // detector
    key(
        "detector.distance",
        Choice(DISTANCES),
        word!("squared-residual"),
        "What decides: e², e² of drops, eq. 22, 23, the stiffness of eq. 26, the derivative, GLR or Page-Hinkley.",
    ),
    key(
        "detector.quiet_std_n",
        Number(R::POSITIVE),
        number!(Hypotheses::default().quiet_std_n),
        "sigma_0: spread of the residual when nothing happens.",
    ),
    key(
        "detector.rupture_std_n",
        Number(R::POSITIVE),
        number!(Hypotheses::default().rupture_std_n),
        "sigma_1: its spread after a rupture.",
    ),
    key(
        "detector.rupture_mean_n",
        Number(R::ANY),
        number!(Hypotheses::default().rupture_mean_n),
        "m_1 of eq. 22: its mean after a rupture.",
    ),
    key(
        "detector.stiffness_change_n_per_m",
        Number(R::POSITIVE),
        number!(Hypotheses::default().stiffness_change_n_per_m),
        "Correction of the stiffness that a rupture causes, for eq. 26.",
    ),
    key(
        "detector.window_samples",
        Whole(1),
        Fallback::Value(|| Value::Whole(WINDOW_SAMPLES as u64)),
        "How many samples the likelihood ratio looks back over, at most 64.",
    ),
    key(
        "detector.threshold",
        Number(R::POSITIVE),
        Derived("what one sample of a rupture adds; 1.98e-2 N² for the paper's variances"),
        "gamma: an alarm when g exceeds it, in the distance's unit.",
    ),
    key(
        "detector.drift",
        Number(R::ANY),
        Derived("halfway between the hypotheses; 2.02e-2 N² for the paper's variances"),
        "nu, taken off each sample (eq. 27), in the distance's unit.",
    ),
    key("detector.cap", Number(R::POSITIVE), Derived("ten thresholds"), "Largest value of g, in the distance's unit."),
    key(
        "detector.settle_s",
        Number(R::NON_NEGATIVE),
        number!(ArmingSettings::default().settle_s),
        "Quiet contact before alarms are taken.",
    ),
    key(
        "detector.drop_only",
        Flag,
        Fallback::Value(|| Value::Flag(ArmingSettings::default().drop_only)),
        "Whether only a force below an expected resisting force counts.",
    ),
    key(
        "detector.motion",
        Choice(&["any", "not-withdrawn", "inserting"]),
        word!("not-withdrawn"),
        "During which motion of the needle a drop counts.",
    ),
    key(
        "detector.withdrawal_speed_m_per_s",
        Number(R::NON_NEGATIVE),
        number!(ArmingSettings::default().withdrawal_speed_m_per_s),
        "Nothing counts while the needle is withdrawn faster than this (not-withdrawn).",
    ),
    key(
        "detector.insertion_speed_m_per_s",
        Number(R::NON_NEGATIVE),
        number!(ArmingSettings::default().insertion_speed_m_per_s),
        "Nothing counts while the needle goes in more slowly than this (inserting).",
    ),
    key(
        "detector.minimum_depth_m",
        Number(R::NON_NEGATIVE),
        number!(ArmingSettings::default().minimum_depth_m),
        "Nothing counts less deep below estimator.contact_m than this.",
    ),
];
