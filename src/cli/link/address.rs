//! Addresses and keys.

use std::net::{SocketAddr, ToSocketAddrs, UdpSocket};
use std::path::Path;

use crate::cli::error::LinkError;
use trocar_link::Key;

/// The socket address of a text.
pub(super) fn resolved(text: &str) -> Result<SocketAddr, LinkError> {
    let failed = |source| LinkError::Address { address: text.to_owned(), source };
    let mut addresses = text.to_socket_addrs().map_err(failed)?;
    addresses.next().ok_or_else(|| failed(std::io::Error::other("no address of this name")))
}

/// A socket at an address that never waits.
pub(super) fn bound(address: SocketAddr) -> Result<UdpSocket, LinkError> {
    let open = || {
        let socket = UdpSocket::bind(address)?;
        socket.set_nonblocking(true)?;
        Ok(socket)
    };
    open().map_err(|source| LinkError::Bind { address: address.to_string(), source })
}

/// The key in a file. Without one, only addresses of this machine are allowed.
pub(super) fn key(file: Option<&Path>, address: SocketAddr) -> Result<Key, LinkError> {
    let Some(file) = file else {
        let is_here = address.ip().is_loopback();
        return if is_here {
            Ok(Key::of_loopback())
        } else {
            Err(LinkError::NeedsKey { address: address.to_string() })
        };
    };
    let path = || file.display().to_string();
    let bytes = std::fs::read(file).map_err(|source| LinkError::KeyFile { path: path(), source })?;
    Key::new(&bytes).map_err(|source| LinkError::Key { path: path(), source })
}
