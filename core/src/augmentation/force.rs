//! The force that is fed back: the measured one, the exaggerated one, and the cross-fade between them.
//!
//! It is continuous at both ends: what it may change by in one tick is stated with each command and measured.

use super::automaton::{Mode, blend_ticks, has_become, has_changed, is};
use crate::lane::{Lane, Mask};

crate::choice! {
    /// Let the felt force decay, or scale its variation.
    ///
    /// `F*` is the force fed back just before the alarm.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub enum ForceLaw at "augmentation.force_law" = Decay {
        /// `F* → ratio · F*`, exponentially: the same crisp drop at every rupture, whatever its size.
        "decay" => Decay in "augmentation.decay_" {
            /// Where decay ends, as a share of the force at the alarm.
            ratio: f64 [SHARE] = 0.0,
            /// How fast it decays.
            ///
            /// Time constant in s.
            time_constant_s: f64 [POSITIVE] = 0.03,
        },
        /// `F* + κ (F_e - F*)`, floored at 0: the measured variation is scaled, and its size still tells.
        "amplify" => Amplify in "augmentation." {
            /// kappa of amplify.
            gain: f64 at "augmentation.amplification" [AT_LEAST_ONE] = 2.0,
        },
    }
}

/// `u² (3 - 2u)`: the weight of what a cross-fade ends on, by its progress `u` from 0 to 1.
#[inline(always)]
#[must_use]
pub fn cross_fade<L: Lane>(progress: L) -> L {
    progress * progress * (L::splat(3.0) - L::splat(2.0) * progress)
}

/// The fed-back force.
///
/// ```text
/// teleoperation  F = F_e                                     |ΔF| <= |ΔF_e|
/// decay          F = F∞ + (F⁻ - F∞) exp(-T/τ), F∞ = ratio F* |ΔF| <= |F⁻ - F∞| (1 - exp(-T/τ))
/// amplify        F = max(F* + κ (F_e - F*), min(F*, 0))      |ΔF| <= κ |ΔF_e|
/// reengaging     F = F_a + w (F_e - F_a), w = u² (3 - 2u)    |ΔF| <= w |ΔF_e| + Δw |F_e⁻ - F_a|
/// ```
/// `F⁻`: the tick before; `F_a`: the last augmented force; `u` runs from 0 to 1 over the blend. The floor of a force
/// that pulled already is that force, as a jump to 0 would be felt.
#[derive(Debug, Clone)]
pub(super) struct ForceFeedback<L> {
    law: ForceLaw,
    ratio: L,
    keep: L,
    gain: L,
    blend_step: L,
    anchor: L,
    augmented: L,
    progress: L,
    weight: L,
    /// The last tick's force, kept outside of teleoperation, where it is the measured one.
    fed_back: L,
    measured: L,
    mode: L,
}

impl<L: Lane> ForceFeedback<L> {
    pub(super) fn new(law: ForceLaw, blend_s: f64, tick_s: f64) -> Self {
        let (ratio, keep, gain) = match law {
            ForceLaw::Decay { ratio, time_constant_s } => (ratio, libm::exp(-tick_s / time_constant_s), 1.0),
            ForceLaw::Amplify { gain } => (0.0, 0.0, gain),
        };
        Self {
            law,
            ratio: L::splat(ratio),
            keep: L::splat(keep),
            gain: L::splat(gain),
            blend_step: L::splat(1.0 / blend_ticks(blend_s, tick_s)),
            mode: L::splat(Mode::Teleoperation.code()),
            anchor: L::zero(),
            augmented: L::zero(),
            progress: L::splat(1.0),
            weight: L::splat(1.0),
            fed_back: L::zero(),
            measured: L::zero(),
        }
    }

    /// Passes a force on in teleoperation; gives the allowed step.
    #[inline(always)]
    pub(super) fn pass(&mut self, force: L) -> L {
        let allowed = (force - self.measured).abs();
        self.measured = force;
        allowed
    }

    /// The force in the mode that has arrived over the link, and the allowed step.
    ///
    /// Where the link has swallowed a change of mode, the force goes its own way to the mode's: back to the measured one
    /// only through the whole cross-fade.
    #[inline(always)]
    pub(super) fn arrive(&mut self, mode: L, force: L) -> (L, L) {
        let before = self.mode;
        let code = |mode: Mode| L::splat(mode.code());
        let unblended = is(before, Mode::Reengaging) & self.progress.lt(L::splat(1.0));
        let skips_back = is(mode, Mode::Teleoperation) & (is(before, Mode::Augmented) | unblended);
        let nothing_to_blend = is(mode, Mode::Reengaging) & is(before, Mode::Teleoperation);
        let mode = L::select(skips_back, code(Mode::Reengaging), mode);
        let mode = L::select(nothing_to_blend, code(Mode::Teleoperation), mode);
        self.mode = mode;
        if (is(before, Mode::Teleoperation) & is(mode, Mode::Teleoperation)).all() {
            return (force, self.pass(force));
        }
        self.update(before, mode, force)
    }

    /// The force in any mode, and the allowed step.
    #[inline(always)]
    pub(super) fn update(&mut self, before: L, mode: L, force: L) -> (L, L) {
        let zero = L::zero();
        let one = L::splat(1.0);
        let moved = (force - self.measured).abs();
        if has_changed(before, mode) {
            core::hint::cold_path();
            self.fed_back = L::select(is(before, Mode::Teleoperation), self.measured, self.fed_back);
            self.anchor = L::select(has_become(before, mode, Mode::Augmented), self.fed_back, self.anchor);
            let starting = has_become(before, mode, Mode::Reengaging);
            self.progress = L::select(starting, zero, self.progress);
            self.weight = L::select(starting, zero, self.weight);
        }

        let (augmented, augmented_step) = match self.law {
            ForceLaw::Decay { .. } => {
                let end = self.ratio * self.anchor;
                let gap = self.fed_back - end;
                (end + gap * self.keep, gap.abs() * (one - self.keep))
            }
            ForceLaw::Amplify { .. } => {
                let scaled = self.anchor + self.gain * (force - self.anchor);
                (scaled.max(self.anchor.min(zero)), self.gain * moved)
            }
        };
        let is_augmented = is(mode, Mode::Augmented);
        self.augmented = L::select(is_augmented, augmented, self.augmented);

        let is_reengaging = is(mode, Mode::Reengaging);
        let progress = (self.progress + self.blend_step).min(one);
        // The last step ends on 1 whatever the rounding of the sum.
        let progress = L::select(progress.ge(one - L::splat(0.5) * self.blend_step), one, progress);
        let weight = cross_fade(progress);
        let faded = self.augmented + weight * (force - self.augmented);
        let faded_step = weight * moved + (weight - self.weight) * (self.measured - self.augmented).abs();
        self.progress = L::select(is_reengaging, progress, one);
        self.weight = L::select(is_reengaging, weight, one);

        let fed_back = L::select(is_augmented, augmented, L::select(is_reengaging, faded, force));
        let allowed = L::select(is_augmented, augmented_step, L::select(is_reengaging, faded_step, moved));
        self.fed_back = fed_back;
        self.measured = force;
        (fed_back, allowed)
    }
}

crate::lane::gather!(ForceFeedback {
    ratio, keep, gain, blend_step, anchor, augmented, progress, weight, fed_back, measured, mode,
} kinds { law });
