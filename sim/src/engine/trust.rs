//! The trust in the estimate, tick by tick, as further columns of a trace.

use super::Signals;
use super::column::{ColumnValues, TraceColumn};
use crate::estimation::Confidence;

/// The columns of [`TrustColumns`], in the order of a trace's file.
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

/// The flag of a tick out of contact.
const OUT_OF_CONTACT: u8 = 8;

/// The trust in the estimate at each tick.
#[derive(Debug, Clone, PartialEq)]
pub struct TrustColumns {
    /// Standard error of K in N/m.
    pub stiffness_std_n_per_m: Vec<f64>,
    /// Standard error of B in N·s/m.
    pub damping_std_n_s_per_m: Vec<f64>,
    /// The excitation, 0 to 1.
    pub excitation: Vec<f64>,
    /// The flags.
    pub estimate_flags: Vec<u8>,
    contact_m: f64,
    confidence: Confidence,
}

impl TrustColumns {
    /// The trust in the estimates of samples `tick_s` (s) apart, of a contact at `contact_m` (m): from positions (m) and velocities
    /// (m/s), residuals (N), and estimates of K (N/m) and B (N·s/m), all of the same length.
    #[must_use]
    pub fn of(
        (contact_m, tick_s): (f64, f64),
        (position_m, velocity_m_per_s): (&[f64], &[f64]),
        residual_n: &[f64],
        (k, b): (&[f64], &[f64]),
    ) -> Self {
        let mut trust = Self::new(contact_m, tick_s, residual_n.len());
        let motions = position_m.iter().copied().zip(velocity_m_per_s.iter().copied());
        let parameters = k.iter().copied().zip(b.iter().copied());
        for ((motion, residual_n), parameters) in motions.zip(residual_n).zip(parameters) {
            trust.add_estimate(motion, *residual_n, parameters);
        }
        trust
    }

    /// Empty columns with room for `ticks` of `tick_s` (s), for an estimator in contact below `contact_m` (m).
    pub(super) fn new(contact_m: f64, tick_s: f64, ticks: usize) -> Self {
        Self {
            stiffness_std_n_per_m: Vec::with_capacity(ticks),
            damping_std_n_s_per_m: Vec::with_capacity(ticks),
            excitation: Vec::with_capacity(ticks),
            estimate_flags: Vec::with_capacity(ticks),
            contact_m,
            confidence: Confidence::new(tick_s),
        }
    }

    /// Adds a tick. The depth is that of the needle itself, not of the position sensor.
    #[inline]
    pub(super) fn add(&mut self, s: &Signals<f64>) {
        let motion = (s.slave_position_m, s.slave_velocity_m_per_s);
        self.add_estimate(motion, s.residual_n, (s.stiffness_n_per_m, s.damping_n_s_per_m));
    }

    /// Adds a sample: position in m and velocity in m/s, residual in N, and the estimates of K in N/m and B in N·s/m.
    #[inline]
    fn add_estimate(&mut self, (position_m, velocity_m_per_s): (f64, f64), residual_n: f64, (k, b): (f64, f64)) {
        let depth_m = position_m - self.contact_m;
        let in_contact = depth_m > 0.0;
        if in_contact {
            self.confidence.add(depth_m, velocity_m_per_s, residual_n);
        }
        let trust = self.confidence.trust();
        let flags = trust.flags(k, b);
        self.stiffness_std_n_per_m.push(trust.stiffness_std_n_per_m);
        self.damping_std_n_s_per_m.push(trust.damping_std_n_s_per_m);
        self.excitation.push(trust.excitation);
        self.estimate_flags.push(if in_contact { flags } else { flags | OUT_OF_CONTACT });
    }

    /// The columns of [`TRUST_COLUMNS`].
    #[must_use]
    pub fn columns(&self) -> [ColumnValues<&[f64], &[u8]>; TRUST_COLUMNS.len()] {
        [
            ColumnValues::Numbers(&self.stiffness_std_n_per_m),
            ColumnValues::Numbers(&self.damping_std_n_s_per_m),
            ColumnValues::Numbers(&self.excitation),
            ColumnValues::Codes(&self.estimate_flags),
        ]
    }
}
