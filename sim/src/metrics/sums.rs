//! Sums over the ticks of a run, in lanes.

use crate::lane::{Lane, by_index};

/// How many partial sums there are of each quantity: tick `k` goes to number `k mod WAYS`, so that additions need not
/// wait for each other. The order is fixed, whatever the machine and the number of lanes.
const WAYS: usize = 4;

/// How many ticks wait at most before they are added together, a multiple of [`WAYS`].
const BLOCK: usize = 32;

/// How many do. Side by side each tick fills registers by itself, and few leave the cache to what the tick needs.
const fn ticks_waiting<L: Lane>() -> usize {
    if L::WIDTH > 1 { 2 * WAYS } else { BLOCK }
}

/// What is summed of one tick.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample<L> {
    /// `e` in N.
    pub residual_n: L,
    /// `x_e` in m.
    pub slave_m: L,
    /// `x_ref` in m.
    pub reference_m: L,
    /// `F_h v_h` in W.
    pub operator_power_w: L,
    /// `f_e v_e` in W.
    pub tissue_power_w: L,
    /// `f_e` in N.
    pub tissue_force_n: L,
}

impl<L: Lane> Sample<L> {
    /// A sample that leaves every sum and extreme as it is.
    #[inline(always)]
    fn neutral() -> Self {
        let zero = L::zero();
        Self {
            residual_n: zero,
            slave_m: zero,
            reference_m: zero,
            operator_power_w: zero,
            tissue_power_w: zero,
            tissue_force_n: L::splat(f64::NAN),
        }
    }

    /// The sample of the lanes that are `running`, with a tracking error only where they are also `following` the hand.
    #[inline(always)]
    pub(super) fn only(self, running: L::Mask, following: L::Mask) -> Self {
        let neutral = Self::neutral();
        let keep = |value, nothing| L::select(running, value, nothing);
        let reference = L::select(following, self.reference_m, self.slave_m);
        Self {
            residual_n: keep(self.residual_n, neutral.residual_n),
            slave_m: keep(self.slave_m, neutral.slave_m),
            reference_m: keep(reference, neutral.reference_m),
            operator_power_w: keep(self.operator_power_w, neutral.operator_power_w),
            tissue_power_w: keep(self.tissue_power_w, neutral.tissue_power_w),
            tissue_force_n: keep(self.tissue_force_n, neutral.tissue_force_n),
        }
    }
}

/// Samples that wait, one array per quantity.
#[derive(Debug, Clone, Copy)]
struct Block<L> {
    residual_n: [L; BLOCK],
    slave_m: [L; BLOCK],
    reference_m: [L; BLOCK],
    operator_power_w: [L; BLOCK],
    tissue_power_w: [L; BLOCK],
    tissue_force_n: [L; BLOCK],
}

/// The partial sums.
#[derive(Debug, Clone, Copy)]
struct Partial<L> {
    absolute_residual: [L; WAYS],
    squared_tracking_error: [L; WAYS],
    operator_power: [L; WAYS],
    tissue_power: [L; WAYS],
    min_force: [L; WAYS],
    max_force: [L; WAYS],
}

/// Sums and extremes over the samples so far.
#[derive(Debug, Clone, Copy)]
pub(super) struct Totals {
    /// `Σ |e|` in N.
    pub absolute_residual_n: f64,
    /// `Σ (x_e - x_ref)²` in m².
    pub squared_tracking_error_m2: f64,
    /// `Σ F_h v_h` in W.
    pub operator_power_w: f64,
    /// `Σ f_e v_e` in W.
    pub tissue_power_w: f64,
    /// Least `f_e` in N.
    pub min_force_n: f64,
    /// Greatest `f_e` in N.
    pub max_force_n: f64,
}

/// Sums that take a sample a tick.
#[derive(Debug, Clone)]
#[repr(align(64))]
pub(super) struct Sums<L> {
    waiting: Block<L>,
    partial: Partial<L>,
}

impl<L: Lane> Sums<L> {
    pub(super) fn new() -> Self {
        let zero = [L::zero(); WAYS];
        Self {
            waiting: Block::neutral(),
            partial: Partial {
                absolute_residual: zero,
                squared_tracking_error: zero,
                operator_power: zero,
                tissue_power: zero,
                min_force: [L::splat(f64::INFINITY); WAYS],
                max_force: [L::splat(f64::NEG_INFINITY); WAYS],
            },
        }
    }

    /// Takes the sample that comes after `count` others.
    #[inline(always)]
    pub(super) fn push(&mut self, count: u64, sample: Sample<L>) {
        let (block, at) = (&mut self.waiting, count as usize % ticks_waiting::<L>());
        block.residual_n[at] = sample.residual_n;
        block.slave_m[at] = sample.slave_m;
        block.reference_m[at] = sample.reference_m;
        block.operator_power_w[at] = sample.operator_power_w;
        block.tissue_power_w[at] = sample.tissue_power_w;
        block.tissue_force_n[at] = sample.tissue_force_n;
        if at == ticks_waiting::<L>() - 1 {
            self.partial.add::<L>(&self.waiting);
        }
    }

    /// The sample number `index`, one of the last few, as it was pushed.
    pub(super) fn recent(&self, index: u64) -> Sample<L> {
        let (block, at) = (&self.waiting, index as usize % ticks_waiting::<L>());
        Sample {
            residual_n: block.residual_n[at],
            slave_m: block.slave_m[at],
            reference_m: block.reference_m[at],
            operator_power_w: block.operator_power_w[at],
            tissue_power_w: block.tissue_power_w[at],
            tissue_force_n: block.tissue_force_n[at],
        }
    }

    /// The sums of lane `index` over `count` samples: by itself, as what is done after a run is not done in its instruction set.
    pub(super) fn totals_of(&self, index: usize, count: u64) -> Totals {
        let Self { waiting, partial } = self;
        let (still_waiting, neutral) = (count as usize % ticks_waiting::<L>(), Sample::<f64>::neutral());
        let rest = |all: &[L; BLOCK], nothing: f64| -> [f64; BLOCK] {
            std::array::from_fn(|at| if at < still_waiting { all[at].lane(index) } else { nothing })
        };
        let ways = |all: &[L; WAYS]| all.map(|way| way.lane(index));
        let mut sums = Partial {
            absolute_residual: ways(&partial.absolute_residual),
            squared_tracking_error: ways(&partial.squared_tracking_error),
            operator_power: ways(&partial.operator_power),
            tissue_power: ways(&partial.tissue_power),
            min_force: ways(&partial.min_force),
            max_force: ways(&partial.max_force),
        };
        sums.add::<L>(&Block {
            residual_n: rest(&waiting.residual_n, neutral.residual_n),
            slave_m: rest(&waiting.slave_m, neutral.slave_m),
            reference_m: rest(&waiting.reference_m, neutral.reference_m),
            operator_power_w: rest(&waiting.operator_power_w, neutral.operator_power_w),
            tissue_power_w: rest(&waiting.tissue_power_w, neutral.tissue_power_w),
            tissue_force_n: rest(&waiting.tissue_force_n, neutral.tissue_force_n),
        });
        let sum = |ways: [f64; WAYS]| (ways[0] + ways[1]) + (ways[2] + ways[3]);
        let least = |ways: [f64; WAYS]| ways[0].min(ways[1]).min(ways[2].min(ways[3]));
        let greatest = |ways: [f64; WAYS]| ways[0].max(ways[1]).max(ways[2].max(ways[3]));
        Totals {
            absolute_residual_n: sum(sums.absolute_residual),
            squared_tracking_error_m2: sum(sums.squared_tracking_error),
            operator_power_w: sum(sums.operator_power),
            tissue_power_w: sum(sums.tissue_power),
            min_force_n: least(sums.min_force),
            max_force_n: greatest(sums.max_force),
        }
    }
}

impl<L: Lane> Block<L> {
    fn neutral() -> Self {
        let neutral = Sample::neutral();
        Self {
            residual_n: [neutral.residual_n; BLOCK],
            slave_m: [neutral.slave_m; BLOCK],
            reference_m: [neutral.reference_m; BLOCK],
            operator_power_w: [neutral.operator_power_w; BLOCK],
            tissue_power_w: [neutral.tissue_power_w; BLOCK],
            tissue_force_n: [neutral.tissue_force_n; BLOCK],
        }
    }
}

impl<L: Lane> Partial<L> {
    /// Adds a block that was filled by a run over `Width`, each quantity for itself.
    #[inline(always)]
    fn add<Width: Lane>(&mut self, block: &Block<L>) {
        gather::<_, Width>(&mut self.absolute_residual, &block.residual_n, |sum, e| sum + e.abs());
        let tracking_error: [L; BLOCK] = by_index!(BLOCK, |at| block.slave_m[at] - block.reference_m[at]);
        gather::<_, Width>(&mut self.squared_tracking_error, &tracking_error, |sum, error| sum + error * error);
        gather::<_, Width>(&mut self.operator_power, &block.operator_power_w, |sum, power| sum + power);
        gather::<_, Width>(&mut self.tissue_power, &block.tissue_power_w, |sum, power| sum + power);
        gather::<_, Width>(&mut self.min_force, &block.tissue_force_n, |least, force| force.min(least));
        gather::<_, Width>(&mut self.max_force, &block.tissue_force_n, |greatest, force| force.max(greatest));
    }
}

/// Takes a block's values in their order, number `k` to partial result `k mod WAYS`.
#[inline(always)]
fn gather<L: Lane, Width: Lane>(ways: &mut [L; WAYS], values: &[L; BLOCK], take: impl Fn(L, L) -> L) {
    // By index: what iterators are made of may stay a call each where it is not compiled beside this.
    for at in 0..ticks_waiting::<Width>() {
        ways[at % WAYS] = take(ways[at % WAYS], values[at]);
    }
}
