use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;

use axum::Router;
use axum::body::Body;
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::{FromRequestParts, State};
use axum::http::{HeaderValue, Method, Request, Response, StatusCode};
use axum::response::IntoResponse;
use axum::serve::ListenerExt as _;
use thiserror::Error;
use tokio::net::TcpListener;

use super::assets::ASSETS;
use super::guard::{Guard, has_one_host, header, host};
use super::limits::MAX_MESSAGE_BYTES;
use super::session;
use super::state::Catalogue;

#[derive(Debug, Clone)]
pub struct Options {
    pub address: IpAddr,
    /// 0 for any free port.
    pub port: u16,
    pub catalogue: Catalogue,
    pub first: String,
}

#[derive(Debug, Error)]
pub enum ExploreError {
    #[error("cannot serve on {address}: {source}; give another --port, or --port 0 for any free port")]
    Bind { address: SocketAddr, source: std::io::Error },
    /// No threads or events for a server.
    #[error("cannot serve the page: {0}")]
    System(std::io::Error),
}

/// Only the page's own files, no frames, no caching, and the connection closes.
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

#[derive(Debug)]
struct Site {
    guard: Guard,
    catalogue: Catalogue,
    first: String,
}

/// Serves the page until the process ends. Calls `ready` with the server's address and the query of the page's
/// address, which contains a token if other machines can reach the server.
pub fn serve(options: Options, ready: impl FnOnce(SocketAddr, &str)) -> Result<(), ExploreError> {
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build();
    runtime.map_err(ExploreError::System)?.block_on(async {
        let address = SocketAddr::new(options.address, options.port);
        let bind = |source| ExploreError::Bind { address, source };
        let listener = TcpListener::bind(address).await.map_err(bind)?;
        let bound = listener.local_addr().map_err(ExploreError::System)?;
        let guard = Guard::new(bound);
        let guard = if bound.ip().is_loopback() { guard } else { guard.with_token().map_err(ExploreError::System)? };
        ready(bound, &guard.query());
        let site = Site { guard, catalogue: options.catalogue, first: options.first };
        let router = Router::new().fallback(answer).with_state(Arc::new(site));
        // Send each message at once.
        let listener = listener.tap_io(|stream| drop(stream.set_nodelay(true)));
        axum::serve(listener, router).await.map_err(ExploreError::System)
    })
}

async fn answer(State(site): State<Arc<Site>>, request: Request<Body>) -> Response<Body> {
    if !has_one_host(&request) {
        return refusal(400, "The request names two hosts.\n");
    }
    if !site.guard.admits_host(host(&request)) {
        return refusal(421, "Use the address of this server or localhost.\n");
    }
    if request.method() != Method::GET {
        return refusal(405, "GET only.\n");
    }
    let path = request.uri().path();
    if matches!(path, "/" | "/link") && !site.guard.admits_query(request.uri().query()) {
        return refusal(403, "Open the whole address that trocar printed, with its token.\n");
    }
    if path == "/link" {
        return link(&site, request).await;
    }
    match ASSETS.iter().find(|asset| asset.path == path) {
        Some(asset) => text(200, asset.media, asset.content),
        None => refusal(404, "Not found.\n"),
    }
}

async fn link(site: &Site, request: Request<Body>) -> Response<Body> {
    if !site.guard.admits_origin(header(&request, "origin"), host(&request)) {
        return refusal(403, "The server accepts requests from its own pages only.\n");
    }
    let (mut parts, _) = request.into_parts();
    let upgrade = match WebSocketUpgrade::from_request_parts(&mut parts, &()).await {
        Ok(upgrade) => upgrade.max_message_size(MAX_MESSAGE_BYTES).max_frame_size(MAX_MESSAGE_BYTES),
        Err(refused) => return refused.into_response(),
    };
    let (catalogue, first) = (site.catalogue.clone(), site.first.clone());
    upgrade.on_upgrade(move |socket| session::serve(socket, catalogue, first))
}

fn refusal(status: u16, reason: &'static str) -> Response<Body> {
    text(status, "text/plain; charset=utf-8", reason)
}

fn text(status: u16, media: &'static str, body: &'static str) -> Response<Body> {
    let mut response = Response::new(Body::from(body));
    *response.status_mut() = StatusCode::from_u16(status).unwrap_or_default();
    let headers = response.headers_mut();
    for (name, value) in HEADERS {
        headers.insert(*name, HeaderValue::from_static(value));
    }
    headers.insert("content-type", HeaderValue::from_static(media));
    response
}
