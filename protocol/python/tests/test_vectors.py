"""Every pinned frame in both directions, and every bad input with its verdict: of the link and of the daemon's socket."""

from __future__ import annotations

import struct
from dataclasses import asdict, fields
from typing import Any

import pytest
from grip_link import cobs, frame
from grip_link.decoder import TO_CLIENT, TO_DAEMON, TO_DEVICE, TO_HOST, Decoder, Role, Verdict
from grip_link.device import DeviceLink, DriveKind
from grip_link.diff import reference_ident
from grip_link.messages import (
    MESSAGES, BadValue, Config, ConfigAck, DeviceState, Hello, Ident, Kind, Log, Nack, NackReason, PayloadError, Ping, Samples, ShortPayload,
)  # fmt: skip
from grip_link.messages.daemon import Rows

from vectors import BAD_CLIENTS, CLIENTS, INVALID, VALID, Invalid, Valid, words

ROLES = {"to_device": Role.DEVICE, "to_host": Role.HOST, "to_daemon": Role.DAEMON, "to_client": Role.CLIENT}
FRAMES = [case for case in VALID + CLIENTS if case.direction != "cobs"]


def parse(kind: int, payload: bytes, elements: int = 2) -> Any:
    if kind == Kind.SAMPLES:
        return Samples.parse(payload, elements)
    return MESSAGES[kind].parse(payload) if kind in MESSAGES else None


def shown(value: Any) -> str:
    """A value as the vectors write it."""
    if isinstance(value, (bytes, float)):
        return (struct.pack(">f", value) if isinstance(value, float) else value).hex()
    return ",".join(map(shown, value)) if isinstance(value, tuple) else str(int(value))


def named(message: Any) -> dict[str, str]:
    """The fields of a message as the vectors write them."""
    if message is None:
        return {}
    values = {field.name: getattr(message, field.name) for field in fields(message)}
    if isinstance(message, (Samples, Rows)):
        del values["data"]
        values.pop("elements", None)
        values["n"] = len(message)
    if isinstance(message, ConfigAck):
        values = {"config_seq": message.request_seq, "clamped": message.clamped, **asdict(message.config)}
    for old, new in (("version_min", "min"), ("version_max", "max")):
        if old in values:
            values[new] = values.pop(old)
    more = {}
    if isinstance(message, Ident):
        values.update(asdict(values.pop("limits")), **dict(zip(("fw_major", "fw_minor", "fw_patch"), values.pop("firmware"))))
        more["channels"] = ",".join(":".join(map(shown, asdict(one).values())) for one in values.pop("channels"))
    if isinstance(message, (Samples, Rows)):
        more["rows"] = ";".join(map(shown, message.rows if isinstance(message, Samples) else message.raw))
    return {**{name: shown(value) for name, value in values.items() if value is not None}, **more}


@pytest.mark.parametrize("case", [case for case in VALID if case.direction == "cobs"], ids=lambda case: case.name)
def test_cobs_block(case: Valid) -> None:
    data, block = bytes.fromhex(words(case.fields)["data"]), bytes.fromhex(case.wire)
    assert cobs.decode(block) == data
    assert (cobs.encode(data) == block) == (case.use == "both")


@pytest.mark.parametrize("case", FRAMES, ids=lambda case: case.name)
def test_valid_frame(case: Valid) -> None:
    wire, wanted, found = bytes.fromhex(case.wire), words(case.header), words(case.fields)
    decoder = Decoder(ROLES[case.direction])
    decoder.open_session(int(wanted["session"]))
    (block,) = decoder.feed(wire)
    assert block.verdict is Verdict.OK and block.frame is not None
    header = block.frame.header
    assert header == frame.Header(
        Kind[case.type], int(wanted["seq"]), int(wanted["session"]), case.direction in ("to_host", "to_client"),
        wanted["ack_req"] == "1", int(wanted["version"]),
    )  # fmt: skip
    message = parse(header.kind, block.frame.payload, found.get("rows", "").split(";")[0].count(",") + 1)
    assert named(message) == found
    again = frame.encode(header, b"" if message is None else message.pack())
    assert (again == wire) == (case.use == "both")


def error_word(last: Any) -> str:
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


@pytest.mark.parametrize("case", INVALID + BAD_CLIENTS, ids=lambda case: case.name)
def test_verdicts_of_bad_input(case: Invalid) -> None:
    decoder = Decoder(Role(case.role))
    if case.session == "beef":
        decoder.open_session(0xBEEF, 0)
    blocks = list(decoder.feed(bytes.fromhex(case.wire)))
    names = [block.verdict.value for block in blocks]
    assert ",".join(names) == case.verdicts
    counts = {name: count for name, count in asdict(decoder.counters).items() if name not in ("gap", "garbage_bytes")}
    assert {name: count for name, count in counts.items() if count} == {name: names.count(name) for name in names}
    assert error_word(blocks[-1]) == case.error


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
    while wire := device.poll_transmit(3):
        (block,) = Decoder(Role.TAP).feed(wire)
        assert block.frame is not None
        if block.frame.header.kind == Kind.NACK:
            reasons.append(Nack.parse(block.frame.payload).reason)
    assert reasons == ([] if case.nack == "-" else [NackReason[case.nack.upper()]])


def test_there_are_enough_vectors() -> None:
    assert len(VALID) >= 20 and len(INVALID) >= 20
    assert {Kind[case.type] for case in FRAMES} == TO_DEVICE | TO_HOST | TO_DAEMON | TO_CLIENT


@pytest.mark.parametrize("message", [Hello(0, max_rx=1 << 16), Ping(-1), Log(0, 1, b"x" * 256), Config(batch=256)])
def test_values_that_no_field_holds(message: Any) -> None:
    with pytest.raises(PayloadError):
        message.pack()


def test_unknown_codes_are_kept() -> None:
    state = DeviceState(77)
    assert state == 77 and state.name == "OTHER_77" and DeviceState(77) == state
    with pytest.raises(ValueError):
        DeviceState(1 << 16)
