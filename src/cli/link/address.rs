use std::net::{SocketAddr, ToSocketAddrs, UdpSocket};
use std::path::Path;

use crate::cli::error::LinkError;
use trocar_link::Key;

pub(super) fn resolved(text: &str) -> Result<SocketAddr, LinkError> {
    let failed = |source| LinkError::Address { address: text.to_owned(), source };
    let mut addresses = text.to_socket_addrs().map_err(failed)?;
    addresses.next().ok_or_else(|| failed(std::io::Error::other("no address of this name")))
}

/// Non-blocking.
pub(super) fn bound(address: SocketAddr) -> Result<UdpSocket, LinkError> {
    let open = || {
        let socket = UdpSocket::bind(address)?;
        socket.set_nonblocking(true)?;
        Ok(socket)
    };
    open().map_err(|source| LinkError::Bind { address: address.to_string(), source })
}

/// Without a file, only loopback addresses are allowed.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_socket_never_waits() {
        let socket = bound("127.0.0.1:0".parse().expect("an address")).expect("a free port");
        let error = socket.recv(&mut [0; 8]).expect_err("nothing has been sent");
        assert_eq!(error.kind(), std::io::ErrorKind::WouldBlock);
        let taken = bound(socket.local_addr().expect("bound")).expect_err("in use");
        assert!(taken.to_string().ends_with("choose another address or port"), "{taken}");
    }
}
