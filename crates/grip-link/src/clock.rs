//! Clock synchronisation from PONGs: the relation between microcontroller ticks and host time.
//!
//! A PONG gives four times: t1 and t4 of the host (us), rx and tx of the MCU (ticks). Its round trip is
//! RTT = (t4 - t1) - (tx - rx) / f, at least 5 % of the latter. Points with RTT <= 2 RTT_min are kept, the last 64 of them; the middle
//! (rx + tx) / 2 is regressed against (t1 + t4) / 2:
//! ```text
//! tick(t) = m_k + r (t - m_t),   r = f0 + (Sty - f0 Stt) / (Stt + lambda),   lambda = (u / p)^2
//! ```
//! with f0 the nominal tick rate, u = RTT_min / 2 and p = 100 ppm, what a crystal may be off: over a short span the
//! slope stays nominal, over a long one it is the least-squares slope. A point further than 5 sigma from
//! the line is rejected; eight rejections in a row restart with these eight points, as does another boot_id without any. A clock that
//! was rejected so often may have another rate too: p is then wide enough for the
//! eight points to decide, 4 RTT_min over their span.
//! No path is symmetric for sure: the offset is known to u = RTT_min / 2, which is published (D. Mills, RFC 5905).

use crate::message::Pong;

const WINDOW: usize = 64;
const OUTLIERS_TO_RESTART: u8 = 8;
const OUTLIERS: usize = OUTLIERS_TO_RESTART as usize;
/// Widest prior of the rate: beyond it the answers show nothing of it.
const WIDEST: f64 = 0.2;
/// Share of the time inside the MCU that a round trip is not known better than: its clock may run so far off.
const INSIDE: f64 = 0.05;
const CRYSTAL: f64 = 1e-4;
/// Resolution of both clocks \[us\]: no residual spread below it is believed.
const RESOLUTION_US: f64 = 1.0;

/// What became of a PONG.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PongVerdict {
    /// In the regression.
    Kept,
    /// Round trip longer than twice the shortest.
    Slow,
    /// More than 5 sigma off the line.
    Outlier,
    /// Times that cannot be: the answer before the question, or MCU time running back.
    Impossible,
    /// Eight outliers in a row: the estimate started again with these points.
    Restarted,
}

#[derive(Debug, Clone, Copy)]
struct Point {
    /// Host time since the anchor \[us\].
    host_us: f64,
    /// MCU time since the anchor \[ticks\].
    ticks: f64,
    round_trip_us: f64,
}

/// The line through the points.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Line {
    mean_host_us: f64,
    mean_ticks: f64,
    ticks_a_us: f64,
    sigma_us: f64,
}

/// Where the MCU clock stands against the host clock, as of one time: a copy that outlives the estimate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClockRelation {
    line: Line,
    anchor: (u64, u64),
}

/// Estimates where the MCU clock stands against the host clock.
#[derive(Debug, Clone)]
pub struct ClockSync {
    nominal: f64,
    boot_id: u32,
    anchor: Option<(u64, u64)>,
    points: [Point; WINDOW],
    used: usize,
    next: usize,
    shortest_us: f64,
    /// The outliers since the last kept point, with their times of arrival.
    outliers: [(Pong, u64); OUTLIERS],
    in_a_row: u8,
    /// Standard deviation of the rate about the nominal one, before the points show more.
    prior: f64,
    line: Option<Line>,
}

impl ClockSync {
    /// No points yet, for an MCU of `tick_hz` ticks a second.
    #[must_use]
    pub fn new(tick_hz: u32, boot_id: u32) -> Self {
        Self {
            nominal: f64::from(tick_hz) * 1e-6,
            boot_id,
            anchor: None,
            points: [Point { host_us: 0.0, ticks: 0.0, round_trip_us: 0.0 }; WINDOW],
            used: 0,
            next: 0,
            shortest_us: f64::INFINITY,
            outliers: [(Pong { t1_us: 0, rx_tick: 0, tx_tick: 0 }, 0); OUTLIERS],
            in_a_row: 0,
            prior: CRYSTAL,
            line: None,
        }
    }

    /// Boot that the estimate is about.
    #[must_use]
    pub const fn boot_id(&self) -> u32 {
        self.boot_id
    }

    /// Takes a PONG that arrived at host time `t4_us`.
    pub fn push(&mut self, pong: &Pong, t4_us: u64) -> PongVerdict {
        let Some(point) = self.point(pong, t4_us) else { return PongVerdict::Impossible };
        self.shortest_us = self.shortest_us.min(point.round_trip_us);
        let slow = point.round_trip_us > 2.0 * self.shortest_us.max(RESOLUTION_US);
        if self.line.is_some_and(|line| self.is_outlier(&line, &point, slow)) {
            if let Some(slot) = self.outliers.get_mut(usize::from(self.in_a_row)) {
                *slot = (*pong, t4_us);
            }
            self.in_a_row += 1;
            if self.in_a_row < OUTLIERS_TO_RESTART {
                return PongVerdict::Outlier;
            }
            self.restart();
            return PongVerdict::Restarted;
        }
        if slow {
            return PongVerdict::Slow;
        }
        self.in_a_row = 0;
        self.keep(point);
        PongVerdict::Kept
    }

    fn is_outlier(&self, line: &Line, point: &Point, slow: bool) -> bool {
        let off_us = libm::fabs(line.residual_us(point));
        let drift_us = self.prior * libm::fabs(point.host_us - line.mean_host_us);
        let unsure_us = if self.span_us() < 1e7 { drift_us } else { 0.0 };
        // Between two half round trips any asymmetry is possible: that alone makes no outlier. Kept points of one line lie within
        // RTT_min of it: what spreads further is another rate.
        let few = self.used < 4;
        let sigma_us = if few { self.shortest_us } else { line.sigma_us.min(self.shortest_us) };
        let floor_us = sigma_us.max(self.shortest_us / 10.0).max(RESOLUTION_US);
        let trip_us = if slow || few { point.round_trip_us / 2.0 } else { 0.0 };
        let stored = self.points.iter().take(if few { self.used } else { 0 });
        let longest_us = stored.fold(0.0, |most: f64, point| most.max(point.round_trip_us));
        off_us > 5.0 * floor_us + unsure_us + trip_us + longest_us / 2.0
    }

    /// Begins anew with the outliers, whose clock is another one than that of the points before.
    fn restart(&mut self) {
        let outliers = self.outliers;
        *self = Self { nominal: self.nominal, ..Self::new(0, self.boot_id) };
        for (pong, t4_us) in &outliers {
            if let Some(point) = self.point(pong, *t4_us) {
                self.shortest_us = self.shortest_us.min(point.round_trip_us);
                self.put(point);
            }
        }
        self.prior = (4.0 * self.shortest_us.max(RESOLUTION_US) / self.span_us().max(1.0))
            .clamp(CRYSTAL, WIDEST);
        self.fit();
    }

    fn point(&mut self, pong: &Pong, t4_us: u64) -> Option<Point> {
        let trip_us = t4_us.checked_sub(pong.t1_us)?;
        let inside = pong.tx_tick.checked_sub(pong.rx_tick)?;
        let inside_us = inside as f64 / self.nominal;
        let round_trip_us = trip_us as f64 - inside_us;
        if round_trip_us < -RESOLUTION_US - WIDEST * trip_us as f64 {
            return None;
        }
        let (host0, tick0) = *self.anchor.get_or_insert((pong.t1_us, pong.rx_tick));
        Some(Point {
            host_us: distance(pong.t1_us, host0) + trip_us as f64 / 2.0,
            ticks: distance(pong.rx_tick, tick0) + inside as f64 / 2.0,
            round_trip_us: round_trip_us.max(INSIDE * inside_us),
        })
    }

    fn keep(&mut self, point: Point) {
        self.put(point);
        self.fit();
    }

    fn put(&mut self, point: Point) {
        if let Some(slot) = self.points.get_mut(self.next) {
            *slot = point;
        }
        self.next = (self.next + 1) % WINDOW;
        self.used = (self.used + 1).min(WINDOW);
    }

    fn kept(&self) -> impl Iterator<Item = &Point> {
        let limit_us = 2.0 * self.shortest_us.max(RESOLUTION_US);
        self.points.iter().take(self.used).filter(move |point| point.round_trip_us <= limit_us)
    }

    fn span_us(&self) -> f64 {
        let ends = self.kept().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), point| {
            (low.min(point.host_us), high.max(point.host_us))
        });
        ends.1 - ends.0
    }

    fn fit(&mut self) {
        let (count, host, ticks) = self.kept().fold((0.0, 0.0, 0.0), |(n, h, k), point| {
            (n + 1.0, h + point.host_us, k + point.ticks)
        });
        if count < 1.0 {
            self.line = None;
            return;
        }
        let (mean_host_us, mean_ticks) = (host / count, ticks / count);
        let (spread, product) = self.kept().fold((0.0, 0.0), |(spread, product), point| {
            let dt = point.host_us - mean_host_us;
            (spread + dt * dt, product + dt * (point.ticks - mean_ticks))
        });
        let unsure = self.uncertainty_us().max(RESOLUTION_US) / self.prior;
        let ticks_a_us =
            self.nominal + (product - self.nominal * spread) / (spread + unsure * unsure);
        let mut line = Line { mean_host_us, mean_ticks, ticks_a_us, sigma_us: 0.0 };
        let squares =
            self.kept().map(|point| line.residual_us(point)).fold(0.0, |sum, r| sum + r * r);
        line.sigma_us = libm::sqrt(squares / (count - 2.0).max(1.0));
        self.line = Some(line);
    }

    /// RTT_min / 2: bound of the offset error that an asymmetric path can make \[us\]; infinite before the first point.
    #[must_use]
    pub fn uncertainty_us(&self) -> f64 {
        self.shortest_us / 2.0
    }

    /// Standard deviation of the kept points about the line \[us\].
    #[must_use]
    pub fn sigma_us(&self) -> Option<f64> {
        self.line.map(|line| line.sigma_us)
    }

    /// How much faster than nominal the MCU clock runs against the host's \[ppm\].
    #[must_use]
    pub fn drift_ppm(&self) -> Option<f64> {
        self.line.map(|line| (line.ticks_a_us / self.nominal - 1.0) * 1e6)
    }

    /// How far the MCU clock is certainly off its nominal rate (1e-2 for 1 %, positive where it is fast), beyond what the round trips
    /// leave open; 0 where they leave it open, `None` before there are points over 300 ms.
    #[must_use]
    pub fn rate_error(&self) -> Option<f64> {
        let off = self.drift_ppm()? * 1e-6;
        let span_us = self.span_us();
        let unsure = self.shortest_us / span_us;
        (span_us >= 3e5).then(|| libm::copysign((libm::fabs(off) - unsure).max(0.0), off))
    }

    /// Points in the regression.
    #[must_use]
    pub fn points(&self) -> usize {
        self.kept().count()
    }

    /// Host time of an MCU tick \[us\]; `None` before the first point or for a time before host zero.
    #[must_use]
    pub fn host_us(&self, tick: u64) -> Option<u64> {
        self.relation()?.host_us(tick)
    }

    /// The relation of both clocks as of now; `None` before the first point.
    #[must_use]
    pub fn relation(&self) -> Option<ClockRelation> {
        Some(ClockRelation { line: self.line?, anchor: self.anchor? })
    }

    /// MCU tick at a host time \[us\]; `None` before the first point or for a time before tick zero.
    #[must_use]
    pub fn tick(&self, host_us: u64) -> Option<u64> {
        let (line, (host0, tick0)) = (self.line?, self.anchor?);
        moved(
            tick0,
            line.mean_ticks + (distance(host_us, host0) - line.mean_host_us) * line.ticks_a_us,
        )
    }
}

impl ClockRelation {
    /// Host time of an MCU tick \[us\]; `None` for a time before host zero.
    #[must_use]
    pub fn host_us(&self, tick: u64) -> Option<u64> {
        let Self { line, anchor: (host0, tick0) } = *self;
        let since_us =
            line.mean_host_us + (distance(tick, tick0) - line.mean_ticks) / line.ticks_a_us;
        moved(host0, since_us)
    }
}

impl Line {
    fn residual_us(&self, point: &Point) -> f64 {
        (point.ticks - self.mean_ticks) / self.ticks_a_us - (point.host_us - self.mean_host_us)
    }
}

/// `a - b`, exact up to 2^53.
fn distance(a: u64, b: u64) -> f64 {
    if a >= b { (a - b) as f64 } else { -((b - a) as f64) }
}

fn moved(from: u64, by: f64) -> Option<u64> {
    let rounded = libm::round(by);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a whole number, not negative; the conversion saturates"
    )]
    let steps = libm::fabs(rounded) as u64;
    if rounded < 0.0 { from.checked_sub(steps) } else { from.checked_add(steps) }
}
