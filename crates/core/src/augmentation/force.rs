use super::automaton::blend_ticks;
use super::force_laws::{AugmentedTick, ForceLaw};
use super::mode::{Mode, ModeChange, Modes};
use crate::lane::{Gather, LANES, Lane, Mask, Stored, of_each};

/// Weight `u² (3 - 2u)` of the final value.
#[inline(always)]
#[must_use]
pub fn cross_fade<L: Lane>(progress: L) -> L {
    progress * progress * (L::splat(3.0) - L::splat(2.0) * progress)
}

/// The feedback force is continuous at both ends of the cross-fade:
///
/// ```text
/// teleoperation  F = F_e                                     |ΔF| <= |ΔF_e|
/// augmented      F and the bound of |ΔF| by the force law
/// reengaging     F = F_a + w (F_e - F_a), w = u² (3 - 2u)    |ΔF| <= w |ΔF_e| + Δw |F_e⁻ - F_a|
/// ```
/// `F_a`: the last augmented force.
#[derive(Debug, Clone)]
pub(super) struct ForceFeedback<L, F> {
    law: F,
    blend_step: L,
    anchor: L,
    augmented: L,
    progress: L,
    weight: L,
    /// Not updated in teleoperation.
    fed_back: L,
    measured: L,
    mode: Modes<L>,
}

impl<L: Lane, F: ForceLaw<L>> ForceFeedback<L, F> {
    pub(super) fn new(law: F, blend_s: f64, tick_s: f64) -> Self {
        Self {
            law,
            blend_step: L::splat(1.0 / blend_ticks(blend_s, tick_s)),
            mode: Modes::splat(Mode::Teleoperation),
            anchor: L::zero(),
            augmented: L::zero(),
            progress: L::splat(1.0),
            weight: L::splat(1.0),
            fed_back: L::zero(),
            measured: L::zero(),
        }
    }

    /// If a link has lost a change of mode, the force passes through the skipped modes: only the complete cross-fade
    /// returns it to the measured force.
    #[inline(always)]
    pub(super) fn update(&mut self, mode: Modes<L>, force: L, velocity: L) -> (L, L) {
        if (self.mode.is_teleoperation() & mode.is_teleoperation()).all() {
            let allowed = (force - self.measured).abs();
            self.measured = force;
            return (force, allowed);
        }
        let before = self.mode;
        let unblended = before.is_reengaging() & self.progress.lt(L::splat(1.0));
        let skips_back = mode.is_teleoperation() & (before.is_augmented() | unblended);
        let nothing_to_blend = mode.is_reengaging() & before.is_teleoperation();
        self.mode = mode.set_where(skips_back, Mode::Reengaging).set_where(nothing_to_blend, Mode::Teleoperation);
        self.change(ModeChange { before, now: self.mode }, force, velocity)
    }

    #[inline(always)]
    fn change(&mut self, modes: ModeChange<L>, force: L, velocity: L) -> (L, L) {
        let zero = L::zero();
        let one = L::splat(1.0);
        let moved = (force - self.measured).abs();
        let begins = modes.has_become(Mode::Augmented);
        if modes.any_changed() {
            core::hint::cold_path();
            self.fed_back = L::select(modes.before.is_teleoperation(), self.measured, self.fed_back);
            self.anchor = L::select(begins, self.fed_back, self.anchor);
            let starting = modes.has_become(Mode::Reengaging);
            self.progress = L::select(starting, zero, self.progress);
            self.weight = L::select(starting, zero, self.weight);
        }

        let is_augmented = modes.now.is_augmented();
        let (mut augmented, mut augmented_step) = (self.augmented, zero);
        if is_augmented.any() {
            (augmented, augmented_step) = self.law.augmented(&AugmentedTick {
                anchor_n: self.anchor,
                last_n: self.fed_back,
                measured_n: force,
                moved_n: moved,
                velocity_m_per_s: velocity,
                begins,
            });
        }
        self.augmented = L::select(is_augmented, augmented, self.augmented);

        let is_reengaging = modes.now.is_reengaging();
        let progress = (self.progress + self.blend_step).min(one);
        // Exactly 1, despite rounding.
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

impl<F: Gather> Gather for ForceFeedback<f64, F> {
    type Of<L: Lane> = ForceFeedback<L, F::Of<L>>;

    fn gather<L: Lane>(all: [&Self; LANES]) -> Option<Self::Of<L>> {
        macro_rules! numbers {
            ($($field:ident)*) => {
                Some(ForceFeedback {
                    law: F::gather(of_each!(all, |one| &one.law))?,
                    $($field: Gather::gather(of_each!(all, |one| &one.$field))?,)*
                })
            };
        }
        numbers!(blend_step anchor augmented progress weight fed_back measured mode)
    }
}

impl<F: Stored> Stored for ForceFeedback<f64, F> {
    fn numbers(&mut self, with: &mut dyn FnMut(&mut u64)) {
        let Self { law, blend_step, anchor, augmented, progress, weight, fed_back, measured, mode } = self;
        law.numbers(with);
        for number in [blend_step, anchor, augmented, progress, weight, fed_back, measured] {
            number.numbers(with);
        }
        mode.numbers(with);
    }
}
