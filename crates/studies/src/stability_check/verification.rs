use thiserror::Error;

use super::certificate::{CertificateFile, Certificates};
use super::is_tissue;
use trocar_document::significant;
use trocar_scenario::Scenario;
use trocar_stability::{Certificate, Choice, LinearLoop, StabilityError, SwitchingSettings, TissueRange};

#[derive(Debug, Error)]
pub enum VerificationError {
    #[error("not a certificate file: {0}")]
    Form(String),
    #[error("{0}; give the scenario and the --set of the analysis that wrote the file")]
    OtherScenario(String),
    #[error("the scenario has no certificates: {0}")]
    Excluded(String),
    #[error("certificate {name}: {reason}")]
    Unverified {
        name: &'static str,
        /// The part that does not hold.
        reason: String,
    },
    #[error(transparent)]
    Scenario(#[from] StabilityError),
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Verified {
    pub name: &'static str,
    pub conditions: u64,
    pub claim: String,
}

/// Maps and inequalities are rebuilt from the scenario; only the functions are from the file.
pub fn verify(text: &str, scenario: &Scenario) -> Result<Vec<Verified>, VerificationError> {
    let file: CertificateFile =
        serde_json::from_str(text).map_err(|error| VerificationError::Form(error.to_string()))?;
    let tissue = TissueRange::of_parameters(scenario)
        .ok_or(VerificationError::Excluded("its tissue states no springs".to_owned()))?;
    let stiffness_n_per_m = tissue.sector_n_per_m();
    let of_loop = LinearLoop::of(scenario, tissue)?;
    let of_scenario =
        SwitchingSettings::of(scenario, of_loop, stiffness_n_per_m).map_err(VerificationError::Excluded)?;
    check_scenario(&file, &of_scenario).map_err(VerificationError::OtherScenario)?;
    let CertificateFile { stiffness_n_per_m, damping_n_s_per_m, certificates, .. } = file;
    let springs = SwitchingSettings { stiffness_n_per_m, ..of_scenario };
    let driven = SwitchingSettings { damping_n_s_per_m, ..springs.clone() };
    let Certificates { shortest_dwell, growth_at_refractory, statement } = &certificates;
    let all = [
        ("shortest_dwell", shortest_dwell, &springs),
        ("growth_at_refractory", growth_at_refractory, &springs),
        ("statement", statement, &driven),
    ];
    let verified: Vec<Verified> = (all.into_iter())
        .filter_map(|(name, certificate, settings)| Some(verified(name, certificate.as_ref()?, settings)))
        .collect::<Result<_, _>>()?;
    if verified.is_empty() { Err(VerificationError::Form("it has no certificates".to_owned())) } else { Ok(verified) }
}

fn check_scenario(file: &CertificateFile, settings: &SwitchingSettings) -> Result<(), String> {
    let other =
        |what: &str, stated: String, own: String| Err(format!("{what} is {stated}, and the scenario's is {own}"));
    let range = |(low, high): (f64, f64)| format!("{} to {}", significant(low), significant(high));
    let contains = |outer: (f64, f64), inner: (f64, f64)| outer.0 <= inner.0 && inner.1 <= outer.1;
    let (tick_s, delay_ticks) = (settings.of_loop.tick_s, settings.delay_ticks());
    if file.tick_s != tick_s {
        return other("tick_s", file.tick_s.to_string(), tick_s.to_string());
    }
    if file.delay_ticks != delay_ticks {
        return other("delay_ticks", file.delay_ticks.to_string(), delay_ticks.to_string());
    }
    let (stated, own) = (file.stiffness_n_per_m, settings.stiffness_n_per_m);
    if !(is_tissue(stated) && contains(stated, own)) {
        return other("stiffness_n_per_m", range(stated), range(own));
    }
    let (stated, own) = (file.damping_n_s_per_m, settings.damping_n_s_per_m);
    if !(0.0 <= stated.0 && contains(stated, own)) {
        return other("damping_n_s_per_m", range(stated), range(own));
    }
    Ok(())
}

fn verified(
    name: &'static str,
    certificate: &Certificate,
    settings: &SwitchingSettings,
) -> Result<Verified, VerificationError> {
    let unverified = |reason: String| VerificationError::Unverified { name, reason };
    let choice = certificate.choice;
    let (is_statement, refractory) = (name == "statement", settings.phases().refractory);
    if choice.is_driven != is_statement || choice.bounds_m_per_n.is_some() != is_statement {
        return Err(unverified("choice.is_driven or choice.bounds_m_per_n is that of another certificate".to_owned()));
    }
    if name != "shortest_dwell" && choice.dwell_ticks > refractory {
        let dwell = choice.dwell_ticks;
        return Err(unverified(format!("choice.dwell_ticks is {dwell}, and the scenario enforces {refractory}")));
    }
    let conditions = certificate.verify(settings).map_err(unverified)?;
    Ok(Verified { name, conditions, claim: claim(&choice, settings) })
}

fn claim(choice: &Choice, settings: &SwitchingSettings) -> String {
    let (low, high) = settings.stiffness_n_per_m;
    let growth = significant(choice.contraction.sqrt());
    let dwell_ms = significant(1e3 * choice.dwell_ticks as f64 * settings.of_loop.tick_s);
    let stiffness = format!("{} to {} N/m", significant(low), significant(high));
    let growth = format!("with {stiffness} and {dwell_ms} ms between events, the growth per event is at most {growth}");
    let Some([needle, hand]) = choice.bounds_m_per_n.map(|bounds| bounds.map(|bound| significant(1e3 * bound))) else {
        return growth;
    };
    format!("{growth}, and 1 N moves the needle at most {needle} mm and the hand at most {hand} mm")
}

#[cfg(test)]
mod tests;
