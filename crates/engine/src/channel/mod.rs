mod irregular;
mod schedule;

pub use irregular::Irregularity;
pub use schedule::Schedule;

use irregular::Irregular;
use trocar_core::lane::{Lane, Mask};

const MAX_LANES: usize = trocar_core::lane::LANES;

pub const MAX_DELAY_TICKS: u64 = 1_000_000;

trocar_core::settings! {
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct DelaySettings in "channel." {
        /// Delay each way, of any length; replaces the forward_delay_s and backward_delay_s of a base, but has lower
        /// priority than them in the same file.
        delay_s: f64 [NON_NEGATIVE] = 0.0,
        /// Delay from master to slave, of any length; a sampled controller reads the samples that have arrived by its
        /// tick.
        forward_delay_s: f64 [NON_NEGATIVE] => "channel.delay_s" delay_s,
        /// Delay from slave to master, of any length.
        backward_delay_s: f64 [NON_NEGATIVE] => "channel.delay_s" delay_s,
    }
}

impl DelaySettings {
    pub const BOTH: &str = "channel.delay_s";

    pub fn of_each_way(&self) -> [(&'static str, f64); 2] {
        [("channel.forward_delay_s", self.forward_delay_s), ("channel.backward_delay_s", self.backward_delay_s)]
    }

    pub fn is_one_way(key: &str) -> bool {
        matches!(key, "channel.forward_delay_s" | "channel.backward_delay_s")
    }
}

#[derive(Debug, Clone, Copy)]
pub struct Arrival<L: Lane, const N: usize> {
    pub sample: [L; N],
    pub is_fresh: L::Mask,
}

#[derive(Debug, Clone)]
pub struct Delay<L: Lane, const N: usize> {
    line: Box<[[L; N]]>,
    next: usize,
    /// If the lanes differ: from 1 to the length of the line.
    lane_ticks: Option<Box<[usize]>>,
    irregular: Option<Box<Irregular<L, N>>>,
}

impl<L: Lane, const N: usize> Delay<L, N> {
    pub fn new(ticks: u64, initial: [L; N]) -> Self {
        let line = vec![initial; ticks.min(MAX_DELAY_TICKS) as usize].into_boxed_slice();
        Self { line, next: 0, lane_ticks: None, irregular: None }
    }

    /// `random` is `(seed, first_stream)`; lane `i` uses stream `first_stream + i`.
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

    pub fn is_immediate(&self) -> bool {
        self.line.is_empty() && self.irregular.is_none()
    }

    pub fn longest_ticks(&self) -> u64 {
        self.irregular.as_ref().map_or(self.line.len() as u64, |link| link.longest_ticks())
    }

    #[inline(always)]
    pub fn exchange(&mut self, sample: [L; N]) -> Arrival<L, N> {
        if let Some(link) = &mut self.irregular {
            return link.exchange(sample);
        }
        let is_fresh = L::Mask::splat(true);
        if let Some(lane_ticks) = &self.lane_ticks {
            let length = self.line.len();
            let place = |lane: usize| (self.next + length - lane_ticks[lane]) % length;
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

    fn gather<L: Lane>(all: [&Self; trocar_core::lane::LANES]) -> Option<Delay<L, N>> {
        use trocar_core::lane::Gather;
        let lengths = trocar_core::lane::of_each!(all, |one| one.line.len());
        let irregular = Gather::gather(trocar_core::lane::of_each!(all, |one| &one.irregular))?;
        if all.iter().any(|one| one.next != 0) {
            return None;
        }
        if lengths == [lengths[0]; trocar_core::lane::LANES] {
            let line = Gather::gather(trocar_core::lane::of_each!(all, |one| &one.line))?;
            return Some(Delay { line, next: 0, lane_ticks: None, irregular });
        }
        let initial: [L; N] = Gather::gather(trocar_core::lane::of_each!(all, |one| one.line.first()?))?;
        let longest = lengths.into_iter().max().unwrap_or(0);
        let line = vec![initial; longest].into_boxed_slice();
        irregular.is_none().then(|| Delay { line, next: 0, lane_ticks: Some(Box::new(lengths)), irregular: None })
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

    #[test]
    fn a_delay_is_immediate_without_ticks_and_without_irregularity() {
        let regular = |ticks| Delay::<f64, 1>::new(ticks, [0.0]);
        let irregular = |ticks, irregularity: &Irregularity, schedule: &Schedule| {
            regular(ticks).irregular(irregularity, schedule, 1e-3, [0.0], (1, 0))
        };
        let none = Irregularity::default();
        let (jitter, loss) = (Irregularity { jitter_s: 2e-3, ..none }, Irregularity { loss: 0.1, ..none });
        let outage = Schedule::new(std::sync::Arc::default(), std::iter::once(1..2).collect());
        assert!(regular(0).is_immediate() && irregular(0, &none, &Schedule::default()).is_immediate());
        assert!(!regular(1).is_immediate());
        for (irregularity, schedule) in
            [(&jitter, &Schedule::default()), (&loss, &Schedule::default()), (&none, &outage)]
        {
            assert!(!irregular(0, irregularity, schedule).is_immediate());
        }
        assert_eq!((regular(3).longest_ticks(), irregular(3, &jitter, &Schedule::default()).longest_ticks()), (3, 5));
        assert!(none.is_none() && !jitter.is_none() && !loss.is_none());
        assert_eq!([jitter, none].map(|one| one.jitter_ticks(1e-3)), [2, 0]);
    }

    #[test]
    fn a_jitter_of_too_many_ticks_is_refused() {
        let refused = |jitter_s, tick_s| Irregularity { jitter_s, loss: 0.0 }.validate_on_ticks(tick_s).is_err();
        assert_eq!([refused(100.0, 1e-3), refused(100.1, 1e-3), refused(1.0, 1e-6)], [false, true, true]);
    }

    #[test]
    fn every_number_of_a_sample_arrives_at_its_position() {
        let mut delay = Delay::new(2, [0.1, 0.2, 0.3]);
        delay.exchange([1.0, 2.0, 3.0]);
        assert_eq!(delay.exchange([4.0, 5.0, 6.0]).sample, [0.1, 0.2, 0.3]);
        let arrival = delay.exchange([7.0, 8.0, 9.0]);
        assert_eq!((arrival.sample, arrival.is_fresh), ([1.0, 2.0, 3.0], true));
    }
}
