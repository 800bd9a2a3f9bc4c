//! Whether there are certificates, and the router before this one, in; how a session or a router of this program is configured out.

use super::Args;
use grip_fleet::net::Network;
use serde_json::{Value, json};
use std::{io::Write as _, path::Path};
use tempfile::NamedTempFile;

/// A network, and the file that configures it, which goes with it.
pub(crate) struct Way {
    pub(crate) network: Network,
    _file: NamedTempFile,
}

/// The way of a client to a router.
pub(crate) fn client(args: &Args, address: &str) -> anyhow::Result<Way> {
    way(address, &json!({ "transport": { "link": { "tls": keys(args.quic.as_deref()) } } }))
}

/// A router that listens there, and connects to the one before it.
pub(crate) fn router(args: &Args, address: &str, before: Option<&str>) -> anyhow::Result<Way> {
    let before: Vec<&str> = before.into_iter().collect();
    let tls = keys(args.quic.as_deref());
    let transport = json!({ "unicast": { "max_sessions": 10_000 }, "link": { "tls": tls } });
    way(address, &json!({ "connect": { "endpoints": before }, "transport": transport }))
}

fn way(address: &str, config: &Value) -> anyhow::Result<Way> {
    let mut file = NamedTempFile::with_suffix(".json5")?;
    file.write_all(config.to_string().as_bytes())?;
    let network = Network { router: Some(address.to_owned()), file: Some(file.path().to_owned()) };
    Ok(Way { network, _file: file })
}

/// Keys and certificates of `certificates.sh FOLDER localhost 127.0.0.1 scale`.
fn keys(folder: Option<&Path>) -> Value {
    let Some(folder) = folder else { return json!({}) };
    let path = |name: &str| folder.join(name).display().to_string();
    json!({
        "enable_mtls": true,
        "root_ca_certificate": path("authority.pem"),
        "listen_private_key": path("router.key"),
        "listen_certificate": path("router.pem"),
        "connect_private_key": path("scale.key"),
        "connect_certificate": path("scale.pem"),
    })
}
