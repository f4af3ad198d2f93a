pub use trocar_detect as detect;
pub use trocar_document as document;
pub use trocar_figures as figures;
pub use trocar_identify as identify;
pub use trocar_report as report;
pub use trocar_stability as stability;
pub use trocar_studies::{compare, design, reference, roc, run, stability_check, sweep};
