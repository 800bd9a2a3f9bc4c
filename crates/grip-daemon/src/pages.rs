//! The path of a request and the board in; the page out.

use crate::{
    board::Board,
    exposition::{Exposition, MEDIA_TYPE},
    http::{Page, Refusal},
    metrics,
    status::Status,
};

/// `/metrics` for Prometheus, `/status` as JSON, `/healthz` (200 while samples flow, else 503), and `/`, which names them.
/// `now_us` is host time (us); `exposition` lends its memory.
///
/// # Errors
/// [`Refusal`] where there is no such page, it cannot be made, or the health is not good.
pub fn page(board: &Board, now_us: u64, exposition: &mut Exposition, path: &str) -> Page {
    match path {
        "/metrics" => {
            metrics::write(board, now_us, exposition);
            Ok((MEDIA_TYPE, exposition.text().to_owned()))
        }
        "/status" => {
            let json = Status::of(board, now_us).json().map_err(|_| Refusal::Internal)?;
            Ok(("application/json", format!("{json}\n")))
        }
        "/healthz" if board.is_healthy() => Ok(("text/plain; charset=utf-8", "ok\n".to_owned())),
        "/healthz" => Err(Refusal::Unavailable),
        "/" => {
            let text = "gripd: /metrics, /status, /healthz\n".to_owned();
            Ok(("text/plain; charset=utf-8", text))
        }
        _ => Err(Refusal::NotFound),
    }
}
