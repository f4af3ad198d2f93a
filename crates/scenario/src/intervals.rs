use std::ops::Range;
use std::sync::Arc;

use super::error::ScenarioError;
use super::values::Values;
use trocar_core::time::whole_ticks;

/// Returns the first tick at or after a time in s.
pub(super) fn first_tick(time_s: f64, tick_s: f64) -> u64 {
    whole_ticks(time_s, tick_s).unwrap_or((time_s / tick_s).ceil().max(0.0) as u64)
}

/// Returns the ticks of the intervals of a key, in ascending order: from the first tick at or after a start until the
/// tick before the end. `noun` names an interval and begins with a vowel.
pub(super) fn intervals(
    values: &Values,
    (key, noun): (&str, &str),
    times_s: &[f64],
    tick_s: f64,
) -> Result<Arc<[Range<u64>]>, ScenarioError> {
    let refuse = |message: String, remedy: &str| Err(values.error(key, message).remedy(remedy));
    let (pairs, rest) = times_s.as_chunks::<2>();
    if let [begin_s] = rest {
        let message = format!("{key} has {} numbers, and the {noun} at {begin_s} s has no end", times_s.len());
        return refuse(message, &format!("write each {noun} as its start and its end, as in [2.0, 2.5]"));
    }
    if let Some(before) = times_s.iter().find(|&&time_s| time_s < 0.0) {
        return refuse(format!("{key} has {before}, must be at least 0"), "count from the run's start");
    }
    if let Some([begin_s, end_s]) = pairs.iter().find(|[begin_s, end_s]| end_s <= begin_s) {
        return refuse(
            format!("{key} has an {noun} from {begin_s} to {end_s} s, must end after its start"),
            &format!("write each {noun} as its start and its end"),
        );
    }
    if let Some(two) = pairs.windows(2).find(|two| two[1][0] < two[0][1]) {
        return refuse(
            format!("{key} has an {noun} from {} s after one to {} s, must ascend", two[1][0], two[0][1]),
            &format!("sort the {noun}s, and join those that overlap"),
        );
    }
    Ok(pairs.iter().map(|pair| first_tick(pair[0], tick_s)..first_tick(pair[1], tick_s)).collect())
}

#[cfg(test)]
mod tests {
    use super::super::document::Source;
    use super::*;

    #[test]
    fn an_interval_begins_and_ends_at_the_first_tick_at_or_after_its_times() {
        let values = Values::load(&Source::Text { name: "x".into(), text: "".into() }, &[]).expect("empty");
        let of = |times_s: &[f64]| {
            let named = ("channel.outages_s", "outage");
            intervals(&values, named, times_s, 1e-3).map_err(|error| error.to_string())
        };
        let ticks = of(&[0.1, 0.3, 0.3, 0.3004, 0.69, 0.7001]).expect("good");
        assert_eq!(*ticks, [100..300, 300..301, 690..701]);
        for (list, reason) in [
            (&[0.1][..], "has 1 numbers, and the outage at 0.1 s has no end"),
            (&[-0.1, 0.3], "has -0.1, must be at least 0"),
            (&[0.3, 0.3], "from 0.3 to 0.3 s, must end after its start"),
            (&[0.3, 0.4, 0.1, 0.2], "an outage from 0.1 s after one to 0.4 s, must ascend"),
        ] {
            let message = of(list).expect_err("refused");
            assert!(message.contains(reason), "{message}");
        }
    }
}
