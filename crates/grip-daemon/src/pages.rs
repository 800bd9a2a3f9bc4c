//! Pages of the HTTP server, from the path of a request and the board.

use crate::{
    board::Board,
    exposition::{Exposition, MEDIA_TYPE},
    http::{Content, Page, Refusal},
    live::Feed,
    metrics,
    status::Status,
};

/// `/metrics` for Prometheus, `/status` as JSON, `/healthz` (200 while samples flow, else 503), and `/`, a page for a browser with its
/// files and the stream `/events`.
/// `now_us` is host time (us); `exposition` lends its memory.
///
/// # Errors
/// [`Refusal`] where there is no such page, it cannot be made, or the health is not good.
pub fn page(board: &Board, now_us: u64, exposition: &mut Exposition, path: &str) -> Page {
    let plain = |text| Ok(Content::whole("text/plain; charset=utf-8", text));
    let script = |text| Ok(Content::whole("text/javascript; charset=utf-8", text));
    match path {
        "/metrics" => {
            metrics::write(board, now_us, exposition);
            Ok(Content::whole(MEDIA_TYPE, exposition.text().to_owned()))
        }
        "/status" => {
            let json = Status::of(board, now_us).json().map_err(|_| Refusal::Internal)?;
            Ok(Content::whole("application/json", format!("{json}\n")))
        }
        "/healthz" if board.is_healthy() => plain("ok\n"),
        "/healthz" => Err(Refusal::Unavailable),
        "/" => Ok(Content::whole("text/html; charset=utf-8", include_str!("web/page.html"))),
        "/page.css" => Ok(Content::whole("text/css; charset=utf-8", include_str!("web/page.css"))),
        "/page.js" => script(include_str!("web/page.js")),
        "/uplot.js" => script(include_str!("web/uPlot.iife.min.js")),
        "/uplot.license" => plain(include_str!("web/uPlot.LICENSE")),
        "/events" => {
            let all = Feed::default().next(board, now_us, 1).ok_or(Refusal::Internal)?;
            Ok(Content { media_type: "text/event-stream", text: all.into(), more: true })
        }
        _ => Err(Refusal::NotFound),
    }
}
