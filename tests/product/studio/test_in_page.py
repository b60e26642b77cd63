#!/usr/bin/env python3
"""The studio in the page that reconstructs, opened from disk in a headless browser, by its buttons and with its own camera: from nothing to
the relit object; killed, reloaded and stopped meanwhile; saved as a ZIP file, from which the program makes the same.

    test_in_page.py PAGE PROGRAM FOLDER     screenshots and files stay in FOLDER

Exits with 77 and a line where there is no browser."""
import json
import shutil
import subprocess
import sys
import threading
import time
import zipfile
from pathlib import Path

import test_studio
from test_studio import LONG, Film, open_projector, planar

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "view"))
import browser  # noqa: E402
import engines  # noqa: E402

STOPS, PANEL = 8, (320, 200)
APART = 0.1  # dB between the page's object and the program's, of the same photographs
SIMULATOR = ["--split", "test", "--first", "15", "--resolution", "240", "--sensor", "read=0.003"]


# A page that forbids eval lets a script in.
INSIDE = ("(async () => {{ const inner = document.getElementById('studio').contentWindow; if (!inner.document.documentElement) return null; "
          "const script = inner.document.createElement('script'); script.textContent = 'window.asked = (async () => (' + {} + '))()'; "
          "inner.document.documentElement.append(script); script.remove(); return await inner.asked; }})()")


class Page(test_studio.Page):
    """The page; `run` speaks to the studio, a frame of it, once that is open."""

    def __init__(self, program, path, arguments):
        self.path, self.inside, self.lock = path, False, threading.RLock()
        super().__init__(program, ["--js-flags=--max-old-space-size=4096", *arguments])

    def call(self, *given, **more):
        with self.lock:  # the camera's film asks, too
            return super().call(*given, **more)

    def run(self, script, timeout=600, session=""):
        if not self.inside or session:
            return super().run(script, timeout, session)
        return super().run(INSIDE.format(json.dumps(script)), timeout)

    def enter(self):
        self.inside = False
        self.open(str(self.path))
        self.wait("!!window.engine && !!document.getElementById('open-studio')")
        self.click("#open-studio")
        self.inside = True
        self.wait("!!window.ready && !!studio.state")
        self.run("(window.heldStill = () => new Promise(() => {}), 1)")  # nothing begins because it is still

    def hold_panel(self):
        """The projector's window has the panel's pixels, as on a projector."""
        window = next(t for t in self.call("Target.getTargets", session=None)["targetInfos"] if t["type"] == "page" and t["url"] == "about:blank")
        session = self.attach(window["targetId"])
        self.call("Emulation.setDeviceMetricsOverride", {"width": PANEL[0], "height": PANEL[1], "deviceScaleFactor": 1, "mobile": False}, session=session)
        self.wait(f"projector.panel && projector.panel[0] === {PANEL[0]}")


class Seen(threading.Thread):
    """Holds what the simulator photographs of the pattern that is due before the camera."""

    def __init__(self, page, frames, film):
        super().__init__(daemon=True)
        self.page, self.frames, self.film, self.ends, self.shown = page, frames, film, False, None
        self.start()

    def run(self):
        while not self.ends:
            try:
                due = self.page.run("studio.state.active && [studio.state.active.name.split('/').pop(), studio.state.active.next.number]", 5)  # a tab that crashed answers nothing
            except browser.Failure:
                due = None  # between two pages
            if due and due != self.shown:
                self.film.show(self.frames[tuple(due)])
                self.shown = due
            time.sleep(0.02)


def simulate(program, folder):
    """{(folder of the set, number): planar frame} of all photographs, and their size."""
    subprocess.run([program, "patterns", "-o", folder / "patterns", "--projector", "{}x{}".format(*PANEL), "--lollipops", "2"], check=True,
                   stdout=subprocess.DEVNULL)
    frames = {}
    for only in ("empty", *(f"view-{360 * i // STOPS:03d}" for i in range(STOPS))):
        subprocess.run([program, "generate", folder / only, "--photographs", folder / "patterns", "--only", only, "--attitudes", "0", "--views", str(STOPS),
                        *SIMULATOR], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        files = sorted((folder / only / only).glob("*.png"))
        data = planar([file.read_bytes() for file in files])
        one = len(data) // len(files)
        frames.update({(only, int(file.stem)): data[i * one:(i + 1) * one] for i, file in enumerate(files)})
    head = files[0].read_bytes()[16:24]
    return frames, (int.from_bytes(head[:4], "big"), int.from_bytes(head[4:], "big"))


SETS = "objectNow(studio.state).sets"
DONE = f"{SETS}.reduce((sum, set) => sum + set.done, 0)"


def press_until(page, holds, button="#object-shoot", seconds=LONG):
    """Photographs as a person does, a press for each wish, until something holds."""
    end = time.monotonic() + seconds
    while not page.run(holds):
        if page.run("!document.getElementById('shooting-ask').hidden && !document.getElementById('shooting').hidden"):
            page.click("#shooting-go")
        elif not page.run(f"shooting.running || document.querySelector('{button}').hidden || document.querySelector('{button}').disabled"):
            page.click(button)
        elif page.run("!shooting.running && !document.getElementById('shooting').hidden"):
            page.click("#shooting-stop")  # "Go on"
        assert time.monotonic() < end, page.run("[document.getElementById('toast').textContent, JSON.stringify(studio.state.active)]")
        time.sleep(0.05)


def set_up(page, size):
    page.run("doIt({verb: 'set', settings: {projector: [%d, %d]}}).then(() => true)" % PANEL)
    page.click("#steps [data-step=rig]")
    page.click("#open-camera")
    page.wait("!!webcam.stream && document.getElementById('camera-held').textContent")
    assert page.run("document.getElementById('camera-size').textContent") == "{} x {} pixels".format(*size)
    page.run("(webcam.latency = 250)")


def come_back(page, size):
    """After a reload: what was shown is in the folder; camera and projector are opened again."""
    page.enter()
    set_up(page, size)
    open_projector(page)
    page.hold_panel()
    page.click("#steps [data-step=object]")


def photograph_all(page, size):
    """With a reload and a crash of the tab between photographs, a projector window that is closed, and a camera that is unplugged."""
    for way in ("reload", "crash", "window", "camera"):
        before = page.run(DONE)
        press_until(page, f"{DONE} >= {before + 9}")
        shown = page.run(DONE)
        if way == "reload":
            come_back(page, size)
        elif way == "crash":
            try:
                page.inside = False
                page.call("Page.crash", timeout=2)
            except browser.Failure:
                pass
            come_back(page, size)
        elif way == "window":
            page.run("(projector.window.close(), 1)")
            page.wait("!shooting.running && !projector.isOpen")
            open_projector(page)
            page.hold_panel()
            page.click("#steps [data-step=object]")
        else:
            page.run("(() => { const [track] = webcam.stream.getVideoTracks(); track.stop(); track.dispatchEvent(new Event('ended')); })()")
            page.wait("!shooting.running", 60)
            assert page.run("!webcam.stream")
            set_up(page, size)
            page.click("#steps [data-step=object]")
        assert page.run(DONE) >= shown, (way, page.run(DONE), shown)
        print(f"{way}: {shown} photographs were shown, {page.run(DONE)} are kept", flush=True)
    press_until(page, f"{SETS}.every(complete) && !shooting.running")


def make(page):
    """Stopped once in the middle: nothing that was shown is lost."""
    page.wait("studio.state.eye.end !== 'running'", LONG)
    assert page.run("studio.state.eye.end") == "done", page.run("studio.state.eye.log")
    page.click("#make")
    page.wait("studio.state.job.end === 'running' && studio.state.job.current > 0", LONG)
    page.click("#cancel")
    page.wait("!platform.working && studio.state.job.end === 'none'", 60)
    assert page.run(f"{SETS}.every(complete)")
    page.run("doIt({verb: 'set', settings: {draft: true}}).then(() => true)")
    began = time.monotonic()
    page.click("#make")
    page.wait("studio.state.job.name === 'make' && studio.state.job.end !== 'running'", LONG)
    assert page.run("studio.state.job.end") == "done", page.run("studio.state.job.log")
    page.wait_for_viewer()
    seconds = time.monotonic() - began
    page.click("#evaluate")
    page.wait("studio.state.job.name === 'evaluate' && studio.state.job.end !== 'running'", LONG)
    assert page.run("studio.state.job.end") == "done", page.run("studio.state.job.log")
    return seconds


def most_memory():
    """Of the browser's processes that draw pages and compute in them, the largest one's peak, GB."""
    most = 0
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            if b"--type=renderer" in (folder / "cmdline").read_bytes():
                most = max(most, int((folder / "status").read_text().split("VmHWM:")[1].split()[0]))
        except (OSError, IndexError):
            pass  # it ended
    return most / 1e6


def scores_of(text):
    return {row["protocol"]: row["psnr"] for row in json.loads(text)["rows"]}


def save_and_compare(page, program, folder, commands):
    """The ZIP file holds all that the page has; the same commands by the program make the same object of its photographs."""
    page.call("Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(folder)}, session=None)
    page.click("#steps [data-step=rig]")
    page.click("#kept-save")
    end = time.monotonic() + 60
    while not (folder / "rig.zip").exists() and time.monotonic() < end:
        time.sleep(0.2)
    with zipfile.ZipFile(folder / "rig.zip") as packed:
        assert packed.testzip() is None
        packed.extractall(folder / "rig")
    rig = folder / "rig"
    own = scores_of((rig / "objects/object/scores.json").read_text())
    for made in ("calibration.xml", "capture", "object.ply", "view.html", "scores.json", "report.html", "report"):
        path = rig / "objects/object" / made
        shutil.rmtree(path, ignore_errors=True)
        path.unlink(missing_ok=True)
    for line in commands:
        subprocess.run(line.replace("ffprocams", str(program), 1), shell=True, check=True, cwd=rig, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return own, scores_of((rig / "objects/object/scores.json").read_text())


def begin_again(page, folder):
    """Another rig begins; the one that was saved comes back whole."""
    page.run("(window.confirm = () => true, 1)")
    page.click("#kept-new")
    page.wait("studio.state && studio.state.objects.length === 0 && studio.state.patterns.length === 0")
    handle = page.call("Runtime.evaluate", {"expression": "document.getElementById('studio').contentDocument.getElementById('kept-file')"})["result"]["objectId"]
    page.call("DOM.setFileInputFiles", {"files": [str(folder / "rig.zip")], "objectId": handle})
    page.wait("studio.state && studio.state.objects.length === 1 && objectNow(studio.state).view")
    assert page.run(f"{SETS}.every(complete)")


def check_engine(engine, path):
    """From disk: patterns are drawn, the projector's window shows one, and all of it is there after a reload."""
    def ask(script):
        return engine.run(INSIDE.format(json.dumps(script)))

    def until(script):
        end = time.monotonic() + 120
        while not ask(script):
            assert time.monotonic() < end, (engine.name, script, ask("document.getElementById('toast').textContent"))
            time.sleep(0.2)

    def enter():
        engine.go(f"file://{path}")
        while not engine.run("!!window.engine && document.readyState === 'complete'"):
            time.sleep(0.2)
        engine.run("document.getElementById('open-studio').click()")
        until("!!window.ready && !!studio.state")

    enter()
    ask("doIt({verb: 'set', settings: {projector: [%d, %d]}}).then(() => document.getElementById('draw').click())" % PANEL)
    until("studio.state.patterns.length > 0 && studio.state.job.end === 'done'")
    engine.run("""document.body.append(Object.assign(document.createElement('button'), {id: 'press', textContent: 'open', style: 'position: fixed; top: 0; z-index: 1',
        onclick: () => document.getElementById('studio').contentDocument.getElementById('projector-open').click()}))""")
    engine.click("#press")  # browsers give windows to hands only
    until("projector.isOpen")
    shown = ask("platform.blob('patterns/003_lollipop_0.png').then((image) => project({image})).then(({shown}) => shown)")
    enter()
    kept = ask("[studio.state.patterns.length > 0, studio.state.settings.projector]")
    assert shown == list(PANEL) and kept == [True, list(PANEL)], (engine.name, shown, kept)
    print(f"{engine.name}: patterns are drawn, shown and kept", flush=True)


def main():
    path, program, folder = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve(), Path(sys.argv[3]).resolve()
    found = browser.find()
    if not found:
        print("skipped: no Chromium or Chrome")
        return 77
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    frames, size = simulate(program, folder)
    film = Film(folder / "camera.y4m", *size)
    page = Page(found, path, [film.option])
    try:
        began = time.monotonic()
        page.enter()
        painted = super(Page, page).run("performance.getEntriesByName('first-contentful-paint')[0].startTime")
        print(f"opened in {time.monotonic() - began:.1f} s, painted first after {painted / 1000:.2f} s")
        set_up(page, size)
        page.shots(folder, "rig")
        page.click("#draw")
        page.wait("studio.state.patterns.length > 0 && studio.state.job.end === 'done'")
        open_projector(page)
        page.hold_panel()
        page.click("#steps [data-step=object]")
        page.run(f"document.getElementById('object-stops').value = {STOPS}")
        page.click("#object-add")
        page.wait("studio.state.objects.length === 1")
        seen = Seen(page, frames, film)
        photograph_all(page, size)
        seen.ends = True
        seen.join()
        print(f"photographed in {time.monotonic() - began:.0f} s", flush=True)
        page.shots(folder, "object")
        seconds = make(page)
        page.shots(folder, "look")
        commands = json.loads(page.run("textOf('logs/make.json')"))["commands"] + json.loads(
            page.run("textOf('logs/evaluate.json')"))["commands"]
        own, other = save_and_compare(page, program, folder, commands)
        print(f"made in {seconds:.0f} s, at most {most_memory():.2f} GB in one process; page and program, dB: " + ", ".join(f"{name} {own[name]:.2f} {other[name]:.2f}" for name in own))
        assert all(abs(own[name] - other[name]) < APART for name in own), (own, other)
        begin_again(page, folder)
        asked = [url for url in page.requests if not url.startswith(("file:", "blob:", "data:", "about:"))]
        assert not asked, asked
        assert not [line for line in page.said if "exception" in line or line.startswith("error")], page.said
    finally:
        page.close()
    for engine in (engines.Firefox, engines.WebKit):
        if not engine.found():
            print(f"skipped: {engine.name} is not installed")
            continue
        other = engine()
        try:
            check_engine(other, path)
        finally:
            other.close()
    print("the studio in the page: all passed")
    return 0


if __name__ == "__main__":
    sys.exit(main())
