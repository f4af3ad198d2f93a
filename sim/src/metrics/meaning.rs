//! What each metric means, in one sentence for people: the tables of runs and of sweeps say the same.

#![allow(missing_docs, reason = "the sentence is what a constant holds")]

pub const DIVERGED: &str = "When a position left the bounds of the sensible, at which the run was ended.";
pub const RUPTURES: &str = "How many layers gave way.";
pub const RUPTURE_TIME: &str = "When the layer gave way.";
pub const DETECTED_RUPTURES: &str = "Ruptures that an alarm announced within 0.5 s.";
pub const MISSED_RUPTURES: &str = "Ruptures that no alarm announced within 0.5 s.";
pub const UNDECIDED_RUPTURES: &str = "Ruptures without an alarm, less than 0.5 s before the end of the run.";
pub const FALSE_ALARMS: &str = "Alarms that announced no rupture, or one that had been announced before.";
pub const IGNORED_ALARMS: &str = "Alarms that were not taken, as an event was under way or had just ended.";
pub const DETECTION_DELAY: &str = "From the rupture to the alarm that announced it; none where it was missed.";
pub const SLAVE_OVERSHOOT: &str = "How far the needle lurches at most in the 0.5 s after the rupture.";
pub const SLAVE_TRAVEL: &str =
    "How far the needle has gone on 0.3 s after the rupture; less than 0 where it came back.";
pub const MASTER_POSITION: &str = "Where the master was when the layer gave way.";
pub const MASTER_TRAVEL: &str = "How far the hand goes on at most in the 0.5 s after the rupture.";
pub const FEEDBACK_FALL: &str =
    "Until the force fed back to the master is down to 5 % of what it was at the rupture; none if not within 0.5 s.";
pub const FELT_FALL: &str =
    "Until the force on the hand is down to 5 % of what it was at the rupture; none if not within 0.5 s.";
pub const PEAK_FORCE_RATE: &str = "The steepest change of the force on the hand in the 0.5 s after the rupture.";
pub const FELT_CONTRAST: &str =
    "How much of the force on the hand is gone at most within 0.3 s of the rupture; above 100 % it pulls.";
pub const EVENTS: &str = "How often the slave was frozen.";
pub const EVENT_START: &str = "When the slave was frozen.";
pub const EVENT_AUGMENTED: &str = "How long the slave was frozen.";
pub const EVENT_REENGAGING: &str = "How long it then took until the slave followed the hand again.";
pub const MASTER_START: &str = "Where the master was when the slave was frozen.";
pub const MASTER_END: &str = "Where the master was when the slave was released.";
pub const FROZEN_MOTION: &str = "How far the needle moved at most from where it was frozen.";
pub const PEAK_REENGAGING_SPEED: &str = "The greatest speed of the needle while the slave finds back to the hand.";
pub const ENTRY_STEP: &str = "How much the fed-back force changed in the first tick of the event.";
pub const EXIT_STEP: &str = "How much the fed-back force changed in the first tick of re-engaging.";
pub const FEEDBACK_STEP_EXCESS: &str =
    "By how much the fed-back force changed in one tick beyond what its law allows; 0 but for rounding.";
pub const MEAN_RESIDUAL: &str = "How far the estimator's force is from the measured one, averaged over the run.";
pub const MIN_TISSUE_FORCE: &str = "The least force of the tissue on the needle; below 0 it holds the needle back.";
pub const MAX_TISSUE_FORCE: &str = "The greatest force of the tissue on the needle, resisting insertion.";
pub const TRACKING_RMSE: &str = "How far the slave is from its reference while it follows the hand, root mean square.";
pub const FINAL_SLAVE_POSITION: &str = "Where the needle was at the last tick.";
pub const FINAL_TRACKING_ERROR: &str = "How far the slave was from its reference at the last tick, of that reference.";
pub const TELEOPERATION_TIME: &str = "How long the slave followed the hand.";
pub const AUGMENTED_TIME: &str = "How long the slave was frozen and the felt force exaggerated, all events together.";
pub const REENGAGING_TIME: &str = "How long the slave was finding back to the hand, all events together.";
pub const MODE_SWITCHES: &str = "How often following, frozen and finding back took turns.";
pub const OPERATOR_ENERGY: &str = "The work that the hand put into the master.";
pub const TISSUE_ENERGY: &str = "The work that the needle put into the tissue.";
pub const LINK_OUTAGES: &str = "How often the link was silent in either direction.";
pub const LINK_LONGEST_OUTAGE: &str = "The longest of the link's outages.";
pub const LINK_GIVEN_UP: &str = "When the slave gave the link up.";
pub const LINK_MASTER_PORT: &str = "The work that the master put into the link.";
pub const LINK_SLAVE_PORT: &str = "The work that the needle put into the tissue, by the measured force.";
pub const LINK_MASTER_DISSIPATED: &str = "What the passivity controller dissipated at the master.";
pub const LINK_SLAVE_REFUSED: &str = "What the passivity controller kept from the slave.";
