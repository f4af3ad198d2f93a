//! Embedded in the binary. Reports share some of them.

use trocar_report::html::assets as shared;

#[derive(Debug, Clone, Copy)]
pub(super) struct Asset {
    pub path: &'static str,
    pub media: &'static str,
    pub content: &'static str,
}

const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const JAVASCRIPT: &str = "text/javascript; charset=utf-8";
const SVG: &str = "image/svg+xml";

/// All files of the page of `trocar explore`.
pub(super) const ASSETS: &[Asset] = &[
    Asset { path: "/", media: HTML, content: include_str!("index.html") },
    Asset { path: "/explore.css", media: CSS, content: include_str!("explore.css") },
    Asset { path: "/theme.css", media: CSS, content: shared::THEME_CSS },
    Asset { path: "/charts.js", media: JAVASCRIPT, content: shared::CHARTS_JS },
    Asset { path: "/animation.js", media: JAVASCRIPT, content: shared::ANIMATION_JS },
    Asset { path: "/link.js", media: JAVASCRIPT, content: include_str!("link.js") },
    Asset { path: "/controls.js", media: JAVASCRIPT, content: include_str!("controls.js") },
    Asset { path: "/pictures.js", media: JAVASCRIPT, content: include_str!("pictures.js") },
    Asset { path: "/map.js", media: JAVASCRIPT, content: include_str!("map.js") },
    Asset { path: "/listen.js", media: JAVASCRIPT, content: include_str!("listen.js") },
    Asset { path: "/push.js", media: JAVASCRIPT, content: include_str!("push.js") },
    Asset { path: "/explore.js", media: JAVASCRIPT, content: include_str!("explore.js") },
    Asset { path: "/icon.svg", media: SVG, content: include_str!("icon.svg") },
];
