//! Admits only requests from the server's own pages.
//!
//! A browser sends the site of the requesting page (`Origin`) and the host name of the request (`Host`). A page of
//! another site has another origin; a page that uses DNS rebinding has another host. Therefore the host must be an IP
//! address or `localhost`, with the port of the server, and a WebSocket's origin must be the same host.
//!
//! A server that other machines can reach also requires a token, which is part of the printed address.

use std::net::{IpAddr, SocketAddr};

use axum::http::Request;
use axum::http::uri::Authority;

/// Checks that a request comes from a page of this server.
#[derive(Debug, Clone)]
pub struct Guard {
    bound: SocketAddr,
    token: Option<String>,
}

impl Guard {
    pub fn new(bound: SocketAddr) -> Self {
        Self { bound, token: None }
    }

    /// 128 random bits.
    pub fn with_token(self) -> std::io::Result<Self> {
        let mut bytes = [0_u8; 16];
        getrandom::fill(&mut bytes).map_err(std::io::Error::other)?;
        let token = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(Self { token: Some(token), ..self })
    }

    /// `?token=…`; empty without a token.
    pub fn query(&self) -> String {
        self.token.as_ref().map_or(String::new(), |token| format!("?token={token}"))
    }

    /// Without a token, every query is admitted.
    pub fn admits_query(&self, query: Option<&str>) -> bool {
        let Some(token) = &self.token else { return true };
        let given = |part: &str| part.strip_prefix("token=").is_some_and(|given| given == token);
        query.is_some_and(|query| query.split('&').any(given))
    }

    /// True for the `Host` of this server.
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

    /// True if the `Origin` equals the `Host`.
    pub fn admits_origin(&self, origin: Option<&str>, host: &str) -> bool {
        let site = origin.and_then(|origin| origin.strip_prefix("http://"));
        self.admits_host(host) && site.is_some_and(|site| site.eq_ignore_ascii_case(host))
    }
}

/// True for one `Host`, which the address of the request also names, if any. HTTP refuses others, because programs
/// between browser and server can take either.
pub(super) fn has_one_host<T>(request: &Request<T>) -> bool {
    let is_same = |authority: &Authority| authority.as_str().eq_ignore_ascii_case(host(request));
    request.headers().get_all("host").iter().count() < 2 && request.uri().authority().is_none_or(is_same)
}

pub(super) fn host<T>(request: &Request<T>) -> &str {
    header(request, "host").unwrap_or_default()
}

pub(super) fn header<'a, T>(request: &'a Request<T>, name: &str) -> Option<&'a str> {
    request.headers().get(name).and_then(|value| value.to_str().ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn guard(address: &str) -> Guard {
        Guard::new(address.parse().expect("an address"))
    }

    #[test]
    fn the_host_must_be_the_address_and_port_of_the_server() {
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
    fn the_token_must_be_in_the_query() {
        let open = guard("127.0.0.1:8417");
        assert!(open.query().is_empty() && open.admits_query(None));
        let [one, two] = [0, 1].map(|_| guard("0.0.0.0:8417").with_token().expect("random numbers"));
        assert_ne!(one.query(), two.query());
        let query = one.query();
        let token = query.strip_prefix("?token=").expect("a token");
        assert_eq!(token.len(), 32);
        assert!(one.admits_query(Some(&format!("x=1&token={token}"))));
        for query in [None, Some(""), Some("token="), Some(token), Some(&format!("token={}", &token[1..]))] {
            assert!(!one.admits_query(query), "{query:?}");
        }
    }
}
