"""A gripper's ROS 2 node as other implementations see it: rosbags (CDR, hashes of types), xxhash and the Python API of Zenoh.

Usage: ros_check.py MESSAGES DEFINITIONS [GRIPD GRIPFLEET]. MESSAGES is the program ros_messages, DEFINITIONS the folder of the definitions of
grip_msgs; gripd is run on its simulator, with gripfleet, beside a router in this process. Names and tokens are put together here
once more, from docs/design.md of rmw_zenoh.
"""

import json
import math
import re
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy
import xxhash
import zenoh
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from zenoh.ext import Int64, z_deserialize

OWN = ["GripState", "SlipEvent"]
# rcl: letters, digits and underscores, none of them first or twice.
NAME = re.compile(r"(/[A-Za-z](_?[A-Za-z0-9])*)+")
TOPICS = [
    ("joint_states", "sensor_msgs/msg/JointState"),
    ("state", "grip_msgs/msg/GripState"),
    ("slip", "grip_msgs/msg/SlipEvent"),
]
QOS = "::,10:,:,:,,"
PATIENCE_S = 60
SITE, PLACE, DOMAIN = "9-hall.west", "/site_9_hall_west", 7


def types(folder: Path):
    """What rosbags knows of Jazzy, and our own definitions."""
    store = get_typestore(Stores.ROS2_JAZZY)
    for name in OWN:
        store.register(get_types_from_msg((folder / f"{name}.msg").read_text(), f"grip_msgs/msg/{name}"))
    return store


def plain(value: object) -> object:
    """A message as its JSON would be: no number is None."""
    if hasattr(value, "__msgtype__"):
        names = [name for name in value.__dataclass_fields__ if name != "__msgtype__" and not name.isupper()]
        return {name: plain(getattr(value, name)) for name in names}
    if isinstance(value, (list, tuple, numpy.ndarray)):
        return [plain(one) for one in value]
    if isinstance(value, numpy.generic):
        value = value.item()
    return None if isinstance(value, float) and math.isnan(value) else value


def is_right(store, kind: str, data: bytes, wanted: dict) -> bool:
    """Whether the bytes are the message: read by rosbags, field by field, and written by it again."""
    try:
        message = store.deserialize_cdr(data, kind)
        same = bytes(store.serialize_cdr(message, kind, little_endian=True)) == data
    # Damaged bytes fail in many ways; of whole ones none is expected.
    except Exception:  # noqa: BLE001
        return False
    return same and plain(message) == wanted


def dds(kind: str) -> str:
    package, _, name = kind.split("/")
    return f"{package}::msg::dds_::{name}_"


def key(store, domain: int, topic: str, kind: str) -> str:
    return f"{domain}{topic}/{dds(kind)}/{store.hash_rihs01(kind)}"


def publisher_token(store, place: str, topic: str, kind: str) -> str:
    """`place` is the token up to the node's name."""
    return f"{place}/{topic.replace('/', '%')}/{dds(kind)}/{store.hash_rihs01(kind)}/{QOS}"


def check_attachment(data: bytes, token: str) -> tuple[int, int]:
    """Number and time of a publication, whose publisher is the one of the token."""
    number, source_ns, gid = z_deserialize(tuple[Int64, Int64, bytes], zenoh.ZBytes(data))
    digest = xxhash.xxh3_128(token.encode()).intdigest()
    assert gid == digest.to_bytes(16, "little"), (gid.hex(), token)
    return int(number), int(source_ns)


def check_line(store, line: dict) -> int:
    """One printed message; gives the number of wrong messages that were noticed."""
    kind, data, wanted = line["type"], bytes.fromhex(line["bytes"]), line["fields"]
    assert line["hash"] == store.hash_rihs01(kind), (kind, store.hash_rihs01(kind))
    assert is_right(store, kind, data, wanted), (kind, plain(store.deserialize_cdr(data, kind)), wanted)
    assert NAME.fullmatch(line["topic"]) and NAME.fullmatch(line["node"]), line
    assert line["key"] == key(store, line["domain"], line["topic"], kind), line["key"]
    namespace, name = line["node"].rsplit("/", 1)
    start, session, node, entity, rest = line["token"].split("/", 5)[1:5] + [None]
    place = f"@ros2_lv/{start}/{session}/{node}/{entity}/MP/%/{namespace.replace('/', '%')}/{name}"
    assert (start, node, rest) == (str(line["domain"]), "0", None)
    assert line["token"] == publisher_token(store, place, line["topic"], kind), line["token"]
    told = check_attachment(bytes.fromhex(line["attachment"]), line["token"])
    assert told == (line["sequence"], line["source_ns"]), told
    # Where something is not known, another NaN is as good.
    flips = [] if None in wanted.values() else range(len(data))
    wrong = [data[:at] + bytes([data[at] ^ 0x55]) + data[at + 1 :] for at in flips]
    wrong += [data[:length] for length in range(len(data))] + [data + b"\0"]
    for damaged in wrong:
        assert not is_right(store, kind, damaged, wanted), f"{kind}: not noticed: {damaged.hex()}"
    return len(wrong)


def check_printed(store, messages: str) -> None:
    lines = subprocess.run([messages], check=True, stdout=subprocess.PIPE, text=True).stdout.splitlines()
    lines = [json.loads(line) for line in lines]
    assert len(lines) == 6 and {line["type"] for line in lines} == {kind for _, kind in TOPICS}
    wrong = sum(check_line(store, line) for line in lines)
    print(f"ros-check: {len(lines)} messages read and written again by rosbags, {wrong} damaged ones refused")


def session(mode: str, **places: str):
    config = zenoh.Config()
    config.insert_json5("mode", json.dumps(mode))
    config.insert_json5("scouting/multicast/enabled", "false")
    for what, place in places.items():
        config.insert_json5(f"{what}/endpoints", json.dumps([place]))
    return zenoh.open(config)


class Topic:
    """A subscriber as one of rmw_zenoh, peer of the router; it is there before the gripper, of whose name it knows all but the identity."""

    def __init__(self, store, peer, name: str, kind: str) -> None:
        self.store, self.topic, self.name, self.kind, self.heard = store, "", name, kind, []
        self.subscriber = peer.declare_subscriber(key(store, DOMAIN, f"{PLACE}/*/{name}", kind), self.heard.append)

    def check(self, place: str) -> list:
        """The messages under the topic's exact name, of which none is missing."""
        assert {str(sample.key_expr) for sample in self.heard} == {key(self.store, DOMAIN, self.topic, self.kind)}
        token, messages, last = publisher_token(self.store, place, self.topic, self.kind), [], None
        for sample in list(self.heard):
            number, source_ns = check_attachment(sample.attachment.to_bytes(), token)
            assert last in (None, number - 1), (self.topic, last, number)
            last = number
            message = self.store.deserialize_cdr(sample.payload.to_bytes(), self.kind)
            stamp_ns = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
            assert 0 <= source_ns - stamp_ns < PATIENCE_S * 10**9 and abs(source_ns - time.time_ns()) < 2 * PATIENCE_S * 10**9
            messages.append((stamp_ns, message))
        return messages


def tokens(peer) -> set[str]:
    replies = peer.liveliness().get(f"@ros2_lv/{DOMAIN}/**", timeout=5.0)
    return {str(reply.ok.key_expr) for reply in replies if reply.ok}


def wait(what: str, is_so, gripd: subprocess.Popen) -> None:
    """Looks until it is so."""
    until = time.monotonic() + PATIENCE_S
    while not is_so():
        assert gripd.poll() is None, f"gripd has ended: {gripd.returncode}"
        assert time.monotonic() < until, f"not within {PATIENCE_S} s: {what}"
        time.sleep(0.02)


CAUSES = ["knock", "motion", "grip_change", "closing", "arm_stop"]


def check_slips(messages: list, printed: list[dict]) -> None:
    """Each slip is the one that gripd printed."""
    phases = {"incipient": 1, "gross": 2}
    names = ["statistic", "confidence", "speed_m_s", "speed_sigma_m_s", "moved_m", "irregularities", "estimate_n", "command_n", "duration_s"]
    assert [message.number for _, message in messages] == list(range(messages[0][1].number, messages[0][1].number + len(messages)))
    for _, message in messages:
        line = printed[message.number - 1]
        assert message.phase == phases.get(line.get("phase"), 3), (message, line)
        assert abs(message.device_time_us - line["t_s"] * 1e6) < 1.0, (message, line)
        for name in names:
            value, wanted = plain(getattr(message, name)), line.get(name)
            value = None if value == 0xFFFF_FFFF else value
            same = value is wanted if wanted is None else numpy.float32(wanted) == numpy.float32(value)
            assert same, (name, value, wanted)
        for name in ["ruled_out", "possible"]:
            causes = [cause for bit, cause in enumerate(CAUSES) if getattr(message, name) >> bit & 1]
            assert causes == line.get(name, []), (name, causes, line)


def check_tokens(store, found: set[str], topics: list[Topic]) -> list[str]:
    """Node and publishers have the tokens that they should have; gives those of the publishers up to the node's name."""
    node = next(token for token in found if "/NN/" in token)
    _, domain, _, _, _, _, enclave, namespace, name = node.split("/")
    assert (domain, enclave, name) == (str(DOMAIN), "%", "gripd"), node
    namespace = namespace.replace("%", "/")
    assert re.fullmatch(PLACE + "/gripper_[0-9a-f]{32}", namespace), namespace
    for topic in topics:
        topic.topic = f"{namespace}/{topic.name}"
    places = [node.replace("/0/0/NN/", f"/0/{entity}/MP/") for entity in (1, 2, 3)]
    expected = {publisher_token(store, at, topic.topic, topic.kind) for at, topic in zip(places, topics, strict=True)}
    assert found == expected | {node}, found ^ expected
    return places


def check_heard(topics: list[Topic], places: list[str], printed: list[dict]) -> None:
    joints, states, slips = [topic.check(at) for topic, at in zip(topics, places, strict=True)]
    forces = {stamp: message.applied_n for stamp, message in states}
    assert joints and forces.keys() >= {stamp for stamp, _ in joints[:-1]}
    for stamp, joint in joints:
        assert joint.name == ["fingers"] and not len(joint.position) and not len(joint.velocity)
        known = [force for force in [forces.get(stamp, numpy.nan)] if not math.isnan(force)]
        assert stamp not in forces or list(joint.effort) == known, (stamp, joint)
    check_slips(slips, [line for line in printed if line["type"].startswith("slip")])
    print(f"ros-check: {len(joints)} joint states, {len(states)} states, {len(slips)} slips heard of gripd beside a router")


def check_live(store, program: str, fleet: str) -> None:
    """gripd on its simulator and gripfleet, found and heard as by a computer with rmw_zenoh, and gone when it ends."""
    with socket.create_server(("127.0.0.1", 0)) as free:
        endpoint = f"tcp/127.0.0.1:{free.getsockname()[1]}"
    router, folder = session("router", listen=endpoint), tempfile.TemporaryDirectory()
    peer, place = session("peer", connect=endpoint), Path(folder.name)
    topics = [Topic(store, peer, name, kind) for name, kind in TOPICS]
    (place / "gripd.toml").write_text(f'listen = "unix:{place}/gripd.sock"\n[fleet]\nsite = "{SITE}"\nrouter = "{endpoint}"\nros_domain = {DOMAIN}\n')
    command = [program, "--port", "sim", "--json", "--config", "gripd.toml"]
    with (place / "out").open("wb") as out, (place / "err").open("wb") as err:
        gripd = subprocess.Popen(command, cwd=place, stdout=out, stderr=err)
        other = subprocess.Popen([fleet, "--config", "gripd.toml"], cwd=place, stderr=err)
    try:
        wait("a node", lambda: len(tokens(peer)) == 4, gripd)
        places = check_tokens(store, tokens(peer), topics)
        wait("states", lambda: len(topics[1].heard) >= 10, gripd)
        wait("slips", lambda: topics[2].heard, gripd)
        gripd.terminate()
        assert gripd.wait(PATIENCE_S) == 0, (place / "err").read_text()
        until = time.monotonic() + PATIENCE_S
        while tokens(peer):
            assert time.monotonic() < until, f"tokens stay: {tokens(peer)}"
        check_heard(topics, places, [json.loads(line) for line in (place / "out").read_text().splitlines()])
    finally:
        other.kill()
        gripd.kill()
        peer.close()
        router.close()
        folder.cleanup()


def main() -> None:
    store = types(Path(sys.argv[2]))
    check_printed(store, sys.argv[1])
    if len(sys.argv) > 4:
        check_live(store, *sys.argv[3:])


if __name__ == "__main__":
    main()
