//! One step of a rig's controller: `cargo run --release -p trocar-core --example rig_step`.

use trocar_core::rig::{HapticController, Sample, Settings};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut controller = HapticController::new(&Settings { contact_m: 0.012, ..Settings::default() })?;
    // At each tick, 1 ms apart:
    let command = controller.step(&Sample {
        master_position_m: 0.015,
        slave_position_m: 0.0149,
        slave_velocity_m_per_s: 0.01, // or VelocitySource::Filtered, from the positions
        force_n: 1.2,
    });
    // To the slave's position controller, and to the master's force controller:
    println!("reference {} m, force {} N", command.slave_reference_m, command.master_force_n);
    Ok(())
}
