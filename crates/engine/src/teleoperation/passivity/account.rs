use trocar_core::lane::Lane;

/// The energy that a side may spend at its port.
///
/// ```text
/// A += work of the port + received - sent,   A(0) = the side's share of E_0
/// E_m - E_s = A_m + A_s + in transit - E_0 >= -E_0
/// ```
/// Energies are sent as running totals, so a lost sample loses no energy.
#[derive(Debug, Clone)]
pub(super) struct Account<L> {
    pub(super) energy_j: L,
    sent: L,
    received: L,
}

impl<L: Lane> Account<L> {
    pub(super) fn new(energy_j: L) -> Self {
        Self { energy_j, sent: L::zero(), received: L::zero() }
    }

    #[inline(always)]
    pub(super) fn add(&mut self, work_j: L) {
        self.energy_j = self.energy_j + work_j;
    }

    #[inline(always)]
    pub(super) fn receive(&mut self, total_j: L) {
        self.energy_j = self.energy_j + (total_j - self.received);
        self.received = total_j;
    }

    #[inline(always)]
    pub(super) fn send(&mut self, energy_j: L) -> L {
        self.energy_j = self.energy_j - energy_j;
        self.sent = self.sent + energy_j;
        self.sent
    }

    /// Discards energy: two sides together hold no more than two that both begin.
    pub(super) fn peer_restarts(&mut self, max_j: L) {
        self.energy_j = self.energy_j.min(max_j);
        (self.sent, self.received) = (L::zero(), L::zero());
    }

    #[inline(always)]
    pub(super) fn demand(&self, wanted_j: L, counts_under_way: bool) -> L {
        let short = wanted_j - self.energy_j;
        if counts_under_way { self.received + short } else { short }
    }

    /// Demand beyond the energy in transit.
    #[inline(always)]
    pub(super) fn open(&self, demand_j: L, counts_under_way: bool) -> L {
        let open = if counts_under_way { demand_j - self.sent } else { demand_j };
        open.max(L::zero())
    }
}

trocar_core::lane::gather!(Account { energy_j, sent, received });

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lost_total_loses_no_energy() {
        let (mut from, mut to) = (Account::<f64>::new(1.0), Account::<f64>::new(0.0));
        let _lost = from.send(0.25);
        let total = from.send(0.5);
        to.receive(total);
        to.receive(total);
        assert_eq!((from.energy_j, to.energy_j), (0.25, 0.75));
        to.add(-0.5);
        assert_eq!(to.energy_j, 0.25);
    }

    #[test]
    fn energy_in_transit_is_not_demanded_again() {
        let (mut from, mut to) = (Account::<f64>::new(1.0), Account::<f64>::new(0.25));
        let demand = to.demand(1.0, true);
        assert_eq!(from.open(demand, true), 0.75);
        let total = from.send(0.5);
        // The demand is unchanged, and the energy has not arrived.
        assert_eq!((from.open(demand, true), from.open(demand, false)), (0.25, 0.75));
        to.receive(total);
        assert_eq!(from.open(to.demand(1.0, true), true), 0.25);
    }
}
