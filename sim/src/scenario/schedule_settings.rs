//! The keys of scheduled events.

trocar_core::settings! {
    /// Scheduled outages and logged delays of the link.
    #[derive(Debug, Clone, PartialEq)]
    pub(super) struct ScheduleSettings in "channel." no const {
        /// Times of outages, in pairs, as in [2.0, 2.5]: samples sent from a begin to before its end never arrive.
        outages_s: Vec<f64> = [],
        /// A CSV file of logged delays, for forward_delay_s and backward_delay_s at 0: from each time_s on, counted
        /// from the run's start, samples have the delays of the columns with those names, to the nearest tick; where a
        /// delay is empty or lost, they never arrive.
        delays_file: Option<String> [FILE],
    }
}

trocar_core::settings! {
    /// Events without an alarm of the detector.
    #[derive(Debug, Clone, PartialEq)]
    pub(super) struct EventSettings in "augmentation." no const {
        /// Times of scheduled alarms, independent of the detector, as in [1.0, 3.5]; each takes effect if the
        /// supervisor accepts alarms then.
        events_s: Vec<f64> = [],
    }
}
