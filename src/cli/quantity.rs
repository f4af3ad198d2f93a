//! Numbers on the command line, with a unit or without.

use trocar_sim::scenario::parse_quantity;

/// Parses a number in `unit`: plain, or with a unit of its own, as in `30ms` where `unit` is `s`.
pub(super) fn quantity(unit: &'static str) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    move |text| match text.trim().parse() {
        Ok(number) => Ok(number),
        Err(_) => parse_quantity(text, unit),
    }
}
