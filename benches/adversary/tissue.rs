//! Random tissues, whose steepest slopes are about a given stiffness.

use super::draw::Draw;
use super::recording::Recording;

/// All tissues. The last two are recordings by depth, a synthetic one and the shipped one.
pub const KINDS: [&str; 7] =
    ["kelvin-voigt", "hunt-crossley", "generalised", "layers", "tearing", "recording", "in_vivo_like"];

/// A tissue as TOML, and the forces of a recording.
pub fn tissue(draw: &mut Draw, kind: &str, stiffness: f64) -> (String, Option<Recording>) {
    let word = if kind == "in_vivo_like" { "recording" } else { kind };
    let mut text = format!("[tissue]\nkind = \"{word}\"\n");
    let mut recording = None;
    let damping_s = draw.zero_or_log(0.2, 1e-3, 0.1);
    let c_s_per_m = draw.zero_or_log(0.2, 0.3, 30.0);
    match kind {
        "kelvin-voigt" => {
            let damping = damping_s * stiffness;
            text += &format!("stiffness_n_per_m = {stiffness}\ndamping_n_s_per_m = {damping}\n");
        }
        "hunt-crossley" => {
            // The slope at a depth of 1 cm is `stiffness`.
            let mu = stiffness / 0.15;
            text += &format!("mu = {mu}\nlambda = {}\n", c_s_per_m * mu);
        }
        "generalised" => {
            let power = draw.one(&[1.0, 1.5]);
            let mu = stiffness / (power * 0.01_f64.powf(power - 1.0));
            let mus = [0.0; 3].map(|_| mu * draw.log(0.2, 1.0));
            let lambdas = [0.0; 3].map(|_| c_s_per_m * mu * draw.log(0.2, 1.0));
            text += &format!("power = {power}\ndepths_m = [0, 0.01, 0.03]\nmus = {mus:?}\nlambdas = {lambdas:?}\n");
        }
        "recording" | "in_vivo_like" => {
            text += &format!("index = \"depth\"\npresliding_m = {}\n", draw.log(1e-3, 0.015));
            let shipped = kind == "in_vivo_like";
            recording = Some(if shipped { Recording::shipped(stiffness) } else { Recording::draw(draw, stiffness) });
        }
        _ => {
            let (shaft, viscous) = (stiffness * draw.log(0.05, 2.0), stiffness * draw.zero_or_log(0.3, 0.01, 3.0));
            text += &format!("shaft_stiffness_n_per_m = {shaft}\nshaft_damping_n_s_per_m2 = {viscous}\n");
            let count = draw.one(&[1, 2, 3, 4]);
            for index in 0..count {
                let thickness_m = if index + 1 == count { 0.05 } else { draw.log(1e-3, 0.015) };
                let share = draw.log(0.1, 1.0);
                text += &layer(draw, kind, share * stiffness, c_s_per_m);
                text += &format!("name = \"{index}\"\nthickness_m = {thickness_m}\n");
            }
        }
    }
    (text, recording)
}

/// A layer that yields after a few millimetres.
fn layer(draw: &mut Draw, kind: &str, stiffness: f64, c_s_per_m: f64) -> String {
    let (deflection_m, stiffening) = (draw.log(1e-3, 0.02), stiffness * draw.zero_or_log(0.5, 10.0, 300.0));
    let (friction, grip) =
        (stiffness * draw.zero_or_log(0.3, 0.01, 0.3), stiffness * draw.zero_or_log(0.5, 1e-4, 3e-3));
    let rupture_n = stiffness * deflection_m + stiffening * deflection_m * deflection_m;
    let cutting_n = rupture_n * draw.log(0.1, 1.0);
    let law = if kind == "layers" {
        let relaxation_s = draw.log(5e-3, 0.5);
        format!(
            "rupture_force_n = {rupture_n}\ncutting_force_n = {cutting_n}\nrelaxation_s = {relaxation_s}\n\
             damping_s_per_m = {c_s_per_m}\n"
        )
    } else {
        let (share, time_s) = (draw.between(0.2, 1.0), draw.log(0.02, 5.0));
        // With the default crack of 1 mm the layer cuts at R w and ruptures at √(2 k₀ w ℓ R).
        let (toughness, length_m) = (cutting_n / 1e-3, rupture_n * rupture_n / (2.0 * stiffness * cutting_n));
        format!(
            "relaxed_share = {share}\nrelaxation_time_s = {time_s}\ntoughness_j_per_m2 = {toughness}\n\
             release_length_m = {length_m}\n"
        )
    };
    format!(
        "\n[[tissue.layer]]\n{law}stiffness_n_per_m = {stiffness}\nstiffening_n_per_m2 = {stiffening}\n\
         friction_n_per_m = {friction}\ngrip_n = {grip}\n"
    )
}
