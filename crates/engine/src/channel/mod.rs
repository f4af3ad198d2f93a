//! The link between the sides. Each direction delays its samples by whole ticks; the engine steps the remaining
//! fraction of a tick.

mod irregular;
mod schedule;

pub use irregular::{Irregularity, SampleDelays};
pub use schedule::Schedule;

use irregular::Irregular;
use trocar_core::lane::{Lane, Mask};

/// Maximum number of lanes with different delays.
const MAX_LANES: usize = trocar_core::lane::LANES;

/// Longest delay in ticks.
pub const MAX_DELAY_TICKS: u64 = 1_000_000;

trocar_core::settings! {
    /// The delays of the link.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct DelaySettings in "channel." {
        /// Delay each way, of any length. It replaces forward_delay_s and backward_delay_s of a base; beside them, in the
        /// same file, they have priority.
        delay_s: f64 [NON_NEGATIVE] = 0.0,
        /// Delay from master to slave, of any length; a sampled controller reads the samples that have arrived by its
        /// tick.
        forward_delay_s: f64 [NON_NEGATIVE] => "channel.delay_s" delay_s,
        /// Delay from slave to master, of any length.
        backward_delay_s: f64 [NON_NEGATIVE] => "channel.delay_s" delay_s,
    }
}

impl DelaySettings {
    /// The key of the delay each way.
    pub const BOTH: &str = "channel.delay_s";

    /// The key and the delay (s) of each way: forward, backward.
    #[must_use]
    pub fn of_each_way(&self) -> [(&'static str, f64); 2] {
        [("channel.forward_delay_s", self.forward_delay_s), ("channel.backward_delay_s", self.backward_delay_s)]
    }

    /// Whether a key is the delay of one way.
    #[must_use]
    pub fn is_one_way(key: &str) -> bool {
        matches!(key, "channel.forward_delay_s" | "channel.backward_delay_s")
    }
}

/// What the receiver has at a tick: the last sample that has arrived, of `N` numbers.
#[derive(Debug, Clone, Copy)]
pub struct Arrival<L: Lane, const N: usize> {
    /// The sample.
    pub sample: [L; N],
    /// Whether it has arrived at this tick.
    pub is_fresh: L::Mask,
}

/// One direction of the link, for samples of `N` numbers. Until the first one arrives, the receiver has the initial
/// one.
#[derive(Debug, Clone)]
pub struct Delay<L: Lane, const N: usize> {
    line: Box<[[L; N]]>,
    next: usize,
    /// The delay of each lane in ticks, if they differ: at least 1 and at most the length of the line.
    own_ticks: Option<Box<[usize]>>,
    irregular: Option<Box<Irregular<L, N>>>,
}

impl<L: Lane, const N: usize> Delay<L, N> {
    /// A delay of `ticks` (0: the same tick; limited to [`MAX_DELAY_TICKS`]) holding `initial`.
    #[must_use]
    pub fn new(ticks: u64, initial: [L; N]) -> Self {
        let line = vec![initial; ticks.min(MAX_DELAY_TICKS) as usize].into_boxed_slice();
        Self { line, next: 0, own_ticks: None, irregular: None }
    }

    /// Adds random and scheduled delays and losses, on ticks of `tick_s` (s). `random` is `(seed, first_stream)`: lane
    /// `i` uses stream `first_stream + i` of the seed.
    #[must_use]
    pub fn irregular(
        mut self,
        irregularity: &Irregularity,
        schedule: &Schedule,
        tick_s: f64,
        initial: [L; N],
        random: (u64, u64),
    ) -> Self {
        let ticks = self.line.len() as u64;
        let link = || Box::new(Irregular::new((irregularity, schedule), (ticks, tick_s), initial, random));
        self.irregular = (!irregularity.is_none() || !schedule.is_empty()).then(link);
        self
    }

    /// Whether a sample arrives at the tick that sends it.
    #[must_use]
    pub fn is_immediate(&self) -> bool {
        self.line.is_empty() && self.irregular.is_none()
    }

    /// Maximum delay in ticks of a sample that arrives.
    #[must_use]
    pub fn longest_ticks(&self) -> u64 {
        self.irregular.as_ref().map_or(self.line.len() as u64, |link| link.longest_ticks())
    }

    /// Sends a sample and returns the one that arrives.
    #[inline(always)]
    pub fn exchange(&mut self, sample: [L; N]) -> Arrival<L, N> {
        if let Some(link) = &mut self.irregular {
            return link.exchange(sample);
        }
        let is_fresh = L::Mask::splat(true);
        if let Some(own_ticks) = &self.own_ticks {
            let length = self.line.len();
            let place = |lane: usize| (self.next + length - own_ticks[lane]) % length;
            let places: [usize; MAX_LANES] = std::array::from_fn(|lane| if lane < L::WIDTH { place(lane) } else { 0 });
            let sent = |i: usize| L::from_lanes(|lane| self.line[places[lane]][i].lane(lane));
            let arrived = std::array::from_fn(sent);
            self.line[self.next] = sample;
            self.next = (self.next + 1) % length;
            return Arrival { sample: arrived, is_fresh };
        }
        let Some(slot) = self.line.get_mut(self.next) else { return Arrival { sample, is_fresh } };
        let arrived = std::mem::replace(slot, sample);
        self.next += 1;
        if self.next == self.line.len() {
            self.next = 0;
        }
        Arrival { sample: arrived, is_fresh }
    }
}

impl<const N: usize> trocar_core::lane::Gather for Delay<f64, N> {
    type Of<L: Lane> = Delay<L, N>;

    /// Delays of at least one tick may differ: the line is then as long as the longest delay.
    fn gather<L: Lane>(all: [&Self; trocar_core::lane::LANES]) -> Option<Delay<L, N>> {
        use trocar_core::lane::Gather;
        let lengths = trocar_core::lane::of_each!(all, |one| one.line.len());
        let irregular = Gather::gather(trocar_core::lane::of_each!(all, |one| &one.irregular))?;
        if all.iter().any(|one| one.next != 0) {
            return None;
        }
        if lengths == [lengths[0]; trocar_core::lane::LANES] {
            let line = Gather::gather(trocar_core::lane::of_each!(all, |one| &one.line))?;
            return Some(Delay { line, next: 0, own_ticks: None, irregular });
        }
        // Nothing has been sent yet: every entry of a line is the initial sample.
        let initial: [L; N] = Gather::gather(trocar_core::lane::of_each!(all, |one| one.line.first()?))?;
        let longest = lengths.into_iter().max().unwrap_or(0);
        let line = vec![initial; longest].into_boxed_slice();
        irregular.is_none().then(|| Delay { line, next: 0, own_ticks: Some(Box::new(lengths)), irregular: None })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_arrives_after_its_delay() {
        let arrivals = |ticks| {
            let mut delay = Delay::new(ticks, [9.0]);
            [1.0, 2.0, 3.0, 4.0].map(|sample| delay.exchange([sample]).sample[0])
        };
        assert_eq!(arrivals(0), [1.0, 2.0, 3.0, 4.0]);
        assert_eq!(arrivals(1), [9.0, 1.0, 2.0, 3.0]);
        assert_eq!(arrivals(3), [9.0, 9.0, 9.0, 1.0]);
    }
}
