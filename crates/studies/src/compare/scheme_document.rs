use super::{ComparisonReport, IMPEDANCE_FREQUENCIES_HZ, SchemeRow, SchemeStudy, SeedStudy};
use trocar_document::{Cell, Document, Section, Shown, Study, Table};
use trocar_metrics::Unit;

#[derive(Debug, Clone, Copy)]
pub struct SchemeReport<'a> {
    pub study: &'a SchemeStudy,
    pub seeds: Option<&'a SeedStudy>,
}

impl Study for SchemeReport<'_> {
    fn document(&self) -> Document<'_> {
        let Self { study, seeds } = *self;
        let comparison = ComparisonReport { comparison: &study.comparison, facts: None, seeds };
        let mut document = comparison.into_document(Some(&study.rows));
        let mut section = Section::new("schemes", "Passivity schemes");
        section.table(table(study));
        section.text(
            "The felt impedance is that of a hand that oscillates by 1 mm in a tissue of 200 N/m over this link; the tissue's own is 31.8 \
             N·s/m at 1 Hz and 6.4 at 5 Hz.",
        );
        for main in document.sections.iter_mut().filter(|section| section.id == "main") {
            main.shown = Shown::WithAll;
        }
        document.sections.insert(0, section);
        document
    }
}

fn table(study: &SchemeStudy) -> Table {
    let names = study.rows.iter().map(|row| (row.scheme, row.scheme));
    let mut table = Table::new("schemes", "Every scheme", [("quantity", "scheme")].into_iter().chain(names));
    let mut line = |label: &str, unit: Unit, read: &dyn Fn(&SchemeRow) -> Option<f64>| {
        let cells = study.rows.iter().map(|row| Cell::of(read(row), unit));
        table.row(std::iter::once(Cell::from(label)).chain(cells));
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
    table
}
