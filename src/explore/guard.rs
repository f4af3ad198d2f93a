//! The server accepts requests from its own pages only.
//!
//! A browser sends the page of a request (`Origin`) and the host name of the request (`Host`). A page of another site has another
//! origin; a page with DNS rebinding has another host. So a host must be an IP address or `localhost` with the port of the server,
//! and the origin of a WebSocket must be the same host.

use std::net::{IpAddr, SocketAddr};

/// Checks that a request comes from a page of this server.
#[derive(Debug, Clone, Copy)]
pub struct Guard {
    bound: SocketAddr,
}

impl Guard {
    /// Returns the guard of a server with this address.
    #[must_use]
    pub fn new(bound: SocketAddr) -> Self {
        Self { bound }
    }

    /// Returns whether the `Host` of a request is this server.
    #[must_use]
    pub fn admits_host(&self, host: &str) -> bool {
        let (name, port) = match host.rsplit_once(':') {
            // Colons inside brackets belong to an IPv6 address.
            Some((name, port)) if !port.ends_with(']') => (name, Some(port)),
            _ => (host, None),
        };
        let is_port = match port {
            Some(port) => port.parse() == Ok(self.bound.port()),
            None => self.bound.port() == 80,
        };
        is_port && self.admits_name(name)
    }

    fn admits_name(&self, name: &str) -> bool {
        if name.eq_ignore_ascii_case("localhost") {
            return true;
        }
        let inner = name.strip_prefix('[').and_then(|name| name.strip_suffix(']')).unwrap_or(name);
        match inner.parse::<IpAddr>() {
            Ok(address) => address.is_loopback() || !self.bound.ip().is_loopback(),
            Err(_) => false,
        }
    }

    /// Returns whether a page of this server opened a WebSocket: its `Origin` is its `Host`.
    #[must_use]
    pub fn admits_origin(&self, origin: Option<&str>, host: &str) -> bool {
        let site = origin.and_then(|origin| origin.strip_prefix("http://"));
        self.admits_host(host) && site.is_some_and(|site| site.eq_ignore_ascii_case(host))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn guard(address: &str) -> Guard {
        Guard::new(address.parse().expect("an address"))
    }

    #[test]
    fn a_host_is_the_address_and_port_of_the_server() {
        let local = guard("127.0.0.1:8417");
        for host in ["127.0.0.1:8417", "localhost:8417", "LocalHost:8417", "[::1]:8417", "127.0.0.2:8417"] {
            assert!(local.admits_host(host), "{host}");
        }
        let others =
            ["evil.example:8417", "127.0.0.1", "127.0.0.1:80", "localhost.evil.example:8417", "10.0.0.1:8417", "", ":"];
        for host in others.into_iter().chain(["[::1]", "127.0.0.1:8417:8417", "127.0.0.1:08417x", "2130706433:8417"]) {
            assert!(!local.admits_host(host), "{host}");
        }
        assert!(guard("0.0.0.0:8417").admits_host("10.0.0.1:8417"), "bound to all addresses");
        assert!(!guard("0.0.0.0:8417").admits_host("evil.example:8417"), "a name can point to any address");
        assert!(guard("127.0.0.1:80").admits_host("localhost"));
    }

    #[test]
    fn an_origin_is_the_host() {
        let own = guard("127.0.0.1:8417");
        assert!(own.admits_origin(Some("http://127.0.0.1:8417"), "127.0.0.1:8417"));
        for origin in ["https://127.0.0.1:8417", "http://localhost:8417", "http://evil.example", "null", ""] {
            assert!(!own.admits_origin(Some(origin), "127.0.0.1:8417"), "{origin}");
        }
        assert!(!own.admits_origin(None, "127.0.0.1:8417"));
        assert!(!own.admits_origin(Some("http://evil.example:8417"), "evil.example:8417"));
    }
}
