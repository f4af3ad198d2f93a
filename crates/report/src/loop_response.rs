//! Poles, zeros, loop gain, step and root locus, as CSV and figures.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use super::Folder;
use super::figures;
use super::pictures::{PictureError, keep};
use super::tables::shortest;
use trocar_lti::Complex64;
use trocar_stability::{Locus, LoopResponse};

/// The cells of a pole or zero: both parts, modulus, and as `s = ln(z) / T` frequency in Hz and damping ratio.
fn cells(z: Complex64, tick_s: f64) -> String {
    let s = z.ln() / tick_s;
    let is_known = z.norm() > 0.0 && s.norm() > 0.0;
    let damping = if is_known { shortest(-s.re / s.norm()) } else { String::new() };
    let frequency = if is_known { shortest(s.im.abs() / TAU) } else { String::new() };
    format!("{},{},{},{frequency},{damping}", shortest(z.re), shortest(z.im), shortest(z.norm()))
}

/// Returns `poles.csv`: all poles and zeros of the closed loop and of the loop gain.
#[must_use]
pub fn poles_csv(response: &LoopResponse) -> String {
    let mut text = "system,kind,re,im,modulus,frequency_hz,damping_ratio\n".to_owned();
    for one in &response.poles {
        for (kind, values) in [("pole", &one.poles), ("zero", &one.zeros)] {
            for &z in values {
                let _ = writeln!(text, "{},{kind},{}", one.system, cells(z, response.tick_s));
            }
        }
    }
    text
}

/// Returns `loop_gain.csv`: the loop gain over frequency.
#[must_use]
pub fn loop_gain_csv(response: &LoopResponse) -> String {
    let mut text = "frequency_hz,re,im,magnitude,phase_deg\n".to_owned();
    for ((hertz, gain), phase) in response.gain.iter().zip(response.phases_deg()) {
        let cells = [*hertz, gain.re, gain.im, gain.norm(), phase].map(shortest);
        let _ = writeln!(text, "{}", cells.join(","));
    }
    text
}

/// Returns `step.csv`: the response to a unit step of the desired position.
#[must_use]
pub fn step_csv(response: &LoopResponse) -> Option<String> {
    let step = response.step.as_ref()?;
    let mut text = "time_s,master_position_m_per_m,slave_position_m_per_m,feedback_force_n_per_m\n".to_owned();
    for (k, time_s) in step.time_s.iter().enumerate() {
        let cells = [*time_s, step.outputs[(0, k)], step.outputs[(1, k)], step.outputs[(2, k)]].map(shortest);
        let _ = writeln!(text, "{}", cells.join(","));
    }
    Some(text)
}

/// Returns `locus.csv`: the poles of the closed loop over a parameter.
#[must_use]
pub fn locus_csv(locus: &Locus, tick_s: f64) -> String {
    let mut text = format!("{},re,im,modulus,frequency_hz,damping_ratio\n", locus.parameter.key());
    for (value, poles) in &locus.branches {
        for &pole in poles {
            let _ = writeln!(text, "{},{}", shortest(*value), cells(pole, tick_s));
        }
    }
    text
}

/// Writes the figure `loop`: Bode diagram, Nyquist diagram and step of the feedback force.
///
/// # Errors
/// [`PictureError`].
pub fn loop_picture(folder: &Folder, name: &str, response: &LoopResponse) -> Result<(), PictureError> {
    keep(folder, "loop", &figures::loop_response(name, response)?)
}

/// Writes the figure `locus`.
///
/// # Errors
/// [`PictureError`].
pub fn locus_picture(folder: &Folder, name: &str, locus: &Locus, tick_s: f64) -> Result<(), PictureError> {
    keep(folder, "locus", &figures::locus(name, locus, tick_s)?)
}
