//! Errors of `trocar link`.

use thiserror::Error;

use trocar_link::{KeyError, RemoteLogError};

/// The error of a link.
#[derive(Debug, Error)]
pub(in crate::cli) enum LinkError {
    /// An address that is none.
    #[error("{address}: {source}: give a host and a port, as in 127.0.0.1:7711")]
    Address {
        /// The address as given.
        address: String,
        /// Why it is none.
        source: std::io::Error,
    },
    /// An address that cannot be used.
    #[error("{address}: {source}: choose another address or port")]
    Bind {
        /// The address.
        address: String,
        /// Why it cannot be used.
        source: std::io::Error,
    },
    /// Another machine without a key.
    #[error(
        "{address} is not an address of this machine only: give both sides the same key with --key-file (head -c 32 /dev/urandom > key)"
    )]
    NeedsKey {
        /// The address.
        address: String,
    },
    /// A key file that cannot be read.
    #[error("{path}: {source}: give a file with the key of both sides")]
    KeyFile {
        /// The file.
        path: String,
        /// Why it cannot be read.
        source: std::io::Error,
    },
    /// A key that is too short.
    #[error("{path}: {source}")]
    Key {
        /// The file.
        path: String,
        /// Its problem.
        source: KeyError,
    },
    /// A proxy between two machines.
    #[error("--proxy is between two sides on this machine, and {address} is not on it: leave out --proxy")]
    ProxyElsewhere {
        /// The address.
        address: String,
    },
    /// A channel that would not act.
    #[error(
        "the delays, jitter, loss and outages of [channel] act with --proxy only: add --proxy, or set them to 0 for the delays of the network"
    )]
    ChannelWithoutProxy,
    /// A pointer on a tissue that replays a recording.
    #[error(
        "the tissue is the force of a recording, which another hand made, and does not answer to --pointer: choose a scenario whose tissue.kind is a model, such as layers/skin-augmented"
    )]
    PointerOnRecording,
    /// No reply.
    #[error("no slave replied at {address} within {wait_s} s: start it, with the same --key-file if there is one")]
    NoReply {
        /// The address.
        address: String,
        /// The time waited in s.
        wait_s: u32,
    },
    /// The slave has another scenario.
    #[error("the slave has another scenario, other settings or another version of trocar: give both sides the same")]
    Differs,
    /// The slave replied, and then no longer.
    #[error("the slave does not answer any more: start both sides again")]
    NotReady,
    /// A log that cannot be read.
    #[error("{path}: {source}: give the folder of a link, which contains master and slave")]
    Log {
        /// The file.
        path: String,
        /// Why it cannot be read.
        source: std::io::Error,
    },
    /// A log that is none.
    #[error(transparent)]
    Content(#[from] RemoteLogError),
    /// The replay is not the link.
    #[error("the link is not its replay, bit for bit")]
    NotReplayed,
}

impl LinkError {
    /// Whether the error comes from invalid input.
    pub(super) fn is_input(&self) -> bool {
        !matches!(self, Self::NoReply { .. } | Self::Differs | Self::NotReady | Self::NotReplayed)
    }
}
