#!/usr/bin/env python3
"""The studio's server without a browser: who may speak to it, what it refuses, and what is on disk whatever happens.

    test_server.py PROGRAM FOLDER [SECONDS]     SECONDS of mangled requests (2)

Exits with 77 where the program was built without the studio."""
import atexit
import concurrent.futures
import contextlib
import http.client
import json
import os
import random
import resource
import shutil
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
import zlib
from pathlib import Path


class Studio:
    def __init__(self, program, folder, *options, limit=0):
        def prepare():
            if limit:
                resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

        self.process = subprocess.Popen([program, "studio", str(folder), "--no-browser", *options], stdout=subprocess.PIPE,
                                        stderr=subprocess.PIPE, text=True, preexec_fn=prepare)
        atexit.register(self.process.kill)  # after a failure
        line = self.process.stdout.readline()
        if "open http://" not in line:
            self.error = self.process.stderr.read()
            self.process.wait()
            return
        self.error, url = "", line.split("open ")[1].split()[0]
        self.port, self.key = int(url.split(":")[2].split("/")[0]), url.rstrip("/").split("/")[-1]
        self.folder = folder

    def ask(self, method, path, body=None, key=None, **headers):
        """Status and body of a request as the page makes it, but for what is given; a header that is None is left out."""
        sent = {"Host": f"127.0.0.1:{self.port}", "Origin": f"http://127.0.0.1:{self.port}"}
        sent.update({name.replace("_", "-"): value for name, value in headers.items()})
        link = http.client.HTTPConnection("127.0.0.1", self.port, timeout=20)
        link.putrequest(method, f"/{self.key if key is None else key}/{path}", skip_host=True)
        if body is not None and "Content_Length" not in headers:
            sent["Content-Length"] = str(len(body))
        for name, value in sent.items():
            if value is not None:
                link.putheader(name, value)
        link.endheaders(body)
        answer = link.getresponse()
        data = answer.read()
        link.close()
        return answer.status, data

    def do(self, **request):
        status, data = self.ask("POST", "do", json.dumps(request).encode())
        return status, json.loads(data)

    def state(self):
        return json.loads(self.ask("GET", "state")[1])

    def wait(self, end="done"):
        stop = time.monotonic() + 240  # seconds, beside other work
        while (state := self.state())["job"]["end"] == "running":
            assert time.monotonic() < stop
            time.sleep(0.05)
        assert state["job"]["end"] == end, state["job"]
        return state

    def photograph(self, name, number, picture):
        status, data = self.ask("POST", f"photograph?set={name}&number={number}", picture)
        return status, json.loads(data)

    def raw(self, data, wait=5.0):
        """The answer to raw bytes."""
        with socket.create_connection(("127.0.0.1", self.port), timeout=wait) as link:
            got = b""
            try:
                link.sendall(data)
                link.shutdown(socket.SHUT_WR)
                while more := link.recv(65536):
                    got += more
            except OSError:
                pass
            return got

    def memory(self):
        """Resident, MB."""
        return int(Path(f"/proc/{self.process.pid}/statm").read_text().split()[1]) * resource.getpagesize() / 1e6

    def kill(self):
        self.process.kill()
        self.process.wait()

    def stop(self):
        self.process.terminate()
        assert self.process.wait(timeout=30) == 0, self.process.returncode


def png(width=64, height=48, grey=128):
    rows = b"".join(b"\0" + bytes((grey, grey, grey)) * width for _ in range(height))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


# --- Who may speak. ---

def strangers_are_refused(studio):
    here = f"127.0.0.1:{studio.port}"
    assert studio.ask("GET", "")[0] == 200
    assert studio.ask("GET", "", Host=f"localhost:{studio.port}", Origin=None)[0] == 200
    refused = [
        ("GET", "state", {"key": ""}), ("GET", "state", {"key": "0" * 32}), ("GET", "state", {"key": studio.key[:-1]}),
        ("GET", "state", {"key": studio.key + "0"}), ("GET", "state", {"key": studio.key.upper() + "x"}),
        ("GET", "state", {"Host": "example.org"}), ("GET", "state", {"Host": f"example.org:{studio.port}"}),
        ("GET", "state", {"Host": "127.0.0.1"}), ("GET", "state", {"Host": f"127.0.0.1:{studio.port}.example.org"}),
        ("GET", "state", {"Origin": "http://example.org"}), ("GET", "state", {"Origin": "null"}),
        ("GET", "state", {"Origin": f"https://{here}"}), ("GET", "state", {"Origin": f"http://{here}0"}),
        ("GET", "state", {"Sec_Fetch_Site": "cross-site"}), ("GET", "state", {"Sec_Fetch_Site": "same-site"}),
        ("POST", "do", {"Origin": None}), ("POST", "do", {"Origin": "http://example.org"}),
        ("POST", "photograph", {"Origin": None}),
    ]
    for method, path, how in refused:
        status, data = studio.ask(method, path, b"{}" if method == "POST" else None, **how)
        assert status == 403, (method, path, how, status)
        assert studio.key.encode() not in data
    for method in ("PUT", "DELETE", "OPTIONS", "TRACE", "CONNECT", "PATCH", "HEAD", "get"):
        assert studio.ask(method, "state")[0] in (400, 405), method
    # no Host at all, HTTP/1.0
    assert b" 40" in studio.raw(f"GET /{studio.key}/state?known=1 HTTP/1.0\r\n\r\n".encode()).split(b"\r\n")[0]
    headers = studio.raw(f"GET /{studio.key}/ HTTP/1.1\r\nHost: {here}\r\nConnection: close\r\n\r\n".encode()).split(b"\r\n\r\n")[0]
    for needed in (b"frame-ancestors 'none'", b"nosniff", b"no-referrer", b"no-store", b"Opener-Policy: same-origin"):
        assert needed in headers, needed
    return len(refused) + 9


def no_path_leads_out(studio):
    secret = studio.folder.parent / "secret.txt"
    secret.write_text("secret")
    (studio.folder / "link.txt").symlink_to(secret)
    (studio.folder / "out").symlink_to(studio.folder.parent)
    os.mkfifo(studio.folder / "pipe.txt")
    (studio.folder / "evil.html").write_text("<script>1</script>")
    assert studio.ask("GET", "file/studio.json")[0] == 200
    paths = ["../secret.txt", "%2e%2e/secret.txt", "..%2fsecret.txt", "patterns/../../secret.txt", "link.txt", "out/secret.txt", "/etc/passwd",
             "//etc/passwd", "%2fetc%2fpasswd", ".studio-lock", ".", "..", "", "/", "patterns", "patterns/", "pipe.txt", "evil.html",
             "studio.json/", "studio.json%00.png", "a" * 300 + ".txt", "\\..\\secret.txt", "patterns/./001_black.png", "~/.profile", "none.txt"]
    for path in paths:
        status, data = studio.ask("GET", "file/" + path)
        assert status in (400, 404) and b"secret" not in data and b"root:" not in data, (path, status)
    for path in ("../state", "%2e%2e/state", "x", "do", "photograph"):
        assert studio.ask("GET", path)[0] in (400, 403, 404), path
    for name in ("link.txt", "out", "pipe.txt", "evil.html"):
        (studio.folder / name).unlink()
    return len(paths) + 5


def bodies_are_bounded(studio):
    before = studio.memory()
    head = f"POST /{studio.key}/%s HTTP/1.1\r\nHost: 127.0.0.1:{studio.port}\r\nOrigin: http://127.0.0.1:{studio.port}\r\n"
    for path, length in (("photograph?set=a&number=1", 10 << 30), ("do", 10 << 30), ("do", (1 << 16) + 1), ("photograph", (1 << 26) + 1),
                         ("do", 1 << 62)):
        assert b" 413 " in studio.raw((head % path + f"Content-Length: {length}\r\n\r\n").encode()).split(b"\r\n")[0], (path, length)
    assert b" 200 " not in studio.raw((head % "do" + "Content-Length: 99999999999999999999999\r\n\r\n").encode())
    # chunks without an end
    with socket.create_connection(("127.0.0.1", studio.port), timeout=10) as link:
        link.sendall((head % "do" + "Transfer-Encoding: chunked\r\n\r\n").encode())
        sent, chunk = 0, b"4000\r\n" + b"x" * 0x4000 + b"\r\n"
        try:
            while sent < 1 << 24:
                link.sendall(chunk)
                sent += 0x4000
        except OSError:
            pass
    assert sent < 1 << 24, "a request's body has no end"
    assert b" 200 " not in studio.raw(f"GET /{studio.key}/state?known=1 HTTP/1.1\r\n".encode() + b"X: " + b"y" * (1 << 17) + b"\r\n\r\n")
    assert studio.ask("GET", "state")[0] == 200
    grown = studio.memory() - before
    assert grown < 40, grown
    return grown


@contextlib.contextmanager
def thousand_connections(studio):
    """Idle ones and halves of requests; another is answered beside them, and the server has ended them in time, whatever is done meanwhile."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(hard, 4096), hard))
    links = []
    for i in range(1000):
        link = socket.create_connection(("127.0.0.1", studio.port), timeout=20)
        if i % 2:
            link.sendall(b"POST /x HTTP/1.1\r\nHo")
        links.append(link)
    with concurrent.futures.ThreadPoolExecutor(len(links[::50])) as waiting:
        ended = [waiting.submit(ended_by_server, link) for link in links[::50]]
        began = time.monotonic()
        assert studio.ask("GET", "state")[0] == 200
        print(f"beside 1000 connections an answer takes {time.monotonic() - began:.3f} s")
        yield
    assert all(one.result() for one in ended), sum(one.result() for one in ended)
    for link in links:
        link.close()
    resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
    assert studio.ask("GET", "state")[0] == 200


def ended_by_server(link):
    link.settimeout(40)
    try:
        while link.recv(65536):
            pass
        return True
    except TimeoutError:
        return False
    except OSError:
        return True


def send_only(studio, data):
    link = socket.create_connection(("127.0.0.1", studio.port), timeout=5)
    try:
        link.sendall(data)
    except OSError:  # it was refused before its end
        pass
    return link


def mangled_requests(studio, seconds):
    """The server outlives them, and the settings are as before."""
    dice, count, waiting = random.Random(36), 0, []
    before = (studio.folder / "studio.json").read_bytes()
    here = f"127.0.0.1:{studio.port}"
    body = json.dumps({"verb": "none", "settings": {"projector": [320, 200]}, "set": "calibration/attitude-00", "number": 1}).encode()
    seeds = [
        f"GET /{studio.key}/state?known=1 HTTP/1.1\r\nHost: {here}\r\n\r\n".encode(),
        f"GET /{studio.key}/file/studio.json HTTP/1.1\r\nHost: {here}\r\n\r\n".encode(),
        f"POST /{studio.key}/do HTTP/1.1\r\nHost: {here}\r\nOrigin: http://{here}\r\nContent-Length: {len(body)}\r\n\r\n".encode() + body,
        f"POST /{studio.key}/photograph?set=calibration/attitude-00&number=1 HTTP/1.1\r\nHost: {here}\r\nOrigin: http://{here}\r\n"
        f"Content-Length: 300\r\n\r\n".encode() + png()[:300],
    ]
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        data = bytearray(dice.choice(seeds))
        for _ in range(dice.randint(1, 8)):
            at = dice.randrange(len(data))
            what = dice.random()
            if what < 0.5:
                data[at] = dice.randrange(256)
            elif what < 0.7:
                del data[at:at + dice.randint(1, 12)]
            elif what < 0.9:
                data[at:at] = dice.choice([b"\r\n", b"\0", b"%00", b"../", b"{", b"9" * 30, bytes(dice.randrange(256) for _ in range(9))])
            else:
                data[at:] = b""
            data = data or bytearray(b"\n")
        waiting.append(send_only(studio, bytes(data)))
        count += 1
        if len(waiting) < 50:
            continue
        time.sleep(0.02)
        for link in waiting:
            link.close()  # answered or waiting for more
        waiting.clear()
    for link in waiting:
        link.close()
    assert studio.process.poll() is None, "the server is gone"
    assert studio.ask("GET", "state")[0] == 200
    assert (studio.folder / "studio.json").read_bytes() == before
    return count


# --- What is asked for. ---

def wrong_requests_change_nothing(studio):
    before = (studio.folder / "studio.json").read_bytes()
    settings = [{"without_board": 1}, {"projector": [63, 200]}, {"projector": [320]}, {"projector": "320x200"}, {"projector": [320, 16385]}, {"projector": [320.5, 200]},
                {"board": [2, 6]}, {"board": None}, {"square": 0}, {"square": -1}, {"square": "16"}, {"board_angles": [0, 1]},
                {"board_angles": [0, 1, "2"]}, {"board_angles": [0, 1, 1e9]}, {"attitudes": 2}, {"attitudes": 41}, {"lollipops": 0}, {"width": 10},
                {"fix": ["k4"]}, {"fix": ["camera.--output"]}, {"fix": "k1"}, {"camera": "other"}, {"watched": "relative"}, {"watched": "/nowhere/at/all"},
                {"simulator": ["--mesh", "/etc/passwd"]}, {"virtual": False}, {"object": "x"}, {"version": 2}, {"../x": 1}]
    requests = [{"verb": "set", "settings": s} for s in settings]
    requests += [{"verb": "set"}, {"verb": "set", "settings": []}, {}, {"verb": 7}, {"verb": "none"}, {"verb": "object"},
                 {"verb": "object", "name": "../x", "stops": 8}, {"verb": "object", "name": "-o", "stops": 8}, {"verb": "object", "name": "x" * 41, "stops": 8},
                 {"verb": "object", "name": "x", "stops": 2}, {"verb": "object", "name": "x", "stops": "8"}, {"verb": "shoot", "set": "calibration/none"},
                 {"verb": "shoot", "set": "calibration/attitude-99999"}, {"verb": "shoot", "set": "../calibration/turntable"},
                 {"verb": "shoot", "set": "objects/none/view-000"}, {"verb": "take", "set": "calibration/attitude-00", "number": 1},
                 {"verb": "take", "set": 1, "number": "1"}, {"verb": "look"}, {"verb": "look", "set": "patterns"},
                 {"verb": "look", "set": "calibration/turntable"}, {"verb": "look", "set": "calibration/attitude-00"},
                 {"verb": "discard", "set": "patterns"}, {"verb": "discard", "set": "../secret.txt"},
                 {"verb": "run"}, {"verb": "run", "step": "rm"}, {"verb": "run", "step": "calibrate"}, {"verb": "run", "step": "make"},
                 {"verb": "run", "step": "evaluate"}, {"verb": "run", "step": "now"}, {"verb": "run", "step": "register"}, {"verb": "try"},
                 {"verb": "try", "view": "view-000", "pattern": "003_lollipop_0.png"}, {"verb": "shoot", "set": "objects/none/now"}]
    for request in requests:
        status, answer = studio.do(**request)
        assert status == 409 and answer["error"], (request, status)
        assert (studio.folder / "studio.json").read_bytes() == before, request
    for text in (b"", b"{", b"[]", b"null", b"\xff\xfe", b'{"verb": "set", "verb": "run"}', b"{" * 60000):
        assert studio.ask("POST", "do", text)[0] == 409, text[:20]
    for picture in (png(320, 200), b"", b"x" * 100):  # of no object
        assert studio.ask("POST", "own", picture)[0] == 409
    return len(requests) + 10


def trials_are_checked(studio):
    """The picture that an object is compared with later: a stop of it and a pattern, or a picture of the panel's size. Makes an object."""
    studio.do(verb="object", name="x", stops=8)
    (studio.folder / "objects/x").mkdir(parents=True)
    assert "not reconstructed" in studio.do(verb="try", view="view-045", pattern="003_lollipop_0.png")[1]["error"]
    (studio.folder / "objects/x/object.ply").write_bytes(b"")
    before = (studio.folder / "studio.json").read_bytes()
    wrong = [("view-046", "003_lollipop_0.png", 0), ("../x", "003_lollipop_0.png", 0), (None, "003_lollipop_0.png", 0), ("view-045", "001_black.png", 0),
             ("view-045", "002_white.png", 0), ("view-045", "000_focus.png", 0), ("view-045", "003_../../x.png", 0), ("view-045", "/etc/passwd", 0),
             ("view-045", "099_none.png", 0), ("view-045", "own", 0), ("view-045", None, 0), ("view-045", "003_lollipop_0.png", 181),
             ("view-045", "003_lollipop_0.png", "1"), ("view-045", "003_lollipop_0.png", 0.5)]
    for view, pattern, turned in wrong:
        status, answer = studio.do(verb="try", view=view, pattern=pattern, turned=turned)
        assert status == 409 and answer["error"] and (studio.folder / "studio.json").read_bytes() == before, (view, pattern, turned)
    for picture in (b"", png(319, 200), png(320, 200)[:-5], b"\xff\xd8" + bytes(100) + b"\xff\xd9"):
        assert studio.ask("POST", "own", picture)[0] == 409
    assert studio.ask("POST", "own", png(320, 200))[0] == 200
    for pattern, numbers in (("own", [1, 2, 999]), ("004_lollipop_1.png", [1, 2, 4])):
        assert studio.do(verb="try", view="view-045", pattern=pattern)[0] == 200
        status, answer = studio.do(verb="shoot", set="objects/x/now")
        assert status == 200 and [shot["number"] for shot in answer["active"]["shots"]] == numbers and answer["active"]["angle"] == 45, answer
        assert "not photographed" in studio.do(verb="run", step="now")[1]["error"]
    assert "not photographed" in studio.do(verb="run", step="register")[1]["error"]
    # watching: one photograph, and only what watching has made is deleted
    now, outside = studio.folder / "objects/x/now", studio.folder / "outside"
    now.mkdir(exist_ok=True)
    (now / "mine.txt").write_bytes(b"kept")
    outside.mkdir()
    (outside / "mine.txt").write_bytes(b"kept")
    assert "watch" in studio.do(verb="try", view="view-045", pattern="004_lollipop_1.png", watch=True)[1]["error"]
    assert studio.do(verb="try", view="view-045", pattern="own", watch=True)[0] == 409  # the user's picture is not the show's
    own = (studio.folder / "objects/x/own.png").read_bytes()
    assert studio.ask("POST", "own?watch=true", png(320, 200, 7))[0] == 200
    assert (studio.folder / "objects/x/own.png").read_bytes() == own != (studio.folder / "objects/x/show.png").read_bytes()
    for _ in range(3):
        assert studio.do(verb="try", view="view-045", pattern="own", watch=True)[0] == 200
        status, answer = studio.do(verb="shoot", set="objects/x/now")
        assert status == 200 and [shot["number"] for shot in answer["active"]["shots"]] == [999], answer
        assert "not photographed" in studio.do(verb="run", step="watch")[1]["error"]
        (now / "deep/er").mkdir(parents=True)
        (now / "deep/link").symlink_to(outside)
        (now / "deep/er/file").write_bytes(b"")
    discarded = [path for path in (studio.folder / "discarded").glob("objects-x-now-*") if (path / "mine.txt").exists()]
    assert len(discarded) == 1 and not list((studio.folder / "discarded").glob("objects-x-now-*/deep")), discarded
    assert studio.do(verb="try", view="view-045", pattern="own")[0] == 200
    assert not now.exists() and (outside / "mine.txt").read_bytes() == b"kept"
    shutil.rmtree(outside)
    # while one object is watched, what was photographed of another by hand is kept
    other = studio.folder / "objects/y/now"
    studio.do(verb="object", name="y", stops=8)
    (other / "capture").mkdir(parents=True)
    (other / "aligned").mkdir()
    for name in ("mine.txt", "capture/scene.json", "aligned/mine.txt"):
        (other / name).write_bytes(b"kept")
    (studio.folder / "objects/y/object.ply").write_bytes(b"")
    studio.do(verb="object", name="x", stops=8)
    assert studio.do(verb="try", view="view-045", pattern="own", watch=True)[0] == 200
    studio.do(verb="object", name="y", stops=8)
    studio.do(verb="run", step="register")
    studio.wait("failed")
    assert (studio.folder / "discarded/objects-y-now-aligned-1/mine.txt").read_bytes() == b"kept" and not (other / "aligned").exists()
    assert studio.do(verb="try", view="view-045", pattern="004_lollipop_1.png")[0] == 200
    assert (studio.folder / "discarded/objects-y-now-1/mine.txt").read_bytes() == b"kept" and not other.exists()
    studio.do(verb="object", name="x", stops=8)
    studio.do(verb="shoot", set="calibration/attitude-00")  # as it was
    return len(wrong) + 10


def photographs_are_checked(studio):
    name = "calibration/attitude-00"
    assert studio.photograph(name, 1, png())[0] == 409  # nobody photographs it
    assert studio.do(verb="shoot", set=name)[0] == 200
    whole = png()
    wrong = [b"", b"x" * 100, whole[:-5], whole[:60], whole[:8], b"\xff\xd8\xff\xd9", b"GIF89a" + bytes(100), whole.replace(b"IEND", b"IENX"),
             whole[:16] + struct.pack(">I", 0) + whole[20:]]
    for picture in wrong:
        status, answer = studio.photograph(name, 1, picture)
        assert status == 409 and "whole PNG or JPEG" in answer["error"], (picture[:12], answer.get("error"))
    for number, said in ((2, "not due"), (0, "not due"), (999, "not due")):
        status, answer = studio.photograph(name, number, whole)
        assert status == 409 and said in answer["error"], answer.get("error")
    for query in ("set=calibration/attitude-00", "number=1", "set=calibration/attitude-00&number=x", "set=calibration/attitude-00&number=-1"):
        assert studio.ask("POST", "photograph?" + query, whole)[0] == 409
    assert studio.photograph("calibration/attitude-01", 1, whole)[0] == 409
    assert not (studio.folder / name).exists()
    status, state = studio.photograph(name, 1, whole)
    assert status == 200 and state["active"]["done"] == 1 and (studio.folder / name / "001.png").read_bytes() == whole
    status, answer = studio.photograph(name, 1, whole)  # a second window, or a camera that fires twice
    assert status == 409 and "another window" in answer["error"]
    status, answer = studio.photograph(name, 2, png(80, 48))
    assert status == 409 and "80 x 48" in answer["error"] and "64 x 48" in answer["error"]
    status, answer = studio.do(verb="set", settings={"projector": [640, 400]})
    assert status == 409 and "photographs" in answer["error"]
    assert studio.do(verb="run", step="patterns")[0] == 409
    return len(wrong) + 11


# --- Whatever happens. ---

def killed_at_any_moment(program, folder, studio):
    """kill -9 between and amid photographs: those that were confirmed exist, and it goes on with the next."""
    dice, confirmed = random.Random(1), 1
    name = "calibration/attitude-00"
    for life in range(6):
        if life % 2 == 0:
            for _ in range(dice.randint(1, 3)):
                due = studio.state()["active"]["next"]["number"]
                assert studio.photograph(name, due, png(grey=due))[0] == 200
                confirmed += 1
            studio.kill()
        else:  # a request on its way
            due = studio.state()["active"]["next"]["number"]
            link = socket.create_connection(("127.0.0.1", studio.port))
            body = png(grey=due)
            link.sendall(f"POST /{studio.key}/photograph?set={name}&number={due} HTTP/1.1\r\nHost: 127.0.0.1:{studio.port}\r\n"
                         f"Origin: http://127.0.0.1:{studio.port}\r\nContent-Length: {len(body)}\r\n\r\n".encode() + body[:dice.randrange(len(body))])
            time.sleep(0.05)
            studio.kill()
            link.close()
        studio = Studio(program, folder)
        state = studio.state()
        assert state["active"]["name"] == name and state["active"]["done"] == confirmed, (state["active"]["done"], confirmed)
    return studio, confirmed


def same_port_again(program, folder):
    """A browser keeps a show by the page's address: the port is that of last time, or another if it is taken."""
    first = Studio(program, folder)
    first.stop()
    again = Studio(program, folder)
    assert again.port == first.port, (first.port, again.port)
    again.stop()
    with socket.create_server(("127.0.0.1", first.port)):
        other = Studio(program, folder)
        assert other.error == "" and other.port != first.port, other.error
        other.stop()


def one_studio_for_a_folder(program, folder, port):
    second = Studio(program, folder)
    assert "another studio works in this folder" in second.error, second.error
    other = Studio(program, folder.parent / "other", "--port", str(port))
    assert f"port {port}" in other.error and "in use" in other.error, other.error
    other = Studio(program, folder.parent / "other", "--virtual")  # begun above as a real rig's
    assert "a real rig's" in other.error, other.error
    assert "cannot be made" in Studio(program, "/proc/none").error


def full_disk(program, folder, studio):
    studio.stop()
    studio = Studio(program, folder, limit=2000)
    noise = random.Random(2)
    due = studio.state()["active"]["next"]["number"]
    rows = b"".join(b"\0" + bytes(noise.randrange(256) for _ in range(64 * 3)) for _ in range(48))
    picture = png()
    at = picture.index(b"IDAT") - 4
    data = zlib.compress(rows)
    picture = picture[:at] + struct.pack(">I", len(data)) + b"IDAT" + data + struct.pack(">I", zlib.crc32(b"IDAT" + data)) + picture[-12:]
    done = studio.state()["active"]["done"]
    status, answer = studio.photograph("calibration/attitude-00", due, picture)
    assert status == 409 and "cannot be written" in answer["error"], answer
    left = sorted(os.listdir(folder / "calibration/attitude-00"))
    assert len(left) == done and not any(name.startswith(".") for name in left), left
    studio.stop()
    return Studio(program, folder)


def damaged_settings(program, folder):
    """Refused by name, and left as they are."""
    whole = json.loads((folder / "studio.json").read_text())
    for change, said in (({"projector": [1]}, "projector"), ({"square": "x"}, "square"), ({"objects": []}, "objects"), ({"camera": 5}, "camera")):
        (folder / "studio.json").write_text(json.dumps({**whole, **change}))
        error = Studio(program, folder).error
        assert "studio.json" in error and said in error, error
    for text in ("", "{", "[]", "null", "{}"):
        (folder / "studio.json").write_text(text)
        assert "studio.json" in Studio(program, folder).error
    (folder / "studio.json").write_text(json.dumps(whole))


def jobs_end(studio):
    """A step's messages are kept beside its command."""
    assert studio.do(verb="cancel")[0] == 200
    log = (studio.folder / "logs/patterns.txt").read_text()
    assert log.startswith("$ ffprocams patterns -o patterns --projector 320x200")
    found = json.loads((studio.folder / "logs/patterns.json").read_text())
    assert found["findings"] == [] and found["commands"][0].startswith("ffprocams patterns")


def the_folder_is_listed_when_something_changed(studio):
    """Not for every step of a job's progress; a page that begins is told what there is."""
    mine = studio.folder / "patterns/099_mine.png"
    patterns = lambda path: json.loads(studio.ask("GET", path)[1])["patterns"]
    before = patterns("state")
    mine.write_bytes(png())
    assert patterns("state?known=0") == before
    assert patterns("state") == [*before, mine.name]
    mine.unlink()
    assert mine.name in patterns("state?known=0")
    assert studio.do(verb="cancel")[0] == 200
    studio.do(verb="set", settings={"width": 128})
    assert patterns("state?known=0") == before


def names_tell_no_kinds(studio):
    """An object may be called like a set of photographs."""
    before = studio.state()["settings"]
    for name in ("attitude-1", "view-2", "projector-2", "empty", "now"):
        state = studio.do(verb="object", name=name, stops=3, empty=True)[1]
        sets = next(of["sets"] for of in state["objects"] if of["name"] == name)
        assert [of["kind"] for of in sets] == ["empty", "stop", "stop", "stop"], sets
        active = studio.do(verb="shoot", set=f"objects/{name}/view-120")[1]["active"]
        assert (active["kind"], active["angle"]) == ("stop", 120) and sum(shot["white"] for shot in active["shots"]) == 1, active
    assert [of["kind"] for of in state["sets"]] == ["attitude"] * (len(state["sets"]) - 1) + ["table"]
    studio.do(verb="object", name=before["object"])
    assert studio.do(verb="shoot", set=before["active"])[0] == 200


def a_watched_folder(program, folder):
    """Every new picture is the shot that is due; other files are not."""
    place = folder.parent / "camera"
    place.mkdir()
    studio = Studio(program, folder, "--virtual")
    assert studio.do(verb="set", settings={"camera": "folder", "watched": str(place)})[0] == 200
    studio.do(verb="run", step="patterns")
    studio.wait()
    name = "calibration/attitude-00"
    studio.do(verb="shoot", set=name)

    def wait_for(condition, said):
        end = time.monotonic() + 60
        while not condition(studio.state()):
            assert time.monotonic() < end, said
            time.sleep(0.02)

    def shown():
        assert studio.do(verb="show", set=name, number=studio.state()["active"]["next"]["number"])[0] == 200

    (place / "IMG_0000.png").write_bytes(png(grey=0))
    wait_for(lambda s: "IMG_0000.png" in s["notice"] and s["active"]["done"] == 0, "no pattern is shown yet")
    shown()
    (place / "IMG_0001.png").write_bytes(png(grey=1))
    wait_for(lambda s: s["active"]["done"] == 1, "a new file")
    (place / "IMG_0001.png").write_bytes(png(grey=1))
    wait_for(lambda s: "IMG_0001.png" in s["notice"] and s["active"]["done"] == 1, "it is written again, before the next pattern")
    assert studio.do(verb="show", set=name, number=1)[0] == 409
    shown()
    assert studio.do(verb="set", settings={"watched": str(place / "nowhere")})[0] == 409  # the old folder stays
    (place / "IMG_0002.CR2").write_bytes(b"raw")
    (place / ".hidden.png").write_bytes(png())
    (place / "part").write_bytes(png(grey=2))
    os.rename(place / "part", place / "IMG_0002.PNG")
    wait_for(lambda s: s["active"]["done"] == 2, "a file that was renamed")
    shown()
    (place / "IMG_0003.jpg").write_bytes(b"\xff\xd8 not a picture")
    wait_for(lambda s: "IMG_0003.jpg" in s["notice"] and s["active"]["done"] == 2, "a damaged file")
    (place / "IMG_0004.png").write_bytes(png(grey=4))
    wait_for(lambda s: s["active"]["done"] == 3 and s["notice"] == "", "it goes on")
    assert (folder / name / "002.png").read_bytes() == png(grey=2)
    studio.stop()
    studio = Studio(program, folder)  # it watches again
    shown()
    (place / "IMG_0005.png").write_bytes(png(grey=5))
    wait_for(lambda s: s["active"]["done"] == 4, "after a new start")
    shutil.rmtree(place)  # its disk was taken out
    wait_for(lambda s: "is gone" in s["notice"], "the folder is gone")
    status, answer = studio.do(verb="shoot", set=name)
    assert status == 409 and "cannot be watched" in answer["error"], answer
    place.mkdir()
    assert studio.do(verb="shoot", set=name)[0] == 200
    shown()
    (place / "IMG_0006.png").write_bytes(png(grey=6))
    wait_for(lambda s: s["active"]["done"] == 5, "it is there again")
    studio.stop()


# --- Control from outside. ---

def osc(address, types=None, *values):
    """A message of Open Sound Control 1.0; without types an old sender's."""
    def text(value):
        raw = value.encode() if isinstance(value, str) else value
        return raw + b"\0" * (4 - len(raw) % 4)
    formats = {"i": ">i", "f": ">f", "h": ">q", "d": ">d"}
    body = [text(value) if kind == "s" else struct.pack(formats[kind], value) for kind, value in zip((types or "").replace("T", "").replace("F", ""), values)]
    return text(address) + (b"" if types is None else text("," + types)) + b"".join(body)


def bundle(*elements):
    return b"#bundle\0" + struct.pack(">Q", 1) + b"".join(struct.pack(">I", len(e)) + e for e in elements)


def control_from_outside(program, folder, seconds):
    free = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    free.bind(("127.0.0.1", 0))
    port = free.getsockname()[1]
    for wrong in ("", "nowhere", "0", "70000", "localhost:9000", ":9000", "1.2.3.4.5:9000", f"127.0.0.1:{port}"):  # the last one is taken
        assert "--osc" in Studio(program, folder, "--osc", wrong).error, wrong
    silent = Studio(program, folder)
    assert json.loads(silent.ask("GET", "control")[1]) == {"osc": None, "number": 0, "events": [], "passed_over": 0, "passed_last": ""}
    assert json.loads(silent.ask("GET", "control?known=0")[1])["osc"] is None  # at once
    silent.stop()
    free.close()
    studio = Studio(program, folder, "--osc", str(port))
    with open("/proc/net/udp", encoding="ascii") as file:  # 0100007F: 127.0.0.1
        assert any(f" 0100007F:{port:04X} " in line for line in file) and f" 00000000:{port:04X} " not in Path("/proc/net/udp").read_text()
    sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    send = lambda packet: sender.sendto(packet, ("127.0.0.1", port))
    asked = lambda known: json.loads(studio.ask("GET", f"control?known={known}")[1])
    def until(known, address):  # sent again and again, since packets of UDP may be lost
        for _ in range(60):
            send(osc(address, "i", 1))
            answer = asked(known)
            if any(event["address"] == address for event in answer["events"]):
                return answer
            time.sleep(0.5)
        raise AssertionError(address)
    send(osc("/go"))
    assert asked(0) == {"osc": f"127.0.0.1:{port}", "number": 1, "events": [{"address": "/go", "values": [], "number": 1}], "passed_over": 0, "passed_last": ""}
    def late():
        time.sleep(0.4)
        send(osc("/projector/1/layer/2/opacity", "f", 0.25))
    helper = threading.Thread(target=late)
    helper.start()
    began = time.monotonic()
    answer = asked(1)  # it waits for what comes, or it would have nothing
    assert time.monotonic() - began < 8  # and not for its ten seconds
    helper.join()
    assert answer["events"] == [{"address": "/projector/1/layer/2/opacity", "values": [0.25], "number": 2}], answer
    send(osc("/cue", "sTFihd", "Ende \u00e4", 7, -(1 << 40), 0.5))
    assert asked(2)["events"][0]["values"] == ["Ende \u00e4", True, False, 7, -(1 << 40), 0.5]
    send(bundle(osc("/a"), bundle(osc("/b", "i", 1)), osc("/c", "")))
    assert [(event["address"], event["bundle"]) for event in asked(3)["events"]] == [("/a", 3), ("/b", 3), ("/c", 3)]

    good, deep = osc("/go", "i", 1), osc("/x")
    for _ in range(6):
        deep = bundle(deep)
    bad = [b"", b"\0" * 4, b"/go", b"/go\0,i\0\0", b"/go\0,i\0\0\0\0", b"/go\0,\1\0\0", b"/go\1" * 900, b"/" * 4096, b"/go\0" * 5000, good + b"\0\0\0\0", good[:-4], good[:-1],
           osc("/go", "f", float("nan")), osc("/go", "d", float("inf")), osc("/go", "s", b"\xff\xfe"), osc("/go", "s", "x" * 401), osc("/" + "x" * 200), osc("/\xe4".encode("latin-1")),
           osc("go"), osc("/go", "i" * 17, *range(17)), osc("/go", "b") + struct.pack(">I", 0xffffffff), osc("/go", "x"), b"/go\0xyz\0", b"/a\0z,\0\0\0", deep, b"#bundle\0", b"#bundlf\0" + bytes(8),
           b"#bundle\0" + bytes(8) + struct.pack(">I", 0xfffffffc) + good, bundle(good)[:-4], bytes(65000)]
    for packet in bad:
        send(packet)
    send(osc("/end"))
    answer = asked(6)
    assert [event["address"] for event in answer["events"]] == ["/end"] and answer["passed_over"] >= len(bad) and answer["passed_last"] == "", answer
    # what cannot be read is passed over alone
    for other in (osc("/tuio/2Dcur", "x"), b"\0\0\0\0", osc("/chan1:rms", "f", float("nan")), b"/go\0,i\0\0"):
        number = asked(0)["number"]
        send(bundle(other, osc("/back"), other, good))
        assert [event["address"] for event in asked(number)["events"]] == ["/back", "/go"], other
    number = asked(0)["number"]
    send(bundle(good, osc("/x", "b") + struct.pack(">I", 3) + b"abc\0", osc("/My Fader", "N"), osc("/p", "crmtI") + bytes(20), osc("/l", "[i]") + bytes(4)) + b"\0\0\0\1")
    assert [(event["address"], event["values"]) for event in asked(number)["events"]] == [("/go", [1]), ("/x", [None]), ("/My Fader", []), ("/p", [None] * 4), ("/l", [0])]
    # faders push no GO out, nor their own last value; all channels in one packet
    number = asked(0)["number"]
    send(osc("/go"))
    for i in range(300):
        send(osc("/projector/1/layer/1/opacity", "f", i / 4))
        if i % 50 == 0:
            asked(0)  # the studio keeps up
    asked(0)
    send(osc("/blackout"))
    send(bundle(*[osc(f"/projector/1/layer/{i + 1}/opacity", "f", 0.5) for i in range(1, 200)]))
    answer = until(number, "/end")
    heard = [event["address"] for event in answer["events"]]
    assert heard[:2] == ["/go", "/projector/1/layer/1/opacity"] and answer["events"][1]["values"] == [299 / 4] and heard.count("/blackout") == 1 and len(set(heard)) == 203, (heard, len(heard))
    for i in range(3000):
        send(osc(f"/other/{i}", "i", 1))
        if i % 50 == 0:
            asked(0)
    answer = until(number, "/end of others")
    heard = [event["address"] for event in answer["events"]]
    assert heard.count("/go") == heard.count("/blackout") == 1 and len(heard) <= 1024
    # nor what only begins like a press, and patterns of faders
    for i in range(1100):
        send(osc("/gobo/rotate", "i", i))
        send(osc("/projector/*/layer/1/opacity", "i", 1))
        if i % 25 == 0:
            asked(0)
    heard = [event["address"] for event in until(number, "/end of gobos")["events"]]
    assert heard.count("/go") == heard.count("/gobo/rotate") == heard.count("/projector/*/layer/1/opacity") == 1, len(heard)
    # nor do presses, of which there are more than are kept, push out what comes with them
    for i in range(1100):
        send(osc("/{go,hold}", "i", 1))
        if i % 50 == 0:
            asked(0)
    number = asked(0)["number"]
    send(bundle(osc("/blackout"), osc("/level", "f", 0.5), osc("/projector/1/gain", "f", 1)))
    assert {"/blackout", "/level", "/projector/1/gain"} <= {event["address"] for event in until(number, "/end of presses")["events"]}

    rng, until, count, before = random.Random(55), time.monotonic() + seconds, 0, studio.memory()
    while time.monotonic() < until:  # mangled
        packet = bytearray(rng.choice((good, deep, bundle(good, osc("/cue", "s", "one"), osc("/y", "dh", 1.0, 2)))))
        for _ in range(rng.randrange(1, 6)):
            packet[rng.randrange(len(packet))] = rng.choice((0, 1, 4, 44, 47, 127, 128, 255, rng.randrange(256)))
        send(bytes(packet[:rng.choice((len(packet), rng.randrange(len(packet) + 1)))]))
        count += 1
    answer = asked(0)
    while not answer["events"] or answer["events"][-1]["address"] != "/last":  # until none of them is still on its way
        send(osc("/last"))
        answer = asked(answer["number"])
    answer = asked(0)
    quarantine = 300 if b"__asan_init" in Path(program).read_bytes() else 0  # AddressSanitizer keeps what was freed
    assert len(answer["events"]) <= 1024 and studio.memory() < before + 20 + quarantine, (len(answer["events"]), studio.memory() - before)
    filled, answered = folder.parent / "filled", threading.Event()
    filled.mkdir()
    assert studio.do(verb="set", settings={"camera": "folder", "watched": str(filled)})[0] == 200
    def fill():  # other things that happen do not lengthen the wait: it ends while they go on
        while not answered.is_set():
            (filled / "x.txt").write_bytes(b"x")
            time.sleep(0.5)
    helper = threading.Thread(target=fill)
    helper.start()
    began = time.monotonic()
    try:
        assert not asked(answer["number"])["events"] and time.monotonic() - began < 30
    finally:
        answered.set()
        helper.join()
    link = socket.create_connection(("127.0.0.1", studio.port))  # one that waits does not keep the studio from its end
    link.sendall(f"GET /{studio.key}/control?known={answer['number']} HTTP/1.1\r\nHost: 127.0.0.1:{studio.port}\r\n\r\n".encode())
    time.sleep(0.2)
    began = time.monotonic()
    studio.stop()
    assert time.monotonic() - began < 5  # and its wait is of ten
    link.close()
    return len(bad), count


def main():
    program, folder = os.path.abspath(sys.argv[1]), Path(sys.argv[2])
    seconds = float(sys.argv[3]) if len(sys.argv) > 3 else 2.0
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    rig = folder / "rig"
    studio = Studio(program, rig, "--virtual")
    if "without the studio" in studio.error:
        print("built without the studio")
        return 77
    print(f"{strangers_are_refused(studio)} strangers are refused")
    assert studio.do(verb="run", step="patterns")[0] == 200
    studio.wait()
    print(f"{no_path_leads_out(studio)} paths lead nowhere")
    print(f"long bodies cost {bodies_are_bounded(studio):.1f} MB")
    print(f"{wrong_requests_change_nothing(studio)} wrong requests change nothing")
    with thousand_connections(studio):  # other studios are tried while they wait for their end
        a_watched_folder(program, folder / "watched")
        print("%d wrong and %d mangled OSC packets" % control_from_outside(program, folder / "control", seconds))
    print(f"{mangled_requests(studio, seconds)} mangled requests")
    print(f"{photographs_are_checked(studio)} photographs are checked")
    print(f"{trials_are_checked(studio)} comparisons are checked")
    jobs_end(studio)
    names_tell_no_kinds(studio)
    the_folder_is_listed_when_something_changed(studio)
    same_port_again(program, folder / "port")
    one_studio_for_a_folder(program, rig, studio.port)
    studio, confirmed = killed_at_any_moment(program, rig, studio)
    print(f"killed six times, {confirmed} photographs confirmed and there")
    studio = full_disk(program, rig, studio)
    studio.stop()
    damaged_settings(program, rig)
    return 0


if __name__ == "__main__":
    signal.signal(signal.SIGPIPE, signal.SIG_IGN)
    sys.exit(main())
