"""COBS, CRC and the decoder: round trips, any chunking, damage."""

from __future__ import annotations

import random
from dataclasses import asdict

import pytest
from grip_link import cobs, frame
from grip_link.crc import crc32c
from grip_link.decoder import Block, Decoder, Role, Verdict
from grip_link.frame import Header
from grip_link.messages import Kind, Ping

from vectors import INVALID, VALID


def test_crc_check_value() -> None:
    assert crc32c(b"123456789") == 0xE3069283
    assert crc32c(b"") == 0 and crc32c(b"6789", crc32c(b"12345")) == 0xE3069283


@pytest.mark.parametrize("zeros", [0.0, 0.01, 0.3, 0.99])
def test_cobs_round_trip(zeros: float) -> None:
    rng = random.Random(2)
    for length in [*range(6), *range(250, 260), *range(505, 515), 480, 492, 700]:
        data = bytes(0 if rng.random() < zeros else rng.randint(1, 255) for _ in range(length))
        block = cobs.encode(data)
        assert 0 not in block and len(block) <= cobs.max_encoded(length)
        assert cobs.decode(block) == data


@pytest.mark.parametrize("block", [b"", b"\0", b"\2", b"\3\1", b"\2\7\0\1", b"\xff" + bytes(253)])
def test_broken_cobs_is_refused(block: bytes) -> None:
    with pytest.raises(cobs.CobsError):
        cobs.decode(block)


def corpus() -> bytes:
    return b"".join(bytes.fromhex(case.wire) for case in VALID if case.direction != "cobs") + b"".join(
        bytes.fromhex(case.wire) for case in INVALID
    )


def decode(chunks: list[bytes], role: Role) -> tuple[list[Block], dict[str, int]]:
    decoder = Decoder(role)
    decoder.open_session(0xBEEF)
    blocks = [block for chunk in chunks for block in decoder.feed(chunk)]
    return blocks, asdict(decoder.counters)


@pytest.mark.parametrize("role", list(Role))
def test_chunking_makes_no_difference(role: Role) -> None:
    rng = random.Random(3)
    whole = bytearray(corpus())
    for _ in range(40):
        whole[rng.randrange(len(whole))] = rng.randrange(256)
    data = bytes(whole)
    expected = decode([data], role)
    assert len(expected[0]) > 60
    assert decode([data[at : at + 1] for at in range(len(data))], role) == expected
    for _ in range(20):
        cuts = sorted(rng.randrange(len(data)) for _ in range(rng.randrange(200)))
        chunks = [data[a:b] for a, b in zip([0, *cuts], [*cuts, len(data)])]
        assert decode(chunks, role) == expected


def test_a_session_opened_between_two_blocks_holds_for_the_second() -> None:
    first = frame.encode(Header(Kind.PING, 1, 1, to_host=False), Ping(1).pack())
    second = frame.encode(Header(Kind.PING, 1, 2, to_host=False), Ping(2).pack())
    decoder = Decoder(Role.DEVICE)
    decoder.open_session(1)
    verdicts = []
    for block in decoder.feed(first + second):
        verdicts.append(block.verdict)
        decoder.open_session(2)
    assert verdicts == [Verdict.OK, Verdict.OK]


def test_blocks_not_fetched_come_with_the_next_bytes() -> None:
    wire = frame.encode(Header(Kind.STATUS, 1, 1, to_host=True), bytes(24))
    decoder = Decoder(Role.TAP)
    decoder.feed(wire + wire)
    assert [block.verdict for block in decoder.feed(wire)] == [Verdict.OK, Verdict.DUPLICATE, Verdict.DUPLICATE]


def test_memory_is_bounded() -> None:
    decoder = Decoder(Role.DEVICE)
    for _ in range(1000):
        assert list(decoder.feed(b"\x55" * 1000)) == []
    assert len(decoder._block) <= frame.MAX_BLOCK and not decoder._input
    (block,) = decoder.feed(b"\0")
    assert block.verdict is Verdict.TOO_LONG and decoder.counters.garbage_bytes == 1_000_000


def test_the_longest_block_is_a_frame_and_one_byte_more_is_not() -> None:
    longest = frame.encode(Header(Kind.SAMPLES, 1, 1, to_host=True), b"\1" * 480)
    assert len(longest) == frame.MAX_WIRE
    (block,) = Decoder(Role.TAP).feed(longest)
    assert block.verdict is Verdict.OK
    (block,) = Decoder(Role.TAP).feed(longest[:-1] + b"\1\0")
    assert block.verdict is Verdict.TOO_LONG


def test_every_byte_of_a_frame_changed_is_never_accepted() -> None:
    before, after = (frame.encode(Header(Kind.PING, seq, 0xBEEF, to_host=False), Ping(seq).pack()) for seq in (6, 8))
    golden = bytes.fromhex(next(case.wire for case in VALID if case.name == "grip_reference"))
    sent = [block.frame for block in decode([before + golden + after], Role.DEVICE)[0]]
    for at in range(len(golden)):
        for other in range(1, 256):
            changed = golden[:at] + bytes([golden[at] ^ other]) + golden[at + 1 :]
            blocks, _ = decode([before + changed + after], Role.DEVICE)
            good = [block.frame for block in blocks if block.verdict is Verdict.OK]
            assert good in (sent, [sent[0], sent[2]])


def test_sequence_wraps_and_gaps_are_counted() -> None:
    def ping(seq: int) -> bytes:
        return frame.encode(Header(Kind.PING, seq & 0xFFFF, 5, to_host=False), Ping(seq).pack())

    decoder = Decoder(Role.DEVICE)
    decoder.open_session(5)
    for seq in range(65_530, 65_546):
        (block,) = decoder.feed(ping(seq))
        assert block.verdict is Verdict.OK
    assert decoder.counters.gap == 0
    for seq, verdict in ((9, Verdict.DUPLICATE), (65_535, Verdict.DUPLICATE), (12, Verdict.OK), (1000, Verdict.OK)):
        (block,) = decoder.feed(ping(seq))
        assert block.verdict is verdict
    assert decoder.counters.gap == 2 + 987
