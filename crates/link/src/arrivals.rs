use trocar_engine::channel::Schedule;
use trocar_engine::teleoperation::{Message, PAYLOAD, Received};

const MAX_EARLY: usize = 256;

/// The messages of one direction, processed as in the simulated channel: the one that was sent last is held, earlier
/// ones are dropped, and a message of a future tick waits for it.
///
/// Records each delay: the ticks from sending to the first possible use.
#[derive(Debug, Clone)]
pub struct Arrivals<const N: usize> {
    held: Message<f64, N>,
    held_tick: Option<u64>,
    latest: Option<(u64, Message<f64, N>)>,
    early: Vec<(u64, Message<f64, N>)>,
    next: u64,
    delays: Box<[u32]>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Fate {
    /// Used at the next tick, or at its own tick if that is later.
    Taken,
    Overtaken,
    Repeated,
    /// Its tick is beyond the run, or too far in the future.
    OutOfRange,
}

impl<const N: usize> Arrivals<N> {
    /// Until a message arrives, the receiver has the `initial` sample.
    pub fn new(ticks: u64, initial: [f64; N]) -> Self {
        Self {
            held: Message { sample: initial, payload: [0.0; PAYLOAD] },
            held_tick: None,
            latest: None,
            early: Vec::with_capacity(MAX_EARLY),
            next: 0,
            delays: vec![Schedule::LOST; ticks as usize].into_boxed_slice(),
        }
    }

    pub(super) fn take(&mut self, sent: u64, message: Message<f64, N>) -> Fate {
        let Some(delay) = usize::try_from(sent).ok().and_then(|sent| self.delays.get_mut(sent)) else {
            return Fate::OutOfRange;
        };
        if *delay != Schedule::LOST || self.early.iter().any(|(early, _)| *early == sent) {
            return Fate::Repeated;
        }
        if sent > self.next {
            if self.early.len() == MAX_EARLY {
                return Fate::OutOfRange;
            }
            self.early.push((sent, message));
            return Fate::Taken;
        }
        *delay = u32::try_from(self.next - sent).unwrap_or(Schedule::LOST - 1);
        let last = self.latest.as_ref().map(|(latest, _)| *latest).max(self.held_tick);
        if last.is_some_and(|last| last > sent) {
            return Fate::Overtaken;
        }
        self.latest = Some((sent, message));
        Fate::Taken
    }

    /// The last sample is held.
    pub(super) fn forget_payload(&mut self) {
        self.held.payload = [0.0; PAYLOAD];
        self.latest = None;
        self.early.clear();
    }

    /// The message for the next tick; later messages are for the tick after it.
    pub fn at_next_tick(&mut self) -> Received<f64, N> {
        if let Some(place) = self.early.iter().position(|(sent, _)| *sent == self.next) {
            let (sent, message) = self.early.swap_remove(place);
            self.take(sent, message);
        }
        self.next += 1;
        let fresh = self.latest.take();
        let is_fresh = fresh.is_some();
        if let Some((sent, message)) = fresh {
            (self.held, self.held_tick) = (message, Some(sent));
        }
        Received { sample: self.held.sample, payload: self.held.payload, is_fresh }
    }

    /// The delay in ticks of each tick's message, or [`Schedule::LOST`].
    pub fn delays(&self) -> &[u32] {
        &self.delays
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(value: f64) -> Message<f64, 1> {
        Message { sample: [value], payload: [value; PAYLOAD] }
    }

    #[test]
    fn the_latest_message_is_held_and_an_overtaken_one_is_dropped() {
        let mut arrivals = Arrivals::new(10, [-7.0]);
        let mut held = vec![];
        // The messages that arrive before each tick, by the tick that sent them.
        for sent in [vec![], vec![1], vec![0], vec![], vec![2, 4, 3], vec![5], vec![9]] {
            for sent in sent {
                arrivals.take(sent, message(sent as f64));
            }
            let received = arrivals.at_next_tick();
            held.push((received.sample[0], received.is_fresh));
        }
        let expected = [(-7.0, false), (1.0, true), (1.0, false), (1.0, false), (4.0, true), (5.0, true), (5.0, false)];
        assert_eq!(held, expected);
        assert!(!arrivals.at_next_tick().is_fresh);
        assert!(!arrivals.at_next_tick().is_fresh);
        let at_nine = arrivals.at_next_tick();
        assert_eq!((at_nine.sample, at_nine.payload, at_nine.is_fresh), ([9.0], [9.0; PAYLOAD], true));
        let lost = Schedule::LOST;
        assert_eq!(arrivals.delays(), [2, 0, 2, 1, 0, 0, lost, lost, lost, 0]);
    }

    #[test]
    fn a_message_has_an_effect_only_once_and_within_the_run() {
        let mut arrivals = Arrivals::new(1000, [0.0]);
        assert_eq!(arrivals.take(0, message(1.0)), Fate::Taken);
        assert_eq!(arrivals.take(0, message(2.0)), Fate::Repeated);
        assert_eq!(arrivals.take(5, message(5.0)), Fate::Taken);
        assert_eq!(arrivals.take(5, message(6.0)), Fate::Repeated);
        assert_eq!(arrivals.take(1000, message(6.0)), Fate::OutOfRange);
        assert_eq!(arrivals.take(u64::MAX, message(6.0)), Fate::OutOfRange);
        let taken = (6..1000).filter(|tick| arrivals.take(*tick, message(0.0)) == Fate::Taken).count();
        assert_eq!(taken, MAX_EARLY - 1);
        assert_eq!(arrivals.at_next_tick().sample, [1.0]);
    }
}
