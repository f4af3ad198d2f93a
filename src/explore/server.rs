//! The server of the page.

use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;

use axum::Router;
use axum::body::Body;
use axum::extract::FromRequestParts;
use axum::extract::ws::WebSocketUpgrade;
use axum::http::{Method, Request, Response};
use axum::response::IntoResponse;
use thiserror::Error;
use tokio::net::{TcpListener, TcpSocket};
use tokio::sync::Semaphore;

use super::assets::ASSETS;
use super::connections::{accept, has_one_host, header, host, text};
use super::guard::Guard;
use super::limits::{MAX_MESSAGE_BYTES, MAX_SESSIONS, MAX_UNACCEPTED};
use super::session;
use super::state::Catalogue;

#[derive(Debug, Clone)]
pub struct Options {
    pub address: IpAddr,
    /// Port of the server; 0 for any free port.
    pub port: u16,
    /// The available scenarios.
    pub catalogue: Catalogue,
    pub first: String,
}

#[derive(Debug, Error)]
pub enum ExploreError {
    #[error("cannot serve on {address}: {source}; give another --port, or --port 0 for any free port")]
    Bind { address: SocketAddr, source: std::io::Error },
    /// The system has no threads or events for a server.
    #[error("cannot serve the page: {0}")]
    System(std::io::Error),
}

#[derive(Debug)]
struct ServerState {
    guard: Guard,
    catalogue: Catalogue,
    /// The name of the first scenario.
    first: String,
    sessions: Arc<Semaphore>,
}

fn bind(address: SocketAddr) -> Result<(TcpListener, SocketAddr), ExploreError> {
    let listener = listen(address).map_err(|source| ExploreError::Bind { address, source })?;
    let bound = listener.local_addr().map_err(ExploreError::System)?;
    Ok((listener, bound))
}

/// Listens like [`TcpListener::bind`], with a longer backlog: a client without room there retries only after a second.
fn listen(address: SocketAddr) -> std::io::Result<TcpListener> {
    let socket = if address.is_ipv4() { TcpSocket::new_v4()? } else { TcpSocket::new_v6()? };
    // On Windows this option has another meaning.
    #[cfg(not(windows))]
    socket.set_reuseaddr(true)?;
    socket.bind(address)?;
    socket.listen(MAX_UNACCEPTED)
}

async fn answer_all(listener: TcpListener, state: Arc<ServerState>) -> std::convert::Infallible {
    accept(listener, Router::new().fallback(move |request: Request<Body>| answer(state.clone(), request))).await
}

/// Serves the page until Ctrl-C or SIGTERM. Calls `ready` with the server's address and the query of the page's
/// address, which contains a token if other machines can reach the server.
///
/// # Errors
/// [`ExploreError`].
pub fn serve(options: Options, ready: impl FnOnce(SocketAddr, &str)) -> Result<(), ExploreError> {
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build();
    let runtime = runtime.map_err(ExploreError::System)?;
    let outcome = runtime.block_on(async {
        let (listener, bound) = bind(SocketAddr::new(options.address, options.port))?;
        let guard = Guard::new(bound);
        let guard = if bound.ip().is_loopback() { guard } else { guard.with_token().map_err(ExploreError::System)? };
        let query = guard.query();
        let sessions = Arc::new(Semaphore::new(MAX_SESSIONS));
        let state = ServerState { guard, catalogue: options.catalogue, first: options.first, sessions };
        let stopped = stopped().map_err(ExploreError::System)?;
        ready(bound, &query);
        tokio::select! {
            never = answer_all(listener, Arc::new(state)) => match never {},
            () = stopped => Ok(()),
        }
    });
    // The threads of the pages end with the process; they have no data to save.
    runtime.shutdown_background();
    outcome
}

fn stopped() -> std::io::Result<impl Future<Output = ()>> {
    #[cfg(unix)]
    {
        use tokio::signal::unix::{SignalKind, signal};
        let (mut interrupt, mut terminate) = (signal(SignalKind::interrupt())?, signal(SignalKind::terminate())?);
        Ok(async move {
            tokio::select! {
                _ = interrupt.recv() => {}
                _ = terminate.recv() => {}
            }
        })
    }
    #[cfg(not(unix))]
    Ok(async {
        // Without a handler, Ctrl-C ends the process.
        if tokio::signal::ctrl_c().await.is_err() {
            std::future::pending::<()>().await;
        }
    })
}

fn refusal(status: u16, reason: &'static str) -> Response<Body> {
    text(status, "text/plain; charset=utf-8", reason)
}

async fn answer(state: Arc<ServerState>, request: Request<Body>) -> Response<Body> {
    if !has_one_host(&request) {
        return refusal(400, "The request names two hosts.\n");
    }
    if !state.guard.admits_host(host(&request)) {
        return refusal(421, "Use the address of this server or localhost.\n");
    }
    if request.method() != Method::GET {
        return refusal(405, "GET only.\n");
    }
    let path = request.uri().path();
    if matches!(path, "/" | "/link") && !state.guard.admits_query(request.uri().query()) {
        return refusal(403, "Open the whole address that trocar printed, with its token.\n");
    }
    if path == "/link" {
        return link(&state, request).await;
    }
    match ASSETS.iter().find(|asset| asset.path == path) {
        Some(asset) => text(200, asset.media, asset.content),
        None => refusal(404, "Not found.\n"),
    }
}

async fn link(state: &ServerState, request: Request<Body>) -> Response<Body> {
    if !state.guard.admits_origin(header(&request, "origin"), host(&request)) {
        return refusal(403, "The server accepts requests from its own pages only.\n");
    }
    let (mut parts, _) = request.into_parts();
    let upgrade = match WebSocketUpgrade::from_request_parts(&mut parts, &()).await {
        Ok(upgrade) => upgrade,
        Err(refused) => return refused.into_response(),
    };
    let Ok(permit) = state.sessions.clone().try_acquire_owned() else {
        return refusal(503, "Too many pages are open; close one.\n");
    };
    let upgrade = upgrade.max_message_size(MAX_MESSAGE_BYTES).max_frame_size(MAX_MESSAGE_BYTES);
    let (catalogue, first) = (state.catalogue.clone(), state.first.clone());
    upgrade.on_upgrade(move |socket| session::serve(socket, catalogue, first, permit))
}
