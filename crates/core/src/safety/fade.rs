use crate::lane::{Lane, Stored};

/// `s_k = clamp(s_{k-1} ± T / d, 0, 1)`.
#[derive(Debug, Clone)]
pub struct Fade<L> {
    step: L,
    share: L,
}

impl<L: Lane> Fade<L> {
    /// Begins at `share`.
    #[must_use]
    pub fn new(duration_s: f64, tick_s: f64, share: f64) -> Self {
        Self { step: L::splat((tick_s / duration_s).min(1.0)), share: L::splat(share) }
    }

    /// From 0 to 1.
    #[inline(always)]
    #[must_use]
    pub fn share(&self) -> L {
        self.share
    }

    /// Towards 1 while the force is present, else towards 0.
    #[inline(always)]
    pub fn update(&mut self, is_present: L::Mask) {
        let step = L::select(is_present, self.step, -self.step);
        self.share = (self.share + step).clamp(L::zero(), L::splat(1.0));
    }

    pub(super) fn complete(&mut self) {
        self.share = L::splat(1.0);
    }
}

impl Stored for Fade<f64> {
    fn numbers(&mut self, with: &mut dyn FnMut(&mut u64)) {
        self.share.numbers(with);
    }
}

crate::lane::gather!(Fade { step, share });

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_decays_and_returns_within_its_duration_and_stays_within_0_and_1() {
        let mut fade = Fade::<f64>::new(4e-3, 1e-3, 1.0);
        let mut shares = |is_present: bool| {
            [0; 5].map(|_| {
                fade.update(is_present);
                fade.share()
            })
        };
        assert_eq!(shares(false), [0.75, 0.5, 0.25, 0.0, 0.0]);
        assert_eq!(shares(true), [0.25, 0.5, 0.75, 1.0, 1.0]);
        let mut at_once = Fade::<f64>::new(1e-4, 1e-3, 1.0);
        at_once.update(false);
        assert_eq!(at_once.share(), 0.0);
    }
}
