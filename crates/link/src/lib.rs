//! The two sides of an insertion as two processes.
//!
//! The crate reads no clock and opens no socket: its functions receive times and packets, so a link can run in virtual
//! time, and its replay in a simulation gives the same bits.

mod arrivals;
mod counters;
mod document;
mod endpoint;
mod ends;
mod greeting;
mod lateness;
mod log;
mod packet;
mod rejoin;
mod seal;
mod silence;
mod summary;
mod window;

pub use arrivals::Arrivals;
pub use counters::Counters;
pub use document::LinkFile;
pub use endpoint::{Endpoint, Trip};
pub use ends::{MasterEnd, Meter, SlaveEnd};
pub use greeting::{Calling, Greeted, Waiting, fingerprint};
pub use lateness::{Lateness, LatenessSummary};
pub use log::{Difference, Direction, RemoteLogError, delays_csv, first_difference, read_direction};
pub use packet::{PACKET_BYTES, Role};
pub use rejoin::{Heard, Rejoin};
pub use seal::{Key, KeyError, MIN_KEY_BYTES, Session};
pub use silence::{Silence, SilenceChange};
pub use summary::{SideSummary, Spread, Trips};
pub use window::Window;
