//! A board that measures as an end, on a line of its own: its rows as datagrams.
//!
//! The board is asked for its samples over the ordinary link. Its rows go on by their numbers; what a new start of the board or a lost
//! line left out is counted by the clock of this computer.

use super::line::{Condition, End};
use core::fmt::Write as _;
use grip_link::{
    frame::MAX_WIRE,
    host::{HostConfig as LinkConfig, HostEvent, HostLink, LinkState},
    message::{ChannelKind, Column, SamplesHeader, Unit},
};
use grip_port::nonce;
use grip_session::{HostConfig, session::device_config, session::explain};
use std::os::unix::net::UnixDatagram;

/// Bytes after which a datagram is sent, whatever follows; a reader takes four times as many.
const LONGEST: usize = 4096;

/// The end.
#[derive(Debug)]
pub(super) struct SensorBoard {
    link: HostLink,
    rows: UnixDatagram,
    /// The columns that rows carry, and the header that names them.
    columns: Vec<Column>,
    header: String,
    period_us: u64,
    /// Number of the next row, and what the board calls it; when the last one came (us).
    next: u32,
    board: Option<u32>,
    came_us: Option<u64>,
    packed: Vec<u8>,
    reason: Option<String>,
}

impl SensorBoard {
    pub(super) fn new(config: &HostConfig, rows: UnixDatagram) -> Result<Self, String> {
        let link = HostLink::new(LinkConfig::new(device_config(config)));
        Ok(Self {
            link: link.map_err(|error| error.to_string())?,
            rows,
            columns: Vec::new(),
            header: String::new(),
            period_us: 0,
            next: 0,
            board: None,
            came_us: None,
            packed: Vec::new(),
            reason: None,
        })
    }

    fn handle(&mut self, now_us: u64, event: HostEvent) {
        match event {
            HostEvent::Configured { .. } => self.begin(),
            HostEvent::Samples { header, .. } => self.send(now_us, header),
            HostEvent::Closed(reason) => self.reason = Some(explain(&reason)),
            _ => {}
        }
    }

    /// The board has taken its CONFIG: the header is sent where it is new.
    fn begin(&mut self) {
        self.board = None;
        let Some(rate_hz) = self.link.in_force().map(|config| config.sample_rate_hz) else {
            return;
        };
        let ident = self.link.ident();
        let unit = ident.and_then(|ident| {
            ident.channels().iter().find(|channel| channel.kind == ChannelKind::Stylus)
        });
        let is_metre = unit.is_some_and(|channel| channel.unit == Unit::Metre);
        let (mut header, mut columns) = (String::new(), Vec::new());
        for column in self.link.layout().columns() {
            let before = header.len();
            if column.kind == ChannelKind::PressureArray {
                (0..column.count).for_each(|taxel| {
                    let _written = write!(header, "pressure_{taxel},");
                });
            } else if let Some(name) = name(column.kind, is_metre) {
                let _written = write!(header, "{name},");
            }
            if header.len() > before {
                columns.push(*column);
            }
        }
        let _written = write!(header, "rate={rate_hz},format=f32");
        if self.header.is_empty() {
            let _sent = self.rows.send(header.as_bytes());
        } else if self.header != header {
            self.reason = Some("the board offers other channels or another rate now".to_owned());
            return;
        }
        self.period_us = 1_000_000_u64.checked_div(u64::from(rate_hz)).unwrap_or(1).max(1);
        (self.header, self.columns) = (header, columns);
    }

    fn send(&mut self, now_us: u64, header: SamplesHeader) {
        let Self { link, columns, packed, rows, .. } = self;
        let Some(samples) = link.samples(header).filter(|_| !columns.is_empty()) else { return };
        let skipped = match self.board {
            Some(board) => header.first_index.wrapping_sub(board),
            None => self.came_us.map_or(0, |came_us| {
                let periods = now_us.saturating_sub(came_us) / self.period_us;
                u32::try_from(periods).unwrap_or(u32::MAX)
            }),
        };
        if skipped > 0 || packed.len() > LONGEST {
            flush(packed, rows);
        }
        self.next = self.next.wrapping_add(skipped);
        if packed.is_empty() {
            packed.extend(self.next.to_le_bytes());
        }
        for row in samples.rows() {
            for column in columns.iter() {
                let values = (0..column.count).map(|k| row.value(column, k).unwrap_or(f32::NAN));
                packed.extend(values.flat_map(f32::to_le_bytes));
            }
        }
        let count = u32::from(header.rows);
        self.next = self.next.wrapping_add(count);
        self.board = Some(header.first_index.wrapping_add(count));
        self.came_us = Some(now_us);
    }
}

impl End for SensorBoard {
    fn opened(&mut self, now_us: u64) {
        self.reason = None;
        // A nonce is never 0, which alone is refused.
        let _opened = self.link.open(now_us, nonce());
    }

    fn closed(&mut self, _now_us: u64) {
        self.link.close();
    }

    fn receive(&mut self, now_us: u64, bytes: &[u8]) {
        let mut left = bytes;
        while let Some(event) = self.link.receive(now_us, &mut left) {
            self.handle(now_us, event);
        }
        flush(&mut self.packed, &self.rows);
    }

    fn poll_transmit(&mut self, now_us: u64, out: &mut Vec<u8>) -> bool {
        self.receive(now_us, &[]);
        let mut frame = [0; MAX_WIRE];
        let Some(length) = self.link.poll_transmit(now_us, &mut frame) else { return false };
        out.clear();
        out.extend(frame.iter().take(length));
        true
    }

    fn condition(&self, _now_us: u64) -> Condition {
        match (&self.reason, self.link.state()) {
            (Some(reason), _) => Condition::Waiting(reason.clone()),
            (None, LinkState::Stream) => Condition::Ready,
            (None, _) => Condition::Waiting("no samples".to_owned()),
        }
    }

    fn is_lost(&self) -> bool {
        self.reason.is_some() || self.link.state() == LinkState::Closed
    }
}

/// Sends what is packed. What finds no room is missing, which the number of the next datagram shows.
fn flush(packed: &mut Vec<u8>, rows: &UnixDatagram) {
    if !packed.is_empty() {
        let _lost = rows.send(packed);
        packed.clear();
    }
}

/// The name of a channel of one value among the rows; `None` where rows do not have it.
fn name(kind: ChannelKind, is_metre: bool) -> Option<&'static str> {
    Some(match kind {
        ChannelKind::Stylus if is_metre => "stylus",
        ChannelKind::Stylus => "vibration",
        ChannelKind::NormalForce => "force_n",
        ChannelKind::TangentialForce => "tangential_n",
        ChannelKind::Travel => "travel_m",
        ChannelKind::Velocity => "velocity_m_s",
        ChannelKind::SecondStylus => "stylus2",
        ChannelKind::Reference => "reference",
        ChannelKind::Pressure => "pressure",
        _ => return None,
    })
}
