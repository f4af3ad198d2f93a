use super::column::{ColumnValues, TraceColumn};
use trocar_base::large_pages::with_capacity;
use trocar_base::rows::Rows;
use trocar_core::estimation::Confidence;

pub const TRUST_COLUMNS: [TraceColumn; 4] = [
    TraceColumn {
        name: "stiffness_std_n_per_m",
        unit: "N/m",
        meaning: "Standard error of the estimated stiffness, from the samples of the last 0.1 s in contact.",
    },
    TraceColumn { name: "damping_std_n_s_per_m", unit: "N·s/m", meaning: "Standard error of the estimated damping." },
    TraceColumn {
        name: "excitation",
        unit: "",
        meaning: "Share of the information about the damping that does not depend on the stiffness; at 0 it cannot be identified.",
    },
    TraceColumn {
        name: "estimate_flags",
        unit: "",
        meaning: "Sum of: 1 if 0 is within two standard errors of K, 2 of B, 4 if K or B is negative, 8 out of contact.",
    },
];

const OUT_OF_CONTACT: u8 = 8;

#[derive(Debug, Clone, PartialEq)]
pub struct TrustColumns {
    pub stiffness_std_n_per_m: Vec<f64>,
    pub damping_std_n_s_per_m: Vec<f64>,
    /// 0 to 1.
    pub excitation: Vec<f64>,
    /// [`Trust::flags`](trocar_core::estimation::Trust::flags), or 8 out of contact.
    pub estimate_flags: Vec<u8>,
}

impl TrustColumns {
    pub fn of(
        (contact_m, tick_s): (f64, f64),
        (position_m, velocity_m_per_s): (&[f64], &[f64]),
        residual_n: &[f64],
        (k, b): (&[f64], &[f64]),
    ) -> Self {
        let mut confidence = Confidence::new(tick_s);
        let mut errors = Rows::new(residual_n.len(), [true; 3]);
        let mut estimate_flags = with_capacity(residual_n.len());
        let motions = position_m.iter().zip(velocity_m_per_s);
        for (((position_m, velocity_m_per_s), residual_n), (k, b)) in motions.zip(residual_n).zip(k.iter().zip(b)) {
            let depth_m = position_m - contact_m;
            let in_contact = depth_m > 0.0;
            if in_contact {
                confidence.add(depth_m, *velocity_m_per_s, *residual_n);
            }
            let trust = confidence.trust();
            errors.push([trust.stiffness_std_n_per_m, trust.damping_std_n_s_per_m, trust.excitation]);
            let flags = trust.flags(*k, *b);
            estimate_flags.push(if in_contact { flags } else { flags | OUT_OF_CONTACT });
        }
        let [stiffness_std_n_per_m, damping_std_n_s_per_m, excitation] = errors.into_columns();
        Self { stiffness_std_n_per_m, damping_std_n_s_per_m, excitation, estimate_flags }
    }

    pub fn columns(&self) -> [ColumnValues<&[f64], &[u8]>; TRUST_COLUMNS.len()] {
        [
            ColumnValues::Numbers(&self.stiffness_std_n_per_m),
            ColumnValues::Numbers(&self.damping_std_n_s_per_m),
            ColumnValues::Numbers(&self.excitation),
            ColumnValues::Codes(&self.estimate_flags),
        ]
    }

    pub fn into_columns(self) -> [ColumnValues<Vec<f64>, Vec<u8>>; TRUST_COLUMNS.len()] {
        [
            ColumnValues::Numbers(self.stiffness_std_n_per_m),
            ColumnValues::Numbers(self.damping_std_n_s_per_m),
            ColumnValues::Numbers(self.excitation),
            ColumnValues::Codes(self.estimate_flags),
        ]
    }
}
