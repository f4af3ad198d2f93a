//! Reads the link's scheduled outages, and its delays from a file.

use std::sync::Arc;

use super::document::Source;
use super::error::ScenarioError;
use super::intervals::{first_tick, intervals};
use super::replay::{embedded, limiting_key};
use super::schedule_settings::{EventSettings, ScheduleSettings};
use super::value::Value;
use super::values::Values;
use trocar_core::time::{TickGrid, nearest_ticks};
use trocar_engine::channel::{DelaySettings, MAX_DELAY_TICKS, Schedule};
use trocar_recording::{DelayRow, Limits, open_delays, read_delays, read_file};

const OUTAGES: &str = ScheduleSettings::KEYS[0].path;
const FILE: &str = ScheduleSettings::KEYS[1].path;
const EVENTS: &str = EventSettings::KEYS[0].path;

pub(super) fn schedules(values: &mut Values, grid: &TickGrid) -> Result<(Schedule, Schedule), ScenarioError> {
    let settings = ScheduleSettings::read(values)?;
    let outages = intervals(values, (OUTAGES, "outage"), &settings.outages_s, grid.tick_s())?;
    let [forward, backward] = logged_delays(values, grid)?;
    Ok((Schedule::new(forward, outages.clone()), Schedule::new(backward, outages)))
}

/// Independent of the detector.
pub(super) fn events(values: &mut Values, grid: &TickGrid) -> Result<Arc<[u64]>, ScenarioError> {
    let times_s = EventSettings::read(values)?.events_s;
    let refuse = |message: String, remedy: &str| Err(values.error(EVENTS, message).remedy(remedy));
    if let Some(before) = times_s.iter().find(|&&time_s| time_s < 0.0) {
        return refuse(format!("{EVENTS} has {before}, must be at least 0"), "count from the run's start");
    }
    let ticks: Arc<[u64]> = times_s.iter().map(|&time_s| nearest_ticks(time_s, grid.tick_s())).collect();
    if let Some(k) = (1..ticks.len()).find(|&k| ticks[k] <= ticks[k - 1]) {
        return refuse(
            format!("{EVENTS} has {} after {}, must ascend by ticks", times_s[k], times_s[k - 1]),
            "sort the events and remove duplicates",
        );
    }
    Ok(ticks)
}

struct DelayTable {
    tick_s: f64,
    ticks: usize,
    begin_s: Option<f64>,
    holding: [u32; 2],
    delays: [Vec<u32>; 2],
}

impl DelayTable {
    fn new(grid: &TickGrid) -> Self {
        let ticks = grid.ticks() as usize;
        let empty = || Vec::with_capacity(ticks);
        Self { tick_s: grid.tick_s(), ticks, begin_s: None, holding: [0; 2], delays: [empty(), empty()] }
    }

    fn take(&mut self, row: &DelayRow) {
        // The first row applies from the start.
        if self.begin_s.is_some() {
            self.hold_until(first_tick(row.time_s, self.tick_s));
        }
        self.begin_s.get_or_insert(row.time_s);
        self.holding = [row.forward_s, row.backward_s].map(|delay_s| {
            let ticks = delay_s.map(|delay_s| nearest_ticks(delay_s, self.tick_s));
            // A sample that arrives after the run counts as lost.
            let ticks = ticks.filter(|&ticks| ticks < self.ticks as u64);
            ticks.and_then(|ticks| u32::try_from(ticks).ok()).unwrap_or(Schedule::LOST)
        });
    }

    fn hold_until(&mut self, tick: u64) {
        let length = self.ticks.min(usize::try_from(tick).unwrap_or(usize::MAX));
        for (delays, holding) in self.delays.iter_mut().zip(self.holding) {
            delays.resize(length.max(delays.len()), holding);
        }
    }
}

fn logged_delays(values: &mut Values, grid: &TickGrid) -> Result<[Arc<[u32]>; 2], ScenarioError> {
    let Some(source) = values.file(FILE) else { return Ok([Arc::default(), Arc::default()]) };
    for (key, delay_s) in DelaySettings::read(values)?.of_each_way() {
        if delay_s != 0.0 {
            let message = format!("{key} is {delay_s:?}, but {FILE} gives the delays");
            return Err(values.error(key, message).remedy(format!("leave out {key}, or {FILE}")));
        }
    }
    let limits = Limits { max_gap_s: None, ..Limits::read(values)? };
    let max_s = MAX_DELAY_TICKS as f64 * grid.tick_s();
    let source = source.canonical();
    let mut table = DelayTable::new(grid);
    let take = |row: &DelayRow| table.take(row);
    let read = match source.plain() {
        Source::Disk(path) => match source.kept() {
            Some(files) => files
                .bytes(path, || read_file(path, &limits))
                .and_then(|bytes| read_delays(&source.display(), &*bytes, &limits, max_s, take)),
            None => open_delays(path, &limits, max_s, take),
        },
        Source::Builtin(name) => read_delays(&source.display(), embedded(values, FILE, name)?, &limits, max_s, take),
        Source::Text { name, text } => read_delays(name, text.as_bytes(), &limits, max_s, take),
        Source::Memory(_) | Source::Kept(..) => {
            let name = source.display();
            return Err(values.error(FILE, format!("{name} is a recording, not a table of delays")));
        }
    };
    read.map_err(|error| {
        let place = limiting_key(&error.problem).and_then(|key| values.place(key)).or(values.place(FILE));
        ScenarioError::new(error.to_string()).at(place)
    })?;
    let end_s = grid.time_s(grid.ticks());
    if let Some(begin_s) = table.begin_s.filter(|&begin_s| begin_s >= end_s) {
        let message = format!("the delays begin at {begin_s} s, after the run's end at {end_s} s");
        return Err(values.error(FILE, message).remedy("count time_s from the run's start"));
    }
    table.hold_until(grid.ticks());
    values.derive_keeping_place(FILE, Value::Text(source.display()));
    Ok(table.delays.map(Arc::from))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filled(rows: &[(f64, Option<f64>)]) -> Vec<u32> {
        let grid = TickGrid::new(1e-3, 0.01).expect("valid");
        let mut table = DelayTable::new(&grid);
        for &(time_s, forward_s) in rows {
            table.take(&DelayRow { time_s, forward_s, backward_s: None });
        }
        table.hold_until(grid.ticks());
        let [forward, backward] = table.delays;
        assert_eq!(backward, [Schedule::LOST; 10]);
        forward
    }

    #[test]
    fn a_tick_has_the_delay_of_the_last_row_at_or_before_it() {
        let rows = [(0.002, Some(0.001)), (0.004, Some(0.0024)), (0.0055, None), (0.008, Some(0.0026))];
        let lost = Schedule::LOST;
        assert_eq!(filled(&rows), [1, 1, 1, 1, 2, 2, lost, lost, 3, 3]);
    }

    #[test]
    fn rows_outside_the_run_and_between_ticks_are_skipped() {
        let rows =
            [(-1.0, Some(0.001)), (-0.5, Some(0.002)), (0.0031, Some(0.003)), (0.0039, Some(0.004)), (7.0, None)];
        assert_eq!(filled(&rows), [2, 2, 2, 2, 4, 4, 4, 4, 4, 4]);
    }

    #[test]
    fn samples_that_arrive_after_the_end_are_lost() {
        assert_eq!(filled(&[(0.0, Some(0.009)), (0.005, Some(0.010))])[4..6], [9, Schedule::LOST]);
    }
}
