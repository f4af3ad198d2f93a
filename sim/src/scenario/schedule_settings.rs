//! What happens at known times: the keys.

trocar_core::settings! {
    /// What the link does at known times.
    #[derive(Debug, Clone, PartialEq)]
    pub(super) struct ScheduleSettings in "channel." no const {
        /// When the link is dead, in pairs, as in [2.0, 2.5]: what is sent from a begin to before its end never arrives.
        outages_s: Vec<f64> = [],
        /// A CSV file of logged delays, for forward_delay_s and backward_delay_s at 0: from each time_s on, counted from the
        /// run's start, what is sent takes as long as its columns of those names say, to the nearest tick; where one is empty
        /// or lost, it never arrives.
        delays_file: Option<String> [FILE],
    }
}

trocar_core::settings! {
    /// What happens without an alarm.
    #[derive(Debug, Clone, PartialEq)]
    pub(super) struct EventSettings in "augmentation." no const {
        /// When the supervisor is alarmed whatever the detector says, as in [1.0, 3.5]; taken where an alarm would be.
        events_s: Vec<f64> = [],
    }
}
