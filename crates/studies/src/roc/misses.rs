use super::tally::{Labels, Tally};
use trocar_core::detector::{CusumDetector, DetectorInput, DetectorSettings};
use trocar_core::time::nearest_ticks;
use trocar_metrics::{DetectorSample, MissRule, RUPTURE_WINDOW_S, SupervisorHistory};

pub(super) fn count(
    tally: &mut Tally,
    settings: &DetectorSettings,
    input: &[DetectorInput<f64>],
    alarms: &[usize],
    labels: &Labels,
    missed: &[usize],
) {
    if missed.is_empty() {
        return;
    }
    let tick_s = labels.tick_s();
    let mut detector = CusumDetector::new(settings, tick_s);
    let sample = |input: &DetectorInput<f64>| DetectorSample::update(&mut detector, input).1;
    let samples: Vec<(u64, DetectorSample)> = (0..).zip(input.iter().map(sample)).collect();
    let supervisor = SupervisorHistory::of_alarms(alarms);
    let rule = MissRule { tick_s, start_s: 0.0, window_s: RUPTURE_WINDOW_S, detector: settings, refractory_s: 0.0 };
    for &rupture in missed {
        let first = nearest_ticks(labels.rupture_s(rupture), tick_s);
        let end = first.saturating_add(1 + rule.window_ticks()).min(samples.len() as u64);
        let window = samples.get(first as usize..end as usize).unwrap_or_default();
        let reason =
            rule.explain(first, window, &supervisor).map_or("at-the-end".to_owned(), |miss| miss.reason.word());
        *tally.missed.entry(reason).or_default() += 1;
    }
}
