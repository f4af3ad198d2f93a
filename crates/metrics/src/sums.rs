use trocar_core::lane::{Lane, by_index};

/// Partial sums per quantity. Tick `k` enters sum `k mod WAYS`: consecutive additions are independent, in the same
/// order on every machine and for any number of lanes.
const WAYS: usize = 4;

/// Maximum number of buffered ticks, a multiple of [`WAYS`].
const BLOCK: usize = 32;

/// Over lanes one tick fills the registers, and a short buffer leaves the cache to the tick.
const fn buffered_ticks<L: Lane>() -> usize {
    if L::WIDTH > 1 { 2 * WAYS } else { BLOCK }
}

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

#[derive(Debug, Clone, Copy)]
struct Block<L> {
    residual_n: [L; BLOCK],
    slave_m: [L; BLOCK],
    reference_m: [L; BLOCK],
    operator_power_w: [L; BLOCK],
    tissue_power_w: [L; BLOCK],
    tissue_force_n: [L; BLOCK],
}

#[derive(Debug, Clone, Copy)]
struct Partial<L> {
    absolute_residual: [L; WAYS],
    squared_tracking_error: [L; WAYS],
    operator_power: [L; WAYS],
    tissue_power: [L; WAYS],
    min_force: [L; WAYS],
    max_force: [L; WAYS],
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Totals {
    pub absolute_residual_n: f64,
    /// `Σ (x_e - x_ref)²` in m².
    pub squared_tracking_error_m2: f64,
    pub operator_power_w: f64,
    pub tissue_power_w: f64,
    pub min_force_n: f64,
    pub max_force_n: f64,
}

#[derive(Debug, Clone)]
#[repr(align(64))]
pub(super) struct Sums<L> {
    buffer: Block<L>,
    partial: Partial<L>,
}

impl<L: Lane> Sums<L> {
    pub(super) fn new() -> Self {
        let zero = [L::zero(); WAYS];
        Self {
            buffer: Block::neutral(),
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

    #[inline(always)]
    pub(super) fn push(&mut self, count: u64, sample: Sample<L>) {
        let (block, at) = (&mut self.buffer, count as usize % buffered_ticks::<L>());
        block.residual_n[at] = sample.residual_n;
        block.slave_m[at] = sample.slave_m;
        block.reference_m[at] = sample.reference_m;
        block.operator_power_w[at] = sample.operator_power_w;
        block.tissue_power_w[at] = sample.tissue_power_w;
        block.tissue_force_n[at] = sample.tissue_force_n;
        if at == buffered_ticks::<L>() - 1 {
            self.partial.add::<L>(&self.buffer);
        }
    }

    pub(super) fn recent(&self, index: u64) -> Sample<L> {
        let (block, at) = (&self.buffer, index as usize % buffered_ticks::<L>());
        Sample {
            residual_n: block.residual_n[at],
            slave_m: block.slave_m[at],
            reference_m: block.reference_m[at],
            operator_power_w: block.operator_power_w[at],
            tissue_power_w: block.tissue_power_w[at],
            tissue_force_n: block.tissue_force_n[at],
        }
    }

    /// Scalar arithmetic: after a run the lanes' instruction set is not enabled.
    pub(super) fn totals_of(&self, index: usize, count: u64) -> Totals {
        let Self { buffer, partial } = self;
        let (remaining, neutral) = (count as usize % buffered_ticks::<L>(), Sample::<f64>::neutral());
        let rest = |all: &[L; BLOCK], nothing: f64| -> [f64; BLOCK] {
            std::array::from_fn(|at| if at < remaining { all[at].lane(index) } else { nothing })
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
            residual_n: rest(&buffer.residual_n, neutral.residual_n),
            slave_m: rest(&buffer.slave_m, neutral.slave_m),
            reference_m: rest(&buffer.reference_m, neutral.reference_m),
            operator_power_w: rest(&buffer.operator_power_w, neutral.operator_power_w),
            tissue_power_w: rest(&buffer.tissue_power_w, neutral.tissue_power_w),
            tissue_force_n: rest(&buffer.tissue_force_n, neutral.tissue_force_n),
        });
        let sum = |ways: [f64; WAYS]| (ways[0] + ways[1]) + (ways[2] + ways[3]);
        let min = |ways: [f64; WAYS]| ways[0].min(ways[1]).min(ways[2].min(ways[3]));
        let max = |ways: [f64; WAYS]| ways[0].max(ways[1]).max(ways[2].max(ways[3]));
        Totals {
            absolute_residual_n: sum(sums.absolute_residual),
            squared_tracking_error_m2: sum(sums.squared_tracking_error),
            operator_power_w: sum(sums.operator_power),
            tissue_power_w: sum(sums.tissue_power),
            min_force_n: min(sums.min_force),
            max_force_n: max(sums.max_force),
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
    #[inline(always)]
    fn add<Width: Lane>(&mut self, block: &Block<L>) {
        gather::<_, Width>(&mut self.absolute_residual, &block.residual_n, |sum, e| sum + e.abs());
        let tracking_error: [L; BLOCK] = by_index!(BLOCK, |at| block.slave_m[at] - block.reference_m[at]);
        gather::<_, Width>(&mut self.squared_tracking_error, &tracking_error, |sum, error| sum + error * error);
        gather::<_, Width>(&mut self.operator_power, &block.operator_power_w, |sum, power| sum + power);
        gather::<_, Width>(&mut self.tissue_power, &block.tissue_power_w, |sum, power| sum + power);
        gather::<_, Width>(&mut self.min_force, &block.tissue_force_n, |min, force| force.min(min));
        gather::<_, Width>(&mut self.max_force, &block.tissue_force_n, |max, force| force.max(max));
    }
}

#[inline(always)]
fn gather<L: Lane, Width: Lane>(ways: &mut [L; WAYS], values: &[L; BLOCK], take: impl Fn(L, L) -> L) {
    // Iterator methods might not be inlined here.
    for at in 0..buffered_ticks::<Width>() {
        ways[at % WAYS] = take(ways[at % WAYS], values[at]);
    }
}
