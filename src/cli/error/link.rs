use thiserror::Error;

use trocar_link::{KeyError, RemoteLogError};

#[derive(Debug, Error)]
pub(in crate::cli) enum LinkError {
    #[error("{address}: {source}: give a host and a port, as in 127.0.0.1:7711")]
    Address { address: String, source: std::io::Error },
    #[error("{address}: {source}: choose another address or port")]
    Bind { address: String, source: std::io::Error },
    #[error(
        "{address} is not an address of this machine only: give both sides the same key with --key-file (head -c 32 \
         /dev/urandom > key)"
    )]
    NeedsKey { address: String },
    #[error("{path}: {source}: give a file with the key of both sides")]
    KeyFile { path: String, source: std::io::Error },
    #[error("{path}: {source}")]
    Key { path: String, source: KeyError },
    #[error(
        "the delays, jitter, loss and outages of [channel] act in simulations only: set them to 0, and delay the packets \
         with tc netem"
    )]
    Channel,
    #[error("no slave replied at {address} within {wait_s} s: start it, with the same --key-file if there is one")]
    NoReply { address: String, wait_s: u32 },
    #[error("the slave has another scenario, other settings or another version of trocar: give both sides the same")]
    Differs,
    #[error("the slave does not answer any more: start both sides again")]
    NotReady,
    #[error("nothing has come from the {peer} since {since_s:.3} s of the run: start both sides again")]
    PeerLost {
        peer: &'static str,
        /// The time of its last message, in s.
        since_s: f64,
    },
    #[error("the {peer} was started anew during the run, {times}: its first process has ended early")]
    PeerRestarted {
        peer: &'static str,
        /// How often, as `2 times`.
        times: String,
    },
    #[error("joined the {peer} at tick {tick} of its run: the ticks before had no messages")]
    Joined { peer: &'static str, tick: u64 },
    #[error("the run of the {peer} ends too soon to join it: start both sides again")]
    TooLate { peer: &'static str },
    #[error(
        "{path}: a side was started anew during this link, so one simulation cannot repeat it: start both sides again"
    )]
    NotWhole { path: String },
    #[error("{path}: {source}: give the folder of a link, which contains master and slave")]
    Log { path: String, source: std::io::Error },
    #[error(transparent)]
    Content(#[from] RemoteLogError),
    #[error("the replay differs from the link; the two should agree bit for bit")]
    NotReplayed,
}

impl LinkError {
    pub(super) fn is_input(&self) -> bool {
        !matches!(
            self,
            Self::NoReply { .. }
                | Self::Differs
                | Self::NotReady
                | Self::PeerLost { .. }
                | Self::PeerRestarted { .. }
                | Self::Joined { .. }
                | Self::TooLate { .. }
                | Self::NotWhole { .. }
                | Self::NotReplayed
        )
    }
}
