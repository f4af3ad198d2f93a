//! The table of the passivity schemes of a scenario.

use super::Table;
use super::wrap::wrapped;
use trocar_document::show;
use trocar_metrics::Unit;
use trocar_studies::compare::{IMPEDANCE_FREQUENCIES_HZ, SchemeRow, SchemeStudy};

/// Returns a table with a line per quantity and a column per scheme, and a note on the felt impedance.
#[must_use]
pub fn schemes_text(study: &SchemeStudy) -> String {
    let mut heading = vec!["scheme".to_owned()];
    heading.extend(study.rows.iter().map(|row| row.scheme.to_owned()));
    let mut table = Table::new(heading);
    let mut line = |label: &str, unit: Unit, read: &dyn Fn(&SchemeRow) -> Option<f64>| {
        let cells = study.rows.iter().map(|row| show(read(row), unit));
        table.row(std::iter::once(label.to_owned()).chain(cells));
    };
    line("peak feedback force", Unit::Newton, &|row| Some(row.peak_force_n));
    line("position error (RMS)", Unit::Metre, &|row| Some(row.position_error_m));
    line("energy generated", Unit::Joule, &|row| Some(row.generated_j));
    line("energy that it may generate", Unit::Joule, &|row| row.promised_j);
    for (index, frequency_hz) in IMPEDANCE_FREQUENCIES_HZ.into_iter().enumerate() {
        let label = format!("felt impedance at {frequency_hz} Hz (N·s/m)");
        line(&label, Unit::Number, &|row| Some(row.felt_impedance_n_s_per_m[index]));
    }
    line("overshoot after a rupture", Unit::Metre, &|row| row.overshoot_m);
    line("missed ruptures", Unit::Count, &|row| Some(row.missed_ruptures as f64));
    line("needle left behind", Unit::Metre, &|row| Some(row.left_behind_m));
    let note = "The felt impedance is that of a hand that oscillates by 1 mm in a tissue of 200 N/m over this link; the tissue's own \
                is 31.8 N·s/m at 1 Hz and 6.4 at 5 Hz.\n";
    format!("{table}\n{}", wrapped(note, 0))
}
