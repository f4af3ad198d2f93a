use std::sync::Arc;

use super::super::{
    AnyTissue, DepthCurves, DepthReplay, GeneralisedSettings, HuntCrossleySettings, KelvinVoigtSettings,
    LayerParameters, LayersParameters, Model, OrganMotion, Reaction, RecordedForce, Recording, ReplaySettings,
    ShaftParameters, Springs, StillTissue, Surface, TearingSettings, Tissue, TissueSettings,
};
use super::{TICK_S, rupturing};
use trocar_core::error::InvalidValue;

/// Settings of each kind that simulates its tissue.
fn simulated() -> [TissueSettings; 5] {
    [
        TissueSettings::KelvinVoigt(KelvinVoigtSettings::default()),
        TissueSettings::HuntCrossley(HuntCrossleySettings::default()),
        TissueSettings::Generalised(GeneralisedSettings::default()),
        TissueSettings::Layers(LayersParameters { contact_m: 0.0, ..LayersParameters::default() }),
        TissueSettings::Tearing(TearingSettings::default()),
    ]
}

#[test]
fn only_kinds_with_layers_have_default_layers() {
    let names =
        |word| -> Vec<&str> { TissueSettings::default_layers(word).into_iter().map(|(name, _)| name).collect() };
    assert_eq!(names("layers"), ["skin", "fat", "muscle", "capsule", "organ"]);
    assert_eq!(names("tearing"), ["organ"]);
    for word in ["recording", "kelvin-voigt", "hunt-crossley", "generalised", "unknown"] {
        assert_eq!(names(word), [""; 0], "{word}");
    }
}

#[test]
fn only_layers_rupture_and_their_names_are_known() {
    let names = simulated().map(|settings| rupturing(&settings.layers()).join(" "));
    assert_eq!(names, ["", "", "", "skin muscle capsule", "organ"]);
    assert_eq!(TissueSettings::Recording(ReplaySettings::default()).layers(), []);
}

#[test]
fn the_surface_is_known_only_for_simulated_tissues() {
    let surface = Surface { contact_m: 0.013 };
    let settings = TissueSettings::KelvinVoigt(KelvinVoigtSettings { surface, ..Default::default() });
    assert_eq!(settings.surface_m(), Some(0.013));
    assert_eq!(TissueSettings::Recording(ReplaySettings::default()).surface_m(), None);
}

#[test]
fn the_springs_match_the_kind() {
    let springs = simulated().map(|settings| settings.springs(Some(0.02)));
    assert_eq!(springs[0], Some(Springs::constant(200.0, 5.0)));
    let is_range = |springs: &Springs| springs.stiffness_n_per_m.0 < springs.stiffness_n_per_m.1;
    assert!(springs[1..].iter().all(|springs| springs.as_ref().is_some_and(is_range)));
    let relaxes = springs.map(|springs| springs.is_some_and(|springs| springs.relaxation.is_some()));
    assert_eq!(relaxes, [false, false, false, false, true]);
    assert_eq!(simulated().map(|settings| settings.springs(None).is_some()), [true, false, false, true, true]);
    assert_eq!(TissueSettings::Recording(ReplaySettings::default()).springs(Some(0.02)), None);
}

#[test]
fn values_outside_the_measurements_have_the_key_of_their_layer() {
    let soft = LayerParameters { rupture_force_n: 90.0, stiffness_n_per_m: 5000.0, ..LayerParameters::DEFAULT };
    let parameters = LayersParameters { layers: vec![("dura".into(), soft)], ..LayersParameters::default() };
    let keys: Vec<_> =
        TissueSettings::Layers(parameters).outside_measured().into_iter().map(|outside| outside.key).collect();
    assert!(keys.iter().any(|key| key == "tissue.layer.dura.rupture_force_n"), "{keys:?}");
    assert_eq!(simulated().map(|settings| settings.outside_measured().len()), [0; 5]);
}

#[test]
fn impossible_settings_are_refused_before_the_tissue_is_built() {
    let refused = |settings: &TissueSettings| settings.check(TICK_S, 0.0).err().map(|error| error.name);
    assert_eq!(simulated().each_ref().map(refused), [None; 5]);
    let soft = KelvinVoigtSettings { stiffness_n_per_m: -1.0, ..Default::default() };
    assert_eq!(refused(&TissueSettings::KelvinVoigt(soft)), Some("tissue.stiffness_n_per_m"));
    let recording = TissueSettings::Recording(ReplaySettings::default());
    assert_eq!(refused(&recording), None, "its file is checked where it is read");
    let built = recording.build::<f64>(TICK_S, 0.0);
    assert_eq!(built.err().map(|error| error.name), Some("tissue.kind"), "it needs its file");
}

#[test]
fn a_needle_may_start_at_the_surface_of_layers_but_not_below() {
    let at = |start_m| simulated().map(|settings| settings.check(TICK_S, start_m).is_ok());
    assert_eq!(at(0.0), [true; 5]);
    assert_eq!(at(1e-9), [true, true, true, false, false]);
}

/// A spring without settings, which implements only the force.
#[derive(Debug, Clone, Copy)]
struct Bare;

impl Model for Bare {
    type Settings = f64;

    fn build(stiffness: &f64, _tick_s: f64, _start_m: f64) -> Result<Self, InvalidValue> {
        trocar_core::error::positive("tissue.x", *stiffness).map(|_| Self)
    }
}

#[test]
fn a_minimal_kind_has_no_layers_surface_or_springs_and_is_checked_by_building_it() {
    assert_eq!(Bare::check(&1.0, TICK_S, 0.0), Ok(()));
    assert_eq!(Bare::check(&-1.0, TICK_S, 0.0).map_err(|error| error.name), Err("tissue.x"));
    assert_eq!((Bare::default_layers(), Bare::layers(&1.0)), (vec![], vec![]));
    assert_eq!((Bare::surface_m(&1.0), Bare::springs(&1.0, Some(0.1))), (None, None));
    assert!(Bare::outside_measured(&1.0).is_empty());
}

/// A tissue with a force on the shaft.
struct Gripping;

impl Tissue<f64> for Gripping {
    fn react(&mut self, _tick: u64, position_m: f64, velocity_m_per_s: f64) -> Reaction<f64> {
        Reaction { force_n: position_m + 10.0 * velocity_m_per_s, ruptured: true }
    }

    fn shaft_force_n(&self) -> f64 {
        0.25
    }
}

#[test]
fn a_boxed_tissue_behaves_like_the_tissue_in_the_box() {
    let mut boxed: Box<dyn Tissue<f64>> = Box::new(Gripping);
    let reaction = Tissue::<f64>::react(&mut boxed, 0, 3.0, 0.2);
    assert_eq!((reaction.force_n, reaction.ruptured), (5.0, true));
    assert_eq!(Tissue::<f64>::shaft_force_n(&boxed), 0.25);
}

/// Tissues with state or with lists, of which eight may run side by side.
#[cfg(target_arch = "x86_64")]
fn stateful() -> Vec<(&'static str, AnyTissue<f64>)> {
    let build = |settings: &TissueSettings| settings.build::<f64>(TICK_S, 0.0).expect("valid");
    let motion = OrganMotion { breathing_amplitude_m: 4e-3, breathing_period_s: 0.1, ..OrganMotion::DEFAULT };
    let mut all: Vec<(&str, AnyTissue<f64>)> =
        simulated().iter().map(|settings| (settings.word(), AnyTissue::from(build(settings)))).collect();
    let layers = build(&simulated()[3]);
    let shaft = ShaftParameters { static_ratio: 1.5, ..ShaftParameters::DEFAULT };
    let tearing = TissueSettings::Tearing(TearingSettings { shaft, ..TearingSettings::default() });
    all.push(("moving layers", motion.applied_to(layers, TICK_S).expect("valid")));
    all.push(("tearing with static friction", AnyTissue::from(build(&tearing))));
    all.push((
        "recording by time",
        AnyTissue::from(StillTissue::Recording(Recording::Time(by_time(&[1.0, 2.0, 4.0])))),
    ));
    all.push(("recording by depth", AnyTissue::from(StillTissue::Recording(Recording::Depth(by_depth(0.1))))));
    all
}

fn by_time(force_n: &[f64]) -> RecordedForce {
    RecordedForce::new(force_n.into(), Arc::from([1]))
}

/// 100 N/m during the insertion, `share` of that during the withdrawal, and a rupture at 6 mm.
fn by_depth(share: f64) -> DepthReplay<f64> {
    let position: Vec<f64> = (0..=100).chain((0..100).rev()).map(|k| 1e-3 * f64::from(k)).collect();
    let force: Vec<f64> =
        position.iter().enumerate().map(|(k, p)| 100.0 * p * if k > 100 { share } else { 1.0 }).collect();
    let curves = Arc::new(DepthCurves::new(&position, &force).expect("valid"));
    DepthReplay::new(curves, Arc::from([6e-3]), 1e-3, 0.0).expect("valid")
}

#[cfg(target_arch = "x86_64")]
#[test]
fn eight_needles_side_by_side_have_the_same_forces_as_each_alone_in_every_tissue() {
    use crate::engine::{Avx2, InstructionSet};
    use trocar_core::lane::{Gather, Lane, Mask};
    if !InstructionSet::Avx2.is_available() {
        return;
    }
    for (name, tissue) in stateful() {
        let mut alone = [(); 8].map(|()| tissue.clone());
        let mut together: AnyTissue<Avx2> =
            Gather::gather(std::array::from_fn(|lane| &alone[lane])).unwrap_or_else(|| panic!("{name}: alike"));
        let mut ruptures = 0;
        for tick in 0..400_u64 {
            // In, back and in again, each lane to a different depth, at 2 s⁻¹.
            let motions: [(f64, f64); 8] = std::array::from_fn(|lane| {
                let (phase, depth_m) = (0.03 * tick as f64, 0.01 * (lane + 1) as f64);
                (depth_m * (1.0 - phase.cos()), depth_m * 30.0 * phase.sin())
            });
            let place = |of: fn(&(f64, f64)) -> f64| Avx2::from_lanes(|lane| of(&motions[lane]));
            let all = together.react(tick, place(|motion| motion.0), place(|motion| motion.1));
            for (lane, (x, v)) in motions.into_iter().enumerate() {
                let one = alone[lane].react(tick, x, v);
                assert_eq!(all.force_n.lane(lane).to_bits(), one.force_n.to_bits(), "{name}: lane {lane} at {tick}");
                assert_eq!(all.ruptured.lane(lane), one.ruptured, "{name}: lane {lane} at {tick}");
                let shaft = (together.shaft_force_n().lane(lane), alone[lane].shaft_force_n());
                assert_eq!(shaft.0.to_bits(), shaft.1.to_bits(), "{name}: lane {lane} at {tick}");
                ruptures += u32::from(one.ruptured);
            }
        }
        let may_rupture = ["layers", "tearing", "recording"].iter().any(|kind| name.contains(kind));
        assert_eq!(ruptures > 0, may_rupture, "{name}: {ruptures}");
    }
}

#[cfg(target_arch = "x86_64")]
#[test]
fn different_recordings_do_not_run_side_by_side() {
    use crate::engine::Avx2;
    use trocar_core::lane::Gather;
    let (same, other) = (by_time(&[1.0, 2.0]), by_time(&[1.0, 3.0]));
    let later = RecordedForce::new(Arc::from([1.0, 2.0]), Arc::from([0]));
    let mut advanced = same.clone();
    Tissue::<f64>::react(&mut advanced, 1, 0.0, 0.0);
    let is_gathered = |eighth: &RecordedForce| {
        let all = std::array::from_fn(|lane| if lane == 7 { eighth } else { &same });
        RecordedForce::gather::<Avx2>(all).is_some()
    };
    assert!(is_gathered(&same));
    assert_eq!([&other, &later, &advanced].map(is_gathered), [false; 3], "forces, ruptures, and ruptures so far");
    let (deep, flat) = (by_depth(0.1), by_depth(0.2));
    let of_equal_curves = by_depth(0.1);
    let unlabelled = {
        let position = [0.0, 0.1, 0.0];
        let curves = Arc::new(DepthCurves::new(&position, &[0.0, 10.0, 0.0]).expect("valid"));
        DepthReplay::<f64>::new(curves, Arc::from([]), 1e-3, 0.0).expect("valid")
    };
    let is_gathered = |eighth: &DepthReplay<f64>| {
        let all = std::array::from_fn(|lane| if lane == 7 { eighth } else { &deep });
        DepthReplay::gather::<Avx2>(all).is_some()
    };
    assert_eq!([&deep, &of_equal_curves].map(is_gathered), [true; 2]);
    assert_eq!([&flat, &unlabelled].map(is_gathered), [false; 2]);
}
