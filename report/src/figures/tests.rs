//! Every figure with plausible, empty, short and invalid records.

use std::f64::consts::TAU;
use std::time::Instant;

use super::*;

/// Columns of a needle insertion with a rupture at 5.52 s.
#[derive(Default)]
struct Record {
    time: Vec<f64>,
    master: Vec<f64>,
    slave: Vec<f64>,
    operator: Vec<f64>,
    tissue: Vec<f64>,
    feedback: Vec<f64>,
    mode: Vec<u8>,
    residual: Vec<f64>,
    stiffness: Vec<f64>,
    damping: Vec<f64>,
    decision: Vec<f64>,
    ruptures: Vec<f64>,
    alarms: Vec<f64>,
}

const RUPTURE_S: f64 = 5.52;
const ALARM_S: f64 = 5.526;

/// Returns approximately Gaussian noise: a sum of twelve uniform numbers.
fn noise(seed: &mut u64) -> f64 {
    let mut sum = -6.0;
    for _ in 0..12 {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        sum += (*seed >> 40) as f64 / (1_u64 << 24) as f64;
    }
    sum
}

fn insertion(samples: usize, augmented: bool) -> Record {
    let mut record = Record { ruptures: vec![RUPTURE_S, 8.85], alarms: vec![ALARM_S, 8.857], ..Record::default() };
    let mut seed = 7;
    let mut reference_gap = 0.0;
    for k in 0..samples {
        let t = k as f64 * 16.0 / samples as f64;
        let after = t - RUPTURE_S;
        let push = if after < 0.0 {
            19.0 * (t / RUPTURE_S).powf(1.4)
        } else {
            19.0 + 9.5 * (1.0 - (-after / 0.12).exp()) + 1.2 * after.max(0.0)
        };
        let master = push - 30.0 * (t - 14.2).clamp(0.0, 1.2) + 0.15 * (t * TAU * 1.3).sin();
        let force = if after < 0.0 {
            5.7 * (t / RUPTURE_S).powi(3)
        } else if t < 8.85 {
            1.3 + 4.4 * (-after / 0.02).exp() + 0.8 * after
        } else {
            1.5 + 2.4 * (-(t - 8.85) / 0.03).exp() - 3.5 * (t - 14.2).clamp(0.0, 1.1)
        };
        let event = after - (ALARM_S - RUPTURE_S);
        let (mode, slave) = if augmented && (0.0..0.5).contains(&event) {
            reference_gap = master - 19.3;
            (1, 19.3)
        } else if augmented && (0.5..0.9).contains(&event) {
            (2, master - reference_gap * (0.9 - event) / 0.4)
        } else {
            (0, master - 0.25)
        };
        let tissue = if mode == 1 { 4.9 - 0.5 * event } else { force } + 0.012 * noise(&mut seed);
        let feedback = if mode == 1 { 5.7 * (-event / 0.015).exp() } else { force };
        let bump = (0.9 * (-after.max(0.0) / 0.05).exp() * f64::from(after >= 0.0))
            + 0.4 * (-(t - 8.85).max(0.0) / 0.04).exp() * f64::from(t >= 8.85);
        record.time.push(t);
        record.master.push(master * 1e-3);
        record.slave.push(slave * 1e-3);
        record.operator.push(feedback + 0.25 * (t * 4.0).sin() + 0.03 * noise(&mut seed));
        record.tissue.push(tissue);
        record.feedback.push(feedback);
        record.mode.push(mode);
        record.residual.push(0.02 * noise(&mut seed) + bump);
        record.stiffness.push(if t < 0.02 { 4e5 } else { 150.0 + 30.0 * t + 90.0 * (-after.max(0.0)).exp() });
        record.damping.push(if t < 0.02 { -9e4 } else { 12.0 + 6.0 * (t * 1.7).sin() - 20.0 * bump });
        record.decision.push(0.35 * bump * bump);
    }
    record
}

impl Record {
    fn run<'a>(&'a self, name: &'a str) -> RunView<'a> {
        RunView {
            name,
            time_s: &self.time,
            master_position_m: &self.master,
            slave_position_m: &self.slave,
            operator_force_n: &self.operator,
            tissue_force_n: &self.tissue,
            feedback_force_n: &self.feedback,
            mode: &self.mode,
            rupture_times_s: &self.ruptures,
            alarm_times_s: &self.alarms,
        }
    }

    fn estimation(&self) -> EstimationView<'_> {
        EstimationView {
            name: "estimation",
            time_s: &self.time,
            measured_force_n: &self.tissue,
            residual_n: &self.residual,
            stiffness_n_per_m: &self.stiffness,
            damping_n_s_per_m: &self.damping,
            standard_errors: Some([&self.residual, &self.damping]),
            extra_parameter: None,
            decision: &self.decision,
            threshold: 1.98e-2,
            decision_unit: "N²",
            rupture_times_s: &self.ruptures,
            alarm_times_s: &self.alarms,
        }
    }

    /// Returns a record whose columns all have the same values.
    fn filled(values: &[f64]) -> Self {
        let column = || values.to_vec();
        Self {
            time: (0..values.len()).map(|k| k as f64 * 1e-3).collect(),
            master: column(),
            slave: column(),
            operator: column(),
            tissue: column(),
            feedback: column(),
            mode: (0..values.len()).map(|k| (k % 5) as u8).collect(),
            residual: column(),
            stiffness: column(),
            damping: column(),
            decision: column(),
            ruptures: vec![f64::NAN, 0.001, f64::INFINITY, -1e300],
            alarms: vec![0.002, 1e300, f64::NAN],
        }
    }
}

/// Returns every figure of a pair of records, with the name of its file and the drawing time in ms.
fn all(a: &Record, b: &Record) -> Vec<(&'static str, Result<Figure, FigureError>, f64)> {
    let runs = [a.run("classical"), b.run("augmented")];
    let view = b.estimation();
    let timed = |name, draw: &dyn Fn() -> Result<Figure, FigureError>| {
        let start = Instant::now();
        let figure = draw();
        (name, figure, start.elapsed().as_secs_f64() * 1e3)
    };
    vec![
        timed("comparison", &|| comparison(&runs, None)),
        timed("comparison-record", &|| comparison(&runs, Some((0.0, 16.0)))),
        timed("comparison-one", &|| comparison(&runs[1..], None)),
        timed("comparison-four", &|| comparison(&[runs[0], runs[1], runs[0], runs[1]], None)),
        timed("overlay", &|| overlay(&runs, None)),
        timed("overlay-record", &|| overlay(&runs, Some((0.0, 16.0)))),
        timed("estimation", &|| estimation(&view)),
        timed("parameters", &|| parameters(&view)),
        timed("decision", &|| decision(&view)),
        timed("residual", &|| residual_histogram(&view)),
    ]
}

#[test]
fn figures_of_an_insertion_are_small_and_the_same_each_time() {
    let (classical, augmented) = (insertion(16_000, false), insertion(16_000, true));
    let first = all(&classical, &augmented);
    let second = all(&classical, &augmented);
    for ((name, figure, _), (_, again, _)) in first.into_iter().zip(second) {
        let (figure, again) = (figure.expect(name), again.expect(name));
        assert!(figure == again, "{name} differs between two drawings");
        assert!(figure.svg.len() < 300_000, "{name}.svg has {} bytes", figure.svg.len());
        assert!(figure.png.len() < 800_000, "{name}.png has {} bytes", figure.png.len());
        assert!(figure.svg.starts_with("<svg width=\"1600\"") && figure.svg.trim_end().ends_with("</svg>"));
    }
}

#[test]
fn invalid_records_give_figures() {
    let records: [&[f64]; 9] = [
        &[0.0],
        &[f64::NAN],
        &[f64::INFINITY, f64::NEG_INFINITY],
        &[1e300, -1e300, 1e300, f64::MAX],
        &[0.0; 40],
        &[5e-324, -5e-324, 0.0],
        &[f64::NAN, 1.0, f64::NAN, 2.0, 3.0, f64::INFINITY, 1e300, 0.1],
        &[1e-9, 1e9, 1e12, 1e30, 1e31],
        &[-3.0; 7],
    ];
    for values in records {
        let record = Record::filled(values);
        for (name, figure, _) in all(&record, &record) {
            assert!(figure.is_ok(), "{name} of {values:?}: {figure:?}");
        }
    }
    let mut odd = Record::filled(&[1.0, 2.0, 3.0]);
    odd.time = vec![f64::NAN, 1e300, f64::NEG_INFINITY];
    for (name, figure, _) in all(&odd, &odd) {
        assert!(figure.is_ok(), "{name} of odd times: {figure:?}");
    }
}

#[test]
fn a_diverging_run_is_drawn_beside_a_stable_one() {
    let stable = insertion(4000, true);
    let mut diverged = insertion(4000, false);
    for k in 1400..4000 {
        let growth = ((k - 1400) as f64 * 0.4).exp();
        diverged.slave[k] += 1e-6 * growth * (k as f64).sin();
        diverged.tissue[k] = growth;
        diverged.feedback[k] = -growth;
    }
    for (name, figure, _) in all(&diverged, &stable).into_iter().chain(all(&stable, &diverged)) {
        assert!(figure.is_ok(), "{name}: {figure:?}");
    }
}

#[test]
fn a_million_samples_make_small_figures() {
    let record = insertion(1_000_000, true);
    let runs = [record.run("long")];
    let figure = comparison(&runs, Some((0.0, 16.0))).expect("a figure");
    assert!(figure.svg.len() < 300_000, "{}", figure.svg.len());
    let figure = estimation(&record.estimation()).expect("a figure");
    assert!(figure.svg.len() < 300_000, "{}", figure.svg.len());
}

#[test]
fn empty_data_is_an_error() {
    let none = Record::default();
    for (name, figure, _) in all(&none, &none) {
        assert!(matches!(figure, Err(FigureError::Empty { .. })), "{name}");
    }
    assert!(matches!(comparison(&[], None), Err(FigureError::Empty { figure: "comparison" })));
    assert!(matches!(overlay(&[], None), Err(FigureError::Empty { figure: "overlay" })));
    let record = Record::filled(&[1.0, 2.0]);
    let ragged = RunView { mode: &[0], ..record.run("ragged") };
    let error = overlay(&[ragged], None).expect_err("ragged columns");
    assert_eq!(error.to_string(), "ragged: column mode has 1 samples, but time_s has 2");
}

#[test]
fn long_and_unusual_names_are_safe() {
    let record = insertion(500, true);
    let name = "a <very> & long \"name\" with \u{0} control \u{7} characters, 漢字, ".repeat(20);
    let runs = [record.run(&name), record.run(""), record.run(&name)];
    for figure in [comparison(&runs, None), overlay(&runs, None)] {
        let svg = figure.expect("a figure").svg;
        assert!(!svg.contains('\u{0}') && !svg.contains("<very>"));
    }
}

/// Writes sample figures to a folder: `TROCAR_FIGURES=dir cargo test --release figures::tests::samples -- --nocapture`.
#[test]
fn samples() {
    let Ok(folder) = std::env::var("TROCAR_FIGURES") else {
        return;
    };
    let (classical, augmented) = (insertion(16_000, false), insertion(16_000, true));
    std::fs::create_dir_all(&folder).expect("the folder");
    for (name, figure, milliseconds) in all(&classical, &augmented) {
        let figure = figure.expect(name);
        println!("{name}: {milliseconds:.1} ms, svg {} B, png {} B", figure.svg.len(), figure.png.len());
        std::fs::write(format!("{folder}/{name}.svg"), figure.svg).expect("svg");
        std::fs::write(format!("{folder}/{name}.png"), figure.png).expect("png");
    }
}
