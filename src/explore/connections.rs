//! Accepts a limited number of connections, each for a limited time.
//!
//! A connection carries one request and is then closed, unless it becomes a page's WebSocket; those have a separate
//! limit. Beyond the maximum number of connections the oldest is closed, so idle connections cannot block new ones.

use std::collections::VecDeque;
use std::convert::Infallible;

use axum::Router;
use axum::body::Body;
use axum::http::{Request, Response};
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::net::TcpListener;
use tokio::task::JoinHandle;
use tokio::time::{sleep, timeout};

use super::limits::{HEAD_TIMEOUT, MAX_WAITING, REQUEST_TIMEOUT};

/// Accepts connections until it is dropped.
pub(super) async fn accept(listener: TcpListener, router: Router) -> Infallible {
    let mut open: VecDeque<JoinHandle<()>> = VecDeque::with_capacity(MAX_WAITING + 1);
    loop {
        let stream = match listener.accept().await {
            Ok((stream, _)) => stream,
            Err(_) => {
                // There is no free descriptor, or the peer closed the connection. Try again after a short time.
                sleep(std::time::Duration::from_millis(20)).await;
                continue;
            }
        };
        if open.len() >= MAX_WAITING {
            open.retain(|connection| !connection.is_finished());
        }
        if open.len() >= MAX_WAITING
            && let Some(oldest) = open.pop_front()
        {
            oldest.abort();
        }
        let _ = stream.set_nodelay(true);
        let service = TowerToHyperService::new(router.clone());
        open.push_back(tokio::spawn(async move {
            let mut server = http1::Builder::new();
            server.timer(TokioTimer::new()).header_read_timeout(HEAD_TIMEOUT).max_buf_size(16 << 10);
            // An error of a client ends only its own connection.
            let _ =
                timeout(REQUEST_TIMEOUT, server.serve_connection(TokioIo::new(stream), service).with_upgrades()).await;
        }));
    }
}

pub(super) fn text(status: u16, media: &'static str, body: &'static str) -> Response<Body> {
    let mut response = Response::new(Body::from(body));
    *response.status_mut() = axum::http::StatusCode::from_u16(status).unwrap_or_default();
    let headers = response.headers_mut();
    for (name, value) in HEADERS {
        headers.insert(*name, axum::http::HeaderValue::from_static(value));
    }
    headers.insert("content-type", axum::http::HeaderValue::from_static(media));
    response
}

/// Headers of every response: only the page's own files, no frames, no caching, and the connection closes.
const HEADERS: &[(&str, &str)] = &[
    (
        "content-security-policy",
        "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' blob: data:; \
         connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    ),
    ("cache-control", "no-store"),
    ("connection", "close"),
    ("cross-origin-opener-policy", "same-origin"),
    ("cross-origin-resource-policy", "same-origin"),
    ("referrer-policy", "no-referrer"),
    ("x-content-type-options", "nosniff"),
    ("x-frame-options", "DENY"),
];

/// True if the request has one `Host`, and its address, if that names a host, names the same one. HTTP refuses others,
/// because programs between browser and server can take either.
pub(super) fn has_one_host<T>(request: &Request<T>) -> bool {
    let is_same = |authority: &axum::http::uri::Authority| authority.as_str().eq_ignore_ascii_case(host(request));
    request.headers().get_all("host").iter().count() < 2 && request.uri().authority().is_none_or(is_same)
}

pub(super) fn host<T>(request: &Request<T>) -> &str {
    header(request, "host").unwrap_or_default()
}

pub(super) fn header<'a, T>(request: &'a Request<T>, name: &str) -> Option<&'a str> {
    request.headers().get(name).and_then(|value| value.to_str().ok())
}
