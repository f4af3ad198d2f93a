use super::Samples;
use crate::DetectionReport;
use trocar_document::Document;
use trocar_figures::{ESTIMATION_FIGURES, EstimationView, TimelineRow};

impl Samples {
    pub(crate) fn draw<'a>(
        &'a self,
        document: &mut Document<'a>,
        folder: &str,
        name: &'a str,
        report: &'a DetectionReport,
    ) {
        let Self { detection, trust, alarms_s } = self;
        let (_, threshold, decision_unit) = report.detector;
        let view = EstimationView {
            name,
            time_s: &detection.time_s,
            measured_force_n: &detection.measured_force_n,
            residual_n: &detection.residual_n,
            stiffness_n_per_m: &detection.stiffness_n_per_m,
            damping_n_s_per_m: &detection.damping_n_s_per_m,
            standard_errors: Some([(&trust.stiffness_std_n_per_m).into(), (&trust.damping_std_n_s_per_m).into()]),
            extra_parameter: detection.extra_parameter.as_ref().map(|(name, column)| (*name, column.as_slice())),
            decision: &detection.decision,
            threshold,
            decision_unit,
            rupture_times_s: (&report.labelled_ruptures_s).into(),
            alarm_times_s: alarms_s.into(),
        };
        for (name, draw) in ESTIMATION_FIGURES {
            document.figure(format!("{folder}{name}"), draw(&view));
        }
    }
}

pub(super) fn row<'a>(name: &'a str, report: &DetectionReport, from_s: f64) -> TimelineRow<'a> {
    let of = |sample: usize| from_s + sample as f64 * report.interval_s;
    let at = |time_s: f64| from_s + (time_s - report.start_s);
    let intervals = report.intervals.iter();
    TimelineRow {
        name,
        from_s,
        duration_s: report.duration_s,
        shades: intervals.filter_map(|s| Some((of(s.samples.start), of(s.samples.end), s.phase.shade()?))).collect(),
        rupture_times_s: report.labelled_ruptures_s.iter().map(|time_s| at(*time_s)).collect(),
        alarm_times_s: report.alarms.iter().map(|alarm| at(alarm.time_s)).collect(),
    }
}
