use std::ops::Range;
use std::sync::Arc;

use super::MAX_DELAY_TICKS;

#[derive(Debug, Clone, PartialEq, Default)]
pub struct Schedule {
    delays: Arc<[u32]>,
    outages: Arc<[Range<u64>]>,
}

impl Schedule {
    pub const LOST: u32 = u32::MAX;

    /// The last of `delays` (ticks or [`Schedule::LOST`]) applies to all later samples; outages ascend without overlap.
    pub fn new(delays: Arc<[u32]>, outages: Arc<[Range<u64>]>) -> Self {
        Self { delays, outages }
    }

    pub fn is_empty(&self) -> bool {
        self.delays.is_empty() && self.outages.is_empty()
    }

    pub fn has_delays(&self) -> bool {
        !self.delays.is_empty()
    }

    pub fn has_outages(&self) -> bool {
        !self.outages.is_empty()
    }

    pub fn repeating(&self, from: u64, to: u64, until: u64) -> Self {
        let Some(&last) = self.delays.last().filter(|_| from < to) else { return self.clone() };
        let delay = |tick: u64| {
            let of = if tick < to { tick } else { from + (tick - from) % (to - from) };
            self.delays.get(of as usize).copied().unwrap_or(last)
        };
        Self { delays: (0..until.max(to)).map(delay).collect(), outages: self.outages.clone() }
    }

    /// `None` without scheduled delays, or if all samples are lost from some tick on.
    pub fn ages(&self) -> Option<(u64, u64)> {
        let last = arriving(*self.delays.last()?)?;
        let end = self.delays.len() + last as usize;
        let mut arrived = vec![None; end];
        for (sent, delay) in self.delays.iter().enumerate() {
            if let Some(place) = arriving(*delay).and_then(|delay| arrived.get_mut(sent + delay as usize)) {
                *place = Some(sent);
            }
        }
        let mut held = None;
        let mut range = (last, last);
        for (tick, arrived) in arrived.into_iter().enumerate() {
            held = held.max(arrived);
            if let Some(sent) = held {
                let age = (tick - sent) as u64;
                range = (range.0.min(age), range.1.max(age));
            }
        }
        Some(range)
    }

    pub(super) fn longest(&self, link_ticks: u64) -> u64 {
        self.delays.iter().filter_map(|&delay| arriving(delay)).max().unwrap_or(link_ticks)
    }
}

fn arriving(delay: u32) -> Option<u64> {
    (delay != Schedule::LOST).then(|| u64::from(delay).min(MAX_DELAY_TICKS))
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Running {
    schedule: Schedule,
    outage: usize,
}

impl Running {
    pub(super) fn new(schedule: Schedule) -> Self {
        Self { schedule, outage: 0 }
    }

    /// `None` if lost; `tick` must not decrease.
    pub(super) fn delay(&mut self, tick: u64, link_ticks: u64) -> Option<u64> {
        let Schedule { delays, outages } = &self.schedule;
        while outages.get(self.outage).is_some_and(|outage| outage.end <= tick) {
            self.outage += 1;
        }
        if outages.get(self.outage).is_some_and(|outage| outage.start <= tick) {
            return None;
        }
        delays.get(tick as usize).or(delays.last()).map_or(Some(link_ticks), |&delay| arriving(delay))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn delays(schedule: Schedule, ticks: u64) -> Vec<Option<u64>> {
        let mut running = Running::new(schedule);
        (0..ticks).map(|tick| running.delay(tick, 7)).collect()
    }

    #[test]
    fn an_empty_schedule_changes_nothing() {
        assert!(Schedule::default().is_empty());
        assert_eq!(delays(Schedule::default(), 3), [Some(7); 3]);
        assert_eq!(Schedule::default().longest(7), 7);
    }

    #[test]
    fn an_outage_loses_samples_from_its_begin_to_before_its_end() {
        // Two adjacent outages, an empty one, and one that outlasts the run.
        let schedule = Schedule::new(Arc::default(), Arc::from([1..2, 2..3, 4..4, 5..99]));
        assert_eq!(delays(schedule, 7), [Some(7), None, None, Some(7), Some(7), None, None]);
    }

    #[test]
    fn logged_delays_replace_the_links_delay_and_the_last_one_persists() {
        let schedule = Schedule::new(Arc::from([3, Schedule::LOST, 0]), Arc::default());
        assert_eq!(schedule.longest(7), 3);
        assert_eq!(delays(schedule, 5), [Some(3), None, Some(0), Some(0), Some(0)]);
        let schedule = Schedule::new(Arc::from([Schedule::LOST]), Arc::default());
        assert_eq!((schedule.longest(7), delays(schedule, 2)), (7, vec![None; 2]));
        let schedule = Schedule::new(Arc::from([u32::MAX - 1]), Arc::default());
        assert_eq!(schedule.longest(7), MAX_DELAY_TICKS);
    }

    #[test]
    fn a_continued_link_repeats_its_last_delays() {
        let outages: Arc<[Range<u64>]> = std::iter::once(1..2).collect();
        let schedule = Schedule::new(Arc::from([3, 4, 5, 6]), outages.clone()).repeating(1, 3, 8);
        assert_eq!(delays(schedule, 8), [3, 0, 5, 4, 5, 4, 5, 4].map(|delay| Some(delay).filter(|&delay| delay > 0)));
        let schedule = Schedule::new(Arc::from([3, 4]), Arc::default()).repeating(1, 3, 5);
        assert_eq!(delays(schedule, 5), [Some(3), Some(4), Some(4), Some(4), Some(4)]);
        assert_eq!(Schedule::new(Arc::default(), outages.clone()).repeating(1, 3, 5).outages, outages);
    }

    #[test]
    fn a_link_repeats_from_the_first_tick_of_the_period_and_not_without_a_period() {
        let schedule = Schedule::new(Arc::from([9, 1, 2, 3, 8]), Arc::default());
        assert_eq!(delays(schedule.repeating(1, 4, 9), 9), [9, 1, 2, 3, 1, 2, 3, 1, 2].map(Some));
        assert_eq!(schedule.repeating(2, 2, 9), schedule);
    }

    #[test]
    fn ages_are_the_ages_of_the_latest_sample_that_has_arrived() {
        let ages = |delays: &[u32]| Schedule::new(delays.into(), Arc::default()).ages();
        assert_eq!(ages(&[3]), Some((3, 3)));
        // The second sample overtakes the first; at tick 4 it is still the latest, 3 ticks old.
        assert_eq!(ages(&[6, 2, 4, 2, 2]), Some((2, 3)));
        // A lost sample increases the age of the sample before.
        assert_eq!(ages(&[1, 1, Schedule::LOST, Schedule::LOST, 1]), Some((1, 3)));
        // The delay after the end of the list counts too: until then the sample before is held.
        assert_eq!(ages(&[1, 5]), Some((1, 5)));
        assert_eq!((ages(&[1, Schedule::LOST]), ages(&[])), (None, None));
    }
}
