//! What the page is made of, carried in the binary.

/// One file of the page.
#[derive(Debug, Clone, Copy)]
pub(super) struct Asset {
    /// Where the page finds it.
    pub path: &'static str,
    /// Its media type.
    pub media: &'static str,
    /// Its bytes.
    pub content: &'static str,
}

macro_rules! assets {
    ($($path:literal, $media:literal, $file:literal;)*) => {
        &[$(Asset { path: $path, media: $media, content: include_str!(concat!("../../web/", $file)) }),*]
    };
}

/// All of them.
pub(super) const ASSETS: &[Asset] = assets! {
    "/", "text/html; charset=utf-8", "explore/index.html";
    "/explore.css", "text/css; charset=utf-8", "explore/explore.css";
    "/theme.css", "text/css; charset=utf-8", "theme.css";
    "/uPlot.min.css", "text/css; charset=utf-8", "uplot/uPlot.min.css";
    "/uPlot.iife.min.js", "text/javascript; charset=utf-8", "uplot/uPlot.iife.min.js";
    "/uPlot.LICENSE", "text/plain; charset=utf-8", "uplot/LICENSE";
    "/charts.js", "text/javascript; charset=utf-8", "charts.js";
    "/link.js", "text/javascript; charset=utf-8", "explore/link.js";
    "/controls.js", "text/javascript; charset=utf-8", "explore/controls.js";
    "/pictures.js", "text/javascript; charset=utf-8", "explore/pictures.js";
    "/map.js", "text/javascript; charset=utf-8", "explore/map.js";
    "/listen.js", "text/javascript; charset=utf-8", "explore/listen.js";
    "/push.js", "text/javascript; charset=utf-8", "explore/push.js";
    "/explore.js", "text/javascript; charset=utf-8", "explore/explore.js";
    "/icon.svg", "image/svg+xml", "explore/icon.svg";
};
