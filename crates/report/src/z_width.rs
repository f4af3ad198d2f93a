//! The Z-width as CSV, JSON, text and figure.

use std::fmt::Write as _;

use serde_json::{Value as Json, json};

use super::Folder;
use super::figures;
use super::number::significant;
use super::pictures::{PictureError, keep};
use super::tables::shortest;
use trocar_stability::{Walls, ZWidth};

/// The kinds of walls with their limits.
fn kinds(z_width: &ZWidth) -> Vec<(&'static str, &[Walls])> {
    let virtual_walls = z_width.virtual_walls.as_deref().map(|walls| ("virtual", walls));
    std::iter::once(("tissue", z_width.tissue.as_slice())).chain(virtual_walls).collect()
}

/// Returns `z_width.csv`: the maximum stiffness by damping. A cell is empty if no wall has the property, and `inf` beyond
/// the search range.
#[must_use]
pub fn z_width_csv(z_width: &ZWidth) -> String {
    let mut text = "wall,damping_n_s_per_m,max_stable_n_per_m,max_passive_n_per_m\n".to_owned();
    for (kind, walls) in kinds(z_width) {
        for (damping, limits) in z_width.damping_n_s_per_m.iter().zip(walls) {
            let cell = |value: Option<f64>| value.map_or(String::new(), shortest);
            let (stable, passive) = (cell(limits.stable_n_per_m), cell(limits.passive_n_per_m));
            let _ = writeln!(text, "{kind},{},{stable},{passive}", shortest(*damping));
        }
    }
    text
}

/// Returns the Z-width for `stability.json`. A limit beyond the search range is `null`, with `is_beyond_search`.
pub(super) fn z_width_json(z_width: &ZWidth) -> Json {
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

/// Returns the Z-width as text.
#[must_use]
pub fn z_width_text(z_width: &ZWidth) -> String {
    let newtons = |value: f64| {
        if value.is_finite() { format!("{} N/m", significant(value)) } else { "the search range".to_owned() }
    };
    let mut text = String::new();
    for (kind, walls) in kinds(z_width) {
        let best = |of: fn(&Walls) -> Option<f64>| {
            let each = z_width.damping_n_s_per_m.iter().zip(walls).filter_map(|(b, walls)| Some((of(walls)?, *b)));
            let best = each.reduce(|best, one| if one.0 > best.0 { one } else { best });
            best.map_or("none".to_owned(), |(k, b)| format!("up to {} (at {} N·s/m)", newtons(k), significant(b)))
        };
        let place = if kind == "tissue" { "in the tissue" } else { "computed by the master" };
        let _ = writeln!(
            text,
            "Z-width, walls {place}: stable {}, passive {}",
            best(|walls| walls.stable_n_per_m),
            best(|walls| walls.passive_n_per_m)
        );
    }
    if z_width.virtual_walls.is_none() {
        text += "Z-width, walls computed by the master: not known (it needs a force that depends on the sampled position only)\n";
    }
    text
}

/// Writes the figure `z_width`.
///
/// # Errors
/// [`PictureError`].
pub fn z_width_picture(folder: &Folder, name: &str, z_width: &ZWidth) -> Result<(), PictureError> {
    keep(folder, "z_width", &figures::z_width(name, z_width)?)
}
