use trocar_scenario::Scenario;

const OUTAGES: f64 = 3.0;

/// An operating system without real time delays a process by milliseconds.
const MIN_OUTAGE_S: f64 = 0.02;

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SilenceChange {
    Silent(f64),
    Back(f64),
}

/// The time since the other side's last authentic message.
#[derive(Debug, Clone)]
pub struct Silence {
    limit_ns: i64,
    last_ns: i64,
    is_silent: bool,
    count: u64,
}

impl Silence {
    /// The delays of the scenario's channel do not count.
    pub fn new(scenario: &Scenario, start_ns: i64) -> Self {
        let longest_ticks = scenario.longest_delays_ticks().into_iter().max().unwrap_or(0);
        let longest_s = scenario.grid.time_s(longest_ticks);
        let limit_s = OUTAGES * scenario.link.recovery.outage_s.max(MIN_OUTAGE_S);
        Self {
            limit_ns: (1e9 * limit_s) as i64,
            last_ns: start_ns + (1e9 * longest_s) as i64,
            is_silent: false,
            count: 0,
        }
    }

    pub fn hear(&mut self, now_ns: i64) -> Option<SilenceChange> {
        let silent_s = seconds(now_ns - self.last_ns);
        self.last_ns = self.last_ns.max(now_ns);
        std::mem::take(&mut self.is_silent).then_some(SilenceChange::Back(silent_s))
    }

    /// Once per silence.
    pub fn check(&mut self, now_ns: i64) -> Option<SilenceChange> {
        let silent_ns = now_ns - self.last_ns;
        if self.is_silent || silent_ns < self.limit_ns {
            return None;
        }
        self.is_silent = true;
        self.count += 1;
        Some(SilenceChange::Silent(seconds(silent_ns)))
    }

    pub fn count(&self) -> u64 {
        self.count
    }

    pub fn since_ns(&self) -> Option<i64> {
        self.is_silent.then_some(self.last_ns)
    }
}

fn seconds(ns: i64) -> f64 {
    ns as f64 / 1e9
}

#[cfg(test)]
mod tests {
    use super::*;
    use trocar_scenario::Source;

    const MS: i64 = 1_000_000;

    #[test]
    fn a_silence_is_reported_once_after_three_outages_and_ends_with_a_message() {
        let scenario = Scenario::load(&Source::parse("builtin:layers/skin-augmented"), &[]).expect("loads");
        let mut silence = Silence::new(&scenario, 0);
        assert_eq!((silence.check(299 * MS), silence.hear(299 * MS)), (None, None));
        assert_eq!((silence.check(598 * MS), silence.since_ns()), (None, None));
        assert_eq!(silence.check(599 * MS), Some(SilenceChange::Silent(0.3)));
        assert_eq!((silence.check(700 * MS), silence.since_ns()), (None, Some(299 * MS)));
        assert_eq!(silence.hear(799 * MS), Some(SilenceChange::Back(0.5)));
        assert_eq!((silence.since_ns(), silence.count()), (None, 1));
    }
}
