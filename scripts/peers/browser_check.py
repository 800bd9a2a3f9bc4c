"""A page in Chromium tries to command a gripper through the client socket of gripd; nothing may be carried out. gripd's own page works.

Usage: browser_check.py GRIPD FOLDER. gripd holds an object on the simulator, with allow_commands and the default kind of address. The page
comes from a foreign name and sends frames in the bodies of requests, as WebSocket, as TLS and as TURN. The same goes to a plain listener:
a page that sends nothing would pass otherwise. Then gripd must have carried out nothing and refused every connection.
"""

import base64
import json
import re
import socket
import subprocess
import sys
import threading
import time
import urllib.request
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

from grip_link import Daemon
from grip_link.daemon import DaemonLink
from grip_link.messages import Kind
from grip_link.messages.daemon import Command, Notice, NoticeKind, Operation, State, Subscribe

# Longer than anything takes, however busy the machine.
PATIENCE_S = 120
ASKED_N = 25.0
PAGE = """<!DOCTYPE html><title>a page</title><iframe name="away" style="display:none"></iframe><script>
const frames = Uint8Array.from(atob("FRAMES"), letter => letter.charCodeAt(0));
const soon = ms => new Promise(done => setTimeout(done, ms));
const blob = type => new Blob([frames], {type});
async function attack(port) {
    const url = "http://127.0.0.1:" + port + "/";
    const send = options => fetch(url, {signal: AbortSignal.timeout(3000), ...options}).catch(error => error);
    const form = new FormData();
    form.append("file", blob("application/octet-stream"), "a.bin");
    await send({method: "POST", mode: "no-cors", body: blob("text/plain")});
    await send({method: "POST", mode: "no-cors", body: form});
    await send({method: "PUT", body: blob("application/octet-stream")});
    await send({method: "GET", mode: "no-cors"});
    await send({method: "HEAD", mode: "no-cors"});
    await fetch("https://127.0.0.1:" + port + "/", {mode: "no-cors", signal: AbortSignal.timeout(3000)}).catch(error => error);
    navigator.sendBeacon(url, blob("text/plain"));
    const files = new DataTransfer();
    files.items.add(new File([frames], "a.bin"));
    document.body.insertAdjacentHTML("beforeend",
        `<form id="f${port}" method="post" enctype="multipart/form-data" target="away" action="${url}"><input type="file" name="x"></form>`);
    const page = document.getElementById("f" + port);
    page.elements.x.files = files.files;
    page.submit();
    await soon(1000);
    try {
        const talk = new WebSocket("ws://127.0.0.1:" + port + "/");
        talk.onopen = () => talk.send(frames);
    } catch (error) {}
    await soon(1000);
    const call = new RTCPeerConnection({iceServers: [
        {urls: "turn:127.0.0.1:" + port + "?transport=tcp", username: "u".repeat(100), credential: "x"}], iceTransportPolicy: "relay"});
    call.createDataChannel("x");
    await call.setLocalDescription(await call.createOffer());
    await soon(2000);
}
(async () => {
    for (const port of [PORTS]) await attack(port);
    await fetch("/done", {method: "POST", body: "done"});
})();
</script>"""


class Site(ThreadingHTTPServer):
    """The foreign site; `done` is set when its page has tried everything."""

    def __init__(self, page: str) -> None:
        self.done = threading.Event()
        site = self

        class Handler(BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                text = page.encode()
                self.send_response(200)
                self.send_header("Content-Type", "text/html; charset=utf-8")
                self.send_header("Content-Length", str(len(text)))
                self.end_headers()
                self.wfile.write(text)

            def do_POST(self) -> None:
                self.send_response(204)
                self.end_headers()
                site.done.set()

            def log_message(self, *_: object) -> None:
                pass

        super().__init__(("127.0.0.1", 0), Handler)
        threading.Thread(target=self.serve_forever, daemon=True).start()


class Plain:
    """A listener that keeps what each connection sends."""

    def __init__(self) -> None:
        self.came = []
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        threading.Thread(target=self.run, daemon=True).start()

    def run(self) -> None:
        while True:
            connection, _ = self.listener.accept()
            threading.Thread(target=self.take, args=(connection,), daemon=True).start()

    def take(self, connection: socket.socket) -> None:
        at = len(self.came)
        self.came.append(b"")
        connection.settimeout(1)
        try:
            while data := connection.recv(65536):
                self.came[at] += data
        except OSError:
            pass
        connection.close()


class Viewer(threading.Thread):
    """A client that notes the commands that were carried out, and the commanded force."""

    def __init__(self, port: int) -> None:
        super().__init__(daemon=True)
        self.daemon_ = Daemon.open(f"socket://127.0.0.1:{port}", Subscribe(state_ms=20))
        self.obeyed, self.forces, self.broken = [], [], None
        self.start()

    def run(self) -> None:
        try:
            for message in self.daemon_.messages():
                if isinstance(message, Notice) and message.kind == NoticeKind.CLIENT:
                    self.obeyed.append(message.text)
                elif isinstance(message, State):
                    self.forces.append(message.command)
        except Exception as error:  # the thread says it to the main one
            self.broken = error


def frames() -> bytes:
    """What a client sends to move the gripper."""
    link = DaemonLink(77)
    commands = [Command(Operation.AT_LEAST, force_mn=int(1000 * ASKED_N)), Command(Operation.STOP)]
    requests = [(Kind.SUBSCRIBE, Subscribe().pack())] + [(Kind.COMMAND, command.pack()) for command in commands]
    return b"".join(link.request(kind, payload)[1] for kind, payload in requests)


def until(what: str, done) -> None:
    end = time.monotonic() + PATIENCE_S
    while not done():
        assert time.monotonic() < end, f"{what} within {PATIENCE_S} s"
        time.sleep(0.05)


def head_and_frames(port: int) -> None:
    """The same without a browser: head and frames in one write."""
    for method in ["GET", "POST", "PUT", "HEAD", "OPTIONS"]:
        head = f"{method} / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nContent-Length: {len(frames())}\r\n\r\n".encode()
        with socket.create_connection(("127.0.0.1", port), timeout=PATIENCE_S) as connection:
            connection.sendall(head + frames())
            end = time.monotonic() + PATIENCE_S
            try:
                while connection.recv(65536):
                    assert time.monotonic() < end, f"{method}: the connection is still open"
            except ConnectionError:
                pass


def tabs(profile: Path, method: str, path: str) -> list | dict:
    """What the browser answers about its tabs."""
    port = (profile / "DevToolsActivePort").read_text().split()[0]
    request = urllib.request.Request(f"http://127.0.0.1:{port}/json/{path}", method=method)
    with urllib.request.urlopen(request, timeout=PATIENCE_S) as answer:
        return json.load(answer)


def main() -> None:
    program, folder = sys.argv[1], Path(sys.argv[2])
    config = folder / "gripd.toml"
    config.write_text("allow_commands = true\n")
    log = open(folder / "gripd.log", "w+")
    with socket.create_server(("127.0.0.1", 0)) as free, socket.create_server(("127.0.0.1", 0)) as other:
        port, http = free.getsockname()[1], other.getsockname()[1]
    arguments = ["--config", config, "--port", "sim", "--seed", "2", "--listen", f"tcp:127.0.0.1:{port}", "--log-level", "info",
                 "--metrics", f"127.0.0.1:{http}"]
    gripd = subprocess.Popen([program, *arguments], stdout=subprocess.DEVNULL, stderr=log)
    browser = None
    try:
        def listens() -> bool:
            assert gripd.poll() is None, (folder / "gripd.log").read_text()
            return socket.socket().connect_ex(("127.0.0.1", port)) == 0

        until("gripd listens", listens)
        viewer = Viewer(port)
        until("the object is held", lambda: len(viewer.forces) > 50 and viewer.forces[-1] > 1)
        head_and_frames(port)
        plain = Plain()
        page = PAGE.replace("FRAMES", base64.b64encode(frames()).decode()).replace("PORTS", f"{port}, {plain.port}")
        site = Site(page)
        browser = subprocess.Popen(
            ["chromium", "--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-dev-shm-usage",
             f"--user-data-dir={folder / 'profile'}", "--host-resolver-rules=MAP evil.example 127.0.0.1",
             "--no-proxy-server", "--remote-debugging-port=0", f"http://evil.example:{site.server_port}/"],
            stdout=subprocess.DEVNULL, stderr=open(folder / "chromium.log", "w"))
        until("the page has tried everything", site.done.is_set)
        tabs(folder / "profile", "PUT", f"new?http://127.0.0.1:{http}/")
        until("gripd's own page says HELD",
              lambda: any(re.match(r"HELD \d", tab["title"]) for tab in tabs(folder / "profile", "GET", "list")))
        bodies = sum(frames() in sent for sent in plain.came)
        heads = sorted({sent.split(b" ")[0].decode("latin-1")[:8] for sent in plain.came if sent})
        assert bodies >= 3, f"the page sent the frames {bodies} times only: {heads}"
        assert any(b"Upgrade: websocket" in sent for sent in plain.came), heads
        time.sleep(1)
        assert viewer.broken is None, viewer.broken
        assert viewer.obeyed == [], viewer.obeyed
        assert max(viewer.forces) < ASKED_N, max(viewer.forces)
        gripd.terminate()
        gripd.wait(PATIENCE_S)
        text = (folder / "gripd.log").read_text()
        assert "a client asked" not in text, text
        first = text.count("did not begin with SUBSCRIBE")
        refused = first + sum(int(times) for times in re.findall(r"SUBSCRIBE.*\(and (\d+) times more\)", text))
        assert refused >= 5 + bodies, text
        print(json.dumps({"bodies with frames": bodies, "beginnings": heads, "refused": refused, "carried out": 0,
                          "largest force": round(max(viewer.forces), 2)}))
    finally:
        for process in [browser, gripd]:
            if process and process.poll() is None:
                process.terminate()
                process.wait(PATIENCE_S)


if __name__ == "__main__":
    main()
