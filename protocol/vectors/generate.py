#!/usr/bin/env python3
"""Case tables in, valid.tsv and invalid.tsv out.

Frame, COBS and CRC are written here a second time, bit by bit and without tables, so that the vectors are
not the output of a library they are meant to test. Run it in this folder; it needs no package.
"""

import struct
from pathlib import Path

KINDS = {
    "HELLO": 0x01, "CONFIG": 0x03, "START": 0x04, "STOP": 0x05, "PING": 0x06, "GRIP": 0x10,
    "HEARTBEAT": 0x11, "ESTOP": 0x12, "CLEAR_FAULT": 0x13, "IDENT": 0x81, "CONFIG_ACK": 0x83,
    "PONG": 0x86, "ACK": 0x8E, "NACK": 0x8F, "SAMPLES": 0x90, "STATUS": 0x91, "STATS": 0x92,
    "EVENT": 0x93, "LOG": 0x94,
}  # fmt: skip
ACK_REQ = {"HELLO", "CONFIG", "START", "STOP", "ESTOP", "CLEAR_FAULT"}
CONFIG = [
    ("sample_rate_hz", "I"), ("batch", "B"), ("format", "B"), ("ttl_ms", "H"), ("channel_mask", "I"),
    ("force_max_mn", "i"), ("slew_mn_s", "I"), ("hold_cap_mn", "i"), ("loss_after_ms", "H"),
    ("loss_action", "B"), (None, "B"),
]  # fmt: skip
STATS = "ok too_long cobs length crc echo version stale duplicate unknown gap garbage_bytes sent dropped_batches dropped_rows malformed old refused unanswered"
FIELDS = {
    "HELLO": [("min", "B"), ("max", "B"), ("max_rx", "H"), ("caps", "I"), ("time_us", "Q")],
    "CONFIG": CONFIG,
    "START": [],
    "STOP": [],
    "PING": [("t1_us", "Q")],
    "GRIP": [("cmd_id", "I"), ("mode", "B"), ("flags", "B"), ("ttl_ms", "H"), ("force_mn", "i"), ("slew_mn_s", "I"), ("cause_sample", "I")],
    "HEARTBEAT": [("turns", "I"), ("longest_us", "I"), ("late", "H"), ("flags", "H")],
    "ESTOP": [],
    "CLEAR_FAULT": [("fault", "H")],
    "IDENT": [
        ("min", "B"), ("max", "B"), ("max_rx", "H"), ("caps", "I"), ("uid", "16s"), ("boot_id", "I"), ("tick_hz", "I"),
        ("rate_max_hz", "I"), ("force_max_mn", "i"), ("slew_max_mn_s", "I"), ("hold_cap_mn", "i"), ("travel_min_um", "i"),
        ("travel_max_um", "i"), ("fw_major", "B"), ("fw_minor", "B"), ("fw_patch", "H"), ("reset", "B"), ("state", "B"), ("fault", "H"),
    ],
    "PONG": [("t1_us", "Q"), ("rx_tick", "Q"), ("tx_tick", "Q")],
    "ACK": [("kind", "B"), (None, "B"), ("request_seq", "H")],
    "NACK": [("kind", "B"), ("reason", "B"), ("request_seq", "H")],
    "SAMPLES": [("first_index", "I"), ("t0_tick", "Q"), ("dt_ticks", "H"), ("n", "B"), ("format", "B"), ("dropped_total", "I")],
    "STATUS": [
        ("last_cmd_id", "I"), ("state", "B"), ("clamp", "B"), ("fault", "H"), ("applied_mn", "i"), ("target_mn", "i"),
        ("age_us", "I"), ("flags", "H"), ("rejected", "H"),
    ],
    "STATS": [(name, "I") for name in STATS.split()],
    "EVENT": [("tick", "Q"), ("kind", "B"), ("before", "B"), ("after", "B"), (None, "B"), ("fault", "H"), ("dropped", "H"), ("value", "i")],
}  # fmt: skip


def crc(data, polynomial=0x82F63B78):
    state = 0xFFFFFFFF
    for byte in data:
        state ^= byte
        for _ in range(8):
            state = state >> 1 ^ (polynomial if state & 1 else 0)
    return state ^ 0xFFFFFFFF


def cobs(data):
    out, block = bytearray(), bytearray()
    pending = False  # a zero, or the end of a full block, has closed the block before
    for byte in data:
        if len(block) == 254:
            out += b"\xff" + block
            block.clear()
            pending = False
        if byte:
            block.append(byte)
            pending = False
        else:
            out += bytes([len(block) + 1]) + block
            block.clear()
            pending = True
    if block or pending or not data:
        out += bytes([len(block) + 1]) + block
    return bytes(out)


def pack(table, values):
    return struct.pack("<" + "".join(code for _, code in table), *(values[name] if name else 0 for name, _ in table))


def payload(kind, v):
    if kind == "CONFIG_ACK":
        config = pack(CONFIG, v)
        return struct.pack("<IHBB", crc(config), v["config_seq"], v["clamped"], 0) + config
    if kind == "LOG":
        return struct.pack("<QBB", v["tick"], v["level"], len(v["text"])) + v["text"]
    data = pack(FIELDS[kind], v)
    if kind == "IDENT":
        data += struct.pack("<BBHI", len(v["channels"]), 8, 72, 0)
        data += b"".join(struct.pack("<BBBBf", *channel) for channel in v["channels"])
    if kind == "SAMPLES":
        code = "f" if v["format"] else "h"
        data += b"".join(struct.pack("<" + code * len(row), *row) for row in v["rows"])
    return data


def body(kind, data, *, host, ack=None, seq=600, session=0xBEEF, version=1, flags=0, length=None):
    code = KINDS[kind] if isinstance(kind, str) else kind
    ack = kind in ACK_REQ if ack is None else ack
    first = version << 4 | flags | host | ack << 1
    return struct.pack("<BBHHH", first, code, seq, session, len(data) if length is None else length) + data


def wire(content, polynomial=0x82F63B78, tail=b""):
    return b"\0" + cobs(content + struct.pack("<I", crc(content, polynomial))) + tail + b"\0"


def frame(kind, data, **header):
    header.setdefault("host", isinstance(kind, str) and KINDS[kind] >= 0x80)
    return wire(body(kind, data, **header))


def show(kind, v):
    table = CONFIG if kind == "CONFIG_ACK" else FIELDS.get(kind, [])
    names = {"CONFIG_ACK": ["config_seq", "clamped"], "LOG": ["tick", "level", "text"]}.get(kind, [])
    names = names + [name for name, _ in table if name]
    words = []
    for name in names:
        value = v[name]
        words.append(f"{name}={value.hex() if isinstance(value, bytes) else value}")
    if kind == "IDENT":
        entries = (f"{k}:{u}:{f}:{c}:{struct.pack('>f', s).hex()}" for k, u, f, c, s in v["channels"])
        words.append("channels=" + ",".join(entries))
    if kind == "SAMPLES":
        text = (lambda x: struct.pack(">f", x).hex()) if v["format"] else str
        words.append("rows=" + ";".join(",".join(text(x) for x in row) for row in v["rows"]))
    return " ".join(words) or "-"


ROWS = []


def valid(name, kind, values=None, use="both", extra=b"", tail=b"", **header):
    values = values or {}
    host = KINDS[kind] >= 0x80
    ack = header.get("ack", kind in ACK_REQ)
    seq, session = header.get("seq", 600), header.get("session", 0xBEEF)
    data = header.pop("data", None) or payload(kind, values) + extra
    content = wire(body(kind, data, host=host, **header), tail=tail)
    head = f"version={header.get('version', 1)} ack_req={int(ack)} seq={seq} session={session}"
    ROWS.append([name, use, "to_host" if host else "to_device", kind, head, show(kind, values), content.hex()])


def block(name, data, use="both", encoded=None):
    ROWS.append([name, use, "cobs", "-", "-", f"data={data.hex()}", (encoded or cobs(data)).hex()])


config = dict(sample_rate_hz=5000, batch=5, format=0, ttl_ms=50, channel_mask=3, force_max_mn=10000,
              slew_mn_s=200000, hold_cap_mn=8000, loss_after_ms=1000, loss_action=0)  # fmt: skip
ident = dict(min=1, max=1, max_rx=480, caps=0, uid=b"grip-link-test-1", boot_id=0xB007, tick_hz=1000000,
             rate_max_hz=20000, force_max_mn=20000, slew_max_mn_s=400000, hold_cap_mn=15000, travel_min_um=0,
             travel_max_um=50000, fw_major=1, fw_minor=2, fw_patch=3, reset=1, state=1, fault=0,
             channels=[(1, 1, 3, 1, 1e-8), (2, 2, 3, 1, 1e-3), (9, 5, 3, 4, 10.0)])  # fmt: skip
grip = dict(cmd_id=42, mode=1, flags=0, ttl_ms=50, force_mn=5000, slew_mn_s=200000, cause_sample=123456)
hello = dict(min=1, max=1, max_rx=480, caps=0, time_us=0)
samples = dict(first_index=1000, t0_tick=5000000000, dt_ticks=200, n=3, format=0, dropped_total=9,
               rows=[(100, -200), (101, -32768), (102, 0)])  # fmt: skip
status = dict(last_cmd_id=0x01020304, state=5, clamp=16, fault=0x0101, applied_mn=-2, target_mn=5000,
              age_us=70000, flags=1, rejected=3)  # fmt: skip

# The reference frames of the design.
valid("hello_reference", "HELLO", hello, seq=0)
valid("grip_reference", "GRIP", grip, seq=7)
valid("ping_reference", "PING", dict(t1_us=1000000000), seq=9)
valid("estop_reference", "ESTOP", seq=8, session=0)
# One of each other message.
valid("config", "CONFIG", config)
valid("start", "START")
valid("stop", "STOP")
valid("heartbeat", "HEARTBEAT", dict(turns=5, longest_us=900, late=2, flags=1))
valid("clear_fault", "CLEAR_FAULT", dict(fault=0x0201))
valid("ident", "IDENT", ident)
valid("config_ack", "CONFIG_ACK", dict(config, config_seq=0x1234, clamped=0x29))
valid("pong", "PONG", dict(t1_us=1000000000, rx_tick=77, tx_tick=99))
valid("ack", "ACK", dict(kind=4, request_seq=2))
valid("nack", "NACK", dict(kind=3, reason=4, request_seq=1))
valid("samples_i16", "SAMPLES", samples)
valid("status", "STATUS", status)
valid("stats", "STATS", {name: i + 1 for i, name in enumerate(STATS.split())})
valid("event", "EVENT", dict(tick=123456789012, kind=1, before=4, after=5, fault=0, dropped=1, value=-7))
valid("log", "LOG", dict(tick=42, level=1, text=b"low supply"))
# Edges of the ranges; largest frames; rows as f32.
valid("hello_all_ones", "HELLO", dict(min=0, max=15, max_rx=65535, caps=2**32 - 1, time_us=2**64 - 1), seq=65535, session=65535)
valid("config_edges", "CONFIG", dict(sample_rate_hz=1, batch=255, format=1, ttl_ms=65535, channel_mask=2**32 - 1, force_max_mn=0,
                                     slew_mn_s=2**32 - 1, hold_cap_mn=2**31 - 1, loss_after_ms=0, loss_action=2))  # fmt: skip
valid("grip_edges", "GRIP", dict(cmd_id=2**32 - 1, mode=255, flags=1, ttl_ms=65535, force_mn=-(2**31), slew_mn_s=0, cause_sample=2**32 - 1), ack=True)
valid("ident_announcement_16_channels", "IDENT", dict(ident, state=7, fault=0xFFFF, reset=5,
      channels=[(1, 1, 1, 1, 1e-9)] + [(9, 5, 2, 64, 3.4028234663852886e38)] * 15), session=0, seq=65535)  # fmt: skip
valid("samples_f32_nan", "SAMPLES", dict(samples, n=2, format=1, first_index=2**32 - 1, rows=[(1.5e-6, float("nan")), (-0.0, 2.25)]))
valid("samples_480_bytes", "SAMPLES", dict(samples, first_index=0x01010101, t0_tick=0x0101010101010101, dt_ticks=257, n=115, dropped_total=0x01010101,
      rows=[(0x0101 + i, -0x0101 - i) for i in range(115)]), seq=257)  # fmt: skip
valid("log_255_bytes", "LOG", dict(tick=2**64 - 1, level=3, text=b"x" * 255))
valid("log_empty", "LOG", dict(tick=0, level=0, text=b""))
# What a reader must take although no writer of this version makes it.
valid("ping_grown", "PING", dict(t1_us=7), use="decode", extra=b"\x01\x02\x03\x00")
valid("start_reserved_flags", "START", use="decode", flags=0x0C)
grown = payload("IDENT", dict(ident, channels=[]))[:64] + struct.pack("<BBHI", 2, 10, 76, 0) + b"more"
grown += struct.pack("<BBBBf", 1, 1, 3, 1, 1e-8) + b"\x01\x02" + struct.pack("<BBBBf", 2, 2, 3, 1, 1e-3) + b"\x03\x04"
valid("ident_grown", "IDENT", dict(ident, channels=ident["channels"][:2]), use="decode", data=grown)
# A log whose last COBS block is full, with the trailing 01 that other encoders add: text chosen below.
for extra in range(64):
    text = bytes((i * 7 + extra) % 200 + 1 for i in range(240))
    content = body("LOG", payload("LOG", dict(tick=0x0101010101010101, level=2, text=text)), host=True, seq=257)
    whole = content + struct.pack("<I", crc(content))
    if 0 not in whole[8:]:
        break
assert len(whole) - 8 == 254 and whole[7] == 0 and cobs(whole)[-255] == 255
full = dict(tick=0x0101010101010101, level=2, text=text)
valid("log_last_block_full", "LOG", full, seq=257)
valid("log_last_block_full_trailing_01", "LOG", full, seq=257, use="decode", tail=b"\x01")

for n in (0, 1, 253, 254, 255, 480):
    block(f"cobs_{n}", bytes(i % 255 + 1 for i in range(n)))
block("cobs_480_zeros", bytes(480))
block("cobs_zero_after_full_block", bytes(range(1, 255)) + b"\0\x09")
block("cobs_254_trailing_01", bytes(range(1, 255)), use="decode", encoded=cobs(bytes(range(1, 255))) + b"\x01")

BAD = []


def invalid(name, role, content, verdicts, error="-", nack="-", session="beef"):
    BAD.append([name, role, session, content.hex(), verdicts, error, nack])


GRIP, PING, STATUS = payload("GRIP", grip), payload("PING", dict(t1_us=7)), payload("STATUS", status)
ONE = dict(seq=1)
good = frame("PING", PING, **ONE)
content = body("PING", PING, host=False, **ONE)
sum32 = struct.pack("<I", crc(content))

# Blocks that are no frames.
invalid("cobs_code_past_the_end", "device", b"\0\x09\x01\x02\0", "cobs")
invalid("cobs_cut_short", "device", good[:-4] + b"\0", "cobs")
invalid("modem_commands_before_a_frame", "device", b"AT+GCAP\r" + good, "cobs,ok")
invalid("crc_one_bit", "device", b"\0" + cobs(content[:12] + bytes([content[12] ^ 1]) + content[13:] + sum32) + b"\0", "crc")
invalid("crc_of_another_polynomial", "device", wire(content, polynomial=0xEDB88320), "crc")
invalid("crc_big_endian", "device", b"\0" + cobs(content + sum32[::-1]) + b"\0", "crc")
invalid("length_of_eleven_bytes", "device", b"\0" + cobs(content[:11]) + b"\0", "length")
invalid("length_field_too_large", "device", wire(body("PING", PING, host=False, length=9, **ONE)), "length")
invalid("length_field_too_small", "device", wire(body("PING", PING, host=False, length=7, **ONE)), "length")
invalid("length_481", "host", frame("LOG", bytes(481), **ONE), "length")
invalid("too_long_then_good", "device", b"\0" + b"\x55" * 495 + good, "too_long,ok")
# Good frames for somebody else.
invalid("echo_of_the_host", "host", frame("HELLO", payload("HELLO", hello), **ONE), "echo")
invalid("echo_of_the_device", "device", frame("STATUS", STATUS, **ONE), "echo")
invalid("version_2", "device", frame("GRIP", GRIP, version=2, **ONE), "version")
invalid("stale_session", "device", frame("GRIP", GRIP, session=0x1234, **ONE), "stale")
invalid("stale_grip_of_session_0", "device", frame("GRIP", GRIP, session=0, **ONE), "stale")
invalid("stale_estop_of_another_session", "device", frame("ESTOP", b"", session=0x1234, **ONE), "stale")
invalid("stale_before_any_session", "device", frame("GRIP", GRIP, **ONE), "stale", session="none")
invalid("stale_status_of_session_0", "host", frame("STATUS", STATUS, session=0, **ONE), "stale")
invalid("duplicate_and_replay", "device", good + good + frame("PING", PING, seq=300) + frame("PING", PING, seq=45), "ok,duplicate,ok,duplicate")
invalid("gap_256_behind_is_taken", "device", frame("PING", PING, seq=300) + frame("PING", PING, seq=44), "ok,ok")
invalid("unknown_type", "device", frame(0x7E, b"", host=False, ack=False, **ONE), "unknown")
invalid("unknown_type_ack_req", "device", frame(0x7E, b"", host=False, ack=True, **ONE), "unknown", nack="unknown_type")
invalid("unknown_client_type", "host", frame(0xA0, b"\x01", host=True, ack=False, **ONE), "unknown")
# Good frames whose payload or time is wrong.
invalid("hello_of_session_0", "device", frame("HELLO", payload("HELLO", hello), session=0, **ONE), "ok", "session")
invalid("config_short", "device", frame("CONFIG", payload("CONFIG", config)[:27], **ONE), "ok", "short", "malformed")
for name, at, change in (
    ("rate_0", 0, dict(sample_rate_hz=0)),
    ("batch_0", 4, dict(batch=0)),
    ("format_2", 5, dict(format=2)),
    ("negative_force", 12, dict(force_max_mn=-1)),
    ("negative_hold_cap", 20, dict(hold_cap_mn=-(2**31))),
    ("loss_action_3", 26, dict(loss_action=3)),
):
    invalid(f"config_{name}", "device", frame("CONFIG", payload("CONFIG", dict(config, **change)), **ONE), "ok", f"value@{at}", "malformed")
invalid("config_no_channel", "device", frame("CONFIG", payload("CONFIG", dict(config, channel_mask=0x80)), **ONE), "ok", nack="malformed")
invalid("grip_short", "device", frame("GRIP", GRIP[:19], **ONE), "ok", "short")
invalid("start_before_config", "device", frame("START", b"", **ONE), "ok", nack="wrong_state")
invalid("clear_fault_without_one", "device", frame("CLEAR_FAULT", b"\x01\x02", **ONE), "ok", nack="other_fault")
table = payload("IDENT", ident)
invalid("ident_tick_hz_999", "host", frame("IDENT", payload("IDENT", dict(ident, tick_hz=999)), **ONE), "ok", "value@28")
invalid("ident_17_channels", "host", frame("IDENT", table[:64] + b"\x11" + table[65:] + bytes(200), **ONE), "ok", "value@64")
invalid("ident_entry_of_7_bytes", "host", frame("IDENT", table[:65] + b"\x07" + table[66:], **ONE), "ok", "value@65")
invalid("ident_scale_nan", "host", frame("IDENT", table[:76] + struct.pack("<f", float("nan")) + table[80:], **ONE), "ok", "value@76")
invalid("config_ack_crc", "host", frame("CONFIG_ACK", b"\x01" + payload("CONFIG_ACK", dict(config, config_seq=1, clamped=0))[1:], **ONE), "ok", "value@0")
invalid("samples_no_rows", "host", frame("SAMPLES", payload("SAMPLES", dict(samples, n=0)), **ONE), "ok", "value@14")
invalid("samples_row_missing", "host", frame("SAMPLES", payload("SAMPLES", dict(samples, n=4)), **ONE), "ok", "short")
invalid("log_text_missing", "host", frame("LOG", struct.pack("<QBB", 1, 2, 9) + b"8 bytes!", **ONE), "ok", "short")

VALID_HEAD = """\
# Frames that every peer writes and reads alike. Columns, separated by tabs:
# name       unique
# use        both = encoding the fields gives exactly the wire bytes, and decoding these gives the fields; decode = decoding only
# direction  to_device | to_host | cobs (a bare COBS block without delimiters: data in, encoded block out)
# type       name of the message, - for cobs
# header     version, ack_req, seq, session
# fields     payload fields by name, decimal; uid, text and data in hex; channels as kind:unit:formats:count:scale, ...;
#            rows separated by ; and elements by , ; scale and f32 elements as the eight hex digits of their IEEE 754 bits; - = none
# wire       hex of all bytes on the wire, both delimiters included
"""
INVALID_HEAD = """\
# Bytes that a peer must refuse, and how. Columns, separated by tabs:
# name      unique
# role      who listens: device | host
# session   beef = session BEEF is open and 0 is the newest sequence number of it; a device is LINKED (HELLO seq 0 taken, no CONFIG yet);
#           none = no session is open
# wire      hex of all bytes on the wire
# verdicts  the decoder's word on each block in order: ok, or the counter that goes up by one
# error     of the payload of the last block: - = readable; short = ends before a field;
#           value@N = the field at payload offset N is out of its range; session = session 0 in a HELLO.
#           Rows of SAMPLES have two i16 elements here
# nack      reason of the NACK that a device answers, - = no NACK
"""


def save(path, head, rows):
    assert len({row[0] for row in rows}) == len(rows)
    path.write_text(head + "".join("\t".join(row) + "\n" for row in rows))


here = Path(__file__).parent
assert crc(b"123456789") == 0xE3069283
save(here / "valid.tsv", VALID_HEAD, ROWS)
save(here / "invalid.tsv", INVALID_HEAD, BAD)
