//! Every figure, with plausible, empty, short and invalid records.

use std::f64::consts::TAU;

use super::file;
use super::tests::{Texts, svg};
use super::*;
use nalgebra::DMatrix;
use trocar_document::figure::Shade;
use trocar_figures::*;
use trocar_lti::{Complex64, StepResponse};
use trocar_scenario::{Scenario, Source};
use trocar_stability::{DwellPoint, Hybrid, Locus, LoopResponse, Margins, Parameter, PortPoint, Walls, ZWidth};
use trocar_studies::run::{RunReport, run};

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
            is_augmented: false,
            time_s: &self.time,
            master_position_m: &self.master,
            slave_position_m: &self.slave,
            operator_force_n: &self.operator,
            tissue_force_n: &self.tissue,
            feedback_force_n: &self.feedback,
            mode: &self.mode,
            event: Shade::Frozen,
            rupture_times_s: (&self.ruptures[..]).into(),
            alarm_times_s: (&self.alarms[..]).into(),
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
            standard_errors: Some([(&self.residual[..]).into(), (&self.damping[..]).into()]),
            extra_parameter: None,
            decision: &self.decision,
            threshold: 1.98e-2,
            decision_unit: "N²",
            rupture_times_s: (&self.ruptures[..]).into(),
            alarm_times_s: (&self.alarms[..]).into(),
        }
    }

    /// Returns a record with the same values in all columns.
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

/// Returns every figure of a pair of records, with its name.
fn all<'a>(a: &'a Record, b: &'a Record) -> Vec<(&'static str, Result<Figure<'a>, FigureError>)> {
    let runs = [a.run("classical"), RunView { is_augmented: true, ..b.run("augmented") }];
    let view = b.estimation();
    vec![
        ("comparison", comparison(&runs, None)),
        ("comparison-record", comparison(&runs, Some((0.0, 16.0)))),
        ("comparison-one", comparison(&runs[1..], None)),
        ("comparison-four", comparison(&[&runs[..], &runs[..]].concat(), None)),
        ("overlay", overlay(&runs, None)),
        ("overlay-record", overlay(&runs, Some((0.0, 16.0)))),
        ("estimation", estimation(&view)),
        ("parameters", parameters(&view)),
        ("decision", decision(&view)),
        ("residual", residual_histogram(&view)),
    ]
}

/// Returns a logarithmic range, and a column that decreases over it.
fn falling() -> (Vec<f64>, Vec<f64>) {
    (0..60).map(|k| 10.0_f64.powf(-2.0 + 0.08 * f64::from(k))).map(|x| (x, 3.0 / (1.0 + x))).unzip()
}

/// Calls a function with each figure of the analyses and studies, and its name.
fn studies(mut each: impl FnMut(&str, Figure<'_>)) {
    let (x, y) = falling();
    let both = || x.iter().copied().zip(y.iter().copied());
    let port = |(x, y): (f64, f64)| PortPoint {
        frequency_hz: x,
        hybrid: Hybrid { h: [[Complex64::from_polar(x, y), y.into()], [x.into(), (y - 1.0).into()]] },
        transmitted: Complex64::from_polar(y, 3.0 * y),
        ideal: (1.1 * y).into(),
        is_absolutely_stable: false,
        is_passive: false,
    };
    let port_points: Vec<PortPoint> = both().map(port).collect();
    let gain = both().map(|(x, y)| (x, Complex64::from_polar(y, -0.35 * x))).collect();
    let outputs = DMatrix::from_fn(3, y.len(), |_, k| 300.0 * y[k]);
    let response = LoopResponse {
        gain,
        margins: Margins {
            gain: Some(2.0),
            gain_frequency_hz: Some(5.0),
            phase_frequency_hz: Some(2.0),
            ..Margins::default()
        },
        poles: vec![],
        step: Some(StepResponse { time_s: x.clone(), outputs }),
        tick_s: 1e-3,
    };
    let dwell = |(x, y): (f64, f64)| DwellPoint {
        dwell_ticks: (100.0 * x).ceil() as u64,
        certified: (x > 0.1).then_some(y),
        found: 0.9 * y,
    };
    let dwells: Vec<DwellPoint> = both().map(dwell).collect();
    let pole = |re: f64, im: f64| (Complex64::new(re, im) * 1e-3).exp();
    let branches = x.iter().map(|x| (*x, vec![pole(-10.0 * x - 1.0, 3.0 / x), pole(-2.0, 0.0)])).collect();
    let poles = Locus { parameter: Parameter::Delay, branches };
    let walls = |factor: f64| -> Vec<Walls> {
        y.iter().map(|y| Some(factor * y)).map(|most| Walls { stable_n_per_m: most, passive_n_per_m: most }).collect()
    };
    let width = ZWidth { damping_n_s_per_m: x.clone(), tissue: walls(300.0), virtual_walls: Some(walls(900.0)) };
    let absolute_view = AbsoluteView {
        name: "classical".to_owned(),
        caption: "Delay each way (s)".to_owned(),
        values: x.clone(),
        llewellyn: y.clone(),
        needed: y.clone(),
        of_arm: x.clone(),
    };
    let detectors = "squared-residual mean-change variance-change parameter-change force-derivative likelihood-ratio \
                     page-hinkley adaptive";
    let curve = |name| CharacteristicView {
        name,
        false_alarms_per_minute: x.clone(),
        detection: y.iter().map(|y| y / 3.0).collect(),
        delay_median_s: y.iter().map(|y| 1e-3 * y).collect(),
    };
    let curves: Vec<_> = detectors.split(' ').map(curve).collect();
    let tried = "none freeze-decay freeze-amplify freeze-clutch freeze-snap freeze-until-load speed-limit freeze-fade \
                 freeze-still fixture forbidden-region damping cue tip-force weak-force designed";
    let strategy = |(index, name)| StrategyView {
        name,
        reached: Some(if index % 3 == 2 { 0.6 } else { 1.0 }),
        noticed: Some(0.08 * index as f64),
        excess_m: Some(1e-3 * index as f64),
        high_excess_m: Some(2e-3 * index as f64),
        final_excess_m: Some(-3e-3 * index as f64),
        is_compared: index % 3 != 2,
        is_on_front: index % 2 == 0 && index % 3 != 2,
    };
    let tried: Vec<_> = tried.split(' ').enumerate().map(strategy).collect();
    let means: Vec<f64> = (0..48).map(|k| f64::from(k % 7)).collect();
    let axis = |name, log| AxisView { name, log };
    let heat_view = HeatView {
        name: "scale_factors",
        caption: "rupture 1: depth 2 s later in mm (mean over 5 seeds)",
        axes: [axis("scaling.force", true), axis("tissue.stiffness_n_per_m (N/m)", true)],
        x: x[..8].to_vec(),
        y: x[..6].to_vec(),
        means: &means,
    };
    let bar = |(axis, share, slope)| InfluenceBar {
        title: format!("rupture 1: depth 2 s later, by {axis} (on average 8.9 mm to 12.4 mm)"),
        share: Some(share),
        slope,
    };
    let influences = [("scaling.force", 0.8, Some(-0.9)), ("operator.arm_stiffness_n_per_m", 0.1, None)].map(bar);
    let map_axis = |caption| MapAxisView { caption, values: &x, is_logarithmic: true, scenario_value: 1.0 };
    let stable: Vec<bool> = (0..3600).map(|k| k % 60 + k / 60 < 60).collect();
    let grew: Vec<Option<bool>> = stable.iter().enumerate().map(|(k, stable)| Some((k % 50 == 0) == *stable)).collect();
    let map_view = MapView {
        name: "classical",
        x: map_axis("Force scale"),
        y: map_axis("Tissue stiffness (N/m)"),
        stable: &stable,
        boundary: &[[(0.1, 100.0), (100.0, 0.1)]],
        grew: &grew,
    };
    let row = |name| TimelineRow {
        name,
        from_s: 0.0,
        duration_s: 12.0,
        shades: vec![(1.0, 5.0, Shade::Insertion), (5.0, 7.0, Shade::Hold), (7.0, 11.0, Shade::Withdrawal)],
        rupture_times_s: vec![4.0],
        alarm_times_s: vec![4.01, 9.0],
    };
    let with_tank = Scenario::load(&Source::parse("passivity/late-wall-tank"), &[]).expect("shipped");
    let with_tank = run(with_tank).expect("runs");
    each("principle", principle());
    let figures = [
        ("energy", energy(&RunReport::of(&with_tank).energies())),
        ("ports", ports("classical", &port_points)),
        ("loop", loop_response("classical", &response)),
        ("switching", switching("augmented", &dwells, 1e-3)),
        ("locus", locus("classical", &poles, 1e-3)),
        ("z_width", z_width("classical", &width)),
        ("absolute", absolute(&absolute_view)),
        ("roc", characteristic("in_vivo_like", &curves, 1e-2)),
        ("strategies", strategies("skin-augmented", &tried)),
        ("heat", heat_map(&heat_view)),
        ("tornado", tornado("scale_factors", &influences)),
        ("stability", stability_map(&map_view)),
        ("timeline", timeline(&[row("first"), row("second"), row("a third recording")])),
        ("delays", delay_histogram(&[0.002, 0.003, 0.003, 0.008, 0.02])),
    ];
    for (name, figure) in figures {
        each(name, figure.expect(name));
    }
}

const COLUMN: &str = "3.5in";
const PAGE: &str = "7.16in";

fn width(text: &str) -> FigureWidth {
    text.parse().expect("a width")
}

/// Returns the texts of a page. Asserts that no text is clipped, overlaps another or leaves the page.
fn texts(name: &str, figure: &Figure<'_>, size: &str) -> Vec<String> {
    let ((width, height), Texts(all)) = Texts::of(figure, width(size));
    for (index, (text, bounds)) in all.iter().enumerate() {
        let [left, top, right, bottom] = *bounds;
        let is_inside = left >= 0.0 && top >= 0.0 && right <= width && bottom <= height;
        assert!(is_inside, "{name}: {text:?} at {bounds:?} on {width} x {height}");
        assert!(!text.contains('…'), "{name}: {text}");
        assert!(bottom - top >= 7.0 || right - left >= 7.0, "{name}: {text} at {bounds:?}");
        for (other, [l, t, r, b]) in &all[..index] {
            let overlap = left < *r && *l < right && top < *b && *t < bottom;
            assert!(!overlap, "{name}: {text:?} {bounds:?} and {other:?}");
        }
    }
    all.into_iter().map(|(text, _)| text).collect()
}

#[test]
fn texts_are_at_least_7_pt_and_neither_clipped_nor_overlapping() {
    let (classical, augmented) = (insertion(4000, false), insertion(4000, true));
    let check = |name: &str, figure: Figure<'_>| {
        for size in [COLUMN, PAGE, "5in", "254mm"] {
            let texts = texts(&format!("{name} at {size}"), &figure, size);
            assert!(texts.len() > 4, "{name}: {texts:?}");
            let svg = svg(&figure, width(size).points());
            let size = svg.split("font-size=\"").nth(1).and_then(|rest| rest.split('"').next()?.parse().ok());
            assert!(size.is_some_and(|size: f64| size >= 700.0), "{size:?} hundredths of a point");
        }
    };
    for (name, figure) in all(&classical, &augmented) {
        check(name, figure.expect(name));
    }
    studies(check);
}

#[test]
fn panels_have_letters_and_figures_name_their_runs() {
    let (classical, augmented) = (insertion(400, false), insertion(400, true));
    for (name, figure) in all(&classical, &augmented) {
        let texts = texts(name, &figure.expect(name), COLUMN);
        let names = ["classical", "augmented", "estimation"];
        assert!(texts.iter().any(|text| names.contains(&text.as_str())), "{name}: {texts:?}");
        assert_eq!(texts.contains(&"(b)".to_owned()), name != "residual", "{name}: {texts:?}");
    }
}

#[test]
fn a_png_contains_its_resolution_and_has_the_requested_width() {
    let record = insertion(400, true);
    let figure = estimation(&record.estimation()).expect("a figure");
    for (size, pixels) in [(COLUMN, 1050), (PAGE, 2148)] {
        let bytes = file(&figure, FigureFormat::Png, width(size)).expect("a file");
        let decoder = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().expect("a PNG");
        assert_eq!(decoder.info().width, pixels);
        let resolution = decoder.info().pixel_dims.expect("a resolution");
        assert_eq!((resolution.xppu, resolution.unit), (11_811, png::Unit::Meter));
    }
}

#[test]
fn a_pdf_embeds_its_typefaces_and_maps_them_to_text() {
    let record = insertion(4000, true);
    let figure = estimation(&record.estimation()).expect("a figure");
    let bytes = file(&figure, FigureFormat::Pdf, width(COLUMN)).expect("a file");
    let text = String::from_utf8_lossy(&bytes);
    assert!(text.starts_with("%PDF-") && text.contains("/MediaBox [0 0 252 "));
    let count = |what: &str| text.matches(what).count();
    // Regular and bold; every font has its file.
    assert_eq!((count("/Type0"), count("/FontFile2"), count("/ToUnicode")), (2, 2, 2));
    for font in ["TROCAR+DejaVuSans", "TROCAR+DejaVuSans-Bold"] {
        assert!(text.contains(font), "{font}");
    }
    assert!(bytes.len() < 200_000, "{}", bytes.len());
}

#[test]
fn figures_of_an_insertion_are_small_and_reproducible() {
    let (classical, augmented) = (insertion(16_000, false), insertion(16_000, true));
    let (first, second) = (all(&classical, &augmented), all(&classical, &augmented));
    for ((name, figure), (_, again)) in first.into_iter().zip(second) {
        let (figure, again) = (figure.expect(name), again.expect(name));
        for format in FigureFormat::ALL {
            let file = |figure: &Figure<'_>| file(figure, format, FigureWidth::default()).expect(name);
            let bytes = file(&figure);
            assert!(bytes == file(&again), "{name} differs between two drawings");
            assert!(bytes.len() < 1_000_000, "{name}.{format} has {} bytes", bytes.len());
        }
    }
}

/// Asserts that a figure exists and can be drawn in all formats, also at the smallest width.
fn drawn(name: &str, figure: Result<Figure<'_>, FigureError>) {
    let figure = figure.unwrap_or_else(|error| panic!("{name}: {error}"));
    for format in FigureFormat::ALL {
        let file = file(&figure, format, width("2.5in"));
        assert!(file.is_ok_and(|file| !file.is_empty()), "{name}");
    }
}

#[test]
fn invalid_records_are_drawn() {
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
        for (name, figure) in all(&record, &record) {
            drawn(&format!("{name} of {values:?}"), figure);
        }
    }
    let mut odd = Record::filled(&[1.0, 2.0, 3.0]);
    odd.time = vec![f64::NAN, 1e300, f64::NEG_INFINITY];
    for (name, figure) in all(&odd, &odd) {
        drawn(&format!("{name} of odd times"), figure);
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
    for (name, figure) in all(&diverged, &stable).into_iter().chain(all(&stable, &diverged)) {
        drawn(name, figure);
    }
}

#[test]
fn a_million_samples_make_small_figures() {
    let record = insertion(1_000_000, true);
    let runs = [record.run("long")];
    for figure in [comparison(&runs, Some((0.0, 16.0))), estimation(&record.estimation())] {
        let svg = svg(&figure.expect("a figure"), width(PAGE).points());
        assert!(svg.len() < 300_000, "{}", svg.len());
    }
}

#[test]
fn empty_data_is_an_error() {
    let none = Record::default();
    for (name, figure) in all(&none, &none) {
        assert!(matches!(figure, Err(FigureError::Empty { .. })), "{name}");
    }
    assert!(matches!(comparison(&[], None), Err(FigureError::Empty { figure: "comparison" })));
    assert!(matches!(overlay(&[], None), Err(FigureError::Empty { figure: "overlay" })));
    let record = Record::filled(&[1.0, 2.0]);
    let ragged = RunView { mode: &[0], ..record.run("ragged") };
    let Err(error) = overlay(&[ragged], None) else { panic!("ragged columns") };
    assert_eq!(error.to_string(), "ragged: column mode has 1 samples, but time_s has 2");
}

#[test]
fn long_and_unusual_names_are_safe() {
    let record = insertion(500, true);
    let name = "a <very> & long \"name\" with \u{0} control \u{7} characters, 漢字, ".repeat(20);
    let runs = [record.run(&name), record.run(""), record.run(&name)];
    for figure in [comparison(&runs, None), overlay(&runs, None)] {
        let svg = svg(&figure.expect("a figure"), width(COLUMN).points());
        assert!(!svg.contains('\u{0}') && !svg.contains("<very>"));
    }
}
