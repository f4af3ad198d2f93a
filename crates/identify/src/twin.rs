use std::fmt::Write as _;

use trocar_document::shortest;

use crate::actuator::Bounded;
use crate::structure::Parameter;

const POINTS: usize = 128;

const METRICS: &str = r#"metrics = [
    "max_slave_overshoot_m", "missed_ruptures", "false_alarms", "stability_gain_margin", "stability_delay_margin_s",
]"#;

pub(crate) const KEYS: [(&str, Parameter); 5] = [
    ("mass_kg", Parameter::Mass),
    ("damping_n_s_per_m", Parameter::Viscous),
    ("coulomb_friction_n", Parameter::Coulomb),
    ("proportional_gain", Parameter::PositionGain),
    ("derivative_gain", Parameter::VelocityGain),
];

/// Axes are the 95 % intervals of `slave.toml`; parameters without an interval stay.
pub(crate) fn twin(parameters: &[(Parameter, Bounded)]) -> String {
    let mut text = format!(
        "# How far do overshoot and margins depend on what the recordings leave open about the slave?\n\
         # Each parameter is drawn evenly from its 95 % interval and independently of the others, so that the spread\n\
         # is rather too wide than too narrow. The gain margin times a scale is the largest stable scale.\n\
         base = \"slave.toml\"\n{METRICS}\n\n[design]\nkind = \"sobol\"\npoints = {POINTS}\n\n[axes]\n"
    );
    for (key, parameter) in KEYS {
        let found = parameters.iter().find(|(own, _)| *own == parameter).map(|(_, bounded)| bounded);
        if let Some(Bounded { low, high, .. }) = found
            && high.is_finite()
            && low.max(0.0) < *high
        {
            let _ = writeln!(text, "slave.{key} = {{ from = {}, to = {} }}", shortest(low.max(0.0)), shortest(*high));
        }
    }
    text
}
