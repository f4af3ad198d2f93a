use super::varying::jitter_margin_ticks;
use super::{
    ClosedLoop, Hybrid, Limit, LinearLoop, Margins, Mode, Parameter, Ports, SampledBound, Search, Sensitivity,
    StabilityError, largest_stable, sensitivities,
};
use trocar_lti::Complex64;

const FREQUENCIES: usize = 400;

pub const LOWEST_HZ: f64 = 0.1;

/// Fraction of the sampling rate; sampling images matter above it.
const HIGHEST_SHARE: f64 = 0.25;

pub const LIMITED: [Parameter; 4] =
    [Parameter::ForceScale, Parameter::PositionScale, Parameter::Stiffness, Parameter::Delay];

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PortPoint {
    pub frequency_hz: f64,
    pub hybrid: Hybrid,
    /// The impedance transmitted to the hand, `Z_t` in N·s/m.
    pub transmitted: Complex64,
    pub ideal: Complex64,
    pub is_absolutely_stable: bool,
    pub is_passive: bool,
}

#[derive(Debug, Clone)]
pub struct Analysis {
    pub settings: LinearLoop,
    pub mode: Mode,
    pub margins: Margins,
    /// `None` if unstable or unlimited.
    pub jitter_margin_ticks: Option<u64>,
    pub limits: Vec<Limit>,
    pub sensitivities: Vec<Sensitivity>,
    /// Empty without a hybrid matrix.
    pub ports: Vec<PortPoint>,
    pub sampled: Option<SampledBound>,
}

impl Analysis {
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

    pub fn port_verdicts(settings: &LinearLoop) -> Result<Option<(bool, bool)>, StabilityError> {
        let points = ports(settings)?;
        let all = |holds: fn(&PortPoint) -> bool| points.iter().all(holds);
        Ok((!points.is_empty()).then(|| (all(|point| point.is_absolutely_stable), all(|point| point.is_passive))))
    }

    pub fn is_stable(&self) -> bool {
        self.mode.spectral_radius < 1.0
    }

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
