//! The page's server.

use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;

use axum::Router;
use axum::body::Body;
use axum::extract::FromRequestParts;
use axum::extract::ws::WebSocketUpgrade;
use axum::http::{Method, Request, Response};
use axum::response::IntoResponse;
use thiserror::Error;
use tokio::net::TcpListener;
use tokio::sync::Semaphore;

use super::assets::ASSETS;
use super::connections::{accept, header, host, text};
use super::guard::Guard;
use super::limits::{MAX_MESSAGE_BYTES, MAX_SESSIONS};
use super::session;
use super::state::Catalogue;

/// Where to serve what.
#[derive(Debug, Clone)]
pub struct Options {
    /// The address to bind to.
    pub address: IpAddr,
    /// The port; 0 lets the system choose.
    pub port: u16,
    /// The scenarios.
    pub catalogue: Catalogue,
    /// The scenario that is shown first, by its name in the catalogue.
    pub first: String,
}

/// Why there is no page.
#[derive(Debug, Error)]
pub enum ExploreError {
    /// The address cannot be bound to.
    #[error("{address} cannot be served on: {source}; give another --port, or --port 0 for any that is free")]
    Bind {
        /// The address.
        address: SocketAddr,
        /// Why.
        source: std::io::Error,
    },
    /// The system gives no threads or events to a server.
    #[error("the page cannot be served: {0}")]
    System(std::io::Error),
}

/// What every request is answered from.
#[derive(Debug)]
struct RunWorker {
    guard: Guard,
    catalogue: Catalogue,
    first: String,
    sessions: Arc<Semaphore>,
}

/// Serves the page until Ctrl-C or SIGTERM; `ready` is told the address once it is there.
///
/// # Errors
/// [`ExploreError`].
pub fn serve(options: Options, ready: impl FnOnce(SocketAddr)) -> Result<(), ExploreError> {
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build();
    let runtime = runtime.map_err(ExploreError::System)?;
    let outcome = runtime.block_on(async {
        let address = SocketAddr::new(options.address, options.port);
        let listener = TcpListener::bind(address).await.map_err(|source| ExploreError::Bind { address, source })?;
        let bound = listener.local_addr().map_err(ExploreError::System)?;
        let desk = Arc::new(RunWorker {
            guard: Guard::new(bound),
            catalogue: options.catalogue,
            first: options.first,
            sessions: Arc::new(Semaphore::new(MAX_SESSIONS)),
        });
        let router = Router::new().fallback(move |request: Request<Body>| answer(desk.clone(), request));
        let stopped = stopped().map_err(ExploreError::System)?;
        ready(bound);
        tokio::select! {
            never = accept(listener, router) => match never {},
            () = stopped => Ok(()),
        }
    });
    // Pages' threads end with the program; none of them holds anything that could be lost.
    runtime.shutdown_background();
    outcome
}

/// Resolves at Ctrl-C or SIGTERM, which are listened to from now on.
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
        // Where nothing can listen, Ctrl-C ends the program as ever.
        if tokio::signal::ctrl_c().await.is_err() {
            std::future::pending::<()>().await;
        }
    })
}

/// What is said where there is nothing to give.
fn refusal(status: u16, reason: &'static str) -> Response<Body> {
    text(status, "text/plain; charset=utf-8", reason)
}

async fn answer(desk: Arc<RunWorker>, request: Request<Body>) -> Response<Body> {
    if !desk.guard.admits_host(host(&request)) {
        return refusal(421, "This server is addressed by its address or as localhost.\n");
    }
    if request.method() != Method::GET {
        return refusal(405, "GET only.\n");
    }
    if request.uri().path() == "/link" {
        return link(&desk, request).await;
    }
    match ASSETS.iter().find(|asset| asset.path == request.uri().path()) {
        Some(asset) => text(200, asset.media, asset.content),
        None => refusal(404, "There is nothing here.\n"),
    }
}

/// A page's WebSocket.
async fn link(desk: &RunWorker, request: Request<Body>) -> Response<Body> {
    if !desk.guard.admits_origin(header(&request, "origin"), host(&request)) {
        return refusal(403, "Only pages of this server may talk to it.\n");
    }
    let (mut parts, _) = request.into_parts();
    let upgrade = match WebSocketUpgrade::from_request_parts(&mut parts, &()).await {
        Ok(upgrade) => upgrade,
        Err(refused) => return refused.into_response(),
    };
    let Ok(permit) = desk.sessions.clone().try_acquire_owned() else {
        return refusal(503, "Too many pages are open; close one.\n");
    };
    let (catalogue, first) = (desk.catalogue.clone(), desk.first.clone());
    upgrade
        .max_message_size(MAX_MESSAGE_BYTES)
        .max_frame_size(MAX_MESSAGE_BYTES)
        .on_upgrade(move |socket| session::serve(socket, catalogue, first, permit))
}
