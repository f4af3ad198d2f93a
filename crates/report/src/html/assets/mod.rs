/// Colours, fonts and spacing, for the light and the dark theme.
pub const THEME_CSS: &str = include_str!("theme.css");
/// Charts from the descriptions of figures.
pub const CHARTS_JS: &str = include_str!("charts.js");
pub const ANIMATION_JS: &str = include_str!("animation.js");
pub(super) const REPORT_HTML: &str = include_str!("report.html");
pub(super) const REPORT_CSS: &str = include_str!("report.css");
pub(super) const REPORT_JS: &str = include_str!("report.js");

#[cfg(test)]
mod tests {
    use super::*;
    use trocar_document::figure::NAMES;

    #[test]
    fn the_theme_has_every_colour_of_figures() {
        for (name, _) in NAMES {
            assert!(THEME_CSS.contains(&format!("--{name}: light-dark(")), "{name}");
        }
    }
}
