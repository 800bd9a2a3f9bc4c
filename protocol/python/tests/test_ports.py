"""Real ports: a pseudo-terminal, a socket on loopback, loop://, and the commands."""

from __future__ import annotations

import math
import os
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from grip_link import ChannelKind, Config, GripLink, LinkClosed, Pty, StreamClosed, VirtualMcu
from grip_link.stream import ByteStream, FdStream, SerialStream, open_stream

CONFIG = Config(sample_rate_hz=1000, batch=5)


@contextmanager
def gripper(stream: ByteStream) -> Iterator[VirtualMcu]:
    """A gripper that runs in a thread."""
    mcu = VirtualMcu(stream, lambda t_s: (1e-6 * math.sin(40 * t_s), 2.0))
    running = True

    def run() -> None:
        try:
            while running:
                mcu.step(0.001)
        except StreamClosed:
            pass

    thread = threading.Thread(target=run)
    thread.start()
    try:
        yield mcu
    finally:
        running = False
        thread.join()


def hold(link: GripLink) -> None:
    """300 samples with a force of 2 N, which must arrive."""
    count = 0
    for sample in link.samples(10.0):
        link.grip(2.0)
        assert abs(sample[ChannelKind.STYLUS]) <= 1.01e-6 and sample[ChannelKind.NORMAL_FORCE] == pytest.approx(2.0)
        count += 1
        if count == 300:
            break
    assert count == 300
    assert link.wait(lambda: link.status is not None and link.status.applied_mn == 2000, 2.0)
    assert link.counters.bad_blocks == 0


def test_pty() -> None:
    with Pty() as pty, gripper(pty.stream) as mcu:
        with GripLink.open(pty.path, CONFIG) as link:
            hold(link)
        time.sleep(0.1)
        assert mcu.drive.force_mn == 2000
        with GripLink.open(pty.path, CONFIG) as link:
            assert sum(1 for _ in link.samples(0.1)) > 10


def test_a_port_is_opened_by_one_program_only() -> None:
    with Pty() as pty, gripper(pty.stream), GripLink.open(pty.path, CONFIG), pytest.raises(OSError):
        GripLink.open(pty.path, CONFIG)


@contextmanager
def listener() -> Iterator[tuple[socket.socket, str]]:
    with socket.create_server(("127.0.0.1", 0)) as server:
        yield server, f"socket://127.0.0.1:{server.getsockname()[1]}"


def test_socket() -> None:
    with listener() as (server, url):
        stream = open_stream(url)
        peer, _ = server.accept()
        with peer, gripper(FdStream(peer.fileno(), owns=False)):
            with GripLink(stream, CONFIG) as link:
                link.connect()
                hold(link)


def test_a_socket_that_is_hung_up_closes_the_link() -> None:
    with listener() as (server, url):
        stream = open_stream(url)
        peer, _ = server.accept()
        with GripLink(stream, CONFIG) as link:
            with gripper(FdStream(peer.fileno(), owns=False)):
                link.connect()
            peer.close()
            with pytest.raises(LinkClosed) as closed:
                link.wait(lambda: False, 5.0)
            assert closed.value.code == "port"


def test_loop_is_an_echo_and_no_gripper() -> None:
    stream = open_stream("loop://")
    assert isinstance(stream, SerialStream)
    with GripLink(stream, CONFIG) as link:
        with pytest.raises(LinkClosed, match="no_answer"):
            link.connect(0.7)
        assert link.counters.echo >= 5 and link.counters.bad_blocks == 0


def test_1200_baud_is_refused() -> None:
    with pytest.raises(ValueError, match="1200"):
        open_stream("/nowhere", 1200)


def command(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "grip_link", *words], capture_output=True, text=True, timeout=60, check=False
    )


def test_the_commands(tmp_path: Path) -> None:
    port = tmp_path / "gripper"
    with subprocess.Popen([sys.executable, "-m", "grip_link", "mcu", "--pty", str(port), "--duration", "60"], stderr=subprocess.PIPE, text=True) as mcu:
        try:
            assert mcu.stderr is not None and str(port) in mcu.stderr.readline()
            info = command("info", str(port))
            assert info.returncode == 0 and "stylus x 1, 1e-08 metre a step" in info.stdout
            table = command("watch", str(port), "--duration", "0.5", "--rate", "500")
            lines = table.stdout.splitlines()
            assert table.returncode in (0, 3) and lines[0] == "index,t_s,stylus_m,normal_force_n"
            assert len(lines) > 100 and all(abs(float(line.split(",")[2])) < 2.1e-6 for line in lines[1:])
        finally:
            mcu.send_signal(2)
    assert mcu.returncode == 0 and not os.path.lexists(port)


def test_commands_say_what_is_wrong(tmp_path: Path) -> None:
    missing = command("info", str(tmp_path / "none"))
    assert missing.returncode == 1 and missing.stderr.startswith("grip_link: ") and not missing.stdout
    assert command().returncode == 2
    (tmp_path / "taken").touch()
    taken = command("mcu", "--pty", str(tmp_path / "taken"))
    assert taken.returncode == 1 and "taken" in taken.stderr
