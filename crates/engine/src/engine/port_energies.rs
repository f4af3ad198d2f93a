use super::Signals;

/// Positive from the hand to the tissue:
///
/// ```text
/// hand        ∫ F_h dx_h     by the trapezoidal rule
/// master      Σ F_ed Δx_h    exact: F_ed is held over a tick
/// reference   Σ f_e Δx_ref
/// needle      ∫ f_e dx_e     by the trapezoidal rule
/// ```
/// An error of the velocity does not accumulate over a closed path.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PortEnergies {
    pub hand_j: f64,
    pub master_j: f64,
    pub reference_j: f64,
    pub needle_j: f64,
    last: Option<Last>,
}

#[derive(Debug, Clone, PartialEq)]
struct Last {
    master_m: f64,
    hand_n: f64,
    feedback_n: f64,
    reference_m: f64,
    needle_m: f64,
    tissue_n: f64,
}

impl PortEnergies {
    #[inline]
    pub fn add(&mut self, s: &Signals<f64>) {
        let now = Last {
            master_m: s.master_position_m,
            hand_n: s.operator_force_n,
            feedback_n: s.feedback_force_n,
            reference_m: s.slave_reference_m,
            needle_m: s.slave_position_m,
            tissue_n: s.tissue_force_n,
        };
        if let Some(last) = &self.last {
            let moved_m = now.master_m - last.master_m;
            self.hand_j += 0.5 * (now.hand_n + last.hand_n) * moved_m;
            self.master_j += last.feedback_n * moved_m;
            self.reference_j += now.tissue_n * (now.reference_m - last.reference_m);
            self.needle_j += 0.5 * (now.tissue_n + last.tissue_n) * (now.needle_m - last.needle_m);
        }
        self.last = Some(now);
    }
}
