"""PONGs in, the relation between microcontroller ticks and host time out.

A PONG gives t1 and t4 of the host (us), rx and tx of the MCU (ticks): RTT = (t4 - t1) - (tx - rx) / f. Points with
RTT <= 2 RTT_min are kept, the last 64 of them; the middle (rx + tx) / 2 is regressed against (t1 + t4) / 2 with the
slope drawn to the nominal tick rate while the span is short (crystals are off by at most 100 ppm). A point over
5 sigma off the line is rejected; eight in a row restart with these points, and their rate may be off by 4 RTT_min over
their span. The offset is known to RTT_min / 2 (RFC 5905).
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from enum import Enum
from typing import Optional

from .messages import Pong

_WINDOW = 64
_OUTLIERS_TO_RESTART = 8
_CRYSTAL = 1e-4
_WIDEST = 0.2
_INSIDE = 0.05
_RESOLUTION_US = 1.0


class PongVerdict(Enum):
    """What became of a PONG."""

    KEPT = "kept"
    SLOW = "slow"
    OUTLIER = "outlier"
    IMPOSSIBLE = "impossible"
    RESTARTED = "restarted"


@dataclass(frozen=True)
class _Point:
    host_us: float
    ticks: float
    round_trip_us: float


@dataclass(frozen=True)
class _Line:
    mean_host_us: float
    mean_ticks: float
    ticks_a_us: float
    sigma_us: float = 0.0

    def residual_us(self, point: _Point) -> float:
        return (point.ticks - self.mean_ticks) / self.ticks_a_us - (point.host_us - self.mean_host_us)


class ClockSync:
    """Estimates where the MCU clock of one boot stands against the host clock."""

    def __init__(self, tick_hz: int, boot_id: int) -> None:
        self.boot_id = boot_id
        self._nominal = tick_hz * 1e-6
        self._restart()

    def _restart(self) -> None:
        self._anchor: Optional[tuple[int, int]] = None
        self._points: deque[_Point] = deque(maxlen=_WINDOW)
        self._shortest_us = math.inf
        self._outliers: list[tuple[Pong, int]] = []
        self._prior = _CRYSTAL
        self._line: Optional[_Line] = None

    def push(self, pong: Pong, t4_us: int) -> PongVerdict:
        """Takes a PONG that arrived at host time ``t4_us``."""
        point = self._point(pong, t4_us)
        if point is None:
            return PongVerdict.IMPOSSIBLE
        self._shortest_us = min(self._shortest_us, point.round_trip_us)
        slow = point.round_trip_us > 2.0 * max(self._shortest_us, _RESOLUTION_US)
        if self._line is not None and self._is_outlier(self._line, point, slow):
            self._outliers.append((pong, t4_us))
            if len(self._outliers) < _OUTLIERS_TO_RESTART:
                return PongVerdict.OUTLIER
            self._restart_with(self._outliers)
            return PongVerdict.RESTARTED
        if slow:
            return PongVerdict.SLOW
        self._outliers = []
        self._points.append(point)
        self._line = self._fit()
        return PongVerdict.KEPT

    def _restart_with(self, outliers: list[tuple[Pong, int]]) -> None:
        self._restart()
        for pong, t4_us in outliers:
            point = self._point(pong, t4_us)
            if point is not None:
                self._shortest_us = min(self._shortest_us, point.round_trip_us)
                self._points.append(point)
        hosts = [point.host_us for point in self._kept()]
        span_us = max(hosts) - min(hosts) if hosts else 0.0
        self._prior = min(max(4.0 * max(self._shortest_us, _RESOLUTION_US) / max(span_us, 1.0), _CRYSTAL), _WIDEST)
        self._line = self._fit()

    def _point(self, pong: Pong, t4_us: int) -> Optional[_Point]:
        trip_us, inside = t4_us - pong.t1_us, pong.tx_tick - pong.rx_tick
        if trip_us < 0 or inside < 0:
            return None
        inside_us = inside / self._nominal
        round_trip_us = trip_us - inside_us
        if round_trip_us < -_RESOLUTION_US - _WIDEST * trip_us:
            return None
        if self._anchor is None:
            self._anchor = (pong.t1_us, pong.rx_tick)
        host0, tick0 = self._anchor
        return _Point(pong.t1_us - host0 + trip_us / 2, pong.rx_tick - tick0 + inside / 2, max(round_trip_us, _INSIDE * inside_us))

    def _is_outlier(self, line: _Line, point: _Point, slow: bool) -> bool:
        drift_us = self._prior * abs(point.host_us - line.mean_host_us)
        hosts = [kept.host_us for kept in self._kept()]
        unsure_us = drift_us if not hosts or max(hosts) - min(hosts) < 1e7 else 0.0
        few = len(self._points) < 4
        trip_us = point.round_trip_us / 2 if slow or few else 0.0
        longest_us = max((stored.round_trip_us for stored in self._points), default=0.0) if few else 0.0
        sigma_us = self._shortest_us if few else min(line.sigma_us, self._shortest_us)
        floor_us = max(sigma_us, self._shortest_us / 10.0, _RESOLUTION_US)
        return abs(line.residual_us(point)) > 5.0 * floor_us + unsure_us + trip_us + longest_us / 2

    def _kept(self) -> list[_Point]:
        limit_us = 2.0 * max(self._shortest_us, _RESOLUTION_US)
        return [point for point in self._points if point.round_trip_us <= limit_us]

    def _fit(self) -> Optional[_Line]:
        kept = self._kept()
        if not kept:
            return None
        host = math.fsum(point.host_us for point in kept) / len(kept)
        ticks = math.fsum(point.ticks for point in kept) / len(kept)
        spread = math.fsum((point.host_us - host) ** 2 for point in kept)
        product = math.fsum((point.host_us - host) * (point.ticks - ticks) for point in kept)
        unsure = max(self.uncertainty_us, _RESOLUTION_US) / self._prior
        slope = self._nominal + (product - self._nominal * spread) / (spread + unsure * unsure)
        line = _Line(host, ticks, slope)
        squares = math.fsum(line.residual_us(point) ** 2 for point in kept)
        return _Line(host, ticks, slope, math.sqrt(squares / max(len(kept) - 2, 1)))

    @property
    def uncertainty_us(self) -> float:
        """RTT_min / 2 [us]: bound of the offset error; infinite before the first PONG."""
        return self._shortest_us / 2.0

    @property
    def sigma_us(self) -> Optional[float]:
        """Standard deviation of the kept points about the line [us]."""
        return None if self._line is None else self._line.sigma_us

    @property
    def drift_ppm(self) -> Optional[float]:
        """How much faster than nominal the MCU clock runs against the host's [ppm]."""
        return None if self._line is None else (self._line.ticks_a_us / self._nominal - 1.0) * 1e6

    @property
    def points(self) -> int:
        """Points in the regression."""
        return len(self._kept())

    def host_us(self, tick: int) -> Optional[float]:
        """Host time of an MCU tick [us]; None before the first PONG."""
        if self._line is None or self._anchor is None:
            return None
        host0, tick0 = self._anchor
        line = self._line
        return host0 + line.mean_host_us + (tick - tick0 - line.mean_ticks) / line.ticks_a_us

    def tick(self, host_us: float) -> Optional[float]:
        """MCU tick at a host time [us]; None before the first PONG."""
        if self._line is None or self._anchor is None:
            return None
        host0, tick0 = self._anchor
        line = self._line
        return tick0 + line.mean_ticks + (host_us - host0 - line.mean_host_us) * line.ticks_a_us
