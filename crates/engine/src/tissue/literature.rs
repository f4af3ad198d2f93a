//! Sources: `docs/src/evidence/literature.md`. The ranges are wider than the measurements, because tissues, needles and
//! species differ. Ratios of static to kinetic friction are ratios of means.

use std::borrow::Cow;

use trocar_core::settings::Range;

use super::named_layers::{Measurable, path_in_layer};

#[derive(Debug, PartialEq)]
pub struct Bounds {
    pub low: f64,
    pub high: f64,
    pub stated: &'static str,
}

impl Bounds {
    pub fn contains(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }

    pub const fn range(&self) -> Range {
        if self.low == 1.0 {
            Range::AT_LEAST_ONE
        } else if self.low > 0.0 {
            Range::POSITIVE
        } else {
            Range::NON_NEGATIVE
        }
    }
}

#[derive(Debug, Clone)]
pub struct Outside {
    pub key: Cow<'static, str>,
    pub value: f64,
    pub bounds: &'static Bounds,
}

pub(super) fn outside<'a>(of: impl IntoIterator<Item = Measurable<'a>>) -> Vec<Outside> {
    of.into_iter()
        .filter(|(_, _, value, bounds)| !bounds.contains(*value))
        .map(|(key, layer, value, bounds)| Outside { key: path_in_layer(key, layer), value, bounds })
        .collect()
}

macro_rules! bounds {
    ($low:literal to $high:literal $unit:literal, $reason:literal) => {
        Bounds { low: $low as f64, high: $high as f64, stated: concat!($low, " to ", $high, $unit, " (", $reason, ")") }
    };
}

pub const THICKNESS_M: Bounds = bounds!(0 to 0.3 " m", "chosen here: no needle is longer");

pub const DEFLECTION_M: Bounds = bounds!(0 to 0.1 " m", "no membrane bulges more");

/// `a₁`.
pub const STIFFNESS_N_PER_M: Bounds =
    bounds!(0 to 20000 " N/m", "measured in bovine liver: 2 to 48 N/m, Okamura et al. 2004");

/// `a₂`.
pub const STIFFENING_N_PER_M2: Bounds =
    bounds!(0 to 2e7 " N/m²", "measured in bovine liver: 2300 to 5200 N/m², Okamura et al. 2004");

pub const RUPTURE_FORCE_N: Bounds =
    bounds!(0.0005 to 19.2 " N", "the range measured in 24 works, van Gerwen et al. 2012");

pub const CUTTING_FORCE_N: Bounds = bounds!(0.0005 to 19.2 " N", "measured: 0.05 to 1.3 N, van Gerwen et al. 2012");

pub const TOUGHNESS_J_PER_M2: Bounds = bounds!(
    76 to 30400 " J/m²",
    "measured: 76 J/m² in porcine liver by needle to 30400 J/m² in porcine skin by tearing, CJME 35 (2022), table 2"
);

/// `c`.
pub const DAMPING_S_PER_M: Bounds = bounds!(0 to 100 " s/m", "chosen here; 100 s/m doubles the force at 10 mm/s");

pub const FRICTION_N_PER_M: Bounds = bounds!(
    0 to 800 " N/m",
    "measured: 10.6 N/m in bovine liver to 80 N/m in PVC, Okamura et al. 2004, DiMaio and Salcudean 2003"
);

pub const GRIP_N: Bounds = bounds!(
    0 to 7 " N",
    "measured on whole shafts: 0.15 to 2.8 N, up to 150 % more on one that was turned, van Gerwen et al. 2012"
);

/// `σ`.
pub const SHAFT_STIFFNESS_N_PER_M: Bounds = bounds!(10 to 1e5 " N/m", "chosen here; the largest measured friction, 2.8 N, then drags tissue by 0.28 m to 0.03 mm");

pub const STATIC_RATIO: Bounds = bounds!(1 to 10 "", "measured in bovine liver: 1.5 to 1.7, Okamura et al. 2004");

pub const STICK_SPEED_M_PER_S: Bounds =
    bounds!(0 to 0.01 " m/s", "insertions go at 0.4 to 10 mm/s, van Gerwen et al. 2012");

pub const SHAFT_DAMPING_N_S_PER_M2: Bounds = bounds!(
    0 to 2000 " N·s/m²",
    "measured in bovine liver: 212 to 293 N·s/m², Okamura et al. 2004; up to 1327 N·s/m² by another method, Simone and Okamura 2002"
);

#[derive(Debug)]
pub struct Measured {
    pub quantity: &'static str,
    pub tissue: &'static str,
    pub low: f64,
    pub high: f64,
    pub source: &'static str,
    pub bounds: &'static Bounds,
}

const fn measured(
    quantity: &'static str,
    tissue: &'static str,
    (low, high): (f64, f64),
    source: &'static str,
    bounds: &'static Bounds,
) -> Measured {
    Measured { quantity, tissue, low, high, source, bounds }
}

const GOKGOL: &str = "Gokgol et al. 2012";
const REVIEW: &str = "review, CJME 2022";
const OKAMURA: &str = "Okamura et al. 2004";
const VAN_GERWEN: &str = "van Gerwen et al. 2012";

pub const MEASURED: [Measured; 18] = [
    measured(
        "thickness_m",
        "yellow ligament, L2 to S1, means",
        (3.19e-3, 3.71e-3),
        "Khasawneh et al. 2023",
        &THICKNESS_M,
    ),
    measured("rupture_force_n", "any, 24 works, median 1.22", (5e-4, 19.2), VAN_GERWEN, &RUPTURE_FORCE_N),
    measured("rupture_force_n", "bovine liver, mean ± SD of 19", (1.475, 3.133), OKAMURA, &RUPTURE_FORCE_N),
    measured("deflection at rupture, m", "bovine liver, mean ± SD of 19", (0.0131, 0.0202), OKAMURA, &DEFLECTION_M),
    measured("cutting_force_n", "any, 10 works, median 0.95", (0.05, 1.3), VAN_GERWEN, &CUTTING_FORCE_N),
    measured("cutting_force_n", "bovine liver, mean ± SD of 5", (0.58, 1.3), OKAMURA, &CUTTING_FORCE_N),
    measured("stiffness_n_per_m", "bovine liver, two", (2.0, 48.0), OKAMURA, &STIFFNESS_N_PER_M),
    measured("stiffening_n_per_m2", "bovine liver, two", (2300.0, 5200.0), OKAMURA, &STIFFENING_N_PER_M2),
    measured("toughness_j_per_m2", "bovine liver, 4 needles, mean ± SD", (158.0, 170.0), GOKGOL, &TOUGHNESS_J_PER_M2),
    measured("toughness_j_per_m2", "porcine liver, by needle and by blade", (76.0, 225.0), REVIEW, &TOUGHNESS_J_PER_M2),
    measured(
        "toughness_j_per_m2",
        "porcine skin, by needle to by tearing",
        (1136.0, 30400.0),
        REVIEW,
        &TOUGHNESS_J_PER_M2,
    ),
    measured("friction_n_per_m", "bovine liver, in and out, means", (10.57, 11.96), OKAMURA, &FRICTION_N_PER_M),
    measured("friction_n_per_m", "PVC, 1 to 9 mm/s", (34.0, 80.0), "DiMaio and Salcudean 2003", &FRICTION_N_PER_M),
    measured("grip_n, as a whole shaft's friction", "any, 10 works, median 1.0", (0.15, 2.8), VAN_GERWEN, &GRIP_N),
    measured("static_ratio", "bovine liver, out and in, means", (1.52, 1.75), OKAMURA, &STATIC_RATIO),
    measured("stick_speed_m_per_s", "bovine liver, set", (5e-6, 5e-6), OKAMURA, &STICK_SPEED_M_PER_S),
    measured(
        "shaft_damping_n_s_per_m2",
        "bovine liver, in and out, means",
        (212.31, 293.08),
        OKAMURA,
        &SHAFT_DAMPING_N_S_PER_M2,
    ),
    measured(
        "shaft_damping_n_s_per_m2",
        "bovine liver, 0.8 to 0.2 Hz",
        (377.0, 1327.0),
        "Simone and Okamura 2002",
        &SHAFT_DAMPING_N_S_PER_M2,
    ),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_measurement_is_in_its_range() {
        for Measured { quantity, low, high, bounds, .. } in &MEASURED {
            assert!(low <= high && bounds.contains(*low) && bounds.contains(*high), "{quantity}");
            assert!(bounds.range().contains(bounds.low) && bounds.range().contains(2.0 * bounds.high), "{quantity}");
        }
    }

    #[test]
    fn values_outside_are_listed_with_their_ranges() {
        let inside = ("a", None, 19.2, &RUPTURE_FORCE_N);
        let found =
            outside([inside, ("*.b", Some("dura"), 19.3, &RUPTURE_FORCE_N), ("c", None, 4e-4, &RUPTURE_FORCE_N)]);
        assert_eq!(found.iter().map(|one| &*one.key).collect::<Vec<_>>(), ["dura.b", "c"]);
        assert!(found[0].bounds.stated.starts_with("0.0005 to 19.2 N (the range measured"));
    }
}
