use crate::settings::{ActsFor, Range};

/// No product of a tick overflows or underflows.
const LIMIT: Range = Range::stated(1e-12, 1e6, "positive, from 1e-12 to 1e6");

const WHEN_ACTING: ActsFor = ActsFor::all_but(SafetyActs::KEY.path, SafetyActs::WORDS, "nowhere");

crate::choice! {
    /// The controllers whose commands pass the safety stage.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum SafetyActs at "safety.acts" = OnRigs {
        /// In Rust, C, Python and exported units; not the simulation.
        "on-rigs" => OnRigs,
        "everywhere" => Everywhere,
        "nowhere" => Nowhere,
    }
}

crate::settings! {
    /// Limits of the commands to the motors, and checks that stop a rig.
    ///
    /// Chosen here for a desktop haptic device; the shipped scenarios reach 13.8 N and 1511 N/s.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct SafetySettings in "safety." {
        /// Where the limits act.
        acts: SafetyActs,
        /// Largest magnitude of the master's force.
        force_limit_n: f64 [self::LIMIT] for (WHEN_ACTING) = 20.0,
        /// Largest rate of the master's force.
        force_rate_n_per_s: f64 [self::LIMIT] for (WHEN_ACTING) = 2000.0,
        /// Largest speed of the slave's reference.
        reference_speed_m_per_s: f64 [self::LIMIT] for (WHEN_ACTING) = 0.5,
        /// Largest distance of the slave's reference from the measured slave.
        lead_m: f64 [self::LIMIT] for (WHEN_ACTING) = 0.05,
        /// Largest distance between hand and slave at which a rig starts without alignment.
        start_tolerance_m: f64 [self::LIMIT] for (WHEN_ACTING) = 2e-3,
        /// Speed of the reference on its way from the slave to the hand, during an alignment.
        alignment_speed_m_per_s: f64 [self::LIMIT] for (WHEN_ACTING) = 0.03,
        /// Number of consecutive bad samples that are a fault: the force decays and the reference holds.
        bad_samples: u64 [1..] for (WHEN_ACTING) = 10,
        /// Duration in which the force decays after a fault or a stop, and in which it returns.
        decay_s: f64 [self::LIMIT] for (WHEN_ACTING) = 0.2,
        /// Checks for a stuck or reversed force sensor and for a velocity that contradicts the positions.
        checks_sensors: bool for (WHEN_ACTING) = true,
        /// Motion of the needle over which a force other than 0 does not change: the sensor is stuck.
        ///
        /// A noiseless sensor in a tissue of constant force looks stuck, too.
        stuck_travel_m: f64 [self::LIMIT] for (WHEN_ACTING) = 2e-3,
        /// Motion into the tissue against a force that pulls: the force has the wrong sign.
        pull_travel_m: f64 [self::LIMIT] for (WHEN_ACTING) = 5e-3,
        /// Motion over which position and velocity are compared: a velocity that differs by more than a factor of 2 has
        /// the wrong unit or sign.
        velocity_travel_m: f64 [self::LIMIT] for (WHEN_ACTING) = 5e-3,
    }
}

impl SafetySettings {
    /// True if rigs are limited.
    #[must_use]
    pub fn acts_on_rigs(&self) -> bool {
        self.acts != SafetyActs::Nowhere
    }

    /// True if the simulation is limited.
    #[must_use]
    pub fn acts_in_simulation(&self) -> bool {
        self.acts == SafetyActs::Everywhere
    }
}
