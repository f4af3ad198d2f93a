use trocar_core::lane::Lane;

#[derive(Debug, Clone, Copy)]
pub(super) struct ShaftContact<L> {
    pub(super) kinetic_n: L,
    pub(super) length_m: L,
}

impl<L: Lane> ShaftContact<L> {
    pub(super) fn none() -> Self {
        Self { kinetic_n: L::zero(), length_m: L::zero() }
    }

    #[inline(always)]
    pub(super) fn and(self, friction_n_per_m: L, grip_n: L, length_m: L) -> Self {
        let grip = L::select(length_m.gt(L::zero()), grip_n, L::zero());
        Self { kinetic_n: self.kinetic_n + (friction_n_per_m * length_m + grip), length_m: self.length_m + length_m }
    }
}

trocar_core::lane::gather!(ShaftContact { kinetic_n, length_m });

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_friction_of_layers_adds_up_and_a_layer_without_length_has_no_grip() {
        let contact = ShaftContact::<f64>::none().and(10.0, 0.5, 0.02).and(30.0, 0.25, 0.01).and(99.0, 9.0, 0.0);
        assert!((contact.kinetic_n - (0.2 + 0.5 + 0.3 + 0.25)).abs() < 1e-12, "{contact:?}");
        assert!((contact.length_m - 0.03).abs() < 1e-15);
    }
}
