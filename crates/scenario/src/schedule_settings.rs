use trocar_core::augmentation::WHEN_ENABLED;

trocar_core::settings! {
    /// Scheduled outages and logged delays of the link.
    #[derive(Debug, Clone, PartialEq)]
    pub(super) struct ScheduleSettings in "channel." no const {
        /// Start and end times of outages, for example [2.0, 2.5]. Samples sent from a start until just before its end
        /// never arrive.
        outages_s: Vec<f64> = [],
        /// CSV file of logged delays with the columns time_s, forward_delay_s and backward_delay_s; the keys of the
        /// same names must be 0. A row applies from its time_s after the start of the run, rounded to a tick. An empty
        /// delay, or the word lost, is a lost sample.
        delays_file: Option<String> [FILE],
    }
}

trocar_core::settings! {
    /// Events without an alarm of the detector.
    #[derive(Debug, Clone, PartialEq)]
    pub(super) struct EventSettings in "augmentation." no const {
        /// Times of scheduled alarms, independent of the detector, for example [1.0, 3.5]. An alarm has an effect if
        /// the supervisor accepts alarms at that time.
        events_s: Vec<f64> for (WHEN_ENABLED) = [],
    }
}
