#!/usr/bin/env python3
"""Case tables and the fields of ../MESSAGES.md in, valid.tsv and invalid.tsv out.

Frame, COBS and CRC are written here a second time, bit by bit and without tables, so that the vectors are
not the output of a library they are meant to test. Run it in this folder; it needs no package.
"""

import re
import struct
from pathlib import Path

CODES = {"u8": "B", "u16": "H", "u32": "I", "u64": "Q", "i32": "i", "i64": "q", "f32": "f"}
ACK_REQ = {"HELLO", "CONFIG", "START", "STOP", "ESTOP", "CLEAR_FAULT"}
KINDS, WAYS, FIELDS, TEXTS = {}, {}, {}, {}
"""By the name of a message its type, who it goes to, its fields with their codes of struct, and the name of the text behind them."""


def code_of(kind):
    name, count = re.fullmatch(r"(\w+)(?:\[(\d+)\])?", kind).groups()
    return CODES[name] if count is None else count + ("s" if name == "u8" else CODES[name])


def read_tables():
    kind = key = way = None
    for line in (Path(__file__).parent.parent / "MESSAGES.md").read_text().splitlines():
        if found := re.fullmatch(r"## To the (\w+)", line):
            way = f"to_{found[1]}"
        elif line.startswith("## "):
            return
        elif found := re.fullmatch(r"### (\w\w) (\w+)", line):
            kind = key = found[2]
            KINDS[kind], WAYS[kind], FIELDS[kind] = int(found[1], 16), way, []
        elif line == "Appended:":
            key = kind + "_APPENDED"
            FIELDS[key] = []
        elif line.startswith("One entry"):
            key = None
        elif key and (found := re.match(r"\| \d+ \| \S+ \| (\S+) \| (`\w+`|reserved) \|", line)):
            name = found[2].strip("`")
            if name.endswith("_len"):
                TEXTS[kind] = name[:-4]
            else:
                FIELDS[key].append((None if name == "reserved" else name, code_of(found[1])))


read_tables()
# What follows is a table of its own.
FIELDS["IDENT"] = FIELDS["IDENT"][:-4]
FIELDS["CONFIG_ACK"] = FIELDS["CONFIG_ACK"][1:]
ACK_REQ |= {kind for kind, way in WAYS.items() if way == "to_daemon"}


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
    listed = [values[name] if name else 0 for name, _ in table]
    flat = [x for value in listed for x in (value if isinstance(value, tuple) else (value,))]
    return struct.pack("<" + "".join(code for _, code in table), *flat)


def table_of(kind, v):
    grown = FIELDS.get(kind + "_APPENDED", [])
    return FIELDS.get(kind, []) + [field for field in grown if field[0] in v]


def payload(kind, v):
    data = pack(table_of(kind, v), v)
    if kind == "CONFIG_ACK":
        config = pack(FIELDS["CONFIG"], v)
        data = struct.pack("<I", crc(config)) + data + config
    if kind in TEXTS:
        text = v[TEXTS[kind]]
        data += bytes([len(text)]) + text
    if kind == "ROWS":
        data += b"".join(struct.pack("<I" + "f" * (len(row) - 1), *row) for row in v["rows"])
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
    table = table_of(kind, v) + (FIELDS["CONFIG"] if kind == "CONFIG_ACK" else [])
    names = [name for name, _ in table if name] + [name for own, name in TEXTS.items() if own == kind]
    words = []
    for name in names:
        value = v[name]
        if dict(table).get(name) == "f":
            value = struct.pack(">f", value)
        if isinstance(value, tuple):
            value = ",".join(map(str, value))
        words.append(f"{name}={value.hex() if isinstance(value, bytes) else value}")
    if kind == "ROWS":
        rows = (",".join([str(row[0])] + [struct.pack(">f", x).hex() for x in row[1:]]) for row in v["rows"])
        words.append("rows=" + ";".join(rows))
    if kind == "IDENT":
        entries = (f"{k}:{u}:{f}:{c}:{struct.pack('>f', s).hex()}" for k, u, f, c, s in v["channels"])
        words.append("channels=" + ",".join(entries))
    if kind == "SAMPLES":
        text = (lambda x: struct.pack(">f", x).hex()) if v["format"] else str
        words.append("rows=" + ";".join(",".join(text(x) for x in row) for row in v["rows"]))
    return " ".join(words) or "-"


ROWS = []


def valid(name, kind, values=None, use="both", extra=b"", tail=b"", rows=ROWS, **header):
    values = values or {}
    host = WAYS[kind] in ("to_host", "to_client")
    ack = header.get("ack", kind in ACK_REQ)
    seq, session = header.get("seq", 600), header.get("session", 0xBEEF)
    data = header.pop("data", None) or payload(kind, values) + extra
    content = wire(body(kind, data, host=host, **header), tail=tail)
    head = f"version={header.get('version', 1)} ack_req={int(ack)} seq={seq} session={session}"
    rows.append([name, use, WAYS[kind], kind, head, show(kind, values), content.hex()])


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
# A board of one accelerometer, in m/s2, without an actuator.
valid("ident_sensor_board", "IDENT", dict(ident, force_max_mn=0, hold_cap_mn=0, channels=[(1, 4, 2, 1, 1.0)]))
valid("config_ack", "CONFIG_ACK", dict(config, config_seq=0x1234, clamped=0x29))
valid("pong", "PONG", dict(t1_us=1000000000, rx_tick=77, tx_tick=99))
valid("ack", "ACK", dict(kind=4, request_seq=2))
valid("nack", "NACK", dict(kind=3, reason=4, request_seq=1))
valid("samples_i16", "SAMPLES", samples)
valid("status", "STATUS", status)
valid("stats", "STATS", {name: i + 1 for i, (name, _) in enumerate(FIELDS["STATS"])})
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

CLIENTS = []
NAN = float("nan")
welcome = dict(min=1, max=1, max_rx=480, flags=5, token=0x01020304, run_id=77, host_us=123456789, real_time=2, text=b"gripd 0.1.0")
slip_first = dict(number=3, device_us=5000000, host_us=5000321, phase=1, method=1, speed_source=5, esc_kind=1, statistic=1.5,
            confidence=0.875, speed=0.0125, sigma=0.001, moved=0.0004, irregularities=7, esc=2.5, esc_chosen=NAN, esc_flags=8,
            notes=1, ruled_out=0, possible=0, estimate=3.25, command=2.75, duration=NAN)  # fmt: skip
slip = dict(slip_first, ruled_out=0b01101, possible=0b00010, certified=600.0)
state_first = dict(device_us=5000000, host_us=5000321, scene=2, grip=4, stylus=0, travel=6, pressure=3, reference=7, device=4, notes=2,
             fault=0x0101, esc_flags=1, esc_kind=2, statistic=0.25, command=2.5, applied=2.25, esc=-1.5, estimate=NAN,
             rate_hz=10000, lost=12)  # fmt: skip
state_second = dict(state_first, late=1.5)
state = dict(state_second, need_low=1.75, need=2.0, need_high=2.25, admissible=1.125)
health_first = {name: i + 1 for i, (name, _) in enumerate(FIELDS["HEALTH"])}
health = dict(health_first, p999=28, clock_half=29.5, clock_offset=-30, histogram=tuple(range(31, 55)))
rows = dict(first_index=1000, t0_us=5000000, every_nth=10, channels=3, n=2, taxels=0, rows=[(0, 1e-6, 2.5), (1001, NAN, 2.75)])
notice = dict(kind=1, code=1, value=0, count=42, host_us=5000321, text=b"42 frames of rows dropped: you read too slowly")
subscribe = dict(min=1, max=1, topics=15, every_nth=10, state_ms=100)
command = dict(operation=1, fault=0, force_mn=4250, token=0)
setup = dict(settings=2, fw_major=1, fw_minor=2, fw_patch=345, in_force=bytes(range(32)), configured=bytes(range(32, 64)), text=b"default")
load = dict(sha256=bytes(range(64, 96)), size=261, offset=255, bytes=b"tail\n}")
for kind, values in (
    ("WELCOME", welcome), ("SLIP", slip), ("STATE", state), ("HEALTH", health),
    ("GRIPPER", dict(uid=b"grip-link-test-1", boot_id=0xB007, rate_hz=10000, force_max=20.0, link=4, taxels=16, stylus=1)),
    ("ROWS", rows), ("NOTICE", notice), ("SUBSCRIBE", subscribe), ("COMMAND", command), ("QUERY", {}),
    ("SETUP", setup), ("LOAD", load), ("OBJECT", dict(text="Größe 1".encode())),
    ("SHADOW", load),
    ("ESTIMATES", dict(slip=3, device_us=5000000, host_us=5000321, slipped=2.5, in_force=4.25, shadow=3.75, unsure=2)),
):  # fmt: skip
    valid(kind.lower(), kind, values, rows=CLIENTS)
valid("welcome_no_text", "WELCOME", dict(welcome, flags=0, token=0, text=b""), rows=CLIENTS, seq=0)
valid("welcome_255_bytes", "WELCOME", dict(welcome, text=b"x" * 255), rows=CLIENTS)
valid("slip_of_an_older_daemon", "SLIP", slip_first, rows=CLIENTS)
valid("slip_grown_again", "SLIP", slip, use="decode", extra=b"\x01\x02\x03", rows=CLIENTS)
valid("slip_ended_nothing_known", "SLIP", dict({name: NAN if code == "f" else 0 for name, code in FIELDS["SLIP"]},
      phase=3, irregularities=2**32 - 1, duration=0.125), rows=CLIENTS)  # fmt: skip
valid("state_unknown_codes", "STATE", dict(state, scene=200, grip=255, reference=99, device=77), rows=CLIENTS)
valid("state_of_an_older_daemon", "STATE", state_first, rows=CLIENTS)
valid("state_of_before_the_needed_force", "STATE", state_second, rows=CLIENTS)
valid("state_grown_in_part", "STATE", state_second, use="decode", extra=b"\x01\x02\x03", rows=CLIENTS)
valid("state_age_not_known", "STATE", dict(state, late=NAN), rows=CLIENTS)
valid("state_grown_again", "STATE", state, use="decode", extra=b"\x01\x02\x03", rows=CLIENTS)
MOST = {"B": 255, "H": 65535, "I": 2**32 - 1, "Q": 2**64 - 1}
health_most = {name: MOST.get(code, NAN) for name, code in FIELDS["HEALTH"]}
valid("health_all_ones", "HEALTH", dict(health_most, p999=NAN, clock_half=0.0, clock_offset=-(2**63), histogram=(2**64 - 1,) * 24), rows=CLIENTS)
valid("health_clock_not_known", "HEALTH", dict(health, clock_half=NAN, clock_offset=0), rows=CLIENTS)
valid("health_of_an_older_daemon", "HEALTH", health_first, rows=CLIENTS)
valid("health_grown_in_part", "HEALTH", health_first, use="decode", extra=b"\x01" * 207, rows=CLIENTS)
valid("health_grown_again", "HEALTH", health, use="decode", extra=b"\x01\x02\x03", rows=CLIENTS)
valid("gripper_none", "GRIPPER", dict(uid=bytes(16), boot_id=0, rate_hz=0, force_max=NAN, link=0, taxels=0, stylus=0), rows=CLIENTS)
valid("rows_64_taxels", "ROWS", dict(rows, channels=511, n=1, taxels=64, first_index=2**32 - 1, every_nth=65535, rows=[(0, *range(9), *range(64))]), rows=CLIENTS)
valid("rows_full", "ROWS", dict(rows, channels=1, n=57, every_nth=1, rows=[(100 * i, i * 1e-8) for i in range(57)]), rows=CLIENTS)
valid("notice_session_0", "NOTICE", dict(notice, kind=5, code=5, count=0, text=b"too many clients are connected"), rows=CLIENTS, session=0)
valid("notice_unknown_kind", "NOTICE", dict(notice, kind=99, code=255, value=65535, text="ä".encode()), rows=CLIENTS)
valid("subscribe_nothing", "SUBSCRIBE", dict(min=0, max=15, topics=65535, every_nth=0, state_ms=65535), rows=CLIENTS, seq=65535, session=65535)
valid("command_release", "COMMAND", dict(operation=2, fault=0, force_mn=0, token=0x01020304), rows=CLIENTS)
valid("command_clear_fault", "COMMAND", dict(operation=5, fault=0x0201, force_mn=2**31 - 1, token=2**32 - 1), rows=CLIENTS, ack=False)
valid("setup_nothing_known", "SETUP", dict(setup, settings=0, fw_major=0, fw_minor=0, fw_patch=0, in_force=bytes(32), configured=bytes(32), text=b""), rows=CLIENTS)
valid("load_the_model_of_the_configuration", "LOAD", dict(sha256=bytes(32), size=0, offset=0, bytes=b""), rows=CLIENTS)
valid("load_full_piece", "LOAD", dict(load, size=1 << 20, offset=0, bytes=bytes(range(255))), rows=CLIENTS, ack=False)
valid("command_expect", "COMMAND", dict(operation=6, fault=0, force_mn=9500, token=0), rows=CLIENTS)
valid("object_none", "OBJECT", dict(text=b""), rows=CLIENTS)
valid("shadow_none", "SHADOW", dict(sha256=bytes(32), size=0, offset=0, bytes=b""), rows=CLIENTS)
valid("estimates_nothing_known", "ESTIMATES", dict(slip=2**32 - 1, device_us=0, host_us=2**64 - 1, slipped=NAN, in_force=NAN,
      shadow=NAN, unsure=0), rows=CLIENTS)  # fmt: skip
valid("command_grown", "COMMAND", command, use="decode", extra=b"\x01\x02\x03\x00", rows=CLIENTS)

BAD_CLIENTS = []
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

line, BAD = BAD, BAD_CLIENTS
SUBSCRIBE, COMMAND = payload("SUBSCRIBE", subscribe), payload("COMMAND", command)
STATE, SLIP, ROW = payload("STATE", state), payload("SLIP", slip), payload("ROWS", rows)
DOWN, UP = dict(ONE, host=False), dict(ONE, host=True)
invalid("daemon_hello", "daemon", frame("HELLO", payload("HELLO", hello), **DOWN), "unknown")
invalid("daemon_grip", "daemon", frame("GRIP", GRIP, **DOWN), "unknown")
invalid("daemon_estop_of_session_0", "daemon", frame("ESTOP", b"", session=0, **DOWN), "stale")
invalid("daemon_echo", "daemon", frame("STATE", STATE, **UP), "echo")
invalid("daemon_stale_command", "daemon", frame("COMMAND", COMMAND, session=0x1234, **DOWN), "stale")
invalid("daemon_command_before_subscribe", "daemon", frame("COMMAND", COMMAND, **DOWN), "stale", session="none")
invalid("daemon_replay", "daemon", frame("COMMAND", COMMAND, **DOWN) * 2, "ok,duplicate")
invalid("daemon_version_2", "daemon", frame("COMMAND", COMMAND, version=2, **DOWN), "version")
invalid("daemon_subscribe_short", "daemon", frame("SUBSCRIBE", SUBSCRIBE[:7], **DOWN), "ok", "short", "malformed")
invalid("daemon_command_short", "daemon", frame("COMMAND", COMMAND[:11], **DOWN), "ok", "short", "malformed")
invalid("daemon_operation_0", "daemon", frame("COMMAND", b"\0" + COMMAND[1:], **DOWN), "ok", "value@0", "malformed")
invalid("daemon_operation_7", "daemon", frame("COMMAND", b"\x07" + COMMAND[1:], **DOWN), "ok", "value@0", "malformed")
invalid("daemon_object_short", "daemon", frame("OBJECT", b"\x05cup", **DOWN), "ok", "short", "malformed")
invalid("daemon_negative_force", "daemon", frame("COMMAND", payload("COMMAND", dict(command, force_mn=-1)), **DOWN), "ok", "value@4", "malformed")
invalid("daemon_load_short", "daemon", frame("LOAD", payload("LOAD", load)[:-1], **DOWN), "ok", "short", "malformed")
invalid("daemon_shadow_short", "daemon", frame("SHADOW", payload("SHADOW", load)[:-1], **DOWN), "ok", "short", "malformed")
invalid("daemon_load_too_long", "daemon", frame("LOAD", payload("LOAD", dict(load, size=(1 << 20) + 1)), **DOWN), "ok", "value@32", "malformed")
invalid("client_status_of_the_line", "client", frame("STATUS", STATUS, **UP), "unknown")
invalid("client_samples_of_the_line", "client", frame("SAMPLES", payload("SAMPLES", samples), **UP), "unknown")
invalid("client_stale_state", "client", frame("STATE", STATE, session=0x1234, **UP), "stale")
invalid("client_state_of_session_0", "client", frame("STATE", STATE, session=0, **UP), "stale")
invalid("client_ident_of_session_0", "client", frame("IDENT", payload("IDENT", ident), session=0, **UP), "stale")
invalid("client_state_infinite", "client", frame("STATE", payload("STATE", dict(state, command=float("inf"))), **UP), "ok", "value@32")
invalid("client_health_short", "client", frame("HEALTH", payload("HEALTH", health_first)[:143], **UP), "ok", "short")
invalid("client_health_infinite_half", "client", frame("HEALTH", payload("HEALTH", dict(health, clock_half=float("inf"))), **UP), "ok", "value@148")
invalid("client_slip_short", "client", frame("SLIP", SLIP[:71], **UP), "ok", "short")
invalid("client_slip_infinite", "client", frame("SLIP", payload("SLIP", dict(slip, certified=float("inf"))), **UP), "ok", "value@72")
invalid("client_rows_none", "client", frame("ROWS", ROW[:16] + b"\0" + ROW[17:], **UP), "ok", "value@16")
invalid("client_rows_step_0", "client", frame("ROWS", ROW[:12] + b"\0\0" + ROW[14:], **UP), "ok", "value@12")
invalid("client_rows_no_channel", "client", frame("ROWS", ROW[:14] + b"\0\0" + ROW[16:], **UP), "ok", "value@14")
invalid("client_rows_missing", "client", frame("ROWS", ROW[:16] + b"\x03" + ROW[17:], **UP), "ok", "short")
invalid("client_notice_text_missing", "client", frame("NOTICE", payload("NOTICE", notice)[:-1], **UP), "ok", "short")
BAD = line
for name, role, code, up in (("welcome_to_a_host", "host", 0xA0, True), ("subscribe_to_a_device", "device", 0xA8, False), ("command_to_a_device", "device", 0xA9, False)):
    invalid(name, role, frame(code, COMMAND, host=up, ack=False, **ONE), "unknown")


def save(name, about, rows):
    assert len({row[0] for row in rows}) == len(rows)
    text = f"# {about}. The columns: README.md.\n" + "".join("\t".join(row) + "\n" for row in rows)
    (Path(__file__).parent / name).write_text(text)


assert crc(b"123456789") == 0xE3069283
save("valid.tsv", "Frames that every peer writes and reads alike", ROWS)
save("invalid.tsv", "Bytes that a peer must refuse, and how", BAD)
save("clients.tsv", "Frames of the socket of the daemon", CLIENTS)
save("clients-invalid.tsv", "Bytes that the daemon or a client must refuse", BAD_CLIENTS)
