use trocar_core::lane::Lane;

#[derive(Debug, Clone, Copy)]
pub(in crate::teleoperation) struct Port<L> {
    force: L,
    pub(in crate::teleoperation) position: L,
    pub(in crate::teleoperation) energy_j: L,
}

impl<L: Lane> Port<L> {
    pub(in crate::teleoperation) fn at(position: L) -> Self {
        Self { force: L::zero(), position, energy_j: L::zero() }
    }

    /// Adds the held force's work; returns the displacement.
    #[inline(always)]
    pub(in crate::teleoperation) fn moved(&mut self, position: L) -> L {
        let displacement = position - self.position;
        self.position = position;
        self.energy_j = self.energy_j + self.force * displacement;
        displacement
    }

    #[inline(always)]
    pub(in crate::teleoperation) fn hold(&mut self, force: L) {
        self.force = force;
    }

    #[inline(always)]
    pub(in crate::teleoperation) fn pushed(&mut self, position: L, force: L) -> L {
        let work = L::splat(0.5) * (force + self.force) * (position - self.position);
        (self.position, self.force) = (position, force);
        self.energy_j = self.energy_j + work;
        work
    }
}

#[derive(Debug, Clone, Copy)]
pub struct SlavePort<L> {
    pub force_n: L,
    /// Cost against the measured force, scaled to the master.
    pub cost_j_per_m: L,
    /// Since the last tick, scaled to the master; 0 when a reference is limited.
    pub work_j: L,
    pub position_m: L,
    pub velocity_m_per_s: L,
}

trocar_core::lane::gather!(Port { force, position, energy_j });

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_work_of_a_held_force_is_force_times_displacement() {
        let mut port = Port::<f64>::at(1.0);
        assert_eq!((port.moved(1.5), port.energy_j), (0.5, 0.0), "no force yet");
        port.hold(4.0);
        assert_eq!((port.moved(1.25), port.energy_j), (-0.25, -1.0));
        port.hold(-2.0);
        assert_eq!((port.moved(0.25), port.energy_j, port.position), (-1.0, 1.0, 0.25));
    }

    #[test]
    fn the_work_of_a_force_linear_in_position_is_the_work_of_its_mean() {
        let mut port = Port::<f64>::at(1.0);
        // A spring of 6 N/m stores 3 x².
        for position in [1.5, 1.2, 2.0] {
            port.pushed(position, 6.0 * (position - 1.0));
        }
        assert!((port.energy_j - 3.0).abs() < 1e-12, "{}", port.energy_j);
        assert_eq!(port.pushed(1.0, 0.0), -3.0);
    }
}
