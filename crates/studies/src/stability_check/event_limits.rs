//! Values of an event's parameters up to which every motion is certified to decay.

use trocar_core::augmentation::{AugmentationSettings, ForceLawSettings, Reengage};
use trocar_stability::{Peaks, StabilityError, SwitchingSettings};

/// Ratio of the certified to the uncertified value at which a search ends.
const MAX_RATIO: f64 = 1.05;

const STEP: f64 = 2.0;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EventLimit {
    pub key: &'static str,
    /// Unit of the key.
    pub value: f64,
    /// True if larger values are more difficult to certify.
    pub is_largest: bool,
    /// Certified; a value at most 5 % further is not.
    pub certified: Option<f64>,
    pub is_beyond_search: bool,
}

struct Parameter {
    key: &'static str,
    value: f64,
    is_largest: bool,
    /// The end that is easy to certify comes first.
    ends: (f64, f64),
    set: fn(&mut AugmentationSettings, f64),
}

fn parameters(settings: &SwitchingSettings) -> Vec<Parameter> {
    let augmentation = &settings.augmentation;
    let tick_s = settings.of_loop.tick_s;
    let of_law = match augmentation.force {
        ForceLawSettings::Amplify(law) => Some(Parameter {
            key: "augmentation.amplification",
            value: law.gain,
            is_largest: true,
            ends: (1.0, 1e3),
            set: |augmentation, value| {
                if let ForceLawSettings::Amplify(law) = &mut augmentation.force {
                    law.gain = value;
                }
            },
        }),
        ForceLawSettings::Decay(law) => Some(Parameter {
            key: "augmentation.decay_time_constant_s",
            value: law.time_constant_s,
            is_largest: true,
            ends: (tick_s, 1e3),
            set: |augmentation, value| {
                if let ForceLawSettings::Decay(law) = &mut augmentation.force {
                    law.time_constant_s = value;
                }
            },
        }),
        ForceLawSettings::Damp(law) => Some(Parameter {
            key: "augmentation.damp_damping_n_s_per_m",
            value: law.damping_n_s_per_m,
            is_largest: true,
            ends: (1e-3, 1e4),
            set: |augmentation, value| {
                if let ForceLawSettings::Damp(law) = &mut augmentation.force {
                    law.damping_n_s_per_m = value;
                }
            },
        }),
        // The certificate does not cover it.
        ForceLawSettings::Guide(_) => None,
    };
    let of_return = match augmentation.reengage {
        Reengage::Fade(fade) => Some(Parameter {
            key: "augmentation.gap_time_constant_s",
            value: fade.gap_time_constant_s,
            is_largest: true,
            ends: (tick_s, 1e3),
            set: |augmentation, value| {
                if let Reengage::Fade(fade) = &mut augmentation.reengage {
                    fade.gap_time_constant_s = value;
                }
            },
        }),
        Reengage::Ramp(_) | Reengage::RampUntilLoad(_) | Reengage::WhenStill(_) | Reengage::Clutch | Reengage::Snap => {
            None
        }
    };
    let automaton = &augmentation.automaton;
    let shortest_hold = Parameter {
        key: "augmentation.min_hold_s",
        value: automaton.min_hold_s,
        is_largest: false,
        ends: (automaton.max_hold_s, tick_s),
        set: |augmentation, value| augmentation.automaton.min_hold_s = value,
    };
    let refractory = Parameter {
        key: "augmentation.refractory_s",
        value: automaton.refractory_s,
        is_largest: false,
        ends: (trocar_stability::LONGEST_DWELL_S, tick_s),
        set: |augmentation, value| augmentation.automaton.refractory_s = value,
    };
    of_law.into_iter().chain(of_return).chain([shortest_hold, refractory]).collect()
}

impl EventLimit {
    pub fn of_each(settings: &SwitchingSettings, peaks: Option<&Peaks>) -> Result<Vec<Self>, StabilityError> {
        parameters(settings).iter().map(|parameter| Self::of(settings, peaks, parameter)).collect()
    }

    fn of(settings: &SwitchingSettings, peaks: Option<&Peaks>, parameter: &Parameter) -> Result<Self, StabilityError> {
        let &Parameter { key, value, is_largest, ends: (easy, difficult), set } = parameter;
        let is_certified = |value: f64| {
            let mut changed = settings.clone();
            set(&mut changed.augmentation, value);
            Peaks::exist(&changed, peaks)
        };
        let within = |value: f64| value.clamp(easy.min(difficult), easy.max(difficult));
        let step = if is_largest { STEP } else { 1.0 / STEP };
        let present = within(value);
        let (mut certified, mut fails) =
            if is_certified(present)? { (Some(present), None) } else { (None, Some(present)) };
        while let (Some(found), None) = (certified, fails)
            && found != difficult
        {
            let next = within(found * step);
            if is_certified(next)? { certified = Some(next) } else { fails = Some(next) }
        }
        while let (None, Some(failing)) = (certified, fails)
            && failing != easy
        {
            let next = within(failing / step);
            if is_certified(next)? { certified = Some(next) } else { fails = Some(next) }
        }
        while let (Some(found), Some(failing)) = (certified, fails)
            && (failing / found).max(found / failing) > MAX_RATIO
        {
            let middle = (found * failing).sqrt();
            if is_certified(middle)? { certified = Some(middle) } else { fails = Some(middle) }
        }
        Ok(Self { key, value, is_largest, certified, is_beyond_search: fails.is_none() })
    }
}
