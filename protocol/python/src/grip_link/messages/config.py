"""CONFIG and its answer: the sampling and the limits wanted, and those in force."""

from __future__ import annotations

import struct
from dataclasses import dataclass

from ..crc import crc32c
from .codes import Clamped, LossAction, SampleFormat
from .wire import BadValue, ShortPayload, closed, pack, unpack

TTL_MIN_MS = 20
TTL_MAX_MS = 100

_CONFIG = struct.Struct("<IBBHIiIiHBx")
_ACK = struct.Struct("<IHBx")


@dataclass(frozen=True)
class Config:
    """CONFIG (03), host to MCU, 28 bytes: u32 rate, u8 batch, u8 format, u16 ttl, u32 mask, i32 F_max, u32 slew,
    i32 hold cap, u16 loss delay, u8 loss action, u8 reserved. The microcontroller clamps it to its own limits."""

    sample_rate_hz: int = 1000
    """Samples a second, >= 1."""
    batch: int = 10
    """Rows a batch, 1..255; a batch also ends after 1 ms."""
    format: SampleFormat = SampleFormat.I16
    ttl_ms: int = 50
    """Life of a GRIP [ms], 20..100."""
    channel_mask: int = 0xFFFF
    """Channels to send; bit 0 is the first channel of IDENT."""
    force_max_mn: int = 10_000
    """Largest force [mN], >= 0."""
    slew_mn_s: int = 100_000
    """Fastest change of force [mN/s], >= 1."""
    hold_cap_mn: int = 10_000
    """Largest force held without commands [mN], >= 0."""
    loss_after_ms: int = 1000
    """Time in HOLD before the loss action [ms], 100..60000."""
    loss_action: LossAction = LossAction.HOLD

    @classmethod
    def parse(cls, payload: bytes) -> Config:
        """Reads a payload; raises PayloadError."""
        rate, batch, fmt, ttl, mask, f_max, slew, cap, after, action = unpack(_CONFIG, payload)
        if batch == 0:
            raise BadValue(4, batch)
        sample_format = closed(SampleFormat, fmt, 5)
        loss_action = closed(LossAction, action, 26)
        for at, value, good in ((0, rate, rate > 0), (12, f_max, f_max >= 0), (16, slew, slew > 0), (20, cap, cap >= 0)):
            if not good:
                raise BadValue(at, value)
        return cls(rate, batch, sample_format, ttl, mask, f_max, slew, cap, after, loss_action)

    def pack(self) -> bytes:
        """The 28 payload bytes."""
        return pack(
            _CONFIG, self.sample_rate_hz, self.batch, self.format, self.ttl_ms, self.channel_mask, self.force_max_mn,
            self.slew_mn_s, self.hold_cap_mn, self.loss_after_ms, self.loss_action,
        )  # fmt: skip

    def changed(self, given: Config) -> Clamped:
        """Which fields ``given`` has changed."""
        pairs = (
            (Clamped.RATE, self.sample_rate_hz != given.sample_rate_hz),
            (Clamped.BATCH, self.batch != given.batch),
            (Clamped.MASK, self.channel_mask != given.channel_mask),
            (Clamped.FORCE_MAX, self.force_max_mn != given.force_max_mn),
            (Clamped.SLEW, self.slew_mn_s != given.slew_mn_s),
            (Clamped.TTL, self.ttl_ms != given.ttl_ms),
            (Clamped.HOLD_CAP, self.hold_cap_mn != given.hold_cap_mn),
            (Clamped.LOSS_DELAY, self.loss_after_ms != given.loss_after_ms),
        )
        return Clamped(sum(bit for bit, differs in pairs if differs))


@dataclass(frozen=True)
class ConfigAck:
    """CONFIG_ACK (83), MCU to host, 36 bytes: u32 CRC-32C of bytes 8..36, u16 seq of the CONFIG, u8 clamped fields,
    u8 reserved, the CONFIG in force."""

    request_seq: int
    clamped: Clamped
    config: Config

    @classmethod
    def parse(cls, payload: bytes) -> ConfigAck:
        """Reads a payload and checks its CRC; raises PayloadError."""
        crc, seq, clamped = unpack(_ACK, payload)
        end = _ACK.size + _CONFIG.size
        if len(payload) < end:
            raise ShortPayload(end, len(payload))
        if crc32c(payload[_ACK.size : end]) != crc:
            raise BadValue(0, crc)
        return cls(seq, Clamped(clamped), Config.parse(payload[_ACK.size : end]))

    def pack(self) -> bytes:
        """The 36 payload bytes."""
        config = self.config.pack()
        return pack(_ACK, crc32c(config), self.request_seq, self.clamped) + config
