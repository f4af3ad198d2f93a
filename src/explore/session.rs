//! One request after the other.

use std::time::Instant;

use axum::extract::ws::{Message, WebSocket};

use super::controls::greeting;
use super::page::Page;
use super::protocol::ServerMessage;
use super::state::Catalogue;

/// Serves a page until it closes or sends an invalid message.
pub(super) async fn serve(mut socket: WebSocket, catalogue: Catalogue, first: String) {
    let began = Instant::now();
    if socket.send(message(greeting(&catalogue, &first))).await.is_err() {
        return;
    }
    let mut page = Page::new(catalogue);
    while let Some(Ok(received)) = socket.recv().await {
        let Message::Text(text) = received else { continue };
        let Ok(request) = serde_json::from_str(&text) else { return };
        // A computation must not block other pages.
        let answer = tokio::task::block_in_place(|| page.answer(request, &|| began.elapsed().as_secs_f64()));
        if let Some(answer) = answer
            && socket.send(message(answer)).await.is_err()
        {
            return;
        }
    }
}

fn message(answer: ServerMessage) -> Message {
    match answer {
        ServerMessage::Text(text) => Message::Text(text.into()),
        ServerMessage::Frame(bytes) => Message::Binary(bytes.into()),
    }
}
