use std::borrow::Cow;

use super::Samples;
use super::tables::Event;
use crate::DetectionReport;
use trocar_document::{DataTable, Values};
use trocar_engine::engine::{ColumnValues, TRUST_COLUMNS};

pub(super) fn samples(Samples { detection, trust, .. }: &Samples) -> DataTable<'_> {
    let columns: [(&str, &[f64]); 9] = [
        ("time_s", &detection.time_s),
        ("position_m", &detection.position_m),
        ("velocity_m_per_s", &detection.velocity_m_per_s),
        ("measured_force_n", &detection.measured_force_n),
        ("stiffness_n_per_m", &detection.stiffness_n_per_m),
        ("damping_n_s_per_m", &detection.damping_n_s_per_m),
        ("residual_n", &detection.residual_n),
        ("distance", &detection.distance),
        ("decision", &detection.decision),
    ];
    let extra = detection.extra_parameter.iter().map(|(name, column)| (*name, column.as_slice()));
    let columns = columns.into_iter().chain(extra);
    let table = columns.fold(DataTable::new("detection").sampled(), |table, (name, column)| {
        table.with(name, Values::Numbers(Cow::Borrowed(column)))
    });
    let trust = TRUST_COLUMNS.iter().zip(trust.columns());
    trust.fold(table, |table, (column, values)| table.with(column.name, column_values(values)))
}

pub fn column_values<'a>(column: ColumnValues<impl Into<Cow<'a, [f64]>>, impl Into<Cow<'a, [u8]>>>) -> Values<'a> {
    match column {
        ColumnValues::Numbers(numbers) => Values::Numbers(numbers.into()),
        ColumnValues::Codes(codes) => Values::Codes(codes.into()),
    }
}

/// Labels `found`, `false`, or `alarm` without labels, and `missed`.
pub(super) fn events<'a>(recordings: impl IntoIterator<Item = (&'a str, &'a DetectionReport)>) -> DataTable<'a> {
    let of = |(file, report): (&'a str, &'a DetectionReport)| {
        Event::all(report).into_iter().map(move |event| (file, report, event))
    };
    let rows: Vec<_> = recordings.into_iter().flat_map(of).collect();
    let alarm = |(_, report, event): &(&str, &'a DetectionReport, Event)| match event {
        Event::Alarm(index) => Some(&report.alarms[*index]),
        Event::Missed(_) => None,
    };
    let label = |row: &(&str, &'a DetectionReport, Event)| match row.2 {
        Event::Alarm(index) => row.1.alarms[index].label,
        Event::Missed(label) => Some(label),
    };
    let name = |(_, report, event): &(&str, &DetectionReport, Event)| match event {
        Event::Missed(_) => "missed",
        Event::Alarm(_) if report.scores.is_none() => "alarm",
        Event::Alarm(index) if report.alarms[*index].label.is_some() => "found",
        Event::Alarm(_) => "false",
    };
    let kind = |row| label(row).and_then(|label| row.1.labelled_kinds[label].as_deref()).unwrap_or_default();
    let samples = rows.iter().map(|row| alarm(row).map(|alarm| alarm.sample as u64));
    DataTable::new("events")
        .texts("file", rows.iter().map(|row| row.0))
        .texts("event", rows.iter().map(name))
        .numbers("time_s", rows.iter().map(|(_, report, event)| event.time_s(report)))
        .with("sample", Values::OptionalWhole(samples.collect()))
        .optional("position_m", rows.iter().map(|row| alarm(row).map(|alarm| alarm.position_m)))
        .optional("depth_m", rows.iter().map(|row| alarm(row).map(|alarm| alarm.depth_m)))
        .optional("force_n", rows.iter().map(|row| alarm(row).map(|alarm| alarm.force_n)))
        .optional("residual_n", rows.iter().map(|row| alarm(row).map(|alarm| alarm.residual_n)))
        .optional("rupture_s", rows.iter().map(|row| label(row).map(|label| row.1.labelled_ruptures_s[label])))
        .texts("kind", rows.iter().map(kind))
        .optional("delay_s", rows.iter().map(|row| alarm(row).and_then(|alarm| alarm.delay_s)))
}
