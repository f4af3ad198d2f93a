use crate::lane::{Stored, store_code};

/// State of the commands.
///
/// ```text
///              enable                hand reached
///   disabled ──────────> aligning ────────────────> active
///      ^                    ^  │                       │
///      │ stop               │  └────────┐              │ bad samples, implausible sensor
///      │ (any state)        │           v              │
///      └──               good samples,  fault <────────┘
///                        or enable
/// ```
/// Only the active state commands the supervisor's force. A rig starts aligning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SafetyState {
    /// The force decays, and the reference holds.
    Disabled,
    /// The reference moves to the hand; the force is 0.
    Aligning,
    /// The supervisor's commands, limited.
    Active,
    /// The force decays, and the reference holds.
    Fault,
}

impl SafetyState {
    /// In the order of the codes.
    pub const ALL: [Self; 4] = [Self::Disabled, Self::Aligning, Self::Active, Self::Fault];

    /// 0: disabled, 1: aligning, 2: active, 3: fault.
    #[must_use]
    pub fn code(self) -> u8 {
        self as u8
    }

    /// `disabled`, `aligning`, `active` or `fault`.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Disabled => "disabled",
            Self::Aligning => "aligning",
            Self::Active => "active",
            Self::Fault => "fault",
        }
    }
}

/// Cause of the last fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FaultCause {
    /// `safety.bad_samples` samples in a row.
    BadSamples,
    /// The force did not change during a motion.
    StuckForce,
    /// The force pulled the needle into the tissue.
    ForceSign,
    /// The velocity contradicted the positions.
    Velocity,
}

impl FaultCause {
    /// In the order of the codes.
    pub const ALL: [Self; 4] = [Self::BadSamples, Self::StuckForce, Self::ForceSign, Self::Velocity];

    /// 1: bad samples, 2: stuck force, 3: sign of the force, 4: velocity.
    #[must_use]
    pub fn code(self) -> u8 {
        self as u8 + 1
    }

    /// `bad-samples`, `stuck-force`, `force-sign` or `velocity`.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::BadSamples => "bad-samples",
            Self::StuckForce => "stuck-force",
            Self::ForceSign => "force-sign",
            Self::Velocity => "velocity",
        }
    }
}

impl Stored for SafetyState {
    fn numbers(&mut self, with: &mut dyn FnMut(&mut u64)) {
        // An unknown code is the state that moves nothing.
        store_code(self, Self::ALL, Self::code, Self::Disabled, with);
    }
}

impl FaultCause {
    pub(super) fn store(cause: &mut Option<Self>, with: &mut dyn FnMut(&mut u64)) {
        store_code(cause, Self::ALL.map(Some), |cause| cause.map_or(0, Self::code), None, with);
    }
}
