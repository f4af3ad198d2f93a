//! The Kelvin-Voigt model (eq. 1).

use super::{Reaction, Tissue};
use crate::error::{InvalidValue, finite, non_negative};
use crate::lane::{Lane, Mask};

/// `f = K p + B v` for `p > 0`, 0 otherwise, with `p = x_e - contact` (eq. 1, in this crate's sign).
#[derive(Debug, Clone, Copy)]
pub struct KelvinVoigt<L> {
    stiffness: L,
    damping: L,
    contact: L,
}

impl<L: Lane> KelvinVoigt<L> {
    /// A tissue of stiffness `K` (N/m) and damping `B` (N·s/m), both at least 0, whose surface is at `contact_m` (m).
    ///
    /// # Errors
    /// [`InvalidValue`] naming the parameter out of range.
    pub fn new(stiffness_n_per_m: f64, damping_n_s_per_m: f64, contact_m: f64) -> Result<Self, InvalidValue> {
        Ok(Self {
            stiffness: L::splat(non_negative("tissue.stiffness_n_per_m", stiffness_n_per_m)?),
            damping: L::splat(non_negative("tissue.damping_n_s_per_m", damping_n_s_per_m)?),
            contact: L::splat(finite("tissue.contact_m", contact_m)?),
        })
    }
}

impl<L: Lane> Tissue<L> for KelvinVoigt<L> {
    #[inline(always)]
    fn react(&mut self, _tick: u64, position: L, velocity: L) -> Reaction<L> {
        let depth = position - self.contact;
        let force = self.stiffness * depth + self.damping * velocity;
        Reaction { force_n: L::select(depth.gt(L::zero()), force, L::zero()), ruptured: L::Mask::splat(false) }
    }
}

crate::lane::gather!(KelvinVoigt { stiffness, damping, contact });

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_answers_only_in_contact() {
        let mut tissue = KelvinVoigt::<f64>::new(200.0, 5.0, 0.01).expect("valid");
        assert_eq!(tissue.react(0, 0.01, 1.0).force_n, 0.0);
        assert!((tissue.react(0, 0.03, -0.1).force_n - 3.5).abs() < 1e-12);
        assert!(KelvinVoigt::<f64>::new(-1.0, 0.0, 0.0).is_err());
    }
}
