"""Every pinned frame in both directions, and every bad input with its verdict."""

from __future__ import annotations

import struct
from dataclasses import asdict
from typing import Any

import pytest
from grip_link import cobs, frame
from grip_link.decoder import TO_DEVICE, TO_HOST, Decoder, Role, Verdict
from grip_link.device import DeviceLink, DriveKind
from grip_link.diff import reference_ident
from grip_link.messages import (
    MESSAGES,
    Ack,
    BadValue,
    ClearFault,
    Config,
    ConfigAck,
    DeviceState,
    Event,
    Grip,
    Heartbeat,
    Hello,
    Ident,
    Kind,
    Log,
    Nack,
    NackReason,
    PayloadError,
    Ping,
    Pong,
    Samples,
    ShortPayload,
    Stats,
    Status,
)

from vectors import INVALID, VALID, Invalid, Valid, words

EMPTY = (Kind.START, Kind.STOP, Kind.ESTOP)


def parse(kind: int, payload: bytes, elements: int = 2) -> Any:
    if kind == Kind.SAMPLES:
        return Samples.parse(payload, elements)
    return None if kind in EMPTY else MESSAGES[kind].parse(payload)


def pack(message: Any) -> bytes:
    return b"" if message is None else bytes(message.pack())


def bits(value: float) -> str:
    return struct.pack(">f", value).hex()


def shown(message: Any) -> dict[str, str]:
    """The fields of a message as the vectors write them."""
    if message is None:
        return {}
    if isinstance(message, Samples):
        show = bits if message.format else str
        rows = ";".join(",".join(show(x) for x in row) for row in message.rows)
        values = {**asdict(message), "n": len(message), "rows": rows}
        names = ("first_index", "t0_tick", "dt_ticks", "n", "format", "dropped_total", "rows")
        return {name: f"{values[name]}" if name != "format" else f"{message.format:d}" for name in names}
    values = asdict(message)
    if isinstance(message, ConfigAck):
        values = {"config_seq": values["request_seq"], "clamped": values["clamped"], **values["config"]}
    if isinstance(message, (Hello, Ident)):
        values["min"], values["max"] = values.pop("version_min"), values.pop("version_max")
    if isinstance(message, Ident):
        values.update(values.pop("limits"))
        values.update(zip(("fw_major", "fw_minor", "fw_patch"), values.pop("firmware")))
        entries = (f"{c.kind:d}:{c.unit:d}:{c.formats}:{c.count}:{bits(c.scale)}" for c in message.channels)
        values["channels"] = ",".join(entries)
    return {
        name: value.hex() if isinstance(value, bytes) else value if isinstance(value, str) else str(int(value))
        for name, value in values.items()
    }


@pytest.mark.parametrize("case", [case for case in VALID if case.direction == "cobs"], ids=lambda case: case.name)
def test_cobs_block(case: Valid) -> None:
    data, block = bytes.fromhex(words(case.fields)["data"]), bytes.fromhex(case.wire)
    assert cobs.decode(block) == data
    assert (cobs.encode(data) == block) == (case.use == "both")


@pytest.mark.parametrize("case", [case for case in VALID if case.direction != "cobs"], ids=lambda case: case.name)
def test_valid_frame(case: Valid) -> None:
    wire, wanted = bytes.fromhex(case.wire), words(case.header)
    decoder = Decoder(Role.DEVICE if case.direction == "to_device" else Role.HOST)
    decoder.open_session(int(wanted["session"]))
    (block,) = decoder.feed(wire)
    assert block.verdict is Verdict.OK and block.frame is not None
    header = block.frame.header
    assert header == frame.Header(
        Kind[case.type], int(wanted["seq"]), int(wanted["session"]), case.direction == "to_host",
        wanted["ack_req"] == "1", int(wanted["version"]),
    )  # fmt: skip
    fields = words(case.fields)
    message = parse(header.kind, block.frame.payload, fields.get("rows", "").split(";")[0].count(",") + 1)
    assert shown(message) == fields
    again = frame.encode(header, pack(message))
    assert (again == wire) == (case.use == "both")
    (second,) = Decoder(Role.TAP).feed(again) if header.to_host else (block,)
    assert second.frame is not None
    assert parse(header.kind, second.frame.payload, getattr(message, "elements", 2)) == pytest.approx(message, nan_ok=True)


def error_word(case: Invalid, last: Any) -> str:
    if last is None or last.verdict is not Verdict.OK:
        return "-"
    if last.frame.header.kind == Kind.HELLO and last.frame.header.session == 0:
        return "session"
    try:
        parse(last.frame.header.kind, last.frame.payload)
    except ShortPayload:
        return "short"
    except BadValue as error:
        return f"value@{error.at}"
    return "-"


@pytest.mark.parametrize("case", INVALID, ids=lambda case: case.name)
def test_verdicts_of_bad_input(case: Invalid) -> None:
    decoder = Decoder(Role(case.role))
    if case.session == "beef":
        decoder.open_session(0xBEEF, 0)
    blocks = list(decoder.feed(bytes.fromhex(case.wire)))
    names = [block.verdict.value for block in blocks]
    assert ",".join(names) == case.verdicts
    counts = {name: count for name, count in asdict(decoder.counters).items() if name not in ("gap", "garbage_bytes")}
    assert {name: count for name, count in counts.items() if count} == {name: names.count(name) for name in names}
    assert error_word(case, blocks[-1]) == case.error


def linked_device(case: Invalid) -> DeviceLink:
    device = DeviceLink(reference_ident())
    device.ready(0)
    if case.session == "beef":
        hello = frame.Header(Kind.HELLO, 0, 0xBEEF, to_host=False, ack_req=True)
        assert device.receive(1, frame.encode(hello, Hello(0).pack()))
        while device.poll_transmit(1):
            pass
    return device


@pytest.mark.parametrize("case", [case for case in INVALID if case.role == "device"], ids=lambda case: case.name)
def test_device_refuses(case: Invalid) -> None:
    device = linked_device(case)
    before = device.state
    events = device.receive(2, bytes.fromhex(case.wire))
    assert events == [] and device.state == before
    assert device.drive(3).kind is DriveKind.PASSIVE
    assert (device.malformed == 1) == (case.error != "-")
    reasons = []
    while True:
        wire = device.poll_transmit(3)
        if wire is None:
            break
        (block,) = Decoder(Role.TAP).feed(wire)
        assert block.frame is not None
        if block.frame.header.kind == Kind.NACK:
            reasons.append(Nack.parse(block.frame.payload).reason)
    assert reasons == ([] if case.nack == "-" else [NackReason[case.nack.upper()]])


def test_there_are_enough_vectors() -> None:
    assert len(VALID) >= 20 and len(INVALID) >= 20
    assert {Kind[case.type] for case in VALID if case.type != "-"} == {kind for kind in Kind if kind in TO_DEVICE | TO_HOST}


@pytest.mark.parametrize("message", [Hello(0, max_rx=1 << 16), Ping(-1), Log(0, 1, b"x" * 256), Config(batch=256)])
def test_values_that_no_field_holds(message: Any) -> None:
    with pytest.raises(PayloadError):
        message.pack()


def test_unknown_codes_are_kept() -> None:
    state = DeviceState(77)
    assert state == 77 and state.name == "OTHER_77" and DeviceState(77) == state
    with pytest.raises(ValueError):
        DeviceState(1 << 16)
