//! The keys of the tissue, but for those of its layers.

use trocar_core::settings::{Key, Range as R};

pub(super) const KEYS: &[Key] = &[
    Key::choice(
        "tissue.kind",
        &["recording", "kelvin-voigt", "hunt-crossley", "generalised", "layers"],
        "recording",
        "Replays the recording's force over time, or answers as a spring and damper, even (eq. 1), stiffening (eq. 2) or \
         varying with depth (eq. 3-4), or as layers that give way.",
    ),
    Key::choice(
        "tissue.index",
        &["time", "depth"],
        "time",
        "Replay by time, or by depth: then a frozen slave feels a held force.",
    ),
    Key::number(
        "tissue.presliding_m",
        R::POSITIVE,
        2e-3,
        "Travel over which a retreat in a replay by depth turns to the force of the way out.",
    ),
    Key::number("tissue.stiffness_n_per_m", R::NON_NEGATIVE, 200.0, "K of kelvin-voigt."),
    Key::number("tissue.damping_n_s_per_m", R::NON_NEGATIVE, 5.0, "B of kelvin-voigt."),
    Key::number("tissue.contact_m", R::ANY, 0.0, "Surface of every tissue but a recording."),
    Key::number("tissue.mu", R::NON_NEGATIVE, 2000.0, "mu of hunt-crossley, in N/m^n."),
    Key::number("tissue.lambda", R::NON_NEGATIVE, 200.0, "lambda of hunt-crossley, in N·s/m^(n+1)."),
    Key::number(
        "tissue.power",
        R::NON_NEGATIVE,
        1.5,
        "n of hunt-crossley and generalised, a multiple of 0.25 up to 7.75.",
    ),
    Key::numbers(
        "tissue.depths_m",
        &[0.0, 0.02],
        "Depths below the surface at which generalised has its coefficients: 1 to 16, ascending; linear between them.",
    ),
    Key::numbers("tissue.mus", &[2000.0, 1000.0], "mu of generalised at each depth, at least 0, in N/m^n."),
    Key::numbers("tissue.lambdas", &[200.0, 200.0], "lambda of generalised at each depth, at least 0, in N·s/m^(n+1)."),
];
