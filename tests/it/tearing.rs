//! Layers that tear: how a rupture depends on the speed, the intact layer, and the list of layers in scenarios.

use trocar::scenario::{Scenario, Source};
use trocar::tissue::{Crack, ShaftParameters, Surface, Tearing, TearingLayer, TearingSettings, Tissue};

const TICK_S: f64 = 1e-3;

/// The insertion speeds, from 0.5 to 100 mm/s.
const SPEEDS_M_PER_S: [f64; 8] = [5e-4, 1e-3, 2e-3, 5e-3, 0.01, 0.02, 0.05, 0.1];

/// Returns a layer without friction, on a shaft without viscous friction, so that only the tip has a force.
fn settings(layer: TearingLayer) -> TearingSettings {
    let layer = TearingLayer { friction_n_per_m: 0.0, ..layer };
    let shaft = ShaftParameters { damping_n_s_per_m2: 0.0, ..ShaftParameters::DEFAULT };
    TearingSettings {
        surface: Surface::DEFAULT,
        crack: Crack::DEFAULT,
        shaft,
        layers: vec![("membrane".into(), layer)],
    }
}

/// A rupture: the deflection (m), the force (N), and the work until the rupture (J).
#[derive(Debug, Clone, Copy)]
struct Rupture {
    deflection_m: f64,
    force_n: f64,
    work_j: f64,
}

/// Simulates the rupture of a layer by a needle at a constant speed, with ticks of `tick_s`.
fn simulated(layer: TearingLayer, speed_m_per_s: f64, tick_s: f64) -> Rupture {
    let mut tissue = Tearing::<f64>::new(&settings(layer), tick_s, 0.0).expect("valid");
    let (mut work_j, mut before) = (0.0, (0.0, 0.0));
    for tick in 0..1_000_000 {
        let x = speed_m_per_s * tick_s * tick as f64;
        let reaction = tissue.react(tick, x, speed_m_per_s);
        work_j += 0.5 * (reaction.force_n + before.1) * (x - before.0);
        before = (x, reaction.force_n);
        if reaction.ruptured {
            return Rupture { deflection_m: x, force_n: reaction.force_n, work_j };
        }
    }
    panic!("no rupture at {speed_m_per_s} m/s");
}

/// Computes the rupture in closed form: the force of the solid under a deflection `V t`, and by bisection the
/// deflection at which the energy release rate equals the toughness.
fn closed_form(layer: TearingLayer, speed_m_per_s: f64) -> Rupture {
    let TearingLayer { stiffness_n_per_m: k0, stiffening_n_per_m2: a2, relaxed_share, relaxation_time_s: tau, .. } =
        layer;
    let (relaxed, branch) = (relaxed_share * k0, (1.0 - relaxed_share) * k0);
    // The deflection that the Maxwell branch reaches.
    let reach = speed_m_per_s * tau;
    let of_branch = |d: f64| -branch * reach * (-d / reach).exp_m1();
    let force = |d: f64| relaxed * d + a2 * d * d + of_branch(d);
    let width = Crack::DEFAULT.crack_width_m;
    let release = |d: f64| {
        force(d) * (force(d) + layer.concentration * of_branch(d)) / (2.0 * k0 * width * layer.release_length_m)
    };
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if release(middle) < layer.toughness_j_per_m2 { low = middle } else { high = middle }
    }
    let d = low;
    let work_j = 0.5 * relaxed * d * d + a2 * d.powi(3) / 3.0 + branch * reach * (d + reach * (-d / reach).exp_m1());
    Rupture { deflection_m: d, force_n: force(d), work_j }
}

type Quantity = fn(&Rupture) -> f64;

/// Returns the slopes of a quantity over the speed, on logarithmic scales, from each speed to the next.
fn slopes(ruptures: &[Rupture], quantity: Quantity) -> Vec<f64> {
    let pairs = ruptures.windows(2).zip(SPEEDS_M_PER_S.windows(2));
    pairs.map(|(pair, speed)| (quantity(&pair[1]) / quantity(&pair[0])).ln() / (speed[1] / speed[0]).ln()).collect()
}

#[test]
fn oracle_force_deflection_and_work_at_the_rupture_fall_with_the_speed_as_in_closed_form() {
    let layers = [
        TearingLayer::DEFAULT,
        TearingLayer { concentration: 0.0, ..TearingLayer::DEFAULT },
        TearingLayer { stiffening_n_per_m2: 2e4, relaxed_share: 0.3, relaxation_time_s: 3.0, ..TearingLayer::DEFAULT },
    ];
    for layer in layers {
        // A tick moves the needle by at most 0.1 µm.
        let fine = |speed: f64| simulated(layer, speed, (1e-7 / speed).min(TICK_S));
        let here = SPEEDS_M_PER_S.map(fine);
        let there = SPEEDS_M_PER_S.map(|speed| closed_form(layer, speed));
        let quantities: [(&str, Quantity); 3] =
            [("deflection", |r| r.deflection_m), ("work", |r| r.work_j), ("force", |r| r.force_n)];
        for (name, quantity) in quantities {
            if name == "force" && layer.concentration == 0.0 {
                let force_n = layer.rupture_force_n(Crack::DEFAULT.crack_width_m);
                assert!(here.iter().all(|rupture| (rupture.force_n / force_n - 1.0).abs() < 1e-3), "{here:?}");
                continue;
            }
            for (slope, expected) in slopes(&here, quantity).iter().zip(slopes(&there, quantity)) {
                assert!(expected < 0.0 && *slope < 0.0, "{name} falls: {slope}, {expected}");
                assert!((slope - expected).abs() <= 0.1 * expected.abs(), "{name}: {slope} instead of {expected}");
            }
            let fall = quantity(&there[7]) / quantity(&there[0]);
            assert!(fall < 0.95, "{name}: {fall}");
        }
    }
}

#[test]
fn a_tick_of_a_millisecond_resolves_a_rupture() {
    for speed in SPEEDS_M_PER_S {
        let (here, there) =
            (simulated(TearingLayer::DEFAULT, speed, TICK_S), closed_form(TearingLayer::DEFAULT, speed));
        // The rupture is found at the end of its tick.
        let tick_m = speed * TICK_S;
        assert!((-1e-9..tick_m + 1e-9).contains(&(here.deflection_m - there.deflection_m)), "{here:?} {there:?}");
    }
}

#[test]
fn an_intact_layer_relaxes_at_a_held_depth() {
    let layer = TearingLayer::DEFAULT;
    let mut tissue = Tearing::<f64>::new(&settings(layer), TICK_S, 0.0).expect("valid");
    let (k0, tau, d) = (layer.stiffness_n_per_m, layer.relaxation_time_s, 2e-3);
    let (relaxed, branch) = (layer.relaxed_share * k0, (1.0 - layer.relaxed_share) * k0);
    let at_once = -branch * d * tau / TICK_S * (-TICK_S / tau).exp_m1();
    for tick in 0..4000 {
        let force = tissue.react(tick, d, 0.0).force_n;
        let expected = relaxed * d + at_once * (-TICK_S * tick as f64 / tau).exp();
        assert!((force / expected - 1.0).abs() < 1e-6, "{tick}: {force} instead of {expected}");
    }
}

const NAMED: &str = "\
    [simulation]\nduration_s = 3.0\n[operator]\nkind = \"minimum-jerk\"\nstart_m = -0.002\nend_m = 0.05\nmovement_s = 2.0\n\
    [tissue]\nkind = \"tearing\"\n\
    [[tissue.layer]]\nname = \"ligament\"\nthickness_m = \"4 mm\"\n\
    [[tissue.layer]]\nname = \"dura\"\nthickness_m = 5e-4\ntoughness_j_per_m2 = 400.0\n\
    [[tissue.layer]]\nname = \"cord\"\n";

fn load(text: &str, settings: &[&str]) -> Result<Scenario, String> {
    let source = Source::Text { name: "named.toml".into(), text: text.into() };
    let settings: Vec<String> = settings.iter().map(|setting| (*setting).to_owned()).collect();
    Scenario::load(&source, &settings).map_err(|error| error.to_string())
}

#[test]
fn settings_address_layers_by_name_and_the_echo_keeps_the_names() {
    let scenario = load(NAMED, &["tissue.layer.dura.toughness_j_per_m2=500"]).expect("good");
    let echo = scenario.echo();
    let table: toml::Table = echo.parse().expect("TOML");
    let layers = table["tissue"]["layer"].as_array().expect("a list");
    let names: Vec<_> = layers.iter().filter_map(|layer| layer["name"].as_str()).collect();
    assert_eq!(names, ["ligament", "dura", "cord"]);
    assert_eq!(layers[1]["toughness_j_per_m2"].as_float(), Some(500.0));
    assert_eq!(layers[0]["thickness_m"].as_float(), Some(4e-3));
    let again = load(&echo, &[]).expect("the echo loads");
    assert_eq!(again.echo(), echo);
    assert_eq!(again.tissue, scenario.tissue);
    assert_eq!(scenario.rupturing_layers(), ["ligament", "dura", "cord"]);
}

/// In this scenario, every column of the trust has values of interest.
#[test]
fn the_trace_shows_when_the_estimate_can_be_trusted() {
    let run = trocar::run::run(load(NAMED, &["sensor.force_noise_std_n=0.02"]).expect("good")).expect("runs");
    let trust = run.trace.trust().expect("the contact is known");
    let flagged = |flag: u8| trust.estimate_flags.iter().filter(|flags| *flags & flag > 0).count();
    assert_eq!(trust.estimate_flags.len(), run.trace.len());
    // The damping cannot be estimated before the contact, and at rest after the motion.
    assert!(flagged(8) > 100 && flagged(2) > 300, "{} {}", flagged(8), flagged(2));
    let negative = |k: usize| run.trace.stiffness_n_per_m[k] < 0.0 || run.trace.damping_n_s_per_m[k] < 0.0;
    assert!((0..run.trace.len()).all(|k| (trust.estimate_flags[k] & 4 > 0) == negative(k)));
    assert!(trust.excitation.iter().all(|share| (0.0..=1.0).contains(share)));
    assert!(trust.stiffness_std_n_per_m.iter().all(|std| *std > 0.0 && *std < 2e3));
}

#[test]
fn a_scenarios_list_of_layers_replaces_the_list_of_its_base() {
    let folder = crate::support::test_folder::TestFolder::new();
    folder.file("base.toml", NAMED);
    folder.file("layer.toml", "base = \"base.toml\"\n[[tissue.layer]]\nname = \"dura\"\ngrip_n = 0.3\n");
    folder.file("changed.toml", "base = \"base.toml\"\n[tissue.layer.dura]\ngrip_n = 0.3\n");
    let of = |name: &str| {
        let scenario = Scenario::load(&Source::Disk(folder.path(name)), &[]).expect("good");
        scenario.echo().parse::<toml::Table>().expect("TOML")["tissue"]["layer"].as_array().expect("a list").clone()
    };
    let (of_layer, changed) = (of("layer.toml"), of("changed.toml"));
    assert_eq!((of_layer.len(), changed.len()), (1, 3));
    assert_eq!(of_layer[0]["toughness_j_per_m2"].as_float(), Some(TearingLayer::DEFAULT.toughness_j_per_m2));
    assert_eq!(changed[1]["toughness_j_per_m2"].as_float(), Some(400.0));
    assert_eq!(changed[1]["grip_n"].as_float(), Some(0.3));
}

#[test]
fn invalid_layers_are_refused_with_a_place_and_a_remedy() {
    for (text, settings, reasons) in [
        (NAMED, &["tissue.layer.dara.grip_n=0.1"][..], &["there is no layer dara", "ligament, dura, cord"][..]),
        (NAMED, &["tissue.layer.dura.grip=0.1"], &["did you mean tissue.layer.dura.grip_n?"]),
        (NAMED, &["tissue.layer.dura.grip_n=-1"], &["tissue.layer.dura.grip_n is -1, must be"]),
        (NAMED, &["tissue.layer.dura.relaxation_time_s=1e-5"], &["tissue.layer.dura.relaxation_time_s"]),
        ("[tissue]\nkind = \"kelvin-voigt\"\n[[tissue.layer]]\nname = \"a\"\n", &[], &["tissue.layer has no effect"]),
        (NAMED, &["tissue.layer.dura.rupture_force_n=2"], &["tissue.layer.dura.rupture_force_n has no effect"]),
        (
            NAMED,
            &["tissue.layer.dura.stiffness_n_per_m=0"],
            &["tissue.layer.dura.stiffness_n_per_m is 0, must be above 0"],
        ),
        ("[tissue]\nkind = \"tearing\"\n[[tissue.layer]]\ngrip_n = 1.0\n", &[], &["has no name"]),
        ("[[tissue.layer]]\nname = \"a b\"\n", &[], &["must be at most 32 letters"]),
        ("[[tissue.layer]]\nname = \"a\"\n[[tissue.layer]]\nname = \"a\"\n", &[], &["are called a"]),
        ("[tissue]\nlayer = 3\n", &[], &["tissue.layer is 3, must be a list of layers"]),
        ("[[scaling]]\nforce = 1.0\n", &[], &["write a section once"]),
    ] {
        let message = load(text, settings).expect_err(text);
        for reason in reasons {
            assert!(message.contains(reason), "{message}");
        }
    }
}
