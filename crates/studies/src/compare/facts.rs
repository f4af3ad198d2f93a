use schemars::JsonSchema;
use serde::Serialize;

use super::Comparison;
use trocar_metrics::{Metrics, RuptureMetrics};

/// A statement of the paper and the corresponding result.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Fact {
    /// Number of the paper's figure; 0 for none.
    #[serde(skip)]
    pub figure: u8,
    /// The subject.
    pub what: &'static str,
    /// The statement, with the section of the paper.
    pub paper: &'static str,
    /// The condition for agreement.
    pub asked: &'static str,
    /// The result.
    pub ours: String,
    /// True if the result meets the condition.
    pub holds: bool,
}

/// `None` unless there are a classical and an augmented run with two ruptures and an event.
pub fn paper_facts(comparison: &Comparison) -> Option<Vec<Fact>> {
    let [classical, augmented] = comparison.runs.as_slice() else { return None };
    let (c, a) = (&classical.metrics, &augmented.metrics);
    let ([c1, c2], [a1, a2]) = (c.ruptures.as_slice(), a.ruptures.as_slice()) else { return None };
    let event = a.events.first()?;
    let mm = |metres: f64| 1e3 * metres;
    let ms = |seconds: f64| 1e3 * seconds;
    let travel = mm(c1.slave_travel_m?);
    let (from, to) = (mm(event.master_start_m), mm(event.master_end_m));
    let frozen = mm(a.events.iter().map(|event| event.frozen_motion_m).fold(0.0, f64::max));
    let duration_s = event.augmented_s?;
    let fall = |rupture: &RuptureMetrics| rupture.feedback_fall_s;
    let excess = a.feedback_step_excess_n.max(0.0);
    let steps = |step: f64, allowed: f64| format!("{step:.5} N of {allowed:.5} N");
    let delays = [c1, c2, a1, a2].map(|rupture| rupture.detection_delay_s);
    let detected = delays.iter().all(|delay| delay.is_some_and(|delay| delay <= 0.010));
    let has_no_false_alarm = |m: &Metrics| m.false_alarms == 0;
    let (min_n, max_n) = (c.min_tissue_force_n?, c.max_tissue_force_n?);
    let error = c.mean_absolute_residual_n?.max(a.mean_absolute_residual_n?);
    let noise = &comparison.noise;
    let detects_in_noise = noise.iter().all(|n| n.missed_ruptures == 0 && n.false_alarms == 0);
    let derivative_fails = noise.iter().all(|n| n.derivative_exceedances.is_some_and(|samples| samples > 0));
    let delay = |rupture: &RuptureMetrics| {
        rupture.detection_delay_s.map_or("missed".into(), |delay| format!("{:.0} ms", ms(delay)))
    };
    let fall_text = |rupture: &RuptureMetrics| fall(rupture).map_or("—".into(), |fall| format!("{:.0} ms", ms(fall)));
    Some(vec![
        Fact {
            figure: 15,
            what: "classical: slave travel in 300 ms",
            paper: "9 mm (5.2)",
            asked: "9.0 ± 0.5 mm",
            ours: format!("{travel:.2} mm"),
            holds: (travel - 9.0).abs() <= 0.5,
        },
        Fact {
            figure: 16,
            what: "augmented: master during the event",
            paper: "19 to 28 mm (5.2)",
            asked: "± 0.7 mm",
            ours: format!("{from:.2} to {to:.2} mm"),
            holds: (from - 19.0).abs() <= 0.7 && (to - 28.0).abs() <= 0.7,
        },
        Fact {
            figure: 16,
            what: "augmented: slave motion while frozen",
            paper: "frozen (5.1)",
            asked: "at most 0.1 mm",
            ours: format!("{frozen:.3} mm"),
            holds: frozen <= 0.1,
        },
        Fact {
            figure: 16,
            what: "augmented: length of the event",
            paper: "about 0.5 s (5.2)",
            asked: "0.5 ± 0.05 s",
            ours: format!("{duration_s:.3} s"),
            holds: (duration_s - 0.5).abs() <= 0.05,
        },
        Fact {
            figure: 16,
            what: "feedback force down to 5 %",
            paper: "converges faster (5.2)",
            asked: "sooner",
            ours: format!("{} against {}", fall_text(a1), fall_text(c1)),
            holds: fall(a1).is_some_and(|a| fall(c1).is_none_or(|c| a < c)),
        },
        Fact {
            figure: 16,
            what: "its change in the first tick frozen",
            paper: "continuous (5.1)",
            asked: "what its law allows",
            ours: steps(event.entry_step_n, event.entry_step_allowed_n),
            holds: event.entry_step_n <= event.entry_step_allowed_n + 1e-9,
        },
        Fact {
            figure: 16,
            what: "its change in the first tick released",
            paper: "continuous (5.1)",
            asked: "what its law allows",
            ours: steps(event.exit_step_n?, event.exit_step_allowed_n?),
            holds: event.exit_step_n? <= event.exit_step_allowed_n? + 1e-9,
        },
        Fact {
            figure: 16,
            what: "its change beyond the law, all events",
            paper: "continuous (5.1)",
            asked: "none",
            ours: format!("{excess:.0e} N"),
            holds: excess <= 1e-9,
        },
        Fact {
            figure: 13,
            what: "detection of 5.52 s and 8.85 s",
            paper: "less than 10 ms (4.6)",
            asked: "both, within 10 ms",
            ours: format!("{} and {}; {} and {}", delay(c1), delay(c2), delay(a1), delay(a2)),
            holds: detected,
        },
        Fact {
            figure: 13,
            what: "false alarms, extraction included",
            paper: "none (4.6)",
            asked: "none",
            ours: format!("{} and {}", c.false_alarms, a.false_alarms),
            holds: has_no_false_alarm(c) && has_no_false_alarm(a),
        },
        Fact {
            figure: 6,
            what: "tissue force, in the paper's sign",
            paper: "-5.69 to 2.45 N (3.2.2)",
            asked: "about -5.7 to 2.5 N",
            ours: format!("{:.2} to {:.2} N", -max_n, -min_n),
            holds: (max_n - 5.7).abs() <= 0.15 && (min_n + 2.5).abs() <= 0.15,
        },
        Fact {
            figure: 6,
            what: "mean |residual|",
            paper: "0.0486 N (3.2.2)",
            asked: "below 0.05 N",
            ours: format!("{error:.4} N"),
            holds: error < 0.05,
        },
        Fact {
            figure: 12,
            what: "with 6.25e-4 N² of white noise",
            paper: "two distinct peaks (4.4.3)",
            asked: "both and only both",
            ours: noise
                .iter()
                .map(|n| format!("{} of {}, {} false", n.ruptures - n.missed_ruptures, n.ruptures, n.false_alarms))
                .collect::<Vec<_>>()
                .join("; "),
            holds: detects_in_noise,
        },
        Fact {
            figure: 9,
            what: "the derivative in that noise",
            paper: "very difficult (4.1)",
            asked: "fails",
            ours: noise
                .first()
                .map(|n| {
                    let found = n.ruptures - n.derivative_missed_ruptures;
                    let beyond = n.derivative_exceedances.unwrap_or(0);
                    format!("{found} of {}; a threshold for both: {beyond} false", n.ruptures)
                })
                .unwrap_or_default(),
            holds: derivative_fails,
        },
    ])
}
