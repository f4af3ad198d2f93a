//! The keys of the tissue, but for those of its layers.

use super::key;
use crate::scenario::keys::{Fallback, Key};
use crate::scenario::layer_keys::within;
use crate::scenario::value::{Kind, Range as R, Value};
use crate::tissue::{ShaftParameters, literature};
use Kind::{Choice, Number, Numbers};

pub(super) const KEYS: &[Key] = &[
    key(
        "tissue.kind",
        Choice(&["recording", "kelvin-voigt", "hunt-crossley", "generalised", "layers"]),
        word!("recording"),
        "Replays the recording's force over time, or answers as a spring and damper, even (eq. 1), stiffening (eq. 2) or \
         varying with depth (eq. 3-4), or as layers that give way.",
    ),
    key(
        "tissue.index",
        Choice(&["time", "depth"]),
        word!("time"),
        "Replay by time, or by depth: then a frozen slave feels a held force.",
    ),
    key(
        "tissue.presliding_m",
        Number(R::POSITIVE),
        number!(2e-3),
        "Travel over which a retreat in a replay by depth turns to the force of the way out.",
    ),
    key("tissue.stiffness_n_per_m", Number(R::NON_NEGATIVE), number!(200.0), "K of kelvin-voigt."),
    key("tissue.damping_n_s_per_m", Number(R::NON_NEGATIVE), number!(5.0), "B of kelvin-voigt."),
    key("tissue.contact_m", Number(R::ANY), number!(0.0), "Surface of every tissue but a recording."),
    key("tissue.mu", Number(R::NON_NEGATIVE), number!(2000.0), "mu of hunt-crossley, in N/m^n."),
    key("tissue.lambda", Number(R::NON_NEGATIVE), number!(200.0), "lambda of hunt-crossley, in N·s/m^(n+1)."),
    key(
        "tissue.power",
        Number(R::NON_NEGATIVE),
        number!(1.5),
        "n of hunt-crossley and generalised, a multiple of 0.25 up to 7.75.",
    ),
    key(
        "tissue.depths_m",
        Numbers,
        Fallback::Value(|| Value::Numbers(vec![0.0, 0.02])),
        "Depths below the surface at which generalised has its coefficients: 1 to 16, ascending; linear between them.",
    ),
    key(
        "tissue.mus",
        Numbers,
        Fallback::Value(|| Value::Numbers(vec![2000.0, 1000.0])),
        "mu of generalised at each depth, at least 0, in N/m^n.",
    ),
    key(
        "tissue.lambdas",
        Numbers,
        Fallback::Value(|| Value::Numbers(vec![200.0, 200.0])),
        "lambda of generalised at each depth, at least 0, in N·s/m^(n+1).",
    ),
    key(
        "tissue.shaft_stiffness_n_per_m",
        Number(within(&literature::SHAFT_STIFFNESS_N_PER_M)),
        number!(ShaftParameters::default().stiffness_n_per_m),
        "sigma of layers: how stiffly the shaft drags tissue along before it slides.",
    ),
    key(
        "tissue.static_ratio",
        Number(within(&literature::STATIC_RATIO)),
        number!(ShaftParameters::default().static_ratio),
        "Static by kinetic friction of the shaft in layers.",
    ),
    key(
        "tissue.stick_speed_m_per_s",
        Number(within(&literature::STICK_SPEED_M_PER_S)),
        number!(ShaftParameters::default().stick_speed_m_per_s),
        "Speed below which the shaft sticks again.",
    ),
    key(
        "tissue.shaft_damping_n_s_per_m2",
        Number(within(&literature::SHAFT_DAMPING_N_S_PER_M2)),
        number!(ShaftParameters::default().damping_n_s_per_m2),
        "Viscous friction of the shaft per length in layers.",
    ),
];
