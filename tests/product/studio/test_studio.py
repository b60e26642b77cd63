#!/usr/bin/env python3
"""The studio in a headless browser, driven by its buttons: from nothing to the relit object on the simulated rig, and what that
is worth against the truth.

    test_studio.py PROGRAM FOLDER     screenshots and the studio's folder stay in FOLDER

Exits with 77 and a line where there is no browser, and where the program was built without the studio."""
import atexit
import base64
import json
import math
import os
import re
import resource
import shutil
import socket
import subprocess
import sys
import threading
import time
import urllib.request
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "view"))
import browser  # noqa: E402

STOPS = 8
WINDOW = (900, 600)  # of a page: what a browser draws without a graphics card costs by the pixel
LONG = 600  # seconds of patience where other programs may want the processors, too
ALONE = (0.01, 1.0, 1.0)  # without a board: the camera's middle is not known, which tilts axis and rig together
MASKS = 1.0  # dB that calibration and masks cost at new poses; measured: 0.71


class Studio:
    """The program's server."""

    def __init__(self, program, folder, *options):
        self.process = subprocess.Popen([program, "studio", str(folder), "--no-browser", *options], stdout=subprocess.PIPE,
                                        stderr=subprocess.PIPE, text=True)
        atexit.register(self.process.kill)  # after a failure
        line = self.process.stdout.readline()
        if "open http://" not in line:
            raise SystemExit(line + self.process.stderr.read())
        self.url = line.split("open ")[1].split()[0]

    def stop(self):
        self.process.terminate()
        assert self.process.wait(timeout=30) == 0, self.process.returncode


class Page(browser.Browser):
    def __init__(self, program, arguments=(), slides=False):
        # WebGL is there nevertheless; the page costs half, and less where nothing slides.
        super().__init__(program, *WINDOW, ["--disable-gpu", *([] if slides else ["--force-prefers-reduced-motion"]), *arguments])

    @property
    def said(self):
        """The console's lines but for the driver's advice on speed."""
        return [line for line in self.console if "GL Driver Message (OpenGL, Performance" not in line]

    def start(self, url):
        self.open(url)
        self.wait("document.readyState === 'complete' && !!window.ready")

    def click(self, selector):
        """The middle of an element, by the mouse, where a person would press it, as soon as it can be pressed; again
        where the page moved under the mouse meanwhile."""
        hit = False
        while not hit:
            self.wait(f"""(window.middle = (() => {{ const e = document.querySelector({json.dumps(selector)}); e.scrollIntoView({{block: 'center'}});
                const r = e.getBoundingClientRect(), x = r.left + r.width / 2, y = r.top + r.height / 2;
                if (e.disabled || !e.contains(document.elementFromPoint(x, y))) return null;
                window.hit = false;
                window.addEventListener('click', (event) => {{ window.hit = e.contains(event.target); }}, {{capture: true, once: true}});
                return [x, y]; }})()) !== null""")
            x, y = self.run("window.middle")
            self.mouse("mousePressed", x, y)
            self.mouse("mouseReleased", x, y, buttons=0)
            hit = self.run("window.hit") is not False  # nothing where the click opened another page

    def wait_for_viewer(self):
        """The viewer has the object; it draws one sample a pixel from then on, as nothing here looks at its picture."""
        self.wait("!document.getElementById('look').hidden && !!document.getElementById('viewer').contentWindow.ready", LONG)
        self.run("document.getElementById('viewer').contentWindow.ready.then(() => { "
                 "document.getElementById('viewer').contentWindow.viewer.scene.drawing.samples = 1; return true; })")

    def shots(self, folder, name):
        """Screenshots of the whole page: wide and dark, narrow and light."""
        for width, height, scheme in ((1400, 900, "dark"), (400, 800, "light")):
            self.resize(width, height)
            self.scheme(scheme)
            self.run("new Promise((done) => requestAnimationFrame(() => setTimeout(done, 150)))")
            self.screenshot(str(folder / f"{name}-{width}-{scheme}.png"))
        self.resize(*WINDOW)
        self.scheme("light")


def processors():
    """Seconds of them that the programs took that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def check_remedies(page, folder, pictures):
    """A doubt is shown with what to do about it."""
    log = folder / "logs/make.json"
    text = log.read_text()
    found = json.loads(text)
    views = next(finding for finding in found["findings"] if finding["code"] == "views")
    views.update(code="few-views", severity="doubt", advice="photograph all around")
    log.write_text(json.dumps(found))
    page.run("tellChecks(studio.state, objectNow(studio.state)).then(() => true)")
    shown = page.run("[...document.querySelectorAll('#doubts li')].map((line) => [line.dataset.code, line.querySelector('.remedy')?.textContent ?? ''])")
    page.run("document.getElementById('doubts').scrollIntoView({block: 'center'})")
    page.screenshot(str(pictures / "doubt.png"))
    log.write_text(text)
    assert ["few-views", "photograph all around"] in shown, shown


def go_through(page, folder, pictures):
    """Every step by its buttons; seconds of each."""
    times, began = {}, time.monotonic()

    def done(name):
        nonlocal began
        times[name] = time.monotonic() - began
        page.shots(pictures, name)
        began = time.monotonic()

    page.click("#boards-or-not [data-board=yes]")
    page.wait("!document.getElementById('board-measures').hidden")
    page.shots(pictures, "rig")
    began = time.monotonic()
    page.click("#draw")
    page.wait("!document.getElementById('board').hidden && !document.getElementById('board-shoot').disabled")
    done("patterns")
    page.click("#board-shoot")
    page.wait("studio.state.active && studio.state.active.done > 5", LONG)
    page.shots(pictures, "photographing")
    page.wait("studio.state.sets.every(complete) && !shooting.running", LONG)
    done("boards")
    page.wait("document.querySelectorAll('#seen-says li').length > 0 && /tilted/.test(document.querySelector('#board-sets small').textContent)")
    page.click("#calibrate")
    page.wait("studio.state.axis && studio.state.job.end === 'done' && document.getElementById('calibration-figures').children.length === 8", LONG)
    if not page.run("document.getElementById('fix').hidden"):
        page.click("#fix")
        page.wait("studio.state.job.commands.join().includes('--fix') && studio.state.job.end === 'done'", LONG)
    done("calibration")
    page.click("#steps [data-step=object]")
    page.click("#object-add")
    page.wait("!document.getElementById('object-shoot').hidden && !document.getElementById('object-shoot').disabled")
    page.click("#object-shoot")
    page.wait("objectNow(studio.state).sets.every(complete) && !shooting.running", LONG)
    done("object")
    page.click("#make")
    page.wait_for_viewer()  # the draft
    page.wait("studio.state.job.name === 'make' && studio.state.job.end === 'done'", LONG)
    page.wait_for_viewer()
    check_remedies(page, folder, pictures)
    done("relit")
    page.click("#evaluate")
    page.wait("!document.getElementById('scores').hidden", LONG)
    assert page.run("fetch(document.getElementById('compared').href).then((answer) => answer.text())").count("<img") > 10  # the report
    done("compared")
    compared_now(page)
    done("now")
    return times


def check_object_step(page):
    """The step's controls stay what they are while the state changes, its lines do not, and a message covers neither steps nor controls."""
    line = "document.getElementById('known-figures').lastElementChild.textContent"
    page.wait(f"!{line}.includes('photographed since')", LONG)
    whole = page.run(line)
    fewer = page.run(f"(() => {{ const state = structuredClone(studio.state), object = objectNow(state); object.sets.at(-1).done = 0; drawKnown(state, object); return {line}; }})()")
    other = page.run(f"(() => {{ const state = structuredClone(studio.state), object = objectNow(state); object.name = 'other', object.sets.slice(-2).forEach((set) => {{ set.done = 0; }}), state.eye.end = 'running'; drawKnown(state, object); return {line}; }})()")
    page.run("drawKnown(studio.state, objectNow(studio.state))")
    assert whole == page.run(line) and other == fewer == f"{whole}, 1 discarded since", (whole, fewer, other)
    assert page.run("(() => { const tab = document.querySelector('#object-tabs button'); tab.focus(); drawState(studio.state); return document.activeElement === tab; })()")
    for quality, draft in (("draft", "true"), ("fine", "false")):
        page.click(f"#quality input[value={quality}]")
        page.wait(f"!!studio.state.settings.draft === {draft} && document.querySelector('#quality :checked').value === '{quality}'")
    for width in (1400, 400):
        page.resize(width, 800)
        covered = page.run("""(() => { say('calibrate: view-045: black and white are exchanged: exchange their files.');
            const rect = (e) => e.getBoundingClientRect(), toast = rect(document.getElementById('toast'));
            return [document.querySelector('main'), ...document.querySelectorAll('#steps button')].map((e) => [e, rect(e)]).filter(([, r]) =>
                r.left < toast.right && toast.left < r.right && r.top < toast.bottom && toast.top < r.bottom).map(([e]) => e.tagName + e.innerText.slice(0, 20)); })()""")
        assert not covered, (width, covered)
    page.resize(*WINDOW)


def go_without_board(program, found, folder, first, pictures):
    """From nothing to the relit object by the codes on it alone. The photographs that the first rig simulated are copied."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    film = Film(folder.with_suffix(".y4m"), 480, 360)
    studio, page, began = Studio(program, folder, "--virtual", "--osc", str(port)), Page(found, [film.option]), time.monotonic()
    try:
        page.start(studio.url)
        page.shots(pictures, "rig-alone")
        page.click("#draw")
        page.click("#object-add")
        page.wait("!document.getElementById('object-shoot').hidden && !document.getElementById('object-shoot').disabled")
        for stage in ("empty", "view-*"):
            for made in (first / "virtual").glob(stage):
                shutil.copytree(made, folder / "virtual" / made.name)
        page.click("#object-shoot")
        page.wait("objectNow(studio.state).sets.every(complete) && !shooting.running && studio.state.eye.end !== 'running'", LONG)
        page.wait("/well enough/.test(document.getElementById('known-verdict').textContent)")
        page.shots(pictures, "known")
        check_object_step(page)
        page.click("#make")
        page.wait_for_viewer()  # the draft
        page.wait("studio.state.job.name === 'make' && studio.state.job.end === 'done'", LONG)
        page.wait_for_viewer()
        seconds = time.monotonic() - began
        check_show_step(page)
        controlled(page, port)
        compared_now(page)
        watched(page)
        watched_by_webcam(page, program, folder, film)
        assert not page.said, page.said
    finally:
        page.close()
        studio.stop()
    return seconds


def check_show_step(page):
    """The show's controls are open when its step is entered, and after a reload there; the verdict's number is that of the checks."""
    opened = """(() => { const page = document.getElementById('viewer')?.contentDocument, cues = page && page.getElementById('cues'); return !window.left && !!cues &&
        cues.closest('details').open && !page.getElementById('views').closest('details').open && page.body.classList.contains('with-panel'); })()"""
    page.wait("/^Good: /.test(document.getElementById('verdict').textContent)")
    counts = page.run("['verdict', 'passed'].map((id) => document.getElementById(id).textContent.match(/[0-9]+(?= checks)/)[0]).concat(document.getElementById('passed').textContent.split(' ')[0])")
    assert len(set(counts)) == 1, counts
    page.resize(400, 800)
    page.click("#steps [data-step=show]")
    page.wait(opened)
    page.run("window.left = true")
    page.call("Page.reload")
    page.wait(opened)
    page.resize(*WINDOW)
    page.click("#steps [data-step=look]")
    page.wait_for_viewer()


def controlled(page, port):
    """OSC messages reach the viewer in the page."""
    viewer, took = "document.getElementById('viewer').contentWindow.viewer", []
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        for packet, dark in ((b"/blackout\0\0\0,i\0\0\0\0\0\1", "true"), (b"/blackout\0\0\0,\0\0\0", "false")):
            page.wait("/127.0.0.1/.test(document.getElementById('viewer').contentWindow.document.getElementById('osc').textContent)")
            began = time.monotonic()
            sender.sendto(packet, ("127.0.0.1", port))
            page.wait(f"{viewer}.dark === {dark}")
            took.append(time.monotonic() - began)
    print(f"OSC: blackout after {took[0]:.2f} s, light after {took[1]:.2f}")


def compared_now(page):
    """As the object stands; after the table was turned by two degrees; and with camera and projector found again by the object."""
    def ask(button, rows, turned=0):
        page.run(f"document.getElementById('now-view').value = 'view-045'; document.getElementById('now-pattern').value = '004_lollipop_1.png'; "
                 f"document.getElementById('now-turned').value = {turned}")
        page.click(button)
        page.wait(f"document.querySelectorAll('#now-scores tbody tr').length === {rows} && !document.getElementById('now-go').disabled", LONG)
        return page.run("[...document.querySelector('#now-scores tbody tr:last-child').children].map((cell) => cell.textContent)")

    before, moved, again = ask("#now-go", 1), ask("#now-go", 2, 2), ask("#now-register", 3)
    print(f"now {before[1]} dB, with the table turned by 2 degrees {moved[1]} dB; {again[0]}: {again[1]} dB")
    before, moved, found = (float(row[1]) for row in (before, moved, again))
    turns = [float(word) for word in re.findall(r"by ([\d.]+)", again[0])]
    assert before > 37 and moved < before - 4 and found > before - 1.5 and all(abs(turn - 2) < 0.3 for turn in turns) and len(turns) == 2


def watched(page):
    """Under the show's own picture: nothing has moved, the table has been turned by two degrees, and back; then from another stop."""
    def look(turned, stop):
        page.run(f"document.getElementById('now-view').value = '{stop}'; document.getElementById('now-turned').value = {turned}; window.said = ''; "
                 "lookOnce().then((text) => { window.said = text; }, (error) => { window.said = error.stack; }); true")
        page.wait("!!window.said", LONG)
        said = page.run("window.said")
        print(f"watched at {stop}, the table off by {turned} degrees: {said}")
        return said

    said = [look(turned, "view-045") for turned in (0, 2, 0)]
    turns = [float(word) for text in said[1:] for word in re.findall(r"by ([\d.]+)°", text)]
    assert "Nothing has moved" in said[0] and len(turns) == 4 and all(abs(turn - 2) < 0.5 for turn in turns), said
    assert page.run("""(() => { const {viewer} = document.getElementById('viewer').contentWindow, {pose} = viewer.projectors[0].device;
        return pose.every((x, i) => x === watching.poses.projector[i]); })()""")  # the viewer has followed
    assert "Nothing has moved" in look(0, "view-090")


class Film:
    """The film before a browser's camera: one picture, which the browser reads again for each frame."""

    def __init__(self, path, width, height):
        self.path, self.head = path, f"YUV4MPEG2 W{width} H{height} F30:1 Ip A1:1 C420jpeg\nFRAME\n".encode()
        path.write_bytes(self.head + b"\x80" * (width * height * 3 // 2))
        self.option = f"--use-file-for-fake-video-capture={path}"

    def show(self, frame):
        with open(self.path, "r+b") as out:
            out.seek(len(self.head))
            out.write(frame)


def planar(pictures):
    """PNG files as frames (4:2:0), one after the other."""
    return subprocess.run(["ffmpeg", "-loglevel", "error", "-f", "image2pipe", "-c:v", "png", "-i", "-", "-pix_fmt", "yuv420p", "-f", "rawvideo", "-"],
                          input=b"".join(pictures), check=True, stdout=subprocess.PIPE).stdout


def watched_by_webcam(page, program, folder, film):
    """The same by this browser's camera, which sees what the simulator photographs of the show's picture."""
    settings = json.loads((folder / "studio.json").read_text())

    def photograph(turned):
        place, stops = (45, STOPS) if turned == 0 else (45 + turned, 360)
        shown, seen = folder / "trial/shown", folder / f"trial/{place}"
        shown.mkdir(parents=True, exist_ok=True)
        picture = page.run("pictureOfShow(viewerOf()).then(({blob}) => new Promise((done) => { const read = new FileReader(); "
                           "read.onload = () => done(read.result.split(',')[1]); read.readAsDataURL(blob); }))")
        (shown / "999_own.png").write_bytes(base64.b64decode(picture))
        shutil.rmtree(seen, ignore_errors=True)
        subprocess.run([program, "generate", seen, "--photographs", shown, "--only", f"view-{place:03d}", "--attitudes", str(settings["attitudes"]),
                        "--views", str(stops), *settings["simulator"]], cwd=folder, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        film.show(planar([next(seen.glob("view-*/*.png")).read_bytes()]))

    def look(turned):
        photograph(turned)
        time.sleep(0.5)
        page.run("window.heard = []; window.said = ''; new MutationObserver(() => heard.push(document.getElementById('watch-says').textContent))"
                 ".observe(document.getElementById('watch-says'), {childList: true}); "
                 "lookOnce().then((text) => { window.said = text; }, (error) => { window.said = error.stack; }); true")
        page.wait("!!window.said", LONG)
        said = page.run("window.said")
        print(f"watched by webcam, the table off by {turned} degrees: {said} {page.run('heard')}", flush=True)
        return said

    page.run("doIt({verb: 'set', settings: {camera: 'browser'}}).then(() => openCamera()).then(() => { document.getElementById('now-view').value = 'view-045'; return true; })")
    page.run("beginAgain(watching, null, Uint32Array.of()); true")
    said = [look(turned) for turned in (0, 0, 0, 2)]
    turns = [float(word) for word in re.findall(r"by ([\d.]+)°", said[3])]
    assert all("Nothing has moved" in text for text in said[:3]) and len(turns) == 2 and all(abs(turn - 2) < 0.5 for turn in turns), said
    assert any("Something has moved" in text for text in page.run("heard")), page.run("heard")  # at once, by the photographs alone
    page.run("doIt({verb: 'set', settings: {camera: 'virtual'}}).then(() => true)")


# --- Other cameras, which see what the simulated one saw. ---

class Seen(threading.Thread):
    """Holds the photograph that is due before a camera, whenever another is."""

    def __init__(self, studio, virtual, show):
        super().__init__(daemon=True)
        self.url, self.virtual, self.show, self.ends = studio.url + "state", virtual, show, False
        self.start()

    def run(self):
        before = None
        while not self.ends:
            with urllib.request.urlopen(self.url) as answer:
                state = json.load(answer)
            active, folder = state["active"], state["settings"]["camera"] == "folder"
            due = active and (active["shown"] or not folder) and (active["name"].split("/")[-1], active["next"]["number"])
            if due and due != before:
                stage, number = due
                self.show(self.virtual / stage / stage / (f"{number:02d}.png" if stage == "turntable" else f"{number:03d}.png"))
            before = due
            time.sleep(0.01)

    def stop(self):
        self.ends = True
        self.join()


def open_projector(page):
    page.click("#steps [data-step=rig]")
    page.click("#projector-open")
    page.wait("projector.isOpen")
    assert page.run("document.getElementById('projector-size').textContent.includes('pixels')")


BY_BUTTON = "window.heldStill = () => new Promise(() => {}); true"  # nothing begins because it is still


def photograph(page, button, sets, count, seconds):
    """As a person does: one set after the other of those that an expression names, a press for each wish."""
    for i in range(count):
        page.wait(f"!document.querySelector('{button}').disabled")
        page.click(button)
        end = time.monotonic() + seconds
        while not page.run(f"{sets}.filter(complete).length > {i} && !shooting.running"):
            if page.run("!document.getElementById('shooting-ask').hidden && !document.getElementById('shooting').hidden"):
                page.click("#shooting-go")
            assert time.monotonic() < end, page.run("document.getElementById('toast').textContent")
            time.sleep(0.03)


def photograph_boards(page, boards, seconds=LONG):
    page.click("#steps [data-step=board]")
    photograph(page, "#board-shoot", "studio.state.sets", boards, seconds)


def calibrate_and_relight(page):
    """With the boards photographed: the calibration, the empty stage, the object at its stops, and what the viewer shows."""
    page.run("doIt({verb: 'set', settings: {fix: ['k3', 'k2']}}).then(() => true)")  # few boards do not determine them
    page.click("#calibrate")
    page.wait("studio.state.calibrated && studio.state.axis && studio.state.job.end === 'done'", LONG)
    page.click("#steps [data-step=object]")
    page.click("#object-add")
    page.wait("!document.getElementById('object-shoot').hidden && !document.getElementById('object-shoot').disabled")
    photograph(page, "#object-shoot", "objectNow(studio.state).sets", STOPS + 1, LONG)
    page.click("#make")
    page.wait_for_viewer()  # the draft
    page.wait("studio.state.job.name === 'make' && studio.state.job.end === 'done'", LONG)
    page.wait_for_viewer()


def watched_folder(program, found, folder, first):
    """A camera's program writes files into a folder: every photograph is on disk to the bit."""
    place = folder / "camera"
    place.mkdir()
    studio, page = Studio(program, folder / "watched", "--virtual"), Page(found)
    count = 0

    def show(file):
        nonlocal count
        count += 1
        shutil.copy(file, place / "part")  # whole when it appears, as cameras' programs have it
        os.rename(place / "part", place / f"IMG_{count:04d}.PNG")

    try:
        page.start(studio.url)
        page.click("[data-camera=folder]")
        page.wait("studio.state.settings.camera === 'folder'")
        page.run(f"document.getElementById('watched').value = {json.dumps(str(place))}; "
                 "document.getElementById('watched').dispatchEvent(new Event('change'))")
        page.wait("studio.state.settings.watched")
        page.run("doIt({verb: 'set', settings: {attitudes: 4, without_board: false}}).then(() => true)")
        page.click("#draw")
        page.wait("studio.state.patterns.length > 0 && studio.state.job.end === 'done'")
        open_projector(page)
        seen = Seen(studio, first / "virtual", show)
        photograph_boards(page, 5)
        calibrate_and_relight(page)
        seen.stop()
        assert not page.said, page.said
    finally:
        page.close()
        studio.stop()
    photographs = [file for file in (folder / "watched").glob("*/*/*.png") if file.parent.parent.name == "calibration"]
    photographs += (folder / "watched/objects/object").glob("[ev]*/*.png")
    assert len(photographs) == count == 4 * 36 + 5 + 4 * (STOPS + 1), (len(photographs), count)
    for file in photographs:
        assert file.read_bytes() == (first / file.relative_to(folder / "watched")).read_bytes(), file
    return count


def frames_of(first, stages):
    """Size and planar frames (4:2:0) of the photographs that the simulated camera took."""
    frames, size = {}, None
    for stage in stages:
        files = sorted((first / "virtual" / stage / stage).glob("*.png"))
        data = planar(file.read_bytes() for file in files)
        one = len(data) // len(files)
        frames.update({file: data[i * one:(i + 1) * one] for i, file in enumerate(files)})
        head = files[0].read_bytes()[16:24]
        size = int.from_bytes(head[:4], "big"), int.from_bytes(head[4:], "big")
    return size, frames


def fake_camera(program, found, folder, first):
    """This browser's camera, whose film is the photograph that is due."""
    boards = [f"attitude-{i:02d}" for i in range(4)]
    size, frames = frames_of(first, [*boards, "turntable", "empty", *(f"view-{45 * i:03d}" for i in range(STOPS))])
    film = Film(folder / "camera.y4m", *size)
    film.show(next(iter(frames.values())))

    def show(file):
        film.show(frames[file])

    studio = Studio(program, folder / "browser", "--virtual")
    page = Page(found, [film.option])
    try:
        page.start(studio.url)
        page.click("[data-camera=browser]")
        page.wait("studio.state.settings.camera === 'browser'")
        page.run("doIt({verb: 'set', settings: {attitudes: 4, without_board: false}}).then(() => true)")
        page.wait("studio.state.settings.attitudes === 4")  # what is drawn again after that is there
        page.click("#open-camera")
        page.wait("!!webcam.stream && document.getElementById('camera-held').textContent")
        assert page.run("document.getElementById('camera-size').textContent") == f"{size[0]} x {size[1]} pixels"
        page.click("#draw")
        page.wait("studio.state.patterns.length > 0 && studio.state.job.end === 'done'")
        page.run("webcam.latency = 300")
        open_projector(page)
        seen = Seen(studio, first / "virtual", show)
        # The first board is moved, and held still: nobody presses a button.
        page.click("#steps [data-step=board]")
        page.click("#board-shoot")
        page.wait("!document.getElementById('shooting-ask').hidden")
        time.sleep(1)
        assert page.run("studio.state.active.done === 0")
        for stage in ("attitude-01", "attitude-02", "attitude-00"):
            show(first / "virtual" / stage / stage / "002.png")
            time.sleep(0.4)
        show(first / "virtual/attitude-00/attitude-00/001.png")
        page.wait("studio.state.sets.filter(complete).length > 0 && !shooting.running", LONG)
        page.run(BY_BUTTON)
        photograph_boards(page, 4)
        calibrate_and_relight(page)
        seen.stop()
        assert not page.said, page.said
    finally:
        page.close()
        studio.stop()


# --- What goes wrong. ---

def count_of(folder):
    return len(list((folder / "calibration").glob("*/*.png")))


def faults(program, found, folder, first):
    """Each as it happens to people: what the page says, and what is on disk."""
    rig, told = folder / "faults", 0
    rig.mkdir()
    for part in ("patterns", "virtual"):  # what the first rig has drawn and simulated already
        shutil.copytree(first / part, rig / part)
    studio, page = Studio(program, rig, "--virtual"), Page(found, slides=True)
    try:
        # The page is reloaded while it photographs: it goes on with the next.
        page.start(studio.url)
        page.run("doIt({verb: 'set', settings: {without_board: false}}).then(() => showStep('board')).then(() => true)")
        page.click("#board-shoot")
        page.wait("studio.state.active && studio.state.active.done > 3")
        page.start(studio.url)
        assert page.asked == ["beforeunload"], page.asked
        before = count_of(rig)
        page.wait("!document.getElementById('shooting').hidden && document.getElementById('shooting-stop').textContent === 'Go on'")
        assert count_of(rig) <= before + 1
        # A second window presses the button too: one of them goes on, the other says so, and no photograph is lost or doubled.
        other = Page(found)
        try:
            other.start(studio.url)
            page.click("#shooting-stop")
            other.click("#shooting-stop")
            page.wait("studio.state.sets[0].done === studio.state.sets[0].count", LONG)
            other.wait("!shooting.running", LONG)
        finally:
            other.close()
        assert len(list((rig / "calibration/attitude-00").glob("*.png"))) == 36
        told += 2
        # Taken again: the photographs are moved, not deleted. "Go on" may be busy with the sets after the first.
        if page.run("shooting.running"):
            page.click("#shooting-stop")
            page.wait("!shooting.running")
        page.click("#board-sets .set .again")
        page.wait("studio.state.sets[0].done === 0")
        assert len(list((rig / "discarded/calibration-attitude-00-1").glob("*.png"))) == 36
        page.run("(async () => { for (const {name, done} of studio.state.sets.slice(1)) if (done) await doIt({verb: 'discard', set: name}); return true; })()")
        told += 1
        # Pause, and on.
        page.click("#board-shoot")
        page.wait("studio.state.active && studio.state.active.name.endsWith('00') && studio.state.active.done > 2")
        page.click("#shooting-stop")
        page.wait("!shooting.running && document.getElementById('shooting-stop').textContent === 'Go on'")
        told += 1
        # The studio is killed while the page photographs: the page says so; what it showed is on disk.
        page.click("#shooting-stop")
        page.wait("studio.state.active && studio.state.active.name.endsWith('00') && studio.state.active.done > 3")
        studio.process.kill()
        studio.process.wait()
        page.wait("document.getElementById('toast').textContent.includes('does not answer')")
        shown = page.run("studio.state.active.done")
        assert len(list((rig / "calibration/attitude-00").glob("[0-9]*.png"))) >= shown
        studio = Studio(program, rig)
        page.start(studio.url)
        assert page.run("studio.state.active.done") >= shown
        told += 1
        # A step that cannot be done says what is lacking.
        said = page.run("doIt({verb: 'run', step: 'calibrate'}).catch((error) => error.message)")
        assert "three are the least" in said, said
        told += 1
        # The camera of the browser without a projector window; the window is closed while photographs are taken.
        page.run("doIt({verb: 'discard', set: 'calibration/attitude-00'}).then(() => true)")
        page.run("doIt({verb: 'discard', set: 'calibration/attitude-01'}).then(() => true)")
        page.click("#steps [data-step=rig]")
        page.run(BY_BUTTON)
        page.click("[data-camera=browser]")
        page.wait("studio.state.settings.camera === 'browser'")
        page.click("#steps [data-step=board]")
        page.click("#board-shoot")
        page.wait("document.getElementById('toast').textContent.includes('Open the projector window')")
        # The browser opens no window, and gives no camera.
        page.run("window.openWas = window.open; window.open = () => null; true")
        page.click("#steps [data-step=rig]")
        page.click("#projector-open")
        page.wait("document.getElementById('toast').textContent.includes('allow this page to open windows')")
        page.run("window.open = window.openWas; navigator.mediaDevices.getUserMedia = () => Promise.reject(new DOMException('Permission denied', 'NotAllowedError')); true")
        page.click("#open-camera")
        page.wait("document.getElementById('toast').textContent.includes('cannot be opened: Permission denied')")
        page.run("delete navigator.mediaDevices.getUserMedia")
        told += 2
        open_projector(page)
        assert "full screen" in page.run("document.getElementById('projector-size').textContent")  # it has other pixels than the patterns
        said = page.run("studio.state.settings.virtual = false; takeOne({name: 'x', next: {number: 1, pattern: 'patterns/001_black.png'}})"
                        ".catch((error) => error.message)")
        assert "full screen on the projector's display" in said, said
        page.run("refresh().then(() => true)")
        page.click("#steps [data-step=board]")
        page.click("#board-shoot")
        page.wait("document.getElementById('toast').textContent.includes('Open the camera first')")
        page.click("#steps [data-step=rig]")
        page.click("#open-camera")
        page.wait("!!webcam.stream && document.getElementById('camera-held').textContent")
        # Faults of the camera's picture are reported while they can still be put right.
        page.click("#live-white")
        page.wait("document.getElementById('live-says').children.length === 4")
        assert "too dark" in page.run("document.getElementById('live-says').textContent")
        # The camera does not see the projector.
        page.run("webcam.stream.getVideoTracks()[0].enabled = false")
        page.click("#latency")
        page.wait("document.getElementById('toast').textContent.includes('does not see the projector')")
        page.run("webcam.stream.getVideoTracks()[0].enabled = true")
        page.click("#steps [data-step=board]")
        page.click("#board-shoot")
        page.wait("!document.getElementById('shooting-ask').hidden")
        page.click("#shooting-go")
        # There is no board in the picture: it says so before the codes, and what was photographed is kept.
        page.wait("document.getElementById('shooting-ask').textContent.includes('no chessboard with 9 x 6') && !document.getElementById('shooting-ask').hidden")
        assert len(list((rig / "discarded/calibration-attitude-00-3").glob("*.png"))) == 2
        told += 1
        # The window is closed amid the loading of a pattern, which then fails, too: what counts is that the window is gone.
        page.run("projector.wire.post = function (what) { delete this.post; this.post(what); projector.window.close(); }")
        page.click("#shooting-go")
        page.wait("!shooting.running && document.getElementById('toast').textContent.includes('projector window was closed')")
        told += 5
        # The camera stands still, as one does that another program takes.
        open_projector(page)
        page.run("window.nextFrameWas = HTMLVideoElement.prototype.requestVideoFrameCallback; HTMLVideoElement.prototype.requestVideoFrameCallback = () => {}; true")
        page.click("#steps [data-step=board]")
        page.click("#shooting-stop")
        page.wait("!document.getElementById('shooting-ask').hidden")
        page.click("#shooting-go")
        page.wait("!shooting.running && document.getElementById('toast').textContent.includes('gives no new picture')")
        page.run("HTMLVideoElement.prototype.requestVideoFrameCallback = nextFrameWas; true")
        told += 1
        # The camera is unplugged.
        page.run("webcam.stream.getVideoTracks()[0].dispatchEvent(new Event('ended'))")
        page.wait("document.getElementById('toast').textContent.includes('camera is gone')")
        told += 1
        # The board has other corners than were given.
        for i in range(3, 6):
            shutil.copytree(first / f"calibration/attitude-{i:02d}", rig / f"calibration/attitude-{i:02d}")
        page.run("doIt({verb: 'set', settings: {board: [8, 6]}}).then(() => doIt({verb: 'run', step: 'calibrate'})).then(() => true)")
        page.wait("studio.state.job.end === 'failed' && document.getElementById('toast').textContent.includes('8 x 6')", LONG)
        assert "there is one with 9 x 6" in (rig / "logs/calibrate.txt").read_text() and not (rig / "calibration/calibration.xml").exists()
        told += 1
    finally:
        page.close()
        studio.stop()
    return told


# --- What it is worth. ---

def numbers_of(xml, name):
    data = xml.split(f"<{name} ")[1].split("<data>")[1].split("</data>")[0]
    return [float(word) for word in data.split()]


def calibration_of(folder):
    """Of the rig or, without a board, of the object."""
    return "calibration" if (folder / "calibration").is_dir() else "objects/object"


def check_calibration(folder, truth):
    """Worst relative error of the focal lengths; angle between the axes, degrees."""
    place, worst = folder / calibration_of(folder), 0.0
    xml = (place / "calibration.xml").read_text()
    for ours, theirs in (("cam_int", "cam_K"), ("proj_int", "proj_K")):
        found, true = numbers_of(xml, ours), truth[theirs]
        worst = max(worst, abs(found[0] / true[0][0] - 1), abs(found[4] / true[1][1] - 1))
    axis = json.loads((place / "axis.json").read_text())["axis"]
    cosine = sum(a * b for a, b in zip(axis, truth["axis"])) / math.sqrt(sum(a * a for a in axis) * sum(b * b for b in truth["axis"]))
    return worst, math.degrees(math.acos(min(1.0, cosine)))


NEW = ("023", "113", "203", "293")  # stops between those of the studio


def simulate_new(program, first):
    settings = json.loads((first / "studio.json").read_text())
    for view in NEW:
        subprocess.run([program, "generate", f"virtual/view-{view}", "--photographs", "patterns", "--views", "16", "--attitudes", "0", "--only", f"view-{view}",
                        *settings["simulator"]], cwd=first, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def new_poses(program, folder, first, calibration):
    """dB at NEW of a folder's photographs: "found", by its own calibration and masks, or "true", by those of the simulator."""
    true = first / "virtual/view-000/truth.json"
    place = calibration_of(folder)
    rig = ["-c", true, "-t", true] if calibration == "true" else ["-c", f"{place}/calibration.xml", "-t", f"{place}/axis.json"]

    def run(*words):
        subprocess.run([program, *map(str, words)], cwd=folder, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def make(photographs, output, views):
        run("import", *rig, "--angles", "16x22.5", "--shown", "patterns", "-i", f"black,white,lollipop_0,lollipop_1={photographs}/00[1-4].png",
            "-m", f"{first}/virtual/view-{{view}}/masks/view-{{view}}.png", "--held-out", "lollipop_1=patterns/004_lollipop_1.png", "-w", "128",
            "--name", "object", "-o", output, *(word for view in views for word in ("-v", view)))

    make(f"{first}/virtual/view-{{view}}/view-{{view}}", calibration + "-new", NEW)
    if calibration == "true":
        make("objects/object/view-{view}", "true", [f"{45 * i:03d}" for i in range(STOPS)])
    capture = "true" if calibration == "true" else "objects/object/capture"
    given = [] if calibration == "true" else ["--gaussians", "objects/object/object.ply"]  # those that the viewer shows
    run("evaluate", capture, *given, "--targets", f"{calibration}-new/scene.json", "--json", "new.json")
    rows = json.loads((folder / "new.json").read_text())
    rows = rows["rows"] if isinstance(rows, dict) else rows
    return next(row["psnr"] for row in rows if row["protocol"] == "novel_pose")


def judge(program, folder, first, true=None, limits=(0.003, 0.2, MASKS)):
    """The quality of a folder's calibration and object, in words; the same as numbers are held to their limits: of the
    focal lengths, of the axis in degrees, of new poses in dB."""
    focal, axis = check_calibration(folder, json.loads((first / "virtual/attitude-00/truth.json").read_text()))
    true = true or new_poses(program, folder, first, "true")
    ours = new_poses(program, folder, first, "found")
    print(f"  focal lengths within {100 * focal:.2f} %, the axis within {axis:.3f} degrees; "
          f"new poses {ours:.2f} dB, {true:.2f} with true calibration and masks")
    assert focal < limits[0] and axis < limits[1] and ours > true - limits[2]
    return true


def main():
    program, folder = os.path.abspath(sys.argv[1]), Path(sys.argv[2]).resolve()
    found = browser.find()
    if not found:
        print("no browser: the studio is not tested")
        return 77
    if subprocess.run([program, "studio", "/nowhere/at/all", "--no-browser"], capture_output=True, text=True).stderr.count("without the studio"):
        print("built without the studio")
        return 77
    shutil.rmtree(folder, ignore_errors=True)
    pictures, first = folder / "pictures", folder / "rig"
    pictures.mkdir(parents=True)
    studio = Studio(program, first, "--virtual")
    page = Page(found)
    try:
        page.start(studio.url)
        times = go_through(page, first, pictures)
        assert not page.said, page.said
    finally:
        page.close()
        studio.stop()
    used = processors()
    print(", ".join(f"{name} {seconds:.1f} s" for name, seconds in times.items()) +
          f"; {sum(times.values()):.0f} s together, {used:.0f} s of processors")
    simulate_new(program, first)
    true = judge(program, first, first)
    print(f"without a board: {go_without_board(program, found, folder / 'alone', first, pictures):.1f} s")
    judge(program, folder / "alone", first, true, ALONE)
    print(f"a watched folder: {watched_folder(program, found, folder, first)} photographs, the same to the bit")
    judge(program, folder / "watched", first, true)
    print(f"{faults(program, found, folder, first)} faults are named, and nothing is lost")
    if shutil.which("ffmpeg"):
        fake_camera(program, found, folder, first)
        print("the browser's camera, a film of the photographs in 4:2:0 colour:")
        judge(program, folder / "browser", first)
    return 0


if __name__ == "__main__":
    sys.exit(main())
