use std::net::{SocketAddr, ToSocketAddrs, UdpSocket};
use std::path::Path;

use crate::cli::error::Failure;
use trocar_link::Key;

pub(super) fn resolved(text: &str) -> Result<SocketAddr, Failure> {
    let failed = |error: std::io::Error| {
        Failure::input(format!("{text}: {error}: give a host and a port, as in 127.0.0.1:7711"))
    };
    let mut addresses = text.to_socket_addrs().map_err(failed)?;
    addresses.next().ok_or_else(|| failed(std::io::Error::other("no address of this name")))
}

/// Non-blocking.
pub(super) fn bound(address: SocketAddr) -> Result<UdpSocket, Failure> {
    let open = || -> std::io::Result<UdpSocket> {
        let socket = UdpSocket::bind(address)?;
        socket.set_nonblocking(true)?;
        Ok(socket)
    };
    open().map_err(|error| Failure::input(format!("{address}: {error}: choose another address or port")))
}

/// Without a file, only loopback addresses are allowed.
pub(super) fn key(file: Option<&Path>, address: SocketAddr) -> Result<Key, Failure> {
    let Some(file) = file else {
        if address.ip().is_loopback() {
            return Ok(Key::of_loopback());
        }
        return Err(Failure::input(format!(
            "{address} is not an address of this machine only: give both sides the same key with --key-file (head -c 32 \
             /dev/urandom > key)"
        )));
    };
    let path = file.display();
    let bytes = std::fs::read(file)
        .map_err(|error| Failure::input(format!("{path}: {error}: give a file with the key of both sides")))?;
    Key::new(&bytes).map_err(|error| Failure::input(format!("{path}: {error}")))
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
