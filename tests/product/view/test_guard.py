#!/usr/bin/env python3
"""A show in a headless Chromium with two projector windows: what the audience sees of slips of a hand and of crashes, from
screenshots of both windows each 100 ms.

    test_guard.py PROGRAM DATA [FOLDER]     a table, and the pictures that differ, stay in FOLDER

Exits with 77 and a line where there is no browser."""
import base64
import hashlib
import os
import struct
import subprocess
import sys
import tempfile
import time
import zlib

import browser
from test_view import Checks, Page, png

EVERY, LASTS = 0.1, 2.5  # s: from screenshot to screenshot, and of a slip
SAME = 0.5               # of 255: pictures are the same to the eye below this mean difference
PROJECTORS = 2
READY = "!window.gone && !!window.viewer && document.body.classList.contains('ready')"


def pixels_of(data):
    """RGB bytes of a screenshot, every fourth row and pixel."""
    at, packed, width, height, colour = 8, b"", 0, 0, 2
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + size]
        if kind == b"IHDR":
            width, height, _, colour = struct.unpack(">IIBB", body[:10])
        elif kind == b"IDAT":
            packed += body
        at += 12 + size
    n, raw, out = {2: 3, 6: 4}[colour], zlib.decompress(packed), bytearray()
    stride, before = n * width, bytearray(n * width)
    for y in range(height):
        kind, row = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for i in range(stride if kind else 0):
            left, up, corner = (row[i - n] if i >= n else 0), before[i], (before[i - n] if i >= n else 0)
            if kind == 4:
                p = left + up - corner
                a, b, c = abs(p - left), abs(p - up), abs(p - corner)
                row[i] = (row[i] + (left if a <= b and a <= c else up if b <= c else corner)) & 255
            else:
                row[i] = (row[i] + (0, left, up, (left + up) // 2)[kind]) & 255
        if y % 4 == 0:
            for x in range(0, width, 4):
                out += row[n * x:n * x + 3]
        before = row
    return bytes(out)


def apart(a, b):
    return sum(abs(x - y) for x, y in zip(a, b)) / len(a) if len(a) == len(b) else 255.0


class Audience:
    """The windows' pictures: screenshots, each decoded once."""

    def __init__(self, page, folder):
        self.page, self.folder, self.known, self.sessions = page, folder, {}, {}

    def look(self):
        """A screenshot's name for each window, None for one that is not there or crashed, "" where a browser that is busy gives none."""
        for target in self.page.pages("#projector-"):
            if target not in self.sessions:
                self.sessions[target] = self.page.attach(target)
        there = self.page.pages("")  # one that is being loaded has no address
        self.sessions = {target: session for target, session in self.sessions.items() if target in there}
        return [self.shot(session) for session in self.sessions.values()] + [None] * (PROJECTORS - len(self.sessions))

    def shot(self, session):
        try:
            data = base64.b64decode(self.page.call("Page.captureScreenshot", {"format": "png"}, session=session, timeout=3)["data"])
        except browser.Failure:
            return None if session in self.page.crashed else ""
        name = hashlib.sha256(data).hexdigest()
        if name not in self.known:
            self.known[name] = (pixels_of(data), data)
        return name

    def surely(self):
        """The same when the browser has time to answer."""
        seen = self.look()
        for _ in range(20):
            if "" not in seen:
                return seen
            seen = self.look()
        return seen

    def watch(self, seconds=LASTS):
        seen, end = [], time.monotonic() + seconds
        while time.monotonic() < end:
            began = time.monotonic()
            seen.append(self.look())
            time.sleep(max(0, EVERY - (time.monotonic() - began)))
        return seen

    def pixels(self, name):
        return self.known[name][0]

    def told(self, before, seen, what):
        """In words, with the pictures that differ kept; True in front if nobody saw anything."""
        gone, busy = sum(None in shots for shots in seen), sum("" in shots for shots in seen)
        names = [name for shots in seen for name in shots if name and min(apart(self.pixels(name), self.pixels(b)) for b in before) > SAME]
        black = sum(max(self.pixels(name)) < 8 for name in names)
        for i, name in enumerate(sorted(set(names))[:3]):
            with open(os.path.join(self.folder, f"{what}-{i}.png".replace(" ", "-")), "wb") as file:
                file.write(self.known[name][1])
        words = [f"{gone} without a window"] * bool(gone) + [f"{black} black"] * bool(black) + [f"{len(names) - black} of another picture"] * (len(names) > black)
        words = (", ".join(words) or "the same picture") + f", {busy} without an answer" * bool(busy)
        return not gone and not names and 4 * busy < len(seen), f"{len(seen)} looks: {words}"


class Show(Page):
    """The page, with a show of three cues armed in two windows."""

    def again(self, path=None):
        """Waits for a page that is loaded again."""
        if path:
            self.open(path)
        self.wait(READY, 120)
        self.run("""window.idle = () => new Promise((done) => { const look = () => viewer.pending || viewer.stale || viewer.moving ? setTimeout(look, 20) : done(true); look(); });
            viewer.scene.drawing.samples = 1; viewer.schedule(); true""")

    def begin(self, path):
        self.open(path)
        self.again()
        self.run("""viewer.store.forget(); viewer.frusta = false; viewer.addProjector();
            const shows = [['Rainbow', 'Lollipop'], ['Checker', 'Sunset'], ['Grid', 'Rainbow']];
            for (const names of shows) {
                names.forEach((name, i) => viewer.setContent(new TestContent(name), viewer.projectors[i]));
                viewer.show.add();
            }
            viewer.history.note(); true""")
        for i in range(PROJECTORS):
            self.run(f"viewer.projectors[{i}].window.open()")
        self.run("viewer.show.press(); viewer.show.cues.forEach((cue) => { cue.fade = 0; }); viewer.show.go(0)")
        self.mouse("mousePressed", 5, 200)
        self.mouse("mouseReleased", 5, 200, "left", 0)  # browsers ask only for pages that were touched

    def press(self, key, code, number, session="", modifiers=0, text=""):
        for kind in ("rawKeyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", {"type": kind, "key": key, "code": code, "windowsVirtualKeyCode": number, "modifiers": modifiers,
                                                 "text": text}, session=session)

    def leave(self, agrees, work):
        """Leaves the page by some `work`, or stays where it asks; True if it asked."""
        self.agrees, before = agrees, len(self.asked)
        if agrees:
            self.run("window.gone = true")
        work()
        time.sleep(0.3)
        try:
            self.run("1", timeout=30)  # hears of the question
        except browser.Failure:
            pass  # the page is on its way
        self.agrees = True
        return self.asked[before:] == ["beforeunload"]

    def toast(self):
        return self.run("document.getElementById('toast').textContent")


def quiet(check, audience, name, work, after=lambda: None, seconds=LASTS, same=True):
    """A slip, and what the audience saw of it. `same`: it must see nothing."""
    page = audience.page
    page.run("say('')")
    time.sleep(0.3)
    before = audience.surely()
    said = work()
    seen = audience.watch(seconds)
    more = after()
    seen += audience.watch(1)
    unseen, words = audience.told(before, seen, name)
    check(name, (unseen or not same) and said is not False and more is not False, words)
    return before, seen


def windows_back(page, audience, check, name):
    """The page has its windows again, armed, and a new cue reaches them."""
    page.wait("viewer.windows.open.length === 2", 60)
    armed, at = page.run("[viewer.show.armed, viewer.show.at]")
    before = audience.surely()
    page.run("viewer.show.go().then(() => new Promise((done) => setTimeout(done, 1000)))")
    page.wait("viewer.projectors.every((p) => !p.window.drawing && !p.window.stale) && !viewer.stale", 30)
    after = audience.surely()
    reached = all(a and b and apart(audience.pixels(a), audience.pixels(b)) > 5 for a, b in zip(before, after))
    check(f"{name}: armed at its cue, and GO reaches the windows", armed and reached, f"armed {armed}, cue {at + 1}")
    page.run("viewer.show.go(0)")
    time.sleep(1)


def check_slips(check, page, audience, path, other, picture):
    window = lambda i: list(audience.sessions.values())[i]
    slip = lambda name, work, **more: quiet(check, audience, name, work, **more)
    slip("the reload key", lambda: page.press("F5", "F5", 116))
    slip("Ctrl R", lambda: page.press("r", "KeyR", 82, modifiers=2))
    slip("the reload button, and stay", lambda: page.leave(False, lambda: page.call("Page.reload")))
    slip("the tab closed, and stay", lambda: page.leave(False, lambda: page.call("Page.close")))
    slip("the tab closed by its file's drop, and stay", lambda: page.leave(False, lambda: page.run(f"void (location.href = {'file://' + picture!r})")))
    slip("back, and stay", lambda: page.leave(False, lambda: page.run("void history.back()")))
    slip("a picture dropped on the page", lambda: page.drop("slip.png", "image/png", open(picture, "rb").read()))
    slip("a stage dropped on the page", lambda: page.drop("slip.stage.json", "application/json", b"{}"))
    slip("Escape", lambda: page.press("Escape", "Escape", 27))
    slip("F11", lambda: page.press("F11", "F11", 122))
    slip("a view's number, with the projector along", lambda: page.press("2", "Digit2", 50, text="2"))
    slip("another projector (N)", lambda: page.press("n", "KeyN", 78, text="n"))
    slip("the photograph (V)", lambda: page.press("v", "KeyV", 86, text="v"))
    slip("a drag across the page", lambda: page.drag((200, 150), (300, 250)))
    slip("Armed, pressed twice", lambda: (page.click("#armed"), page.click("#armed"), page.run("viewer.show.armed"))[-1])
    before, seen = slip("Blackout, pressed twice in haste", lambda: page.run("[0, 1].map(() => new MouseEvent('click')).forEach((event) => document.getElementById('dark').dispatchEvent(event)), viewer.dark"), same=False)
    check("  black at once, without any hint, and until it is pressed again", all(max(audience.pixels(name)) < 8 for shots in seen[3:] for name in shots if name), f"{len(seen)} looks")
    page.click("#dark")
    time.sleep(0.6)
    check("  and back", audience.look() == before)
    for name, key, code, number in (("Escape", "Escape", "Escape", 27), ("F5", "F5", "F5", 116), ("Backspace", "Backspace", "Backspace", 8), ("x", "x", "KeyX", 88)):
        slip(f"{name} in a projector window", lambda k=key, c=code, n=number: page.press(k, c, n, session=window(0)))
    drag = {"x": 100, "y": 100, "data": {"items": [], "files": [picture], "dragOperationsMask": 1}}
    slip("a file dropped on a projector window", lambda: [page.call("Input.dispatchDragEvent", {"type": kind, **drag}, session=window(1)) for kind in ("dragEnter", "dragOver", "drop")] and None,
         after=lambda: "not on a projector window" in page.toast())
    slip("a projector window closed, and stay", lambda: (page.call("Input.dispatchMouseEvent", {"type": "mousePressed", "x": 9, "y": 9, "button": "left", "clickCount": 1}, session=window(1)),
         page.leave(False, lambda: page.call("Page.close", session=window(1))))[-1])
    slip("a projector window reloaded", lambda: page.call("Page.reload", session=window(1)) and None)
    slip("another object opened, and back", lambda: page.leave(True, lambda: page.open(other)), after=lambda: page.again(path))
    windows_back(page, audience, check, "another object opened, and back")


def check_awake(check, page, audience):
    """Windows ask that the screen stays on, again each time they are seen again."""
    asked = [page.run("navigator.wakeLock.request = (what) => { window.asked = what; return Promise.resolve({}); }; document.dispatchEvent(new Event('visibilitychange')); window.asked",
                      session=session) for session in audience.sessions.values()]
    check("the screen stays on", asked == ["screen"] * PROJECTORS, str(asked))


def check_closed(check, page, audience):
    """One window is closed on purpose: the page says so, and brings it back."""
    page.run("say('')")
    page.call("Page.close", session=list(audience.sessions.values())[1])
    page.wait("viewer.windows.open.length === 1", 20)
    # a slow browser may drop the goodbye: then it is the pings that tell
    check("a window that is closed is told", any(how in page.toast() for how in ("s window was closed", "s window does not answer")), page.toast())
    page.click("#all-back")
    page.wait("viewer.windows.open.length === 2", 20)
    check("and comes back by one button", page.run("document.getElementById('all-back').hidden"))
    windows_back(page, audience, check, "a window closed, all windows back")


def check_crashes(check, page, audience, path):
    def reload():
        return page.leave(True, lambda: page.call("Page.reload"))

    def crash():
        try:
            page.call("Page.crash", timeout=2)
        except browser.Failure:
            pass  # nothing is left to answer

    quiet(check, audience, "reload, and leave", reload, after=page.again)
    windows_back(page, audience, check, "reload, and leave")
    quiet(check, audience, "the tab crashes, and is loaded again", crash, after=lambda: page.again(path))
    windows_back(page, audience, check, "the tab crashes")
    cue = []
    for at in (1, 0):
        page.run(f"viewer.show.go({at}).then(idle)")
        time.sleep(1)
        cue.append(audience.surely())
    page.resize(96, 72)  # so that a driver in software has time for screenshots
    page.run("viewer.show.cues[1].fade = 90, viewer.show.go(1)")
    def under_way():  # in both windows, far from either cue
        shots = audience.surely()
        return all(shots) and min(apart(audience.pixels(shot), audience.pixels(end)) for shot, *ends in zip(shots, *cue) for end in ends) > 4

    until = time.monotonic() + 60
    while not under_way() and time.monotonic() < until:  # a slow machine shows it late
        time.sleep(0.5)
    before, seen = quiet(check, audience, "reload in the middle of a fade", reload, after=page.again, seconds=4, same=False)
    page.resize(520, 400)
    page.wait("!viewer.pending && viewer.windows.open.length === 2 && viewer.windows.open.every(({window: w}) => !w.drawing && !w.stale)", 150)  # the fade goes on
    seen.append(audience.surely())
    between = [min(apart(audience.pixels(a), audience.pixels(b)) for b in ends) for a, *ends in zip(before, *cue)]
    ends = [apart(audience.pixels(a), audience.pixels(b)) for a, b in zip(seen[-1], cue[0])]
    check("  the windows stay, and end where the fade led", all(None not in shots for shots in seen) and page.run("viewer.show.at") == 1
          and min(between) > 2 and max(ends) < SAME, f"{between} from either cue at first, {ends} at last")
    page.run("viewer.show.cues[1].fade = 0, viewer.show.go(0)")
    time.sleep(1)
    quiet(check, audience, "the graphics context is lost", lambda: page.run("window.gone = true, viewer.graphics.gl.getExtension('WEBGL_lose_context').loseContext()"), after=page.again)
    windows_back(page, audience, check, "the graphics context is lost")
    page.run("sessionStorage.clear(), window.gone = true")
    quiet(check, audience, "the graphics process crashes", lambda: page.call("Browser.crashGpuProcess", session=None) and None, after=page.again)
    windows_back(page, audience, check, "the graphics process crashes")


def main():
    program, data = sys.argv[1:3]
    found = browser.find()
    if not found:
        print("skipped: Chromium is not installed")
        return 77
    check = Checks()
    with tempfile.TemporaryDirectory() as scratch:
        folder = sys.argv[3] if len(sys.argv) > 3 else scratch
        os.makedirs(folder, exist_ok=True)
        ply, path, other, picture = (os.path.join(scratch, name) for name in ("spot.ply", "spot.html", "other.html", "slip.png"))
        subprocess.run([program, "reconstruct", data, "-o", ply, "--polish", "0"], check=True, stdout=subprocess.DEVNULL)
        subprocess.run([program, "view", ply, "--capture", data, "-o", path], check=True, stdout=subprocess.DEVNULL)
        with open(other, "w", encoding="utf-8") as file:
            file.write("<!doctype html><title>Another</title>")
        with open(picture, "wb") as file:
            file.write(png(64, 48, lambda x, y: (255, 0, 255)))
        page = Show(found, 520, 400)
        try:
            page.begin(path)
            audience = Audience(page, folder)
            audience.look()
            check_slips(check, page, audience, path, other, picture)
            check_awake(check, page, audience)
            check_closed(check, page, audience)
            check_crashes(check, page, audience, path)
            page.screenshot(os.path.join(folder, "page.png"))
        finally:
            page.close()
    print(f"{check.failed} failed" if check.failed else "all passed")
    return 1 if check.failed else 0


if __name__ == "__main__":
    sys.exit(main())
