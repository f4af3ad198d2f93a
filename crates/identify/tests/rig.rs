//! The recordings of a real rig with known gains; see `tests/data/teleop_1dof` for their source.

use std::path::{Path, PathBuf};

use trocar_identify::{MachineColumns, Measured, Request, Role, identify};
use trocar_recording::{Column, Limits};

fn recording(name: &str) -> Measured {
    let path: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/teleop_1dof").join(name);
    let column = |name: &str, scale: f64| Column::new(name, scale).expect("a column");
    // The lever is 0.075 m long.
    let columns = MachineColumns {
        time: column("t_s", 1.0),
        master: column("xm_rad", 0.075),
        slave: column("xs_rad", 0.075),
        force: column("tau_e_Nm", 1.0 / 0.075),
        actuator: Some(column("u_s_Nm", 1.0 / 0.075)),
    };
    Measured::open(&path, &columns, &Limits::default()).expect("a recording")
}

#[test]
fn oracle_the_gains_are_those_of_the_source_and_another_recording_is_predicted() {
    let request =
        Request { training: vec![recording("m2_f_foam.csv")], predictions: vec![recording("m2_f_rigid.csv")] };
    let found = identify(request, || ()).expect("a machine");
    // The source states the gains in N·m/rad and N·m·s/rad.
    let per_lever = 0.075_f64.powi(-2);
    let stated = [("position_gain_n_per_m", 25.0, 1e-3), ("velocity_gain_n_s_per_m", 0.15, 1e-2)];
    for (key, stated, tolerance) in stated {
        let (value, interval) = found.parameter(key).expect("a gain");
        let truth = stated * per_lever;
        assert!((value / truth - 1.0).abs() < tolerance, "{key} is {value} {interval:?}, stated {truth}");
    }
    let [trained, predicted] =
        [Role::Training, Role::Prediction].map(|role| found.mean_fit_percent(role).expect("a fit"));
    assert!(trained > 98.0, "{trained} %");
    assert!(predicted > 95.0, "{predicted} %");
}
