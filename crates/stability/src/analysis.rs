//! The analysis of one loop.

use super::varying::jitter_margin_ticks;
use super::{
    ClosedLoop, Hybrid, Limit, LinearLoop, Margins, Mode, Parameter, Ports, SampledBound, Search, Sensitivity,
    StabilityError, largest_stable, sensitivities,
};
use trocar_lti::Complex64;

/// Number of frequencies of the two-port, logarithmically spaced from [`LOWEST_HZ`].
const FREQUENCIES: usize = 400;

/// The lowest frequency of the two-port in Hz.
pub const LOWEST_HZ: f64 = 0.1;

/// The highest frequency as a fraction of the sampling rate. Above it, sampling images matter.
const HIGHEST_SHARE: f64 = 0.25;

/// The parameters whose limits are computed.
pub const LIMITED: [Parameter; 4] =
    [Parameter::ForceScale, Parameter::PositionScale, Parameter::Stiffness, Parameter::Delay];

/// The two-port at one frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PortPoint {
    /// The frequency in Hz.
    pub frequency_hz: f64,
    /// The hybrid matrix.
    pub hybrid: Hybrid,
    /// The impedance transmitted to the hand, `Z_t` in N·s/m.
    pub transmitted: Complex64,
    /// The impedance that an ideal teleoperator transmits: the scales times `Z_e`.
    pub ideal: Complex64,
    /// True if the conditions of absolute stability hold.
    pub is_absolutely_stable: bool,
    /// True if the two-port is passive.
    pub is_passive: bool,
}

/// The analysis of a loop.
#[derive(Debug, Clone)]
pub struct Analysis {
    /// The loop.
    pub settings: LinearLoop,
    /// Its dominant mode.
    pub mode: Mode,
    /// Its margins.
    pub margins: Margins,
    /// The largest jitter of both directions, in ticks on top of the delays, with which the loop is proved stable for
    /// every order of the delays; see [`VaryingDelays`](super::VaryingDelays). `None` if unstable, and if
    /// [unlimited](Self::is_jitter_unlimited).
    pub jitter_margin_ticks: Option<u64>,
    /// The stability limit of each of [`LIMITED`].
    pub limits: Vec<Limit>,
    /// The sensitivities of these limits.
    pub sensitivities: Vec<Sensitivity>,
    /// The two-port over frequency; empty if it has no hybrid matrix.
    pub ports: Vec<PortPoint>,
    /// The condition of Colgate and Schenkel, if it applies.
    pub sampled: Option<SampledBound>,
}

impl Analysis {
    /// Analyses a loop.
    ///
    /// # Errors
    /// [`StabilityError`].
    pub fn of(settings: &LinearLoop) -> Result<Self, StabilityError> {
        let closed = ClosedLoop::new(settings)?;
        let limits = LIMITED
            .into_iter()
            .map(|parameter| largest_stable(settings, parameter, Search::of(parameter)))
            .collect::<Result<Vec<_>, _>>()?;
        Ok(Self {
            mode: closed.dominant_mode()?,
            margins: closed.margins()?,
            jitter_margin_ticks: jitter_margin_ticks(settings)?,
            sensitivities: sensitivities(settings, &limits)?,
            limits,
            ports: ports(settings)?,
            sampled: SampledBound::of(settings)?,
            settings: settings.clone(),
        })
    }

    /// Two verdicts over all frequencies of [`Analysis::of`]: absolutely stable, and passive. `None` without a hybrid
    /// matrix.
    ///
    /// # Errors
    /// [`StabilityError`].
    pub fn port_verdicts(settings: &LinearLoop) -> Result<Option<(bool, bool)>, StabilityError> {
        let points = ports(settings)?;
        let all = |holds: fn(&PortPoint) -> bool| points.iter().all(holds);
        Ok((!points.is_empty()).then(|| (all(|point| point.is_absolutely_stable), all(|point| point.is_passive))))
    }

    /// True if the loop is stable.
    #[must_use]
    pub fn is_stable(&self) -> bool {
        self.mode.spectral_radius < 1.0
    }

    /// True if the loop is proved stable for any jitter of the search.
    #[must_use]
    pub fn is_jitter_unlimited(&self) -> bool {
        self.is_stable() && self.jitter_margin_ticks.is_none()
    }
}

pub(super) fn frequencies_hz(tick_s: f64) -> impl Iterator<Item = f64> {
    let highest_hz = (HIGHEST_SHARE / tick_s).max(10.0 * LOWEST_HZ);
    let step = (highest_hz / LOWEST_HZ).powf(1.0 / (FREQUENCIES - 1) as f64);
    (0..FREQUENCIES).map(move |k| LOWEST_HZ * step.powi(k as i32))
}

fn ports(settings: &LinearLoop) -> Result<Vec<PortPoint>, StabilityError> {
    let two_port = Ports::new(settings)?;
    let (force, position) = two_port.scales();
    let mut points = vec![];
    for frequency_hz in frequencies_hz(settings.tick_s) {
        let omega = std::f64::consts::TAU * frequency_hz;
        let Some(hybrid) = two_port.at(omega)? else { continue };
        let tissue = two_port.tissue(omega);
        points.push(PortPoint {
            frequency_hz,
            hybrid,
            transmitted: hybrid.transmitted(tissue),
            ideal: tissue * (force * position),
            is_absolutely_stable: hybrid.is_absolutely_stable(),
            is_passive: force > 0.0 && position > 0.0 && hybrid.is_passive((force, position)),
        });
    }
    Ok(points)
}
