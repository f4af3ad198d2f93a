use std::f64::consts::TAU;

use trocar_document::DataTable;
use trocar_lti::Complex64;
use trocar_stability::{Locus, LoopResponse};

/// Adds both parts, the modulus, and with `s = ln(z) / T` the frequency in Hz and the damping ratio.
fn with_points<'a>(table: DataTable<'a>, points: &[Complex64], tick_s: f64) -> DataTable<'a> {
    let continuous = |z: &Complex64| {
        let s = z.ln() / tick_s;
        (z.norm() > 0.0 && s.norm() > 0.0).then_some(s)
    };
    table
        .numbers("re", points.iter().map(|z| z.re))
        .numbers("im", points.iter().map(|z| z.im))
        .numbers("modulus", points.iter().map(|z| z.norm()))
        .optional("frequency_hz", points.iter().map(|z| continuous(z).map(|s| s.im.abs() / TAU)))
        .optional("damping_ratio", points.iter().map(|z| continuous(z).map(|s| -s.re / s.norm())))
}

pub(super) fn poles(response: &LoopResponse) -> DataTable<'static> {
    let (mut systems, mut kinds, mut points) = (vec![], vec![], vec![]);
    for one in &response.poles {
        for (kind, values) in [("pole", &one.poles), ("zero", &one.zeros)] {
            for value in values {
                systems.push(one.system);
                kinds.push(kind);
                points.push(*value);
            }
        }
    }
    let table = DataTable::new("poles").texts("system", systems).texts("kind", kinds);
    with_points(table, &points, response.tick_s)
}

pub(super) fn loop_gain(name: &'static str, gain: &[(f64, Complex64)]) -> DataTable<'static> {
    DataTable::new(name)
        .numbers("frequency_hz", gain.iter().map(|(hertz, _)| *hertz))
        .numbers("re", gain.iter().map(|(_, gain)| gain.re))
        .numbers("im", gain.iter().map(|(_, gain)| gain.im))
        .numbers("magnitude", gain.iter().map(|(_, gain)| gain.norm()))
        .numbers("phase_deg", LoopResponse::unwrapped_deg(gain))
}

pub(super) fn step(response: &LoopResponse) -> Option<DataTable<'_>> {
    let step = response.step.as_ref()?;
    let output = |row: usize| (0..step.time_s.len()).map(move |k| step.outputs[(row, k)]);
    Some(
        DataTable::new("step")
            .numbers("time_s", step.time_s.iter().copied())
            .numbers("master_position_m_per_m", output(0))
            .numbers("slave_position_m_per_m", output(1))
            .numbers("feedback_force_n_per_m", output(2)),
    )
}

pub(super) fn locus(locus: &Locus, tick_s: f64) -> DataTable<'static> {
    let (mut values, mut points) = (vec![], vec![]);
    for (value, poles) in &locus.branches {
        values.extend(poles.iter().map(|_| *value));
        points.extend_from_slice(poles);
    }
    with_points(DataTable::new("locus").numbers(locus.parameter.key(), values), &points, tick_s)
}
