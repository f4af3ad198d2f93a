use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use super::Arrival;
use super::schedule::{Running, Schedule};
use trocar_core::error::{InvalidValue, require};
use trocar_core::lane::Lane;
use trocar_core::time::nearest_ticks;

const MAX_JITTER_TICKS: u64 = 100_000;

trocar_core::settings! {
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Irregularity in "channel." {
        /// Maximum extra random delay of each sample, in both directions; a sample that arrives after a later one is
        /// dropped.
        jitter_s: f64 [NON_NEGATIVE] = 0.0,
        /// Probability that a sample is lost, in both directions; the receiver holds the last sample.
        loss: f64 [SHARE] = 0.0,
    }
}

impl Irregularity {
    pub fn validate_on_ticks(&self, tick_s: f64) -> Result<(), InvalidValue> {
        self.validate()?;
        let held = self.jitter_s / tick_s <= MAX_JITTER_TICKS as f64;
        require("channel.jitter_s", self.jitter_s, held, "at most 100000 ticks").map(drop)
    }

    pub fn jitter_ticks(&self, tick_s: f64) -> u64 {
        nearest_ticks(self.jitter_s, tick_s).min(MAX_JITTER_TICKS)
    }

    pub fn is_none(&self) -> bool {
        self.jitter_s == 0.0 && self.loss == 0.0
    }
}

#[derive(Debug, Clone, Copy)]
struct Sent<L, const N: usize> {
    stamp: L,
    sample: [L; N],
}

#[derive(Debug, Clone)]
pub(super) struct Irregular<L, const N: usize> {
    arriving: Box<[Sent<L, N>]>,
    held: Sent<L, N>,
    tick: u64,
    delay_ticks: u64,
    schedule: Running,
    draws: Draws,
    streams: Box<[ChaCha8Rng]>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Draws {
    jitter_choices: f64,
    loss: f64,
}

impl Draws {
    fn new(irregularity: &Irregularity, jitter_ticks: u64) -> Self {
        Self { jitter_choices: (jitter_ticks + 1) as f64, loss: irregularity.loss }
    }

    #[inline(always)]
    fn extra_ticks(&self, rng: &mut ChaCha8Rng) -> Option<u64> {
        // So each setting leaves the other's random numbers unchanged.
        let (loss_draw, jitter_draw) = (rng.random::<f64>(), rng.random::<f64>());
        (loss_draw >= self.loss).then_some((jitter_draw * self.jitter_choices) as u64)
    }
}

fn random_stream(seed: u64, stream: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(stream);
    rng
}

const NEVER: f64 = -1.0;

impl<L: Lane, const N: usize> Irregular<L, N> {
    pub(super) fn new(
        (irregularity, schedule): (&Irregularity, &Schedule),
        (delay_ticks, tick_s): (u64, f64),
        initial: [L; N],
        (seed, first_stream): (u64, u64),
    ) -> Self {
        let jitter_ticks = irregularity.jitter_ticks(tick_s);
        let nothing = Sent { stamp: L::splat(NEVER), sample: initial };
        let stream = |lane: usize| random_stream(seed, first_stream + lane as u64);
        let places = schedule.longest(delay_ticks) + jitter_ticks + 1;
        Self {
            arriving: vec![nothing; places as usize].into_boxed_slice(),
            held: nothing,
            tick: 0,
            delay_ticks,
            schedule: Running::new(schedule.clone()),
            draws: Draws::new(irregularity, jitter_ticks),
            streams: (0..L::WIDTH).map(stream).collect(),
        }
    }

    pub(super) fn longest_ticks(&self) -> u64 {
        self.arriving.len() as u64 - 1
    }

    pub(super) fn exchange(&mut self, sample: [L; N]) -> Arrival<L, N> {
        let places = self.arriving.len() as u64;
        let stamp = self.tick as f64;
        let delay = self.schedule.delay(self.tick, self.delay_ticks);
        for (lane, rng) in self.streams.iter_mut().enumerate() {
            let extra = self.draws.extra_ticks(rng);
            if let (Some(delay), Some(extra)) = (delay, extra) {
                let late = delay + extra;
                let place = &mut self.arriving[((self.tick + late) % places) as usize];
                place.stamp = place.stamp.with_lane(lane, stamp);
                for (waiting, sent) in place.sample.iter_mut().zip(sample) {
                    *waiting = waiting.with_lane(lane, sent.lane(lane));
                }
            }
        }
        let place = &mut self.arriving[(self.tick % places) as usize];
        let is_fresh = place.stamp.gt(self.held.stamp);
        for (held, come) in self.held.sample.iter_mut().zip(place.sample) {
            *held = L::select(is_fresh, come, *held);
        }
        self.held.stamp = self.held.stamp.max(place.stamp);
        place.stamp = L::splat(NEVER);
        self.tick += 1;
        Arrival { sample: self.held.sample, is_fresh }
    }
}

trocar_core::lane::gather!(Sent[N] { stamp, sample });

impl<const N: usize> trocar_core::lane::Gather for Irregular<f64, N> {
    type Of<L: Lane> = Irregular<L, N>;

    fn gather<L: Lane>(all: [&Self; trocar_core::lane::LANES]) -> Option<Irregular<L, N>> {
        use trocar_core::lane::Gather;
        let first = all[0];
        let equal = all.iter().all(|one| {
            (one.tick, one.delay_ticks) == (first.tick, first.delay_ticks)
                && one.draws == first.draws
                && one.schedule == first.schedule
        });
        if !equal {
            return None;
        }
        Some(Irregular {
            arriving: Gather::gather(trocar_core::lane::of_each!(all, |one| &one.arriving))?,
            held: Gather::gather(trocar_core::lane::of_each!(all, |one| &one.held))?,
            tick: first.tick,
            delay_ticks: first.delay_ticks,
            schedule: first.schedule.clone(),
            draws: first.draws,
            streams: all.iter().flat_map(|one| one.streams.iter().cloned()).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use std::ops::Range;
    use std::sync::Arc;

    use super::*;

    /// The sample held at each tick if tick `k` sends `k`; -7 before the first arrival.
    fn held(jitter_s: f64, loss: f64, delay_ticks: u64, seed: u64) -> Vec<f64> {
        scheduled(Irregularity { jitter_s, loss }, &Schedule::default(), delay_ticks, seed)
    }

    fn scheduled(irregularity: Irregularity, schedule: &Schedule, delay_ticks: u64, seed: u64) -> Vec<f64> {
        let mut link = Irregular::new((&irregularity, schedule), (delay_ticks, 1e-3), [-7.0], (seed, 0));
        (0..20_000).map(|tick| link.exchange([f64::from(tick)]).sample[0]).collect()
    }

    #[test]
    fn the_receiver_holds_the_last_sample_as_often_as_samples_are_lost() {
        let held = held(0.0, 0.1, 2, 1);
        let over = held[10..].windows(2).filter(|pair| pair[0] == pair[1]).count();
        assert!((1850..=2150).contains(&over), "{over} of 19989 at 10 %");
        assert!(held.windows(2).all(|pair| pair[1] >= pair[0]));
    }

    #[test]
    fn jitter_stays_within_its_bounds_and_never_reorders_samples() {
        let held = held(5e-3, 0.0, 2, 1);
        for (tick, pair) in held.windows(2).enumerate().skip(20) {
            assert!(pair[1] >= pair[0], "an older sample was taken at {tick}");
            let age = tick as f64 - pair[0];
            assert!((2.0..=7.0).contains(&age), "{age} at {tick}");
        }
        let ages: Vec<f64> = held.iter().zip(0..).map(|(&sent, tick)| f64::from(tick) - sent).skip(20).collect();
        assert!(ages.contains(&2.0) && ages.iter().any(|&age| age >= 5.0));
    }

    fn dead(ticks: Range<u64>) -> Schedule {
        Schedule::new(Arc::default(), std::iter::once(ticks).collect())
    }

    #[test]
    fn samples_sent_in_an_outage_never_arrive() {
        let outage = dead(10..15);
        let held = scheduled(Irregularity::default(), &outage, 3, 1);
        // The sample of tick 9 is held until the sample of tick 15 arrives.
        assert_eq!(held[11..19], [8.0, 9.0, 9.0, 9.0, 9.0, 9.0, 9.0, 15.0]);
        assert_eq!(held[19_999], 19_996.0);
    }

    #[test]
    fn an_outage_does_not_change_the_delays_of_other_samples() {
        let uneven = Irregularity { jitter_s: 5e-3, loss: 0.2 };
        let (without, with) = (scheduled(uneven, &Schedule::default(), 2, 1), scheduled(uneven, &dead(500..800), 2, 1));
        assert_eq!(without[..502], with[..502]);
        assert_eq!(without[820..], with[820..]);
        assert!(with[510..802].iter().all(|&sent| sent < 500.0), "sent in the outage");
    }

    #[test]
    fn logged_delays_are_kept_and_an_overtaken_sample_is_dropped() {
        // Sample 0 takes 6 ticks and is overtaken by sample 1, which takes 2. Sample 2 is lost; 3 and 4 arrive
        // together.
        let logged = Schedule::new(Arc::from([6, 2, Schedule::LOST, 4, 3, 3]), Arc::default());
        let held = scheduled(Irregularity::default(), &logged, 0, 1);
        assert_eq!(held[..10], [-7.0, -7.0, -7.0, 1.0, 1.0, 1.0, 1.0, 4.0, 5.0, 6.0]);
    }

    #[test]
    fn jitter_is_added_to_logged_delays() {
        let logged = Schedule::new(Arc::from([10]), Arc::default());
        let held = scheduled(Irregularity { jitter_s: 5e-3, loss: 0.0 }, &logged, 0, 1);
        let ages: Vec<f64> = held.iter().zip(0..).map(|(&sent, tick)| f64::from(tick) - sent).skip(30).collect();
        assert!(ages.iter().all(|age| (10.0..=15.0).contains(age)) && ages.contains(&10.0), "within its bounds");
        assert!(ages.iter().any(|&age| age >= 13.0));
    }

    #[test]
    fn a_dead_link_holds_the_initial_sample_and_seeds_differ() {
        assert!(held(0.0, 1.0, 0, 1).iter().all(|&sample| sample == -7.0));
        assert_eq!(held(3e-3, 0.2, 1, 1), held(3e-3, 0.2, 1, 1));
        assert_ne!(held(3e-3, 0.2, 1, 1), held(3e-3, 0.2, 1, 2));
    }
}
