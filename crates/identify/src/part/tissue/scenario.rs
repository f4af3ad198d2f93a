use std::fmt::Write as _;

use trocar_document::shortest;

use super::super::Chosen;
use super::super::rupture::Rupture;
use super::super::signals::Signals;

pub(super) fn scenario(training: &[Signals], chosen: &Chosen<'_>, values: &[f64]) -> String {
    let candidate = chosen.candidate;
    let value = |key: &str| candidate.value(values, key);
    let mut text =
        "# What does the needle do in the identified tissue?\nbase = \"layers/skin-augmented\"\n\n[tissue]\n"
            .to_owned();
    let mut line = |key: &str, value: f64| {
        let _ = writeln!(text, "{key} = {}", shortest(value));
    };
    let is_layer = candidate.key.starts_with("layer");
    line("contact_m", value("contact_m"));
    let grip_n = value("grip_n");
    if candidate.key.starts_with("kelvin-voigt") {
        line("stiffness_n_per_m", value("stiffness_n_per_m"));
        line("damping_n_s_per_m", value("damping_n_s_per_m"));
        text.push_str("kind = \"kelvin-voigt\"\n");
    } else if !is_layer {
        line("mu", value("mu"));
        line("lambda", value("lambda"));
        line("power", value("power"));
        text.push_str("kind = \"hunt-crossley\"\n");
    } else {
        if grip_n > 0.0 {
            line("shaft_stiffness_n_per_m", value("shaft_stiffness_n_per_m"));
        }
        text.push_str("kind = \"layers\"\n\n[[tissue.layer]]\nname = \"identified\"\n");
        let rupture = chosen.ruptures.first().map(|(_, rupture)| rupture);
        layer(&mut text, training, rupture, &value);
    }
    if grip_n > 0.0 && !is_layer {
        let _ = writeln!(text, "# The friction of the shaft, {grip_n:.3e} N, is left out: this tissue has none.");
    }
    text
}

/// Without a rupture in the recording, the layer ruptures at twice the largest deflection, or at the deepest allowed
/// one.
fn layer(text: &mut String, training: &[Signals], rupture: Option<&Rupture>, value: &dyn Fn(&str) -> f64) {
    const DEEPEST_M: f64 = 0.099;
    let (stiffness, stiffening) = (value("stiffness_n_per_m"), value("stiffening_n_per_m2"));
    let deepest_m = training.iter().flat_map(|one| &one.position_m).copied().fold(f64::NEG_INFINITY, f64::max);
    let depth_m = (2.0 * (deepest_m - value("contact_m"))).clamp(1e-6, DEEPEST_M);
    let unknown_n = depth_m * (stiffness + stiffening * depth_m);
    let zero_n = value("force_zero_n");
    let rupture_n = rupture.map_or(unknown_n, |rupture| (rupture.force_n - zero_n).max(1e-6));
    let cutting_n = rupture.map_or(unknown_n, |rupture| (rupture.after_n - zero_n).clamp(1e-6, rupture_n));
    for (key, value) in [
        ("stiffness_n_per_m", stiffness),
        ("stiffening_n_per_m2", stiffening),
        ("damping_s_per_m", value("damping_s_per_m")),
        ("rupture_force_n", rupture_n),
        ("cutting_force_n", cutting_n),
        ("grip_n", value("grip_n")),
        ("friction_n_per_m", 0.0),
    ] {
        let _ = writeln!(text, "{key} = {}", shortest(value));
    }
    if rupture.is_none() {
        text.push_str("# The rupture is beyond the depths of the recordings: set its force if you know it.\n");
    }
}
