//! The shipped recordings of a real teleoperator.

use std::path::Path;

use trocar::recording::{Columns, Limits, Recording, RecordingError, open_recording};

/// Columns of a rig whose needle is on a lever of 0.075 m: position = 0.075 * angle, force = torque / 0.075.
fn lever(force: &str) -> Columns {
    Columns {
        time: "t_s".parse().expect("a column"),
        position: "xs_rad:0.075".parse().expect("a column"),
        velocity: "vs_rad_s:0.075".parse().ok(),
        force: format!("{force}:{}", 1.0 / 0.075).parse().expect("a column"),
    }
}

fn open(path: &str, force: &str) -> Result<Recording, RecordingError> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    open_recording(&path, &lever(force), &Limits::default())
}

#[test]
fn the_recordings_are_complete() {
    for (path, force, len) in [
        ("tests/data/teleop_1dof/m2_f_spring.csv", "tau_e_Nm", 9817),
        ("tests/data/teleop_1dof/m2_d_free_motion.csv", "tau_e_Nm", 9215),
        ("scenarios/recordings/own_ctrl_pop.csv", "env_out_Nm_derived", 5810),
    ] {
        let recording = open(path, force).expect(path);
        assert_eq!(recording.len(), len, "{path}");
        assert!((recording.median_interval_s() - 0.0005).abs() < 1e-12, "{path}");
        assert_eq!(recording.ticks_covered(0.0005), Ok(len), "{path}");

        let grid = recording.resample(0.0005, len).expect("a grid");
        assert_eq!(grid.position_m, recording.position_m(), "{path}");
        assert_eq!(grid.velocity_m_per_s.as_deref(), recording.velocity_m_per_s(), "{path}");
        assert_eq!(grid.force_n, recording.force_n(), "{path}");
    }
}

/// The label: the last loaded sample is 3558, t = 1.7790 s, 15 N, 11.27 mm; then the tool travels 0.99 mm in 0.3 s.
#[test]
fn the_pop_occurs_at_its_label() {
    let pop = open("scenarios/recordings/own_ctrl_pop.csv", "env_out_Nm_derived").expect("a recording");
    let (time_s, position_m, force_n) = (pop.time_s(), pop.position_m(), pop.force_n());
    assert_eq!(time_s[3558], 1.7790);
    assert!((position_m[3558] - 11.27e-3).abs() < 0.01e-3, "{}", position_m[3558]);
    let drop_n = force_n[3558] - force_n[3559];
    assert!((14.0..17.0).contains(&drop_n), "{drop_n}");
    let furthest_m = position_m[3558..=3558 + 600].iter().fold(f64::MIN, |most, &x| most.max(x));
    assert!((furthest_m - position_m[3558] - 0.99e-3).abs() < 0.02e-3, "{furthest_m}");
}
