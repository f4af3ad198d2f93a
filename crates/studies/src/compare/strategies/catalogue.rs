#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Strategy {
    pub name: &'static str,
    pub meaning: &'static str,
    /// `section.key=value` texts.
    pub settings: &'static [&'static str],
}

const MEASURED: [&str; 2] = ["augmentation.force_law=damp", "augmentation.damp_damping_n_s_per_m=0"];
const ENABLED: &str = "augmentation.enabled=true";

/// The first one is the scheme without a strategy.
pub const STRATEGIES: [Strategy; 16] = [
    Strategy {
        name: "none",
        meaning: "The classical scheme: alarms have no effect.",
        settings: &["augmentation.enabled=false"],
    },
    Strategy {
        name: "freeze-decay",
        meaning: "The slave is frozen, the felt force decays, and a ramp closes the gap.",
        settings: &[ENABLED, "augmentation.force_law=decay", "augmentation.reengage=ramp"],
    },
    Strategy {
        name: "freeze-amplify",
        meaning: "The slave is frozen, the variation of the felt force is doubled, and a ramp closes the gap.",
        settings: &[ENABLED, "augmentation.force_law=amplify", "augmentation.reengage=ramp"],
    },
    Strategy {
        name: "freeze-clutch",
        meaning: "The slave is frozen, the felt force decays, and the gap is kept.",
        settings: &[ENABLED, "augmentation.force_law=decay", "augmentation.reengage=clutch"],
    },
    Strategy {
        name: "freeze-snap",
        meaning: "The slave is frozen, the felt force decays, and the gap closes at once.",
        settings: &[ENABLED, "augmentation.force_law=decay", "augmentation.reengage=snap"],
    },
    Strategy {
        name: "freeze-until-load",
        meaning: "The slave is frozen, the felt force decays, and a ramp closes the gap until the force rises.",
        settings: &[ENABLED, "augmentation.force_law=decay", "augmentation.reengage=ramp-until-load"],
    },
    Strategy {
        name: "freeze-fade",
        meaning: "The slave is frozen, the felt force decays, and the gap fades over several seconds.",
        settings: &[ENABLED, "augmentation.force_law=decay", "augmentation.reengage=fade"],
    },
    Strategy {
        name: "freeze-still",
        meaning: "The slave is frozen, the felt force decays, and the gap closes when the hand stands still.",
        settings: &[ENABLED, "augmentation.force_law=decay", "augmentation.reengage=when-still"],
    },
    Strategy {
        name: "fixture",
        meaning: "The slave is held until the hand pushes on, a spring guides the hand back, and the gap fades.",
        settings: &[
            ENABLED,
            "augmentation.hold=yielding",
            "augmentation.force_law=guide",
            "augmentation.reengage=fade",
        ],
    },
    Strategy {
        name: "speed-limit",
        meaning: "The slave follows slowly, the measured force is fed back, and a ramp closes the gap.",
        settings: &[ENABLED, "augmentation.hold=speed-limit", MEASURED[0], MEASURED[1]],
    },
    Strategy {
        name: "forbidden-region",
        meaning: "The slave cannot go deeper, the measured force is fed back, and the gap is kept.",
        settings: &[
            ENABLED,
            "augmentation.hold=forbidden-region",
            "augmentation.reengage=clutch",
            MEASURED[0],
            MEASURED[1],
        ],
    },
    Strategy {
        name: "damping",
        meaning: "The slave follows, and the master's damping rises.",
        settings: &[ENABLED, "augmentation.hold=none", MEASURED[0], "augmentation.damp_damping_n_s_per_m=100"],
    },
    Strategy {
        name: "cue",
        meaning: "The slave follows, the measured force is fed back, and a vibration marks the alarm.",
        settings: &[ENABLED, "augmentation.hold=none", "augmentation.cue=true", MEASURED[0], MEASURED[1]],
    },
    Strategy {
        name: "tip-force",
        meaning: "The classical scheme with a force sensor at the tip: the friction on the shaft is not felt.",
        settings: &["augmentation.enabled=false", "sensor.at_tip=true"],
    },
    Strategy {
        name: "weak-force",
        meaning: "The classical scheme with a tenth of the force: the arm is hardly loaded, and hardly lurches.",
        settings: &["augmentation.enabled=false", "scaling.force=0.1"],
    },
    Strategy {
        name: "designed",
        meaning: "The result of designs/liver.toml: a short freeze, a gap that fades, a vibration, a tenth of the force.",
        settings: &[
            ENABLED,
            "augmentation.force_law=decay",
            "augmentation.reengage=fade",
            "augmentation.gap_time_constant_s=0.6",
            "augmentation.min_hold_s=0.07",
            "augmentation.max_hold_s=1",
            "augmentation.cue=true",
            "scaling.force=0.1",
        ],
    },
];
