//! The Z-width.

use serde_json::{Value as Json, json};

use trocar_document::{DataTable, significant};
use trocar_stability::{Walls, ZWidth};

/// The kinds of walls with their limits.
fn kinds(z_width: &ZWidth) -> Vec<(&'static str, &[Walls])> {
    let virtual_walls = z_width.virtual_walls.as_deref().map(|walls| ("virtual", walls));
    std::iter::once(("tissue", z_width.tissue.as_slice())).chain(virtual_walls).collect()
}

/// The maximum stiffness by damping. A cell is empty if no wall has the property, and `inf` beyond the search range.
pub(super) fn table(z_width: &ZWidth) -> DataTable<'static> {
    let (mut wall, mut damping, mut stable, mut passive) = (vec![], vec![], vec![], vec![]);
    for (kind, walls) in kinds(z_width) {
        for (value, limits) in z_width.damping_n_s_per_m.iter().zip(walls) {
            wall.push(kind);
            damping.push(*value);
            stable.push(limits.stable_n_per_m);
            passive.push(limits.passive_n_per_m);
        }
    }
    DataTable::new("z_width")
        .texts("wall", wall)
        .numbers("damping_n_s_per_m", damping)
        .optional("max_stable_n_per_m", stable)
        .optional("max_passive_n_per_m", passive)
}

/// Returns the Z-width for `stability.json`. A limit beyond the search range is `null`, with `is_beyond_search`.
pub(super) fn json(z_width: &ZWidth) -> Json {
    let limit = |value: Option<f64>| {
        json!({
            "max_n_per_m": value.filter(|value| value.is_finite()),
            "is_beyond_search": value.is_some_and(f64::is_infinite),
        })
    };
    let of_walls = |walls: &[Walls]| -> Vec<Json> {
        let each = z_width.damping_n_s_per_m.iter().zip(walls).map(|(damping, walls)| {
            let (stable, passive) = (limit(walls.stable_n_per_m), limit(walls.passive_n_per_m));
            json!({ "damping_n_s_per_m": damping, "stable": stable, "passive": passive })
        });
        each.collect()
    };
    json!({
        "tissue": of_walls(&z_width.tissue),
        "virtual": z_width.virtual_walls.as_deref().map(of_walls),
    })
}

/// The largest stiffness of each kind of wall, a line each.
pub(super) fn lines(z_width: &ZWidth) -> Vec<String> {
    let newtons = |value: f64| {
        if value.is_finite() { format!("{} N/m", significant(value)) } else { "the search range".to_owned() }
    };
    let of_kind = |(kind, walls): (&str, &[Walls])| {
        let best = |of: fn(&Walls) -> Option<f64>| {
            let each = z_width.damping_n_s_per_m.iter().zip(walls).filter_map(|(b, walls)| Some((of(walls)?, *b)));
            let best = each.reduce(|best, one| if one.0 > best.0 { one } else { best });
            best.map_or("none".to_owned(), |(k, b)| format!("up to {} (at {} N·s/m)", newtons(k), significant(b)))
        };
        let place = if kind == "tissue" { "in the tissue" } else { "computed by the master" };
        let (stable, passive) = (best(|walls| walls.stable_n_per_m), best(|walls| walls.passive_n_per_m));
        format!("Z-width, walls {place}: stable {stable}, passive {passive}")
    };
    let mut lines: Vec<String> = kinds(z_width).into_iter().map(of_kind).collect();
    if z_width.virtual_walls.is_none() {
        lines.push(
            "Z-width, walls computed by the master: not known (it needs a force that depends on the sampled position only)"
                .to_owned(),
        );
    }
    lines
}
