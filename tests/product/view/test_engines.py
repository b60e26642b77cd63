#!/usr/bin/env python3
"""The page of `ffprocams view` in each of the three engines: the pixels of the lit object.

    test_engines.py PROGRAM DATA [FOLDER]     screenshots stay in FOLDER

Says which engines are not installed; exits with 77 where none is."""
import base64
import os
import shutil
import subprocess
import sys
import tempfile
import time

import browser
import engines
from test_view import LEAST, Checks, Page, film_of, psnr, read_png

# dB. Mesa's software driver, which Firefox and WebKit use here, takes one mip level for four pixels: a hundred pixels with long
# footprints are too dark (36.2; with one level only 67).
BY_MESA = 34.0
VIEW, PATTERNS = "path_0_theta090", ("all_white", "lollipop_3")

# The mean of the picture's bytes.
SEEN = "(() => { const b = viewer.picture(128, 128); return b.reduce((sum, x, i) => sum + (i % 4 < 3 ? x : 0), 0) / (b.length / 4 * 3); })()"


class Chromium(Page):
    name = "Chromium"

    def __init__(self):
        super().__init__(browser.find(), 520, 400)

    @staticmethod
    def found():
        return browser.find()

    def picture(self):
        return base64.b64decode(self.call("Page.captureScreenshot", {"format": "png"})["data"])


def pixels(page, width, height):
    return base64.b64decode(page.run(f"(() => {{ let text = ''; for (const byte of viewer.picture({width}, {height})) "
                                     "text += String.fromCharCode(byte); return btoa(text); })()"))


def check_engine(check, page, name, folder):
    """Patterns of the file against render's pictures; then each way in which a canvas comes to the graphics driver: a gradient, a
    layer with pulled corners, an effect, a surface, paint, a correction."""
    page.run(f"viewer.jump(viewer.scene.views.find((view) => view.id === {VIEW!r}), true)")
    for pattern in PATTERNS:
        page.run(f"(async () => viewer.setContent(await patternContent(viewer.scene, viewer.scene.patterns.findIndex((p) => p.name === {pattern!r}))))()")
        width, height, wanted = read_png(os.path.join(folder, f"{VIEW}_{pattern}.png"))
        score = psnr(pixels(page, width, height), wanted, 4)
        check(f"{name}, {pattern} as ffprocams render draws it", score >= (LEAST if name == "Chromium" else BY_MESA), f"{score:.2f} dB")
    seen = {"black": page.run("viewer.setContent(new SolidContent('#000')), " + SEEN)}
    for what, do in (("white", "viewer.setContent(new SolidContent('#fff'))"),
                     ("pulled", "viewer.projector.layer.place.pull = [[.3, .3], [-.3, .35], [-.35, -.35], [.3, -.3]], viewer.projector.dirty = true"),
                     ("effect", "viewer.relief.sound.set(1), viewer.setContent(new EffectContent('pulse', '#ffffff'))"),
                     ("surface", "viewer.choosing.choose(viewer.choosing.pointInPicture([0.5, 0.5]), {}), viewer.setLayers([new Layer(new SolidContent('#fff'), {on: 1})])"),
                     ("paint", "viewer.setContent(new SolidContent('#000')), viewer.projector.dab(viewer.projector.pattern.width / 2, "
                               "viewer.projector.pattern.height / 2, viewer.projector.pattern.width / 8, '#fff')"),
                     ("correction", "viewer.projector.clearPaint(), viewer.setLayers([new Layer(new SolidContent('#808080'))]), "
                                    "Object.assign(viewer.projector, {correction: 'paint', watcher: 'now'}), viewer.projector.dirty = true")):
        seen[what] = page.run(f"({do}, {SEEN})")
    lit = {what: mean - seen["black"] for what, mean in seen.items() if what != "black"}
    good = lit["white"] > 10 and 5 < lit["pulled"] < lit["white"] and lit["effect"] > 0.7 * lit["white"] and 0.1 < lit["surface"] < 0.5 * lit["white"] and lit["paint"] > 1 and 2 < lit["correction"] < lit["white"]
    check(f"{name}, the lit object", good, " ".join(f"{what} {mean:+.2f}" for what, mean in lit.items()))
    error = page.run("viewer.graphics.gl.getError()")
    check(f"{name}, no error of the driver", error == 0, error)


def check_tile(check, page, name):
    """The tile of a film that begins black."""
    film = base64.b64encode(film_of("webm", "-c:v", "libvpx")).decode()
    said = page.run(f"viewer.library.take(new File([Uint8Array.from(atob({film!r}), (c) => c.charCodeAt(0))], 'film.webm', {{type: 'video/webm'}})).then(() => '', (error) => error.message)")
    if said:
        print(f"skipped: {name}: {said}")
        return
    pixel = "[...[...document.querySelectorAll('#contents button')].find((b) => b.title === 'film.webm').querySelector('canvas').getContext('2d').getImageData(48, 48, 1, 1).data]"
    until(page, f"{pixel}[1] > 100")
    seen = page.run(pixel)
    check(f"{name}, a film's tile is not black", seen[1] > 200 and seen[0] < 60, f"{seen}")


class Apart:
    """A projector window of a driven engine, and the way back to the page."""

    def __init__(self, page, there):
        self.page, self.there, self.here = page, there, None

    def __enter__(self):
        self.here = next(handle for handle in self.page.handles() if handle not in self.there)
        self.page.turn_to(self.here)
        return self.page

    def __exit__(self, *_):
        self.page.turn_to(self.there[0])


def check_window(check, page, name, path):
    """From disk: a window shows what the page sends, keeps it while the page is away, and is found again by a page that is loaded again."""
    colour = "String([...far.context().getImageData(0, 0, 1, 1).data].slice(0, 3))"
    there = page.handles()
    page.run("""viewer.projector.correction = 'none', viewer.setContent(new SolidContent('#00ff00')), document.body.append(element('button', {id: 'press', style: 'position:fixed;left:0;top:0;z-index:9',
        textContent: 'open', onclick: () => viewer.window.open()}))""")
    page.click("#press")  # browsers give windows to hands only
    until(page, "viewer.window.isOpen && !viewer.window.drawing")
    seen = []
    with Apart(page, there):
        seen.append(page.script(f"return {colour}"))
    page.run("viewer.store.keep()")
    page.go("about:blank")
    with Apart(page, there):
        seen.append(page.script(f"return {colour}"))
    page.start(path, fresh=False)
    until(page, "viewer.window.isOpen && !viewer.window.drawing")
    page.run("viewer.setContent(new SolidContent('#ff0000'))")
    until(page, "!viewer.pending && !viewer.window.drawing && !viewer.window.stale")
    with Apart(page, there):
        seen.append(page.script(f"return {colour}"))
    check(f"{name}, a projector window outlives the page, which finds it again", seen == ["0,255,0", "0,255,0", "255,0,0"], " ".join(seen))


def until(page, condition):
    end = time.monotonic() + 60
    while not page.run(condition):
        if time.monotonic() > end:
            raise browser.Failure("in vain waited for " + condition)
        time.sleep(0.2)


def main():
    program, data = sys.argv[1:3]
    found = []
    for engine in (Chromium, engines.Firefox, engines.WebKit):
        if engine.found():
            found.append(engine)
        else:
            print(f"skipped: {engine.name} is not installed")
    if not found:
        return 77
    check = Checks()
    with tempfile.TemporaryDirectory() as scratch:
        folder = sys.argv[3] if len(sys.argv) > 3 else scratch
        os.makedirs(folder, exist_ok=True)
        ply, path = os.path.join(scratch, "spot.ply"), os.path.join(scratch, "spot.html")
        subprocess.run([program, "reconstruct", data, "-o", ply, "--polish", "0"], check=True, stdout=subprocess.DEVNULL)
        subprocess.run([program, "view", ply, "--capture", data, "-o", path], check=True, stdout=subprocess.DEVNULL)
        subprocess.run([program, "render", ply, "--capture", data, "-o", scratch, "--view", VIEW, *(f"--pattern={p}" for p in PATTERNS)],
                       check=True, stdout=subprocess.DEVNULL)
        for engine in found:
            page = engine()
            try:
                page.start(path)
                check_engine(check, page, engine.name, scratch)
                if engine is not Chromium:  # test_guard.py has it
                    page.start(path, fresh=False)
                    check_window(check, page, engine.name, path)
                    if shutil.which("ffmpeg"):
                        check_tile(check, page, engine.name)
                with open(os.path.join(folder, engine.name.lower() + ".png"), "wb") as file:
                    file.write(page.picture())
            finally:
                page.close()
    print(f"{check.failed} failed" if check.failed else "all passed")
    return 1 if check.failed else 0


if __name__ == "__main__":
    sys.exit(main())
