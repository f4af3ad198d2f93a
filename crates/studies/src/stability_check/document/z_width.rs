use schemars::JsonSchema;
use serde::Serialize;

use trocar_document::{DataTable, significant};
use trocar_stability::{Walls, ZWidth};

fn kinds(z_width: &ZWidth) -> Vec<(&'static str, &[Walls])> {
    let virtual_walls = z_width.virtual_walls.as_deref().map(|walls| ("virtual", walls));
    std::iter::once(("tissue", z_width.tissue.as_slice())).chain(virtual_walls).collect()
}

/// A stiffness is empty if no wall has the property, `inf` beyond the search.
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

/// The Z-width: the stiffest walls by their damping.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct ZWidthPart {
    /// Walls in the tissue.
    tissue: Vec<WallPart>,
    /// Walls computed by the master; `None` if the force does not depend on the sampled position only.
    #[serde(rename = "virtual")]
    virtual_walls: Option<Vec<WallPart>>,
}

/// Walls with one damping.
#[derive(Debug, Serialize, JsonSchema)]
struct WallPart {
    /// Damping, in N·s/m.
    damping_n_s_per_m: f64,
    /// The stiffest wall that is stable with the scenario's arm.
    stable: WallLimit,
    /// The stiffest wall that is passive at the hand.
    passive: WallLimit,
}

/// The stiffest wall with a property.
#[derive(Debug, Serialize, JsonSchema)]
struct WallLimit {
    /// Stiffness, in N/m; `None` without such a wall, and beyond the search range.
    max_n_per_m: Option<f64>,
    /// True if every searched wall has the property.
    is_beyond_search: bool,
}

impl ZWidthPart {
    pub(super) fn of(z_width: &ZWidth) -> Self {
        let limit = |value: Option<f64>| WallLimit {
            max_n_per_m: value.filter(|value| value.is_finite()),
            is_beyond_search: value.is_some_and(f64::is_infinite),
        };
        let wall = |(&damping_n_s_per_m, walls): (&f64, &Walls)| WallPart {
            damping_n_s_per_m,
            stable: limit(walls.stable_n_per_m),
            passive: limit(walls.passive_n_per_m),
        };
        let of_walls = |walls: &[Walls]| z_width.damping_n_s_per_m.iter().zip(walls).map(wall).collect();
        Self { tissue: of_walls(&z_width.tissue), virtual_walls: z_width.virtual_walls.as_deref().map(of_walls) }
    }
}

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
