use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use trocar_stability::{Certificate, Switching};

/// `certificate.json`: all data for an independent verification of the certificates. A matrix is a list of rows.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CertificateFile {
    /// Length of a tick, in s.
    pub(super) tick_s: f64,
    /// Delay around the loop, in ticks.
    pub(super) delay_ticks: u64,
    /// Minimum and maximum stiffness of the tissue, in N/m.
    pub(super) stiffness_n_per_m: (f64, f64),
    /// Minimum and maximum damping of the tissue, in N·s/m. The certificates without an additional force assume the
    /// minimum.
    pub(super) damping_n_s_per_m: (f64, f64),
    pub(super) certificates: Certificates,
}

/// The certificates by name.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Certificates {
    /// The certificate with the shortest time between events.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) shortest_dwell: Option<Certificate>,
    /// The certificate of the smallest growth at the refractory time of the supervisor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) growth_at_refractory: Option<Certificate>,
    /// The certificate of the statement. The rows of `quantity_0` and `quantity_1` are the positions of needle and hand
    /// over their bounds for an additional force of 1 N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) statement: Option<Certificate>,
}

impl CertificateFile {
    pub(super) fn of(switching: &Switching) -> Option<Self> {
        let certificates = Certificates {
            shortest_dwell: switching.certificate.clone(),
            growth_at_refractory: switching.at_refractory.clone(),
            statement: switching.peaks.as_ref().map(|peaks| peaks.certificate.clone()),
        };
        let is_any = certificates.shortest_dwell.is_some() || certificates.statement.is_some();
        let settings = &switching.settings;
        is_any.then(|| Self {
            tick_s: settings.of_loop.tick_s,
            delay_ticks: settings.delay_ticks(),
            stiffness_n_per_m: settings.stiffness_n_per_m,
            damping_n_s_per_m: settings.damping_n_s_per_m,
            certificates,
        })
    }
}
