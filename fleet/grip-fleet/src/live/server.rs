//! WebSocket server of the messages of a live view, for Foxglove apps.

use super::{Topic, Wanted};
use core::{
    net::SocketAddr,
    sync::atomic::{AtomicU64, Ordering},
    time::Duration,
};
use foxglove::{
    ChannelBuilder, Context, FoxgloveError, PartialMetadata, RawChannel, Schema, WebSocketServer,
    WebSocketServerHandle,
    websocket::{ChannelView, Client, ServerListener, Status},
};
use grip_record::mcap::{MESSAGE_ENCODING, SCHEMA_ENCODING};
use std::{
    sync::{Arc, mpsc},
    thread,
};

/// Messages that wait for an app; with more the oldest go. More than a second at 10 kHz.
const BACKLOG: usize = 16_384;

/// Why no app can be served.
#[derive(Debug, thiserror::Error)]
pub enum ServeError {
    /// Other computers could connect, and nobody said that they may.
    #[error("{0} is open to other computers")]
    Remote(SocketAddr),
    /// The system does not let it listen there.
    #[error("cannot listen at {address}: {source}")]
    Bind {
        /// Where.
        address: SocketAddr,
        /// Why.
        source: std::io::Error,
    },
    /// The library refuses.
    #[error("cannot serve Foxglove: {0}")]
    Foxglove(FoxgloveError),
}

/// Serves the topics of one daemon to any number of apps. Its threads are those of the library; nothing here waits for an app.
pub struct Server {
    handle: WebSocketServerHandle,
    /// In the order of [`Topic::ALL`].
    channels: Vec<Arc<RawChannel>>,
    address: SocketAddr,
    newcomers: Arc<Newcomers>,
    // Channels are closed where it ends.
    _context: Arc<Context>,
}

impl core::fmt::Debug for Server {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Server").field("address", &self.address).finish_non_exhaustive()
    }
}

/// Counts subscriptions.
#[derive(Debug, Default)]
struct Newcomers(AtomicU64);

impl ServerListener for Newcomers {
    fn on_subscribe(&self, _client: Client, _channel: ChannelView<'_>) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }
}

impl Server {
    /// Listens at `address`, which must be a loopback address unless `allow_remote`; `name` is what apps show.
    ///
    /// # Errors
    /// [`ServeError`].
    pub fn start(address: SocketAddr, allow_remote: bool, name: &str) -> Result<Self, ServeError> {
        if !allow_remote && !address.ip().to_canonical().is_loopback() {
            return Err(ServeError::Remote(address));
        }
        let context = Context::new();
        let channels = Topic::ALL.into_iter().map(|topic| channel(&context, topic));
        let channels = channels.collect::<Result<_, _>>().map_err(ServeError::Foxglove)?;
        let newcomers = Arc::new(Newcomers::default());
        let host = match address {
            SocketAddr::V4(address) => address.ip().to_string(),
            SocketAddr::V6(address) => format!("[{}]", address.ip()),
        };
        let listener: Arc<dyn ServerListener> = Arc::<Newcomers>::clone(&newcomers);
        let handle = WebSocketServer::new()
            .context(&context)
            .name(name)
            .bind(host, address.port())
            .message_backlog_size(BACKLOG)
            .listener(listener)
            .start_blocking()
            .map_err(|error| match error {
                FoxgloveError::Bind(source) => ServeError::Bind { address, source },
                other => ServeError::Foxglove(other),
            })?;
        let address = SocketAddr::new(address.ip(), handle.port());
        Ok(Self { handle, channels, address, newcomers, _context: context })
    }

    /// Where it really listens: with the port that the system chose for port 0.
    #[must_use]
    pub const fn address(&self) -> SocketAddr {
        self.address
    }

    /// What some app shows now.
    #[must_use]
    pub fn wanted(&self) -> Wanted {
        Wanted::of(|topic| self.channel(topic).is_some_and(|channel| channel.has_sinks()))
    }

    /// Subscriptions so far: another number states that somebody looks who has seen nothing yet.
    #[must_use]
    pub fn subscriptions(&self) -> u64 {
        self.newcomers.0.load(Ordering::Relaxed)
    }

    /// Hands a message to the apps that show its topic.
    pub fn publish(&self, topic: Topic, log_ns: u64, bytes: &[u8]) {
        if let Some(channel) = self.channel(topic) {
            channel.log_with_meta(bytes, PartialMetadata::with_log_time(log_ns));
        }
    }

    fn channel(&self, topic: Topic) -> Option<&RawChannel> {
        self.channels.get(topic.index()).map(AsRef::as_ref)
    }

    /// Warns everybody; a warning of the same name is replaced.
    pub fn warn(&self, name: &str, text: &str) {
        self.handle.publish_status(Status::warning(text).with_id(name));
    }

    /// Takes a warning back.
    pub fn settle(&self, name: &str) {
        self.handle.remove_status(vec![name.to_owned()]);
    }

    /// Takes leave of the apps and waits for them at most so long.
    pub fn stop(self, patience: Duration) {
        let shutdown = self.handle.stop();
        let (ended, end) = mpsc::channel();
        thread::spawn(move || {
            shutdown.wait_blocking();
            // Nobody waits any more: it has taken too long.
            let _late = ended.send(());
        });
        // An app that takes nothing is left to the end of the program.
        let _waited = end.recv_timeout(patience);
    }
}

fn channel(context: &Arc<Context>, topic: Topic) -> Result<Arc<RawChannel>, FoxgloveError> {
    let definition = topic.definition().into_bytes();
    ChannelBuilder::new(topic.name())
        .context(context)
        .message_encoding(MESSAGE_ENCODING)
        .schema(Schema::new(topic.schema(), SCHEMA_ENCODING, definition))
        .build_raw()
}
