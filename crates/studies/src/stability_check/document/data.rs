use trocar_document::{DataTable, Values};
use trocar_lti::Complex64;
use trocar_stability::{Analysis, Axis, PortPoint, StabilityMap};

use crate::stability_check::Check;

pub(super) fn map_points(x: &Axis, y: &Axis) -> impl Iterator<Item = (usize, usize)> + use<> {
    let (columns, rows) = (x.count, y.count);
    (0..rows).flat_map(move |row| (0..columns).map(move |column| (column, row)))
}

pub(super) fn sensitivities(analysis: &Analysis) -> DataTable<'static> {
    let all = &analysis.sensitivities;
    DataTable::new("sensitivities")
        .texts("limit", all.iter().map(|s| s.limit.key()))
        .texts("parameter", all.iter().map(|s| s.parameter.key()))
        .optional("relative_sensitivity", all.iter().map(|s| s.relative))
}

pub(super) fn map(map: &StabilityMap, check: Option<&Check>) -> DataTable<'static> {
    let points: Vec<(usize, usize)> = map_points(&map.x, &map.y).collect();
    let table = DataTable::new("stability_map")
        .numbers(map.x.parameter.key(), points.iter().map(|(column, _)| map.x.value(*column)))
        .numbers(map.y.parameter.key(), points.iter().map(|(_, row)| map.y.value(*row)))
        .flags("stable", points.iter().map(|(column, row)| map.is_stable(*column, *row)));
    match check {
        None => table,
        Some(check) => {
            table.texts("simulated", check.simulated.iter().map(|verdict| verdict.map_or("", |verdict| verdict.word())))
        }
    }
}

pub(super) fn boundary(map: &StabilityMap) -> DataTable<'static> {
    let (x, y) = (map.x.parameter.key(), map.y.parameter.key());
    let segments = &map.boundary;
    DataTable::new("stability_boundary")
        .numbers(format!("{x}_from"), segments.iter().map(|[from, _]| from.0))
        .numbers(format!("{y}_from"), segments.iter().map(|[from, _]| from.1))
        .numbers(format!("{x}_to"), segments.iter().map(|[_, to]| to.0))
        .numbers(format!("{y}_to"), segments.iter().map(|[_, to]| to.1))
}

pub(super) fn ports(analysis: &Analysis) -> DataTable<'static> {
    let points = &analysis.ports;
    let finite = |value: f64| Some(value).filter(|value| value.is_finite());
    let mut table = DataTable::new("ports").numbers("frequency_hz", points.iter().map(|point| point.frequency_hz));
    for (row, column) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        let name = format!("h{}{}", row + 1, column + 1);
        table = with_parts(table, &name, points.iter().map(|point| Some(point.hybrid.h[row][column])));
    }
    table = table
        .optional("llewellyn", points.iter().map(|point| finite(point.hybrid.llewellyn())))
        .flags("absolutely_stable", points.iter().map(|point| point.is_absolutely_stable))
        .flags("passive", points.iter().map(|point| point.is_passive));
    type Read = fn(&PortPoint) -> Option<Complex64>;
    let impedances: [(&str, Read); 3] = [
        ("transmitted", |point| Some(point.transmitted)),
        ("ideal", |point| Some(point.ideal)),
        ("stiffest", |point| point.hybrid.stiffest()),
    ];
    for (name, read) in impedances {
        table = with_parts(table, name, points.iter().map(read));
    }
    table
}

fn with_parts(
    table: DataTable<'static>,
    name: &str,
    values: impl Iterator<Item = Option<Complex64>>,
) -> DataTable<'static> {
    let (re, im) = values.map(|value| (value.map(|value| value.re), value.map(|value| value.im))).unzip();
    table.with(format!("{name}_re"), Values::Optional(re)).with(format!("{name}_im"), Values::Optional(im))
}
