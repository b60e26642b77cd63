#!/usr/bin/env python3
"""The page of `ffprocams view` in a headless browser: its pictures against those of `ffprocams render`, every
control by what it changes in the pixels, what it does with broken input.

    test_view.py PROGRAM DATA [FOLDER]     screenshots stay in FOLDER

Exits with 77 and a line where there is no browser."""
import base64
import json
import math
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import time
import zlib

import browser

LEAST, MEAN = 55.0, 60.0  # dB of single pictures and of all; measured: 63 and 65, without shadows 53, without footprints 51


# --- Pictures, standard library only. ---

def png(width, height, pixel, channels=3):
    rows = b"".join(b"\0" + b"".join(bytes(pixel(x, y)) for x in range(width)) for y in range(height))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", width, height, 8, {1: 0, 3: 2, 4: 6}[channels], 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows, 6)) + chunk(b"IEND", b"")


def read_png(path):
    """Width, height and bytes of an 8-bit RGB PNG."""
    data = open(path, "rb").read()
    at, packed, head = 8, b"", None
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + size]
        if kind == b"IHDR":
            head = struct.unpack(">IIBBBBB", body)
        elif kind == b"IDAT":
            packed += body
        at += 12 + size
    width, height, depth, colour = head[:4]
    assert depth == 8 and colour == 2 and head[6] == 0, path
    raw, stride, out = zlib.decompress(packed), 3 * width, bytearray()
    before = bytearray(stride)
    for y in range(height):
        kind, row = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for i in range(stride):
            left, up, corner = (row[i - 3] if i >= 3 else 0), before[i], (before[i - 3] if i >= 3 else 0)
            if kind == 4:
                p = left + up - corner
                a, b, c = abs(p - left), abs(p - up), abs(p - corner)
                row[i] = (row[i] + (left if a <= b and a <= c else up if b <= c else corner)) & 255
            elif kind:
                row[i] = (row[i] + {1: left, 2: up, 3: (left + up) // 2}[kind]) & 255
        out += row
        before = row
    return width, height, bytes(out)


def psnr(a, b, channels_a=3, channels_b=3):
    pixels = len(a) // channels_a
    assert pixels == len(b) // channels_b
    total = sum((x - y) ** 2 for k in range(3) for x, y in zip(a[k::channels_a], b[k::channels_b]))
    return 10 * math.log10(255 ** 2 * 3 * pixels / total) if total else 99.0


def two_colours(kind="webm"):
    """A film that is red for 0.6 s, then blue as long; nothing where ffmpeg is not installed."""
    if not shutil.which("ffmpeg"):
        return b""
    halves = [part for colour in ("red", "blue") for part in ("-f", "lavfi", "-i", f"color={colour}:s=96x64:d=0.6:r=20")]
    return subprocess.run(["ffmpeg", "-loglevel", "error", *halves, "-filter_complex", "concat", "-f", kind, "-"], check=True,
                          stdout=subprocess.PIPE).stdout


# --- The page. ---

class Page(browser.Browser):
    held, side = False, 2 # samples per side of a pixel that rests, as a page has them

    def start(self, path, fresh=True):
        """`fresh`: as it came, whatever the browser kept of it."""
        self.open(path if "://" in path else "file://" + os.path.abspath(path) + ("?fresh" if fresh else ""))
        self.wait("document.readyState === 'complete' && !!window.ready")
        assert self.run("window.ready"), self.run("document.getElementById('failure').textContent")
        self.run("""window.pixels = (width, height, camera) => {
            const bytes = viewer.picture(width, height, camera);
            let text = '';
            for (let i = 0; i < bytes.length; i += 8192) text += String.fromCharCode(...bytes.subarray(i, i + 8192));
            return btoa(text);
        }; window.bytesOf = (canvas) => { const copy = makeCanvas(canvas.width, canvas.height);
            const context = copy.getContext('2d', {willReadFrequently: true}); context.drawImage(canvas, 0, 0);
            return context.getImageData(0, 0, copy.width, copy.height).data;
        }; window.idle = () => new Promise((done) => {
            const look = () => viewer.pending || viewer.stale || viewer.rough || viewer.moving ? setTimeout(look, 20) : done(true);
            look();
        }); true""")
        if fresh:
            assert self.run("viewer.scene.drawing.samples") == Page.side
        self.samples(self.side)

    def samples(self, side):
        """One is enough where no picture is compared with the program's."""
        self.side = side
        self.run(f"viewer.scene.drawing.samples = {side}; viewer.invalidate(); true")

    def hold(self, on):
        """Keeps the window as it is while only pictures are looked at, or lets it go on."""
        self.run("viewer.schedule = () => {}; true" if on else "delete viewer.schedule; viewer.invalidate(); idle()")
        self.held = on

    def settle(self):
        if not self.held:
            self.run("idle()")

    def pixels(self, width=128, height=128, camera="undefined"):
        return base64.b64decode(self.run(f"pixels({width}, {height}, {camera})"))

    def message(self):
        return self.run("document.getElementById('toast').classList.contains('shown') ? "
                        "document.getElementById('toast').textContent : ''")

    def set(self, name, value):
        """A control by its id, as a hand would."""
        self.run(f"""(() => {{ const c = document.getElementById({name!r});
            if (c.type === 'checkbox') c.checked = {str(bool(value)).lower()};
            else c.value = {value!r};
            c.dispatchEvent(new Event('input', {{bubbles: true}})); }})()""")

    def click(self, selector):
        self.run(f"document.querySelector({selector!r}).click()")

    def far(self, script, number=None):
        """The value of an expression in a projector's window, which is a page of its own; the selected projector's."""
        mark = f"#projector-{self.run('viewer.projector.number') if number is None else number}-"
        end = time.monotonic() + 20
        while not self.pages(mark):
            assert time.monotonic() < end, f"no window {mark}"
            time.sleep(0.05)
        target = self.pages(mark)[-1]
        self.sessions = getattr(self, "sessions", {})
        if target not in self.sessions:
            self.sessions[target] = self.attach(target)
        return self.run(script, session=self.sessions[target])

    def drop(self, name, kind, data):
        self.run(f"""(() => {{ document.getElementById('toast').classList.remove('shown');
            const bytes = Uint8Array.from(atob({base64.b64encode(data).decode()!r}), (c) => c.charCodeAt(0));
            const transfer = new DataTransfer();
            transfer.items.add(new File([bytes], {name!r}, {{type: {kind!r}}}));
            window.dispatchEvent(new DragEvent('drop', {{dataTransfer: transfer, bubbles: true, cancelable: true}})); }})()""")


class Checks:
    def __init__(self):
        self.failed, self.began = 0, time.monotonic()

    def __call__(self, what, good, measured=""):
        self.failed += not good
        print(f"{time.monotonic() - self.began:4.0f} s {'ok  ' if good else 'FAIL'} {what}{': ' if measured != '' else ''}{measured}", flush=True)


def change(a, b):
    """Mean difference of two pictures' bytes."""
    return sum(abs(x - y) for x, y in zip(a, b)) / len(a)


def check_pictures(check, page, program, ply, data, folder):
    """The eight input poses and the six new ones under three patterns."""
    patterns = ("all_white", "lollipop_0", "lollipop_3")
    asked = [f"--pattern={pattern}" for pattern in patterns]
    for poses in ([], ["--poses", os.path.join(data, "targets.json")]):
        subprocess.run([program, "render", ply, "--capture", data, "-o", folder, *poses, *asked], check=True,
                       stdout=subprocess.DEVNULL)
    page.hold(True)
    scores = []
    for index in range(page.run("viewer.scene.views.length")):
        name = page.run(f"viewer.jump(viewer.scene.views[{index}], true); viewer.at.id")
        for pattern in patterns:
            page.run(f"""(async () => viewer.setContent(await patternContent(viewer.scene,
                viewer.scene.patterns.findIndex((p) => p.name === {pattern!r}))))()""")
            width, height, wanted = read_png(os.path.join(folder, f"{name}_{pattern}.png"))
            scores.append(psnr(page.pixels(width, height), wanted, 4))
    subprocess.run([program, "render", ply, "--capture", data, "-o", folder, "--size", "480", "--view", name, "--poses", os.path.join(data, "targets.json"),
                    "--pattern=all_white"], check=True, stdout=subprocess.DEVNULL)
    page.run("(async () => viewer.setContent(await patternContent(viewer.scene, viewer.scene.patterns.findIndex((p) => p.name === 'all_white'))))()")
    width, height, wanted = read_png(os.path.join(folder, f"{name}_all_white.png"))
    large = psnr(page.pixels(width, height), wanted, 4)
    page.hold(False)
    check("the outline of a large picture, too", large >= LEAST, f"{large:.2f} dB, smoothed by {page.run('viewer.renderer.view.deviation'):.2f} px")
    check("pictures as ffprocams render draws them", len(scores) == 42 and min(scores) >= LEAST and
          sum(scores) / len(scores) >= MEAN, f"{len(scores)} pictures, mean {sum(scores) / len(scores):.2f} dB, least {min(scores):.2f} dB")


def check_halves(check, page):
    """Drivers without float blending sum in 16 bits: as good as that must be."""
    full = page.pixels()
    page.run("""(() => { const r = viewer.renderer; window.format = r.sumFormat; r.sumFormat = viewer.graphics.gl.RGBA16F;
        r.view = new GbufferView(r); viewer.projector.shadow = null; viewer.projector.shadowKey = ''; })()""")
    half = page.pixels()
    page.run("""(() => { const r = viewer.renderer; r.sumFormat = window.format; r.view = new GbufferView(r);
        viewer.projector.shadow = null; viewer.projector.shadowKey = ''; })()""")
    score = psnr(full, half, 4, 4)
    check("sums in 16 bits", score >= MEAN and score < 99, f"{score:.2f} dB from those in 32")


def check_maps(check, page, program, ply, data, folder):
    subprocess.run([program, "render", ply, "--capture", data, "-o", folder, "--maps", "--view", "path_0_theta000"],
                   check=True, stdout=subprocess.DEVNULL)
    page.run("viewer.jump(viewer.scene.views[0], true)")
    scores = []
    for number, name in ((2, "normal"), (3, "albedo"), (5, "ambient")):
        page.set("map", str(number))
        width, height, wanted = read_png(os.path.join(folder, f"path_0_theta000_{name}.png"))
        scores.append(psnr(page.pixels(width, height), wanted, 4))
    page.set("map", "light")
    check("G-buffers as render --maps draws them", min(scores) >= LEAST, " ".join(f"{s:.1f} dB" for s in scores))


def check_closed_form(check, page, program, ply, data, folder, view, target, how, least):
    file = os.path.join(folder, how + ".png")
    subprocess.run([program, "compensate", ply, "--capture", data, "--view", view, "--target", target, "--steps", "0",
                    "--gaussians-only", "-o", file, *(["--paint"] if how == "paint" else [])], check=True, stdout=subprocess.DEVNULL)
    page.run("viewer.updatePatterns()")
    made, (width, _, wanted) = base64.b64decode(page.run(SENT)), read_png(file)
    lit = page.run("(() => { const part = viewer.graphics.readFloats(viewer.projector.maps.fine.maps, 0), lit = []; "
                   "for (let i = 3; i < part.length; i += 4) if (part[i] === 1) lit.push(i >> 2); return lit; })()")
    both = [i for i in lit if any(wanted[3 * i:3 * i + 3])]
    blocks = {}
    for i in both:
        blocks.setdefault((i // width // 8, i % width // 8), []).append(i)
    mean = lambda data, channels: [sum(data[channels * i + k] for i in block) / 64 for block in blocks.values() if len(block) == 64 for k in range(3)]
    score = psnr(mean(made, 4), mean(wanted, 3))
    check(f"correction, {how}, as compensate's closed form", score >= least and len(both) > 0.8 * len(lit), f"{score:.2f} dB, {len(both)} of {len(lit)} pixels")


def check_compensation(check, page, program, ply, data, folder):
    """The closed form, painted and in colours, against `ffprocams compensate --steps 0`, which has it at the photographs'
    pixels: means over 8 x 8 pixels where both have levels, of a target without edges."""
    target = os.path.join(folder, "sky.png")
    with open(target, "wb") as file:
        file.write(png(128, 128, lambda x, y: (40 + x, 60 + y, 200 - (x + y) // 2)))
    page.run("viewer.jump(viewer.scene.views[2], true)")
    view = page.run("viewer.at.id")
    option = page.run(f"[...document.getElementById('watcher').options].find((o) => o.textContent === viewName(viewer.scene.views.find((v) => v.id === {view!r}))).value")
    page.drop("sky.png", "image/png", open(target, "rb").read())
    page.wait("viewer.projector.content.name === 'sky.png'")
    page.hold(True)
    for how, least in (("paint", 62), ("colours", 26)):
        page.set("correction", how)
        page.set("watcher", option)
        check_closed_form(check, page, program, ply, data, folder, view, target, how, least)
    check_sharpness(check, page, program, ply, data, folder, view)
    page.hold(False)
    check_holes(check, page)
    page.set("correction", "none")
    page.run("idle()")


def check_sharing(check, page):
    """Two projectors from both sides, painted white, whose dark is a fiftieth of their white: linear light of each alone and
    of both; then in black."""
    page.hold(True)
    white, black, most = page.run("""(() => { const N = 128, {views, centre} = viewer.scene, camera = fitDevice(views[0].camera, N, N), DARK = 0.02;
        viewer.jump(views[0], true), viewer.setContent(new TestContent('White')), viewer.addProjector();
        viewer.projectors.forEach((p, k) => { p.device = {...p.device, pose: orbit(views[0].projector.pose, centre, viewer.up, 1.1 * (2 * k - 1), 0)}; });
        const light = (list) => { viewer.updatePatterns(); viewer.renderer.drawLight(camera, 2, list, false); return viewer.graphics.readFloats(viewer.renderer.light); };
        viewer.setContent(new TestContent('White'));
        const alone = viewer.projectors.map((p) => light([p])), solid = viewer.graphics.readFloats(viewer.renderer.view.mean());
        viewer.renderer.black = viewer.black = DARK;
        Object.assign(viewer.projector, {correction: 'paint', watcher: 0});
        showEverywhere(viewer);
        const compare = (share) => { const both = light(viewer.projectors), counts = [0, 0, 0, 0, 0, 0];
            const reached = (i) => alone.reduce((bits, a, k) => bits | (a[4 * i] > 0.003) << k, 0) * (solid[4 * i + 3] > 0.99);
            for (let y = 2; y < N - 2; y++) for (let x = 2; x < N - 2; x++) {
                const i = N * y + x, r = reached(i), around = (j) => reached(i + (j % 5) - 2 + N * (Math.floor(j / 5) - 2)) === r;
                if (!r || !Array.from({length: 25}, (_, j) => around(j)).every(Boolean)) continue;
                const seen = both[4 * i], each = alone.map((a) => share * a[4 * i]).filter((_, k) => r >> k & 1), n = each.length - 1;
                counts[2 * n]++, counts[2 * n + 1] += seen > 1.03 * Math.max(...each) || seen < 0.97 * Math.min(...each); }
            return counts.slice(0, 4); };
        const white = compare(1);
        for (const p of viewer.projectors) viewer.setContent(new SolidContent('#000000'), p);
        const black = compare(2 * DARK), {most} = viewer.projector;
        Object.assign(viewer, {black: 0}), viewer.renderer.black = 0;
        viewer.removeProjector(), viewer.projector.correction = 'none', viewer.setContent(new TestContent('White'));
        return [white, black, most]; })()""")
    page.hold(False)
    for name, (one, off_one, both, off_both) in (("white", white), ("black", black)):
        check(f"two projectors, {name}: as bright where they overlap as beside", one > 200 and both > 1000 and off_one < 0.05 * one and off_both < 0.05 * both,
              f"of one {off_one} of {one} places off by 3 %, of both {off_both} of {both}; {most} overlap")


SENT = """(() => { const {data} = panelPicture(viewer.graphics, viewer.projector, null, window.kept = window.kept || {});
    let text = '';
    for (let i = 0; i < data.length; i += 8192) text += String.fromCharCode(...data.subarray(i, i + 8192));
    return btoa(text); })()"""


def check_sharpness(check, page, program, ply, data, folder, view):
    """Bars much finer than the photographs: what is seen under the page's pattern and under compensate's, drawn at four
    times the photographs' size, against what was asked for."""
    size, at = 512, lambda name: os.path.join(folder, name)
    asked = png(size, size, lambda x, y: (255, 255, 255) if x // 9 % 2 and y // 26 % 2 else (0, 0, 0))
    for name, content in (("bars.png", asked), ("dark.png", png(8, 8, lambda x, y: (0, 0, 0))), ("light.png", png(8, 8, lambda x, y: (255, 255, 255)))):
        with open(at(name), "wb") as file:
            file.write(content)
    page.drop("bars.png", "image/png", asked)
    page.wait("viewer.projector.content.name === 'bars.png'")
    page.set("correction", "paint")
    page.run("viewer.updatePatterns()")
    sent, (width, height) = base64.b64decode(page.run(SENT)), page.run("[viewer.projector.device.width, viewer.projector.device.height]")
    with open(at("here.png"), "wb") as file:
        file.write(png(width, height, lambda x, y: sent[4 * (width * y + x):4 * (width * y + x) + 3]))
    subprocess.run([program, "compensate", ply, "--capture", data, "--view", view, "--target", at("bars.png"), "--paint", "-o", at("there.png")],
                   check=True, stdout=subprocess.DEVNULL)
    seen = {}
    for name in ("dark", "light", "here", "there"):
        subprocess.run([program, "render", ply, "--capture", data, "--view", view, "--pattern", at(name + ".png"), "--size", str(size),
                        "-o", at("seen")], check=True, stdout=subprocess.DEVNULL)
        seen[name] = read_png(os.path.join(folder, "seen", f"{view}_{name}.png"))[2]
    wanted = read_png(at("bars.png"))[2]
    lit = [i for i in range(0, len(wanted), 3) if max(seen["light"][i + k] - seen["dark"][i + k] for k in range(3)) > 25]
    ends = bytes(seen["light" if wanted[i] else "dark"][i + k] for i in lit for k in range(3))
    scores = {name: psnr(bytes(seen[name][i + k] for i in lit for k in range(3)), ends) for name in ("here", "there")}
    check("bars finer than the photographs are at least as sharp as compensate's", scores["here"] > scores["there"] and len(lit) > 10000,
          f"{scores['here']:.2f} dB, compensate {scores['there']:.2f}, {len(lit)} pixels")


def check_holes(check, page):
    """Pixels that the camera does not see take their neighbours' levels; while things move, coarse maps stand in."""
    page.run("viewer.setContent(new TestContent('White')); "
             "viewer.setProjectorPose(orbit(viewer.projector.device.pose, viewer.scene.centre, viewer.up, 0.6, 0)); viewer.updatePatterns(); true")
    hidden, dark, beyond = page.run("""(() => { const {maps} = viewer.projector.maps.fine;
        const w = maps.width, h = maps.height, part = viewer.graphics.readFloats(maps, 0), {data} = panelPicture(viewer.graphics, viewer.projector, null, window.kept);
        let hidden = 0, dark = 0, beyond = 0;
        for (let y = 1; y < h - 1; y++) for (let x = 1; x < w - 1; x++) {
            const i = w * y + x, beside = [i - 1, i + 1, i - w, i + w].some((j) => part[4 * j + 3] === 1);
            if (part[4 * i + 3] === 0.5 && beside) hidden++, dark += data[4 * i] < 250;
            if (part[4 * i + 3] === 0) beyond += data[4 * i] > 250; }
        return [hidden, dark, beyond]; })()""")
    check("holes and the rim take their neighbours' levels", hidden > 100 and not dark and beyond > 500, f"{hidden} hidden beside lit ones, {dark} dark; {beyond} beyond the outline")
    page.hold(True)
    coarse = page.run("viewer.setCamera(orbit(viewer.pose, viewer.target, viewer.up, 0.1, 0)), viewer.projector.watcher = 'now', viewer.draw(QUALITIES[0], true), viewer.projector.coarse")
    page.hold(False)
    check("corrections are coarse while things move, fine when they rest", coarse and not page.run("viewer.projector.coarse"), f"{coarse}")
    page.run("viewer.jump(viewer.scene.views[2], true); idle()")


def check_same_ids(check, page, path, folder):
    """Poses of a file may have the ids of captured views, and the words of the page: each is its own."""
    twins = os.path.join(folder, "twins.html")
    text = open(path, encoding="utf-8").read()
    for number, name in ((0, "path_0_theta000"), (1, "now")):
        assert f'"id":"novel_0{number}"' in text
        text = text.replace(f'"id":"novel_0{number}"', f'"id":"{name}"')
    with open(twins, "w", encoding="utf-8") as file:
        file.write(text)
    page.start(twins)
    first = page.run("viewer.scene.views.findIndex((v) => v.new)")
    page.set("correction", "paint")
    wrong = []

    def watch(entry):  # in one go: the page shows its own choice again when anything changes
        page.run(f"(() => {{ const w = document.getElementById('watcher'); w.selectedIndex = {entry}; w.dispatchEvent(new Event('input')); }})()")

    for index in range(page.run("viewer.scene.views.length")):
        watch(index + 1)
        if not page.run(f"viewer.watcherOf(viewer.projector) === viewer.scene.views[{index}].camera"):
            wrong.append(index)
    watch(0)
    if page.run("viewer.scene.views.some((v) => viewer.watcherOf(viewer.projector) === v.camera)"):
        wrong.append("where I look from")
    check("a correction is for the camera that was chosen", not wrong, f"not for views {wrong}" if wrong else "")
    page.set("correction", "none")
    chosen = page.run(f"""(() => {{ viewer.jump(viewer.scene.views[{first}], true);
        return [...document.getElementById('views').children].map((t, i) => t.classList.contains('chosen') ? i : -1).filter((i) => i >= 0); }})()""")
    check("one view is shown as chosen", chosen == [first], f"{chosen}")


def check_controls(check, page):
    """Each control changes the picture as it should."""
    page.run("viewer.jump(viewer.scene.views[0], true)")
    page.run("viewer.setContent(new TestContent('White'))")
    page.hold(True)
    base = page.pixels()
    bright = sum(base)

    def changes(what, do, undo, least=0.3):
        do()
        page.settle()
        moved = change(base, page.pixels())
        undo()
        page.settle()
        back = change(base, page.pixels())
        check(what, moved >= least and back < 0.1, f"{moved:.2f} of 255 on average, and back to {back:.2f}")

    middle = (260, 200)
    home = lambda: page.run("viewer.jump(viewer.scene.views[0], true)")
    changes("dragging turns the object", lambda: page.drag(middle, (340, 215)), home)
    changes("dragging with the right button shifts it", lambda: page.drag(middle, (290, 225), "right"), home)
    changes("the wheel goes nearer", lambda: page.call("Input.dispatchMouseEvent", {
        "type": "mouseWheel", "x": 260, "y": 200, "deltaX": 0, "deltaY": -300}), home)
    changes("arrow keys turn", lambda: page.key("ArrowLeft"), home)
    changes("a number jumps to a view", lambda: page.key("4"), lambda: page.key("1"))
    page.key("p")
    changes("P: dragging moves the projector", lambda: page.drag(middle, (360, 200)), home)
    page.key("c")
    handle = page.run("handleOf(viewer, viewer.projector).at")
    changes("the handle moves it in any mode", lambda: page.drag(handle, (handle[0] + 90, handle[1] + 60)), home)
    changes("Lens", lambda: page.set("lens", "20"), home)
    changes("Distance", lambda: page.set("distance", "4"), home)
    page.run("viewer.setContent(new TestContent('Checker'))")
    checker = page.pixels()
    check("test pattern", change(base, checker) > 1, f"{change(base, checker):.2f}")
    page.key("p")
    page.drag(middle, (360, 200), modifiers=8)
    check("P: dragging with Shift aims it", change(checker, page.pixels()) > 0.5, f"{change(checker, page.pixels()):.2f}")
    page.key("c")
    home()
    page.set("roll", "30")
    check("Roll", change(checker, page.pixels()) > 0.5, f"{change(checker, page.pixels()):.2f}")
    home()
    page.run("viewer.setContent(new TestContent('White'))")
    changes("Brightness", lambda: page.set("brightness", "-2"), lambda: page.set("brightness", "0"))
    changes("Exposure", lambda: page.set("exposure", "1"), lambda: page.set("exposure", "0"))
    changes("Ambient light", lambda: page.set("ambient", False), lambda: page.set("ambient", True), 0.02)
    changes("Lit", lambda: page.set("on", False), lambda: page.set("on", True))
    changes("a colour", lambda: page.set("solid", "#3060ff"), lambda: page.run("viewer.setContent(new TestContent('White'))"))
    changes("a text", lambda: page.set("text", "Hello"), lambda: page.run("viewer.setContent(new TestContent('White'))"))
    page.key("n")
    page.run("viewer.setContent(new SolidContent('#ff2020'))")
    two = page.pixels()
    check("a second projector adds its light", page.run("viewer.projectors.length") == 2 and sum(two) > bright * 1.02 and
          change(base, two) > 0.3, f"{sum(two) / bright:.2f} times as bright")
    page.click("#remove")
    page.settle()
    check("and is removed", change(base, page.pixels()) < 0.1)
    page.hold(False) # the brush looks at what is drawn
    page.key("b")
    page.set("brush-colour", "#0040ff")
    page.drag((240, 200), (290, 215))
    page.settle()
    painted = page.pixels()
    check("the brush paints", change(base, painted) > 0.05, f"{change(base, painted):.2f}")
    page.click("#clear")
    page.settle()
    check("and its paint is cleared", change(base, page.pixels()) < 0.1)
    page.key("c")
    page.key("b")
    page.drag((240, 200), (290, 215))
    page.set("erase", True)
    page.set("brush-size", "60")
    page.drag((230, 200), (300, 215))
    page.set("erase", False)
    page.settle()
    check("the eraser takes it away", change(base, page.pixels()) < change(base, painted) / 4, f"{change(base, page.pixels()):.3f} left")
    page.click("#clear")
    page.key("c")

    def pinch():
        for kind, gap in (("touchStart", 40), ("touchMove", 60), ("touchMove", 90), ("touchEnd", 0)):
            points = [{"x": 260 - gap, "y": 200, "id": 1}, {"x": 260 + gap, "y": 200, "id": 2}] if gap else []
            page.call("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    changes("two fingers go nearer", pinch, home)
    overlay = "(() => { const c = viewer.overlay, d = bytesOf(c); let n = 0; for (let i = 3; i < d.length; i += 4) n += d[i] > 0; return n; })()"
    shown = page.run(overlay)
    page.key("x")
    page.settle()  # drawn with the next frame
    check("X hides the frusta", shown > 500 and page.run(overlay) == 0, f"{shown} pixels of them")
    page.key("x")
    page.run("viewer.setProjectorPose(turnPose(viewer.projector.device.pose, axisOf(viewer.projector.device.pose, 0), 0.3, positionOf(viewer.projector.device.pose)))")
    page.click("#aim")
    middle_of = page.run("project(viewer.projector.device, viewer.scene.centre)")
    check("Aim looks at the object", abs(middle_of[0] - 400) < 1 and abs(middle_of[1] - 400) < 1)
    home()
    page.key("?")
    opened = page.run("document.getElementById('keys').open")
    page.run("document.getElementById('keys').close()")
    check("? shows the keys", opened)
    panel = page.run("document.body.classList.contains('with-panel')")
    page.key("h")
    check("H shows and hides the panel", page.run("document.body.classList.contains('with-panel')") != panel)
    page.key("h")
    page.key("f")
    page.wait("!!document.fullscreenElement")
    page.key("f")
    page.wait("!document.fullscreenElement")
    check("F is full screen and back", True)
    shots = page.run("viewer.saved || 0")
    page.key("s")
    page.wait(f"(viewer.saved || 0) > {shots}")
    check("S saves the picture", True)


def check_photograph(check, page, folder):
    page.run("viewer.jump(viewer.scene.views[1], true)")
    page.key("v")
    page.wait("!!viewer.photograph")
    page.run("idle()")
    page.screenshot(os.path.join(folder, "photograph.png"))
    off = page.run(OFF_PHOTOGRAPH)
    check("the photograph lies where the prediction does", off < 0.1, f"{off:.3f} pixels off at most")
    page.drag((200, 200), (240, 200))
    check("and goes when the view does", page.run("!viewer.photograph"))


# Where the photograph and the camera that was drawn with show the same places, on the screen.
OFF_PHOTOGRAPH = """(() => { const box = document.getElementById('photograph').getBoundingClientRect(), {base, scene} = viewer;
    const drawn = viewer.drawn.camera, ratio = drawn.width / innerWidth;
    let most = 0;
    for (const by of [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, -1, -1]]) {
        const point = add3(scene.centre, scale3(by, 0.4 * scene.radius)), a = project(base, point), b = project(drawn, point);
        most = Math.max(most, Math.abs(box.left + a[0] * box.width / base.width - b[0] / ratio), Math.abs(box.top + a[1] * box.height / base.height - b[1] / ratio));
    }
    return most; })()"""


def check_comparison(check, page):
    """Photograph and prediction are of the same light, whatever was set and whoever is chosen."""
    page.run("viewer.jump(viewer.scene.views[1], true); viewer.setContent(new TestContent('White'))")
    page.run("viewer.projector.dab(400, 400, 400, '#2030ff'); true")
    for name, value in (("exposure", "1.5"), ("brightness", "-2"), ("ambient", False), ("correction", "paint"), ("map", "2")):
        page.set(name, value)
    page.key("v")
    page.wait("!!viewer.photograph")
    page.run("idle()")
    photograph = base64.b64decode(page.run("(() => { let t = ''; for (const b of bytesOf(document.getElementById('photograph'))) "
                                           "t += String.fromCharCode(b); return btoa(t); })()"))
    lit = page.pixels()
    score = psnr(photograph, lit, 4, 4)
    check("beside its photograph the prediction has the photograph's light", score > 20, f"{score:.1f} dB")
    page.run("viewer.addProjector(); viewer.select(viewer.projectors[1])")
    page.settle()
    check("whichever projector is chosen", page.run("!!viewer.photograph") and change(lit, page.pixels()) < 0.1)
    page.run("viewer.showPhotograph(false)")
    page.click("#remove")
    kept = page.run("(() => { const p = viewer.projectors[0]; return [viewer.exposure, viewer.ambient, viewer.map, p.stops, p.correction, p.painted]; })()")
    check("afterwards the settings are back", kept == [1.5, False, 2, -2, "paint", True], f"{kept}")
    for name, value in (("exposure", "0"), ("brightness", "0"), ("ambient", True), ("correction", "none"), ("map", "light")):
        page.set(name, value)
    page.click("#clear")


def check_kept(check, page, path, folder):
    """A person's work stays: tiles, undo, a file, the browser's store, the exported picture."""
    page.start(path)
    sun = png(24, 16, lambda x, y: (255, 10 * y, 9 * x))
    tiles = page.run("document.getElementById('contents').children.length")
    whites = page.run("[...document.getElementById('contents').children].filter((t) => /white/i.test(t.title)).length")
    check("one white tile", whites == 1, f"{whites}")
    check("opens on something other than structured light", page.run("viewer.projector.content.name") == "Sunset")
    page.drop("kept.png", "image/png", sun)
    page.wait("viewer.projector.content.name === 'kept.png'")
    page.run("viewer.setContent(new TestContent('Grid')); true")
    page.click("#contents .tile:last-child")
    page.wait("viewer.projector.content.name === 'kept.png'")
    check("a dropped picture has a tile and can be shown again", page.run("document.getElementById('contents').children.length") == tiles + 1)
    page.run("idle().then(() => viewer.history.note())")
    before = page.pixels()
    page.run("viewer.projector.dab(400, 400, 200, '#20ff30'); viewer.history.note()")
    painted = page.pixels()
    page.set("brightness", "-3")
    page.run("viewer.history.note()")
    page.run("viewer.history.go(-1)")
    one = change(painted, page.pixels())
    page.run("viewer.history.go(-1)")
    two = change(before, page.pixels())
    page.run("viewer.history.go(1)")
    again = change(painted, page.pixels())
    check("undo takes a setting and paint back, redo brings it again", change(before, painted) > 0.5 and one < 0.1 and two < 0.1 and again < 0.1,
          f"{one:.2f} {two:.2f} {again:.2f}")
    page.run("viewer.show.add()")
    text = page.run("stageText(viewer)")
    page.run("viewer.addProjector(); viewer.setContent(new SolidContent('#ff0000')); viewer.show.remove(0); true")
    page.drop("show.stage.json", "application/json", text.encode())
    page.wait("viewer.projectors.length === 1 && viewer.show.cues.length === 1")
    check("a stage is loaded from its file", change(painted, page.pixels()) < 0.1)
    bad = json.loads(text)
    bad["projectors"][0]["stops"] = "bright"
    for name, data, told in (("bad.json", json.dumps(bad), "projectors: stops"), ("other.json", "{}", "not a stage"), ("no.json", "{", "not a stage")):
        page.drop(name, "application/json", data.encode())
        page.wait(f"document.getElementById('toast').textContent.includes({told!r})")
    check("other files are refused, and nothing changes", change(painted, page.pixels()) < 0.1)
    exports = page.run("viewer.exports || 0")
    page.click("#export")
    page.wait(f"(viewer.exports || 0) > {exports}")
    check("the projector's picture is exported", True)
    page.run("viewer.show.arm(true), viewer.reloads = true, viewer.store.keep()")
    page.start(path, fresh=False)
    page.wait("viewer.projector.content.name === 'kept.png'")
    check("the browser keeps the stage", change(painted, page.pixels()) < 0.1 and page.run("viewer.show.cues.length") == 1)
    page.wait("viewer.windows.settled && document.getElementById('toast').textContent.startsWith('As you left it: armed')")
    told = page.run("document.getElementById('toast').textContent")
    check("an armed page says whether its windows are back", told == "As you left it: armed. No projector window is open.", told)
    page.run("viewer.store.forget()")


def check_undo(check, page):
    """One gesture is one step, however long it rests and however soon the next one follows."""
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "test_place.js"), encoding="utf-8") as file:
        failures = page.run(file.read() + "; testsOfPlace()")
    check("the page's logic by itself", not failures, "; ".join(failures))
    page.run("viewer.jump(viewer.scene.views[0], true); viewer.setContent(new TestContent('White')); idle().then(() => viewer.history.note())")
    steps = page.run("viewer.history.at")
    page.key("b")
    middle = (250, 200)
    page.mouse("mousePressed", *middle)
    for x in (260, 270):
        page.mouse("mouseMoved", x, 205)
        time.sleep(0.5)
    page.mouse("mouseReleased", 270, 205, "left", 0)
    stroke = page.run("new Promise((done) => setTimeout(() => done([viewer.history.at, viewer.projector.content.name, viewer.projector.painted])))")
    page.click("#contents .tile[data-content=Grid]")
    page.drag((240, 190), (280, 190), steps=2)
    page.key("c")
    page.wait(f"viewer.history.at >= {steps + 3}")
    time.sleep(0.5)  # nor does another step come afterwards
    both = page.run("viewer.history.at")
    check("a stroke that rests is one step, a tile and a stroke are two", stroke == [steps + 1, "White", True] and both == steps + 3, f"{stroke}, {both - steps} steps")
    page.run("viewer.history.go(-2)")
    back = page.run("[viewer.projector.content.name, viewer.projector.painted]")
    page.run("viewer.history.go(-1)")
    check("undo takes them in order", back == ["White", True] and not page.run("viewer.projector.painted"), f"{back}")


# The picture sent to the projector: the mean of a part of it, in shares of its sides.
PART = """((left, top, right, bottom) => { viewer.updatePatterns();
    const {width, height, data} = panelPicture(viewer.graphics, viewer.projector, null, window.kept = window.kept || {}), sum = [0, 0, 0];
    let n = 0;
    for (let y = Math.round(top * height); y < Math.round(bottom * height); y++)
        for (let x = Math.round(left * width); x < Math.round(right * width); x++, n++) for (let k = 0; k < 3; k++) sum[k] += data[4 * (y * width + x) + k];
    return sum.map((value) => Math.round(value / n)); })"""


def check_uncut(check, page):
    """A soft crop on the left leaves the other sides, and the corners between them, as they are."""
    shares = page.run("""(() => {
        const context = makeCanvas(100, 80).getContext('2d', {willReadFrequently: true});
        paintCut(context, {source: new SolidContent('#ffffff'), place: {...newPlace(), crop: [0.2, 0, 0, 0], feather: 0.2}}, 100, 80);
        return [[5, 40], [20, 40], [99, 0], [99, 40], [99, 79], [60, 0], [20, 79]].map(([x, y]) => context.getImageData(x, y, 1, 1).data[3]);
    })()""")
    check("sides that are not cut are not soft", shares[0] < 5 and abs(shares[1] - 128) < 30 and min(shares[2:6]) > 250 and abs(shares[6] - shares[1]) < 5, f"{shares}")


def check_place(check, page):
    """Layers are placed by their handles and by numbers, and the projector's picture has them there."""
    page.resize(1280, 800)
    page.run("viewer.jump(viewer.scene.views[0], true); viewer.setContent(new SolidContent('#0000ff')); document.body.classList.add('with-panel'); idle()")
    page.click("[data-mode=place]")
    behind = page.run("""(() => { viewer.placed({...newPlace(), opacity: 0}, false);
        const data = bytesOf(viewer.flat.canvas), {width, height} = viewer.flat.box(), ratio = devicePixelRatio ** 2;
        viewer.placed(newPlace(), false);
        let bright = 0;
        for (let i = 0; i < data.length; i += 4) bright += data[i] + data[i + 1] + data[i + 2] > 120;
        return bright / (width * height * ratio); })()""")
    check("the object is behind the layers", 0.1 < behind < 0.9, f"{behind:.2f} of the picture")
    page.run("idle()")
    page.hold(True)
    page.click("#add-layer")
    page.set("text", "\u2588\u2588\u2588\u2588")  # blocks, whose pixels are known
    page.run("document.getElementById('text').dispatchEvent(new Event('change', {bubbles: true})); document.activeElement.blur(); true")
    mean = lambda *part: page.run(f"{PART}({', '.join(map(str, part))})")
    screen = lambda at: [at[i] + page.run("(() => { const {left, top} = viewer.flat.box(); return [left, top]; })()")[i] for i in (0, 1)]
    grip = lambda name: screen(page.run(f"viewer.flat.handles().find((h) => h.name === {name!r}).at"))
    size, middle = page.run("[viewer.flat.box().width, viewer.flat.box().height]"), (0.45, 0.48, 0.55, 0.52)
    left, aside = mean(0, 0.48, 0.03, 0.52), mean(0.2, 0.49, 0.22, 0.51)
    check("a text lies over what is below it", mean(*middle) == [255, 255, 255] and aside == [255, 255, 255] and left == mean(0, 0, 1, 0.2) == [0, 0, 255], f"{mean(*middle)} {aside} {left}")
    steps = page.run("viewer.history.at")
    start = grip(0)
    page.drag(start, [start[0] + size[0] / 2, grip(2)[1] - (grip(2)[1] - start[1]) / 2])
    page.settle()
    scaled = page.run("viewer.projector.layer.place")
    small = [mean(0.2, 0.49, 0.22, 0.51), mean(0.7, 0.54, 0.8, 0.56)]
    check("a handle scales it", abs(scaled["width"] - 0.5) < 0.03 and small == [[0, 0, 255], [255, 255, 255]], f"{scaled['width']:.2f}, {small}")
    at = screen([0.75 * size[0], 0.55 * size[1]])
    page.drag(at, [at[0] - size[0] / 4, at[1] - size[1] / 4])
    page.settle()
    check("a drag moves it", mean(0.48, 0.29, 0.52, 0.31) == [255, 255, 255] and mean(0.7, 0.54, 0.8, 0.56) == [0, 0, 255], f"{page.run('viewer.projector.layer.place')}")
    page.click("[data-what=corners]")
    corner = grip(1)
    page.drag(corner, [corner[0], corner[1] - size[1] / 5])
    page.settle()
    check("a pulled corner takes the picture along, in perspective", mean(0.68, 0.2, 0.7, 0.22) == [255, 255, 255] and mean(0.3, 0.2, 0.32, 0.22) == [0, 0, 255],
          f"{mean(0.68, 0.2, 0.7, 0.22)} {mean(0.3, 0.2, 0.32, 0.22)}")
    count = page.run("viewer.history.at") - steps
    for _ in range(3):
        page.key("z", "KeyZ", modifiers=2)
        page.wait("!viewer.history.busy")
    place = page.run("JSON.stringify(viewer.projector.layer.place) === JSON.stringify(newPlace())")
    check("three gestures are three steps back", count == 3 and place and aside == mean(0.2, 0.49, 0.22, 0.51), f"{count} steps")
    page.click("[data-what=crop]")
    edge = grip(7)
    page.drag(edge, [edge[0] + size[0] / 2, edge[1]])
    page.settle()
    crop = [mean(0.3, 0.49, 0.4, 0.51), mean(0.6, 0.49, 0.7, 0.51)]
    page.click("#reset-place")
    page.click("[data-what=mask]")
    for point in ((0.5, 0.3), (0.9, 0.3), (0.9, 0.7), (0.5, 0.7)):
        x, y = screen([point[0] * size[0], point[1] * size[1]])
        page.mouse("mousePressed", x, y)
        page.mouse("mouseReleased", x, y, "left", 0)
    page.settle()
    mask = [mean(0.3, 0.49, 0.4, 0.51), mean(0.6, 0.49, 0.7, 0.51)]
    check("crop and mask take away what they should", crop == mask == [[0, 0, 255], [255, 255, 255]], f"{crop} {mask}")
    page.run("(() => { const input = document.querySelector('#numbers [aria-label^=\"Soft edge\"]'); input.value = 40; input.dispatchEvent(new Event('input', {bubbles: true})); })()")
    soft = [mean(at, 0.49, at + 0.01, 0.51)[0] for at in (0.35, 0.47, 0.495, 0.52, 0.65)]
    check("the edge of a mask is soft", soft[0] < 5 and 20 < soft[1] < soft[2] < soft[3] < 235 and abs(soft[2] - 128) < 20 and soft[4] > 250, f"{soft}")
    check_uncut(check, page)
    page.click("#reset-place")
    page.click("#fit-object")
    part = page.run("(() => { const {width, height} = viewer.projector.device, corners = cornersOf(viewer.projector.layer.frame(width, height)); return [0, 2].flatMap((k) => [corners[k][0] / width, corners[k][1] / height]); })()")
    seen = page.run("partOf(viewer.scene.splats, viewer.projector.device)")
    check("a layer is as large as the object", all(part[k] > seen[k] - 0.01 and part[k + 2] < seen[k + 2] + 0.01 for k in (0, 1)) and 0.15 < part[2] - part[0] < 0.9, f"{part} in {seen}")
    page.click("[data-what=size]")
    page.click("#reset-place")
    page.run("(() => { const input = document.querySelector('#numbers [aria-label=Turn]'); input.value = 90; input.dispatchEvent(new Event('input', {bubbles: true})); })()")
    turned = [mean(0.2, 0.49, 0.22, 0.51), mean(0.49, 0.2, 0.51, 0.22)]
    page.run("(() => { const input = document.querySelector('#numbers [aria-label=Opacity]'); input.value = 50; input.dispatchEvent(new Event('input', {bubbles: true})); })()")
    check("numbers place it, too", turned == [[0, 0, 255], [255, 255, 255]] and abs(mean(0.49, 0.2, 0.51, 0.22)[0] - 128) < 3, f"{turned} {mean(0.49, 0.2, 0.51, 0.22)}")
    page.resize(520, 400)
    page.hold(False)
    page.set("correction", "paint")
    page.run("viewer.show.add(); viewer.setLayers([new Layer(new SolidContent('#ff0000'))]); true")
    page.set("correction", "none")
    page.run("viewer.show.add(); viewer.show.cues.forEach((cue) => { cue.fade = 0; }); viewer.show.at = -1; viewer.show.arm(true); document.getElementById('go').focus(); true")
    page.key(" ", "Space", windowsVirtualKeyCode=32)
    page.wait("viewer.show.at === 0")
    first = page.run("[viewer.projector.layers.length, viewer.projector.layer.place.turn, viewer.projector.correction, viewer.history.at === viewer.history.states.length - 1]")
    page.set("correction", "none")
    shown = mean(0.49, 0.2, 0.51, 0.22)
    page.key("Enter", "Enter", windowsVirtualKeyCode=13)
    page.wait("viewer.show.at === 1")
    check("GO brings layers, places and correction of the next cue", first == [2, 0, "paint", True] and abs(shown[0] - 128) < 3 and mean(0, 0, 1, 1) == [255, 0, 0], f"{first} {shown} {mean(0, 0, 1, 1)}")
    page.run("viewer.window.open()")
    page.run("viewer.show.cues[0].follow = 0.1, viewer.show.cues[1].follow = null, true")
    page.far("dispatchEvent(new KeyboardEvent('keydown', {key: ' '}))")
    page.wait("viewer.show.at === 0")
    page.wait("viewer.show.at === 1")
    check("GO in the projector window, and a cue that follows", not page.run("viewer.show.playing"))
    page.run("viewer.window.close(), viewer.show.go(0)")
    page.wait("viewer.show.at === 1")
    page.run("viewer.show.go(0).then(() => viewer.show.stop())")
    same, refused = page.run("""(async () => { const text = JSON.stringify(plainState(stateOf(viewer))), plain = JSON.parse(text);
        viewer.show.cues = []; viewer.setLayers([new Layer(new TestContent('White'))]);
        await applyState(viewer, await checkState(viewer, JSON.parse(text)), true);
        const again = JSON.stringify(plainState(stateOf(viewer))), at = [...text].findIndex((c, i) => c !== again[i]), same = at < 0 || [text.slice(at - 40, at + 40), again.slice(at - 40, at + 40)], refused = [];
        for (const spoil of [(layer) => { layer.place.pull[0] = [0.9, 0.9]; }, (layer) => { layer.place.turn = 'round'; }, (layer) => { layer.fit = 'any'; }]) {
            const bad = structuredClone(plain); spoil(bad.projectors[0].layers[1]);
            refused.push(await checkState(viewer, bad).then(() => '', (error) => error.message)); }
        return [same, refused]; })()""")
    check("a stage keeps layers, places and cues", same is True and page.run("viewer.projector.layers.length") == 2, f"{same}")
    check("broken layers are refused by name", ["pull" in refused[0], "turn" in refused[1], "fit" in refused[2]] == [True] * 3, f"{refused}")
    page.run("viewer.show.arm(false); viewer.show.cues = []; viewer.changed('cues'); setMode(viewer, 'camera'); viewer.setLayers([new Layer(new TestContent('White'))]); true")
    page.set("correction", "none")


# Of a projector's own pixels, beside what they lie on: [share of those of `inside` that are lit, and of those of `outside`].
LIT_ON = """(inside, outside) => { viewer.projector.dirty = true; viewer.updatePatterns();
    const f = viewer.choosing.field, data = bytesOf(viewer.projector.canvas), counts = [0, 0, 0, 0], at = (of, i) => [of[4 * i], of[4 * i + 1], of[4 * i + 2]];
    for (let i = 0; i < f.width * f.height; i++) {
        const pixel = {lit: Math.max(data[4 * i], data[4 * i + 1], data[4 * i + 2]) / 255, solid: isSolid(f, i), i, place: at(f.place, i), normal: at(f.normal, i), albedo: at(f.albedo, i)};
        [inside, outside].forEach((is, k) => { if (is(pixel)) counts[2 * k] += pixel.lit > 0.5, counts[2 * k + 1]++; });
    }
    return [counts[0] / counts[1], counts[2] / counts[3]].map((x) => Math.round(1000 * x) / 1000); }"""

# Of each effect at a size of a half: what its formula says of a pixel {place, normal}, in a `round` of which a share is over.
EFFECT_SAYS = """({
    scan: (p, round) => { const [low, high] = viewer.relief.heights, h = (dot3(p.place, viewer.up) - low) / (high - low), w = 0.1275; return Math.abs(h - (round * (1 + 2 * w) - w)) / w < 0.5; },
    sweep: (p, round, eye, [near, far]) => { const behind = round * 1.415 - (length3(sub3(p.place, eye)) - near) / (far - near); return behind > 0.005 && behind < 0.2075; },
    pulse: (p, round) => { const soft = 0.415, reach = round * (1 + soft); return length3(p.place) < reach - soft / 2; },
    lamp: (p, round) => { const a = 2 * Math.PI * round, e = 30 * Math.PI / 180, {up} = viewer, right = normalise3(cross3(up, Math.abs(up[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0])), ahead = cross3(up, right);
        const at = scale3(add3(scale3(add3(scale3(right, Math.cos(a)), scale3(ahead, Math.sin(a))), Math.cos(e)), scale3(up, Math.sin(e))), 2.5);
        return dot3(p.normal, normalise3(sub3(at, p.place))) > 0.5; },
})"""


def check_fitting(check, page):
    """A text or a picture that is first put on a surface's layer lies where *Fit* would put it; the layer's row names the surface."""
    page.run("viewer.choosing.select(1), [...document.querySelectorAll('#surfaces button')].find((b) => b.textContent === '+ layer').click(); true")
    place, whole = "JSON.stringify(viewer.projector.layer.place)", page.run("JSON.stringify(newPlace())")
    seen = [page.run(place) == whole]  # a colour fills the surface
    page.set("text", "Tonight")
    for name in ("text", "picture"):
        if name == "picture":
            page.run("viewer.projector.at = 2, viewer.setContent(new SolidContent('#00ff00')); true")
            seen.append(page.run(place) == whole)
            page.drop("wide.png", "image/png", png(64, 16, lambda x, y: (0, 255, 255)))
            page.wait("viewer.projector.content.name === 'wide.png'")
        first = page.run(place)
        page.click("#fit-object")
        seen.append(first == page.run(place) != whole)
    rows = "[...document.querySelectorAll('#layers .name')].map((row) => row.textContent)"
    named = page.run(rows)
    page.run("viewer.choosing.change({...viewer.relief.find(1), name: 'Roof'}); true")
    named.append(page.run(rows)[0])
    page.set("surface-on", "")
    page.run("document.getElementById('surface-on').dispatchEvent(new Event('change')); viewer.setContent(new SolidContent('#00ff00')); true")
    page.drop("tall.png", "image/png", png(16, 64, lambda x, y: (0, 255, 255)))
    page.wait("viewer.projector.content.name === 'tall.png'")
    seen.append(page.run("JSON.stringify(viewer.projector.layer.place) === JSON.stringify(placeInPart(viewer.projector.layer.frame(viewer.projector.device.width, viewer.projector.device.height), partOf(viewer.scene.splats, viewer.projector.device)))"))
    page.run("viewer.placed({...viewer.projector.layer.place, x: 0.1}, false); true")
    page.drop("other.png", "image/png", png(16, 16, lambda x, y: (255, 0, 255)))
    page.wait("viewer.projector.content.name === 'other.png'")
    seen.append(page.run("viewer.projector.layer.place.x === 0.1"))
    named.append(page.run(rows)[0])
    check("what is put on a surface's layer is fitted to it, until a hand places it", all(seen) and len(seen) == 6, f"{seen}")
    check("a layer's row names its surface", named == ["wide.png on Surface 1", "Colour on Surface 1", "Colour", "wide.png on Roof", "other.png"], f"{named}")
    page.run("viewer.choosing.change({...viewer.relief.find(1), name: 'Surface 1'}), editLayers(viewer, (layers) => layers.splice(2, 1)); true")


def check_surfaces(check, page, folder):
    """A click on the object chooses a surface, to which a layer is confined; effects light what their formulas say."""
    page.resize(1000, 700)
    page.run("viewer.jump(viewer.scene.views[0], true); viewer.setContent(new TestContent('White')); document.body.classList.remove('with-panel'); idle()")
    page.hold(True)
    page.key("r", "KeyR")
    spots = [[0.3, 0.55], [0.27, 0.73]] # of the projector's picture, in two cells of the object's colours
    points = page.run(f"(window.spots = {spots}.map((at) => viewer.choosing.pointInPicture(at)))")
    page.run("viewer.draw(QUALITIES[0]); true")
    at = [page.run(f"project(viewer.screenCamera(), spots[{k}]).slice(0, 2)") for k in (0, 1)]

    def press(k, **more):
        page.mouse("mouseMoved", *at[k], "none", 0, **more)
        hovered = page.run("viewer.choosing.hovered && countOf(viewer.choosing.hovered.inside)")
        page.mouse("mousePressed", *at[k], **more)
        page.mouse("mouseReleased", *at[k], "left", 0, **more)
        page.run("new Promise((done) => setTimeout(done))")
        return hovered

    hovered = press(0)
    count = "(viewer.relief.surfaces.length ? countOf(viewer.relief.region(viewer.choosing.surface, viewer.choosing.device).inside) : 0)"
    first = page.run(count)
    check("a click chooses a surface, which was shown before it", hovered == first and 2000 < first < 40000 and len(points) == 2, f"{hovered} and {first} pixels")
    page.screenshot(os.path.join(folder, "surface.png"))
    page.run("viewer.setContent(new SolidContent('#000000')), viewer.projector.layers.push(new Layer(new SolidContent('#ff0000'), {on: 1})), viewer.changed('content')")
    # the cell is what has its colour around the point, and nothing that has another
    cell = f"""(() => {{ const f = viewer.choosing.field, c = scale3(sub3(spots[0], f.centre), 1 / f.radius), i = pixelOf(f, spots[0]), a = [0, 1, 2].map((k) => f.albedo[4 * i + k]);
        const away = (p) => length3(sub3(p.place, c)), tone = (p) => length3(sub3(p.albedo, a));
        return ({LIT_ON})((p) => p.solid && away(p) < 0.12 && tone(p) < 0.08, (p) => !p.solid || tone(p) > 0.3 || away(p) > 0.7); }})()"""
    lit = page.run(cell)
    edge = page.run("(() => { const d = bytesOf(viewer.projector.canvas); let soft = 0, full = 0; for (let i = 0; i < d.length; i += 4) soft += d[i] > 20 && d[i] < 235, full += d[i] >= 235; return [soft, full]; })()")
    check("a layer on it is lit inside, dark outside, and has a soft edge", lit[0] > 0.99 and lit[1] < 0.002 and 100 < edge[0] < 0.3 * edge[1], f"{lit}, {edge} pixels")
    press(1, modifiers=8)
    both = page.run(count)
    page.run("window.twice = stateOf(viewer).surfaces; true")
    press(1, modifiers=1)
    again = page.run(count)
    page.run("viewer.history.note()")
    page.key("z", "KeyZ", modifiers=2)
    page.wait("!viewer.history.busy")
    check("Shift adds a region, Alt takes it away, undo brings it back", both > 1.15 * first and abs(again - first) < 0.02 * first and page.run("viewer.relief.surfaces[0].parts.length") == 2,
          f"{first}, {both}, {again} pixels")
    moved = page.run("""(() => { const {projector: p} = viewer, {device} = p, look = () => { p.dirty = true; viewer.updatePatterns(); const f = viewer.choosing.field, d = bytesOf(p.canvas);
            return spots.map((point) => { const i = pixelOf(f, point); return i < 0 ? -1 : d[4 * i]; }).concat(d.reduce((sum, x, i) => sum + (i % 4 === 0 && x > 127), 0)); };
        p.device = {...device, pose: orbit(device.pose, viewer.scene.centre, viewer.up, 0.4, 0.1)};
        const after = look();
        p.device = device; return [look(), after]; })()""")
    check("it is found again where the projector stands elsewhere", moved[0][:2] == moved[1][:2] == [255, 255] and 0.5 < moved[1][2] / moved[0][2] < 2, f"{moved}")
    check_fitting(check, page)
    box = page.run("(() => { viewer.choosing.select(1); document.getElementById('fit-object').click(); const {x, y, width} = viewer.projector.layer.place; return [viewer.projector.at, x, y, width]; })()")
    page.run("viewer.projector.at = 1; document.getElementById('fit-object').click(); true")
    placed = page.run("(({x, y, width}) => [x, y, width])(viewer.projector.layer.place)")
    check("Fit takes the surface's box", abs(0.5 + placed[0] - 0.29) < 0.12 and abs(0.5 + placed[1] - 0.63) < 0.12 and placed[2] < 0.6, f"{placed}, all: {box}")
    seen = page.run("""(() => { const p = viewer.projector, {device} = p; viewer.projector.layer.place = newPlace(), p.device = {...device, pose: orbit(device.pose, viewer.scene.centre, viewer.up, 0.35, 0)};
        Object.assign(p, {correction: 'paint', watcher: 0, dirty: true}), viewer.ambient = false;
        const view = viewer.scene.views[0].camera, data = viewer.picture(400, 400, view), camera = fitDevice(view, 400, 400), far = viewer.choosing.pointInPicture([0.5, 0.51]);
        const out = [...spots, far].map((point) => { const [x, y] = project(camera, point); return data[4 * (Math.floor(y) * 400 + Math.floor(x))]; });
        Object.assign(p, {correction: 'none', device, dirty: true}), viewer.ambient = true; return out; })()""")
    check("corrected, it lies there for the audience", min(seen[:2]) > 40 and seen[2] < 8, f"{seen}")
    kept = page.run("""(async () => { const text = await stageText(viewer), state = await checkState(viewer, JSON.parse(text)); viewer.choosing.remove(1); const gone = [viewer.relief.surfaces.length, viewer.projector.layer.on];
        await applyState(viewer, state, false); return [gone, JSON.stringify(viewer.relief.surfaces) === JSON.stringify(twice), viewer.projector.layers[1].on]; })()""")
    check("a stage brings surfaces back", kept == [[0, None], True, 1], f"{kept}")
    page.run("viewer.choosing.remove(1); viewer.projector.at = 1; setMode(viewer, 'camera'); editLayers(viewer, (layers) => layers.splice(0, 1)); true")
    for effect in page.run("Object.keys(EFFECTS)"):
        told = page.run(f"""(() => {{ const relief = viewer.relief, says = {EFFECT_SAYS}, name = {effect!r}, rounds = [0.45, 0.3], pulse = name === 'pulse';
            const device = viewer.projector.device, eye = scale3(sub3(positionOf(device.pose), viewer.scene.centre), 1 / viewer.scene.radius), f = viewer.choosing.field, all = [];
            for (let i = 0; i < f.width * f.height; i++) if (isSolid(f, i)) all.push(length3(sub3(placeAt(f, i), eye)));
            all.sort((a, b) => a - b);
            const range = [0.002, 0.998].map((share) => all[Math.floor(share * all.length)]), picture = () => {{ viewer.projector.dirty = true; viewer.updatePatterns(); return bytesOf(viewer.projector.canvas).slice(); }};
            viewer.setContent(new EffectContent(name, '#ffffff', {{speed: pulse ? 0 : 0.5, size: name === 'creases' ? 0.2 : 0.5}}));
            const pictures = [0, 0, 1].map((k) => {{ relief.clock = () => 2 * (7 + rounds[k]), relief.sound.given = rounds[k]; return picture(); }});
            const differs = (a, b) => a.reduce((sum, x, i) => sum + Math.abs(x - b[i]), 0) / a.length, shares = rounds.map((round, k) => {{
                relief.clock = () => 2 * (7 + round), relief.sound.given = round;
                return says[name] ? ({LIT_ON})((p) => p.solid && says[name](p, round, eye, range), (p) => !says[name](p, round, eye, range)) : ({LIT_ON})((p) => p.solid, (p) => !p.solid); }});
            delete relief.clock;
            return [shares, differs(pictures[0], pictures[1]), differs(pictures[0], pictures[2])]; }})()""")
        (shares, still, moves) = told
        good = all(inner > 0.97 and outer < 0.02 for inner, outer in shares) if effect not in ("creases", "sparkle") else all(0.002 < inner < 0.35 and outer == 0 for inner, outer in shares)
        check(f"an effect lights what its formula says, and moves: {effect}", good and still == 0 and moves > 0.1, f"{shares}, {moves:.2f}")
    lines = page.run(f"""(() => {{ const relief = viewer.relief, f = viewer.choosing.field; viewer.setContent(new EffectContent('creases', '#ffffff', {{speed: 0, size: 0.3}})); viewer.projector.dirty = true; viewer.updatePatterns();
        const d = bytesOf(viewer.projector.canvas), counts = [0, 0, 0, 0];
        for (let y = 12; y < f.height - 12; y++) for (let x = 12; x < f.width - 12; x++) {{ const i = y * f.width + x, rim = [1, -1, f.width, -f.width].some((s) => !isSolid(f, i + s));
            const even = [-12, 12, -12 * f.width, 12 * f.width].every((s) => isSolid(f, i + s) && f.normal[4 * i] * f.normal[4 * (i + s)] + f.normal[4 * i + 1] * f.normal[4 * (i + s) + 1] + f.normal[4 * i + 2] * f.normal[4 * (i + s) + 2] > 0.995);
            if (!isSolid(f, i) || !(rim || even)) continue;
            counts[rim ? 0 : 2] += d[4 * i] > 12, counts[rim ? 1 : 3]++; }}
        return [counts[0] / counts[1], counts[2] / counts[3]]; }})()""")
    check("lines lie on outlines, not where the object is even", lines[0] > 0.95 and lines[1] < 0.02, f"{lines[0]:.3f} and {lines[1]:.3f}")
    turned = page.run("""(async () => { await applyControl(viewer, '/projector/1/layer/1/speed', [1.5]), await applyControl(viewer, '/projector/1/layer/1/size', [0.75]), await applyControl(viewer, '/level', [0.4]);
        const {speed, size} = viewer.projector.content.values, out = [speed, size, viewer.relief.sound.level, document.getElementById('effect-speed').value];
        viewer.show.add(), viewer.setContent(new EffectContent('scan', '#ff0000')), viewer.show.cues[0].fade = 30;
        await viewer.show.go(0);
        out.push(!!viewer.projector.fade, viewer.projector.content.effect, viewer.projector.content.values.speed), viewer.show.cues = [], viewer.show.at = -1;
        viewer.projector.endFade(), viewer.relief.sound.given = null; return out; })()""")
    check("its controls answer to addresses, and cues fade to it", turned == [1.5, 0.75, 0.4, "1.5", True, "creases", 1.5], f"{turned}")
    heard = page.run("""(async () => { const {sound} = viewer.relief, told = document.getElementById('sound-told'), pause = () => new Promise((done) => setTimeout(done, 100)), press = () => document.getElementById('microphone').click();
        viewer.setContent(new EffectContent('pulse', '#ffffff'));
        const out = [told.textContent.slice(0, 8)];
        press();
        for (let k = 0; k < 300 && !(sound.running && sound.level > 0.02); k++) await pause();
        out.push(told.textContent, sound.level > 0.02), press();
        for (let k = 0; k < 100 && (sound.running || sound.level); k++) await pause();
        out.push(sound.running, sound.level);
        return out; })()""")
    check("a pulse follows the microphone, and says where it hears", heard == ["No sound", "By the microphone", True, False, 0], f"{heard}")
    page.run("viewer.setContent(new TestContent('White')); viewer.changed('cues'); true")
    page.hold(False)
    page.resize(520, 400)


def check_cues(check, page):
    """A show fades from cue to cue, under correction too."""
    page.run("viewer.jump(viewer.scene.views[0], true); viewer.show.cues = []; true")
    page.set("correction", "paint")
    page.hold(True)
    seen = []
    for colour in ("#ff0000", "#0000ff"):
        page.run(f"viewer.setContent(new SolidContent('{colour}')); viewer.show.add()")
        seen.append(page.pixels())
    page.run("viewer.show.cues[0].fade = 20; viewer.show.go(0)")
    page.run("viewer.projector.fade.began -= 10000, viewer.projector.dirty = true")  # half of the fade later
    half = page.pixels()
    page.run("viewer.projector.fade.began -= 20000; viewer.endFades()")
    last = page.pixels()
    check("a cue fades in, corrected", change(seen[0], half) > 0.2 and change(seen[1], half) > 0.2 and change(seen[0], last) < 0.1,
          f"{change(seen[0], half):.2f} {change(seen[1], half):.2f} {change(seen[0], last):.2f}")
    page.run("viewer.show.cues[1].shown[0].correction = 'none', viewer.show.cues[1].fade = 20, viewer.show.go(1)")  # corrected red to blue as it is
    linear = """(() => { viewer.updatePatterns(); const {width, height, data} = panelPicture(viewer.graphics, viewer.projector, null, window.kept = window.kept || {}), i = 4 * (width * (height >> 1) + (width >> 1));
        return [0, 1, 2].map((k) => (data[i + k] / 255) ** 2.2); })()"""
    page.run("viewer.projector.fade.began = performance.now(), viewer.projector.dirty = true")
    ends = [page.run(linear)]
    page.run("viewer.projector.fade.began -= 10000, viewer.projector.dirty = true")
    middle = page.run(linear)
    page.run("viewer.projector.fade.began -= 20000, viewer.endFades()")
    ends.append(page.run(linear))
    check("a correction fades with its cue", ends[0][0] > 0.9 and ends[1] == [0, 0, 1] and 0.35 < middle[0] < 0.65 and abs(middle[0] + middle[2] - 1) < 0.06,
          f"{ends} {middle}")
    page.run("viewer.show.cues.forEach((cue) => { cue.fade = 0; cue.follow = 0.2; }); viewer.show.go(0)")
    page.wait("viewer.show.at === 1")
    page.wait("viewer.show.at === 0")
    check("cues follow each other in a loop", page.run("viewer.show.playing"))
    page.run("viewer.show.stop(); document.body.classList.add('with-panel'); document.getElementById('cues').closest('details').open = true; " + STILL)
    middle = lambda selector: page.run(f"(() => {{ const e = document.querySelector({selector!r}); e.scrollIntoView({{block: 'center'}}); const {{left, top, width, height}} = e.getBoundingClientRect(); return [left + width / 2, top + height / 2]; }})()")
    page.run("document.querySelector('#cues input').focus(); document.querySelector('#cues input').select()")
    page.key("Q", "KeyQ")
    page.run("viewer.changed('windows'), viewer.changed('cues')")
    page.key("Z", "KeyZ")
    at = middle("#cues button[title='More of cue 1']")
    page.mouse("mousePressed", *at)
    page.mouse("mouseReleased", *at, "left", 0)
    typed = page.run("[viewer.show.cues[0].name, document.querySelector('#cues input').value, document.querySelectorAll('#cues li:first-child .row').length]")
    check("what happens meanwhile takes neither what is typed nor a press", typed == ["QZ", "QZ", 2], f"{typed}")
    page.run("document.body.classList.remove('with-panel'); viewer.show.cues = []; viewer.changed('cues'); true")
    seats = page.run("""(() => {
        const seat = () => JSON.stringify(viewer.watcherOf(viewer.projector).pose), look = (k) => viewer.setCamera(viewer.scene.views[k].camera.pose);
        viewer.projector.watcher = 'now', look(0), viewer.show.arm(true);
        const seats = [seat(), (look(1), seat()), (viewer.show.arm(false), seat())];
        look(0);
        return seats;
    })()""")
    check("an armed show keeps the place that corrections are for", seats[0] == seats[1] != seats[2])
    page.hold(False)
    page.set("correction", "none")


def check_go_bar(check, page):
    """GO and Blackout stay where they are while a show goes on, and nothing shows through; messages name no window that is not there."""
    page.resize(1000, 700)
    page.run("document.body.classList.add('with-panel'); openShow(); viewer.setContent(new SolidContent('#ff0000')); viewer.show.add(); "
             "viewer.setContent(new EffectContent('scan', '#ffffff')); viewer.show.add(); viewer.show.cues.forEach((cue) => { cue.fade = 0; }); "
             "document.getElementById('layers').closest('details').open = true; document.getElementById('panel').scrollTop = 0; " + STILL)
    places = page.run("""(async () => { const out = [], {left, right, top, bottom} = document.getElementById('panel').getBoundingClientRect(), rect = (e) => e.getBoundingClientRect();
        for (const k of [0, 1, 0]) { await viewer.show.go(k); await new Promise(requestAnimationFrame); out.push(['dark', 'go'].map((id) => [rect(document.getElementById(id)).left, rect(document.getElementById(id)).top]).join()); }
        document.getElementById('panel').scrollTop = 300;
        const bar = document.getElementById('go-bar'), seen = [[left + 20, top + 2], [left + 4, top + 30], [right - 24, top + 30]].map((at) => bar.contains(document.elementFromPoint(...at)));
        document.getElementById('panel').scrollTop = 1e6;
        document.getElementById('fit').focus();
        return [new Set(out).size, seen, getComputedStyle(bar).backgroundColor.startsWith('rgb('), rect(document.getElementById('fit')).top >= rect(bar).bottom]; })()""")
    check("GO and Blackout stay in place, nothing shows through above or beside them or lies under them", places == [1, [True] * 3, True, True], f"{places}")
    said = page.run("[true, false].map((on) => { blackout(viewer, on); return document.getElementById('toast').textContent; })")
    check("a blackout without a window says so", said == [f"Blackout is {how}. No projector window is open." for how in ("on", "off")], f"{said}")
    page.run("viewer.show.cues = []; viewer.changed('cues'); viewer.setContent(new TestContent('White')); document.body.classList.remove('with-panel'); true")
    page.resize(520, 400)


def check_midi(check, page):
    """A fake MIDI device: a pad and a fader learn what they do, which the stage keeps."""
    page.run("""window.device = {name: 'fake', onmidimessage: null}; window.play = (...data) => device.onmidimessage({data: Uint8Array.from(data)});
        Object.defineProperty(navigator, 'requestMIDIAccess', {configurable: true, value: async () => ({inputs: new Map([['1', device]]), onstatechange: null})});
        viewer.show.cues = [], viewer.show.add(), viewer.show.add(), viewer.show.at = -1, viewer.show.cues.forEach((cue) => { cue.fade = 0; }), viewer.changed('cues'); true""")
    for address, data in (("/go", "0x90, 36, 100"), ("/projector/1/layer/1/opacity", "0xb0, 7, 64"), ("/blackout", "0x90, 37, 1")):
        page.run(f"document.getElementById('learn-address').value = {address!r}; true")
        page.click("#learn")
        page.wait("!!viewer.midi.learns && !!device.onmidimessage")
        page.run(f"play(0xf8), play({data}), true")
    learned = page.run("[viewer.midi.learns, viewer.show.at, JSON.stringify(viewer.midi.bindings), document.querySelectorAll('#bindings li').length]")
    check("MIDI controls learn", learned == [None, -1, '{"note 1 36":"/go","control 1 7":"/projector/1/layer/1/opacity","note 1 37":"/blackout"}', 3], f"{learned}")
    page.run("play(0x90, 36, 100), play(0x80, 36, 0), true")
    page.wait("viewer.show.at === 0")
    page.run("play(0x90, 36, 9), play(0x90, 36, 0), true")
    page.wait("viewer.show.at === 1")
    page.run("play(0xb0, 7, 0), idle()")
    dark = page.run("[viewer.projector.layer.place.opacity, ...viewer.projector.context.getImageData(9, 9, 1, 1).data]")
    page.run("play(0xb0, 7, 127), play(0x90, 37, 1), play(0x90, 37, 0), idle()")
    check("a pad goes on, a fader fades, a key blacks out", dark[0] == 0 and max(dark[1:4]) == 0 and page.run("[viewer.projector.layer.place.opacity, viewer.dark]") == [1, True], f"{dark}")
    same = page.run("""(async () => { blackout(viewer, false); const text = await stageText(viewer); viewer.midi.bindings = {};
        await loadStage(viewer, text); return JSON.stringify(viewer.midi.bindings); })()""")
    check("a stage keeps what MIDI controls do", same == learned[2], same)
    page.run("delete navigator.requestMIDIAccess; document.querySelectorAll('#bindings button').forEach((b) => b.click()); viewer.midi.access = null, viewer.show.cues = [], viewer.changed('cues'); true")


def check_nudge(check, page):
    """The real projector stands elsewhere than the page believes: three pulls by a hand, from where it lights to where it should."""
    page.resize(900, 640)
    before, after, undone = page.run("""(async () => { const {views, centre, radius} = viewer.scene; viewer.jump(views[0], true); setMode(viewer, 'nudge');
        const p = viewer.projector, believed = p.device, distance = length3(sub3(positionOf(believed.pose), centre));
        const truth = {...believed, pose: movedPose(believed.pose, [0.02, -0.03, 0.025, 0.006, -0.004, 0.005], distance)}, canvas = viewer.canvas;
        await idle();
        const camera = viewer.renderer.view.camera, ratio = camera.width / innerWidth, spots = [];
        for (let y = 8; y < innerHeight - 8; y += 5) for (let x = 8; x < innerWidth - 8; x += 5) { // places of the object
            const depth = viewer.renderer.view.depthUnder(x * ratio, y * ratio);
            if (depth) spots.push({at: [x, y], point: pointAt(camera, x * ratio, y * ratio, depth)}); }
        const miss = () => spots.reduce((sum, {point}) => { const a = project(p.device, point), b = project(truth, point); return sum + Math.hypot(a[0] - b[0], a[1] - b[1]); }, 0) / spots.length;
        const missed = [miss()], middle = [0, 1].map((k) => spots.reduce((sum, s) => sum + s.at[k], 0) / spots.length);
        const far = [0, 2.1, 4.2].map((angle) => spots.reduce((best, s) => { const reach = (s) => (s.at[0] - middle[0]) * Math.cos(angle) + (s.at[1] - middle[1]) * Math.sin(angle);
            const inside = spots.filter((o) => Math.hypot(o.at[0] - s.at[0], o.at[1] - s.at[1]) < 45).length > 225; return inside && (!best || reach(s) > reach(best)) ? s : best; }, null));
        for (const {at: from, point} of far) { // its light there is meant for the place that the page lights by the same pixel
            const pixel = project(truth, point), meant = spots.map((s) => ({s, d: Math.hypot(project(p.device, s.point)[0] - pixel[0], project(p.device, s.point)[1] - pixel[1])})).reduce((a, b) => a.d < b.d ? a : b).s.at;
            const send = (type, [clientX, clientY]) => canvas.dispatchEvent(new PointerEvent(type, {pointerId: 1, clientX, clientY, button: 0, bubbles: true}));
            canvas.setPointerCapture = () => {};
            send('pointerdown', from), send('pointermove', meant), send('pointerup', meant);
            await new Promise((done) => setTimeout(done, 30)), await idle();
            missed.push(miss()); }
        for (let k = 0; k < 3; k++) await unwind(viewer, -1);
        const undone = p.device.pose.every((x, i) => x === believed.pose[i]);
        setMode(viewer, 'camera'), viewer.jump(views[0], true), delete canvas.setPointerCapture;
        return [missed[0], missed.slice(1), undone]; })()""")
    page.resize(520, 400)
    check("three pulls find the projector", after[0] < 0.5 * before and after[2] < 0.15 * before and undone, f"{before:.1f} pixels off, then {', '.join(f'{x:.1f}' for x in after)}; undone {undone}")


def check_letters(check, page, folder):
    """Around a corrected logo with alpha the pattern is black: nothing grows beyond its edge."""
    page.run("viewer.jump(viewer.scene.views[0], true); true")
    disc = png(128, 128, lambda x, y: (255, 255, 255, 255 if (x - 64) ** 2 + (y - 64) ** 2 < 400 else 0), 4)
    solid = png(128, 128, lambda x, y: (255, 255, 255) if (x - 64) ** 2 + (y - 64) ** 2 < 400 else (0, 0, 0))
    page.set("correction", "paint")
    page.set("watcher", "0")
    made = []
    for name, data in (("disc.png", disc), ("solid.png", solid)):
        page.drop(name, "image/png", data)
        page.wait(f"viewer.projector.content.name === '{name}'")
        page.run("viewer.updatePatterns()")
        made.append(page.pixels())
    check("transparent is black under correction", change(made[0], made[1]) < 0.05, f"{change(made[0], made[1]):.3f}")
    page.set("correction", "none")


SMALL = """(() => { const small = [];
    for (const d of document.querySelectorAll('details')) d.open = true;
    for (const c of document.querySelectorAll('button, select, input:not([hidden]), summary')) {
        const box = (c.closest('.check, label.row') || c).getBoundingClientRect();
        if (c.closest('dialog') || !c.offsetParent || c.id === 'split') continue;
        if (box.height < 39.5 || (c.tagName === 'BUTTON' && box.width < 39.5)) small.push((c.id || c.textContent || c.className) + ' ' + box.width + 'x' + box.height);
    }
    return small; })()"""


def check_touch(check, page, folder):
    page.resize(390, 844, 2, mobile=True)
    page.call("Emulation.setTouchEmulationEnabled", {"enabled": True})
    page.run("document.body.classList.add('with-panel'); idle()")
    small = page.run(SMALL)
    check("what fingers press is at least 40 pixels high", not small, "; ".join(small))
    wide = page.run("document.getElementById('tools').scrollWidth <= innerWidth && [...document.querySelectorAll('#tools button')].every((b) => b.getBoundingClientRect().right <= innerWidth)")
    check("all tools are on a phone's screen", wide)
    page.run("document.getElementById('keys').showModal()")
    page.screenshot(os.path.join(folder, "fingers.png"))
    page.run("document.getElementById('keys').close()")
    page.call("Emulation.setTouchEmulationEnabled", {"enabled": False})
    page.resize(1280, 720)
    page.run("idle()")
    out = page.run("""[...document.querySelectorAll('#panel select')].filter((s) => {
        const box = s.getBoundingClientRect(), panel = document.getElementById('panel').getBoundingClientRect();
        return box.width && (box.right > panel.right || box.left < panel.left); }).map((s) => s.id)""")
    check("menus are inside their panel", not out, f"{out}")
    page.resize(520, 400)


def check_keys(check, page):
    """Keys that a control needs are its own; the others stay shortcuts."""
    def press(key, on, code, number, look):
        before = page.run(f"document.querySelector({on!r}).focus(), {look}")
        page.key(key, code, windowsVirtualKeyCode=number)
        return before, page.run(look)

    page.run("viewer.jump(viewer.scene.views[0], true); document.body.classList.add('with-panel')")
    page.run(STILL)
    before, after = press(" ", "#ambient", "Space", 32, "viewer.ambient")
    press(" ", "#ambient", "Space", 32, "viewer.ambient")
    check("Space toggles a checkbox", before != after and page.run("viewer.ambient"), f"{before}, {after}")
    before, after = press(" ", "#panel > details:nth-of-type(4) summary", "Space", 32, "document.querySelector('#panel > details:nth-of-type(4)').open")
    check("Space opens what is folded", not before and after, f"{before}, {after}")
    page.run("document.querySelector('#panel > details:nth-of-type(4)').open = false")
    before, after = press("Home", "#exposure", "Home", 36, "viewer.exposure")
    check("Home is a slider's own", before == 0 and after == -4, f"{before}, {after}")
    page.run("document.activeElement.blur()")
    page.set("exposure", "0")
    before, after = press("4", "#bring", "Digit4", 52, "viewer.scene.views.indexOf(viewer.at)")
    check("a number jumps beside a checkbox too", after == 3, f"{before}, {after}")
    page.run("document.activeElement.blur(); viewer.jump(viewer.scene.views[0], true); document.body.classList.remove('with-panel'); idle()")


def check_targets(check, page):
    """A late picture comes to the projector that it was asked for, or not at all."""
    page.run("""(() => { const real = window.realBitmap = createImageBitmap; window.waits = [];
        window.createImageBitmap = async (...given) => { const wait = waits.shift() || 0, made = await real(...given);
            await new Promise((done) => setTimeout(done, wait)); return made; }; })()""")
    shown = "viewer.projectors.map((p) => p.content.name)"
    page.run("viewer.setContent(new TestContent('White')); waits.push(300); true")
    page.drop("late.png", "image/png", png(16, 16, lambda x, y: (0, 99, 0)))
    page.wait("waits.length === 0")
    page.click("#add")
    page.wait(shown + ".includes('late.png')")
    names = page.run(shown)
    check("a file is for the projector that it was dropped on", names == ["late.png", "White"], " ".join(names))
    page.click("#remove")
    page.run("waits.push(300, 0); true")
    tiles = page.run("""(async () => { const [slow, quick] = document.querySelectorAll('#contents .tile');
        slow.click(); quick.click(); await new Promise((done) => setTimeout(done, 600)); return [quick.title, shortName(viewer.projector.content.name)]; })()""")
    check("of two tiles the later wins", tiles[0] == tiles[1], " ".join(tiles))
    page.run("window.createImageBitmap = realBitmap; true")
    page.run("""(() => { const transfer = new DataTransfer(), slider = document.getElementById('exposure'); slider.focus();
        transfer.items.add(new File([Uint8Array.from(atob('%s'), (c) => c.charCodeAt(0))], 'slid.png', {type: 'image/png'}));
        slider.dispatchEvent(new ClipboardEvent('paste', {clipboardData: transfer, bubbles: true})); slider.blur(); })()""" %
             base64.b64encode(png(32, 32, lambda x, y: (250, 0, 250))).decode())
    page.wait("viewer.projector.content.name === 'slid.png'")
    check("a picture is pasted after a slider was moved", page.run("viewer.projector.content.name === 'slid.png'"))
    page.run("viewer.setContent(new TestContent('White'))")


def check_turning(check, page):
    """A camera that starts overhead comes away from there, and nothing goes over the pole."""
    angles = page.run("""(() => { const {up} = viewer, c = viewer.scene.centre, aside = normalise3(cross3(up, [0.3, 0.5, 0.7]));
        const angle = (p) => Math.acos(clamp(dot3(normalise3(sub3(positionOf(p), c)), up), -1, 1));
        const start = lookAt(add3(c, add3(scale3(up, 3), scale3(aside, 0.15))), c, up);
        return [-0.02, 0.02].map((step) => { let pose = start; for (let i = 0; i < 10; i++) pose = orbit(pose, c, up, 0, step); return angle(pose) - angle(start); }); })()""")
    check("a device overhead can be tilted away", max(angles) > 0.15 and min(angles) > -0.01, " ".join(f"{a:.2f}" for a in angles))


def check_walking(check, page):
    """In a whole scene the camera turns where it stands and walks at its height; an object is gone around."""
    page.run("viewer.scene.whole = true; viewer.jump(viewer.scene.views[0], false); true")
    stands, turned, right = page.run("""(() => { const before = viewer.pose, ahead = axisOf(before, 2);
        viewer.turn(0.4, 0); const after = viewer.pose, seen = axisOf(after, 2);
        return [length3(sub3(positionOf(after), positionOf(before))), Math.acos(dot3(ahead, seen)), dot3(seen, axisOf(before, 0))]; })()""")
    check("in a scene a drag turns the camera where it stands", stands < 1e-6 and 0.15 < turned <= 0.2001 and right < 0, f"{turned:.3f} rad, moved {stands:.1g}")
    far, rise, ahead = page.run("""(() => { const before = positionOf(viewer.pose), look = axisOf(viewer.pose, 2); viewer.dolly(Math.exp(-0.5));
        const by = sub3(positionOf(viewer.pose), before); return [length3(by) / viewer.scene.radius, dot3(by, viewer.up), dot3(by, look)]; })()""")
    check("the wheel walks at one height", abs(far - 0.5) < 1e-3 and abs(rise) < 1e-3 * far and ahead > 0, f"{far:.3f} radii, rises {rise:.1g}")
    page.run("document.activeElement.blur(); window.stood = viewer.pose; true")
    page.key("ArrowUp", "ArrowUp", windowsVirtualKeyCode=38)
    check("an arrow walks ahead", page.run("dot3(sub3(positionOf(viewer.pose), positionOf(stood)), axisOf(stood, 2)) > 0.05 * viewer.scene.radius"))
    over = page.run("""(() => { const {up} = viewer; let pose = viewer.pose; for (let i = 0; i < 200; i++) pose = lookAround(pose, up, 0, 0.05);
        return [dot3(axisOf(pose, 2), up), dot3(axisOf(pose, 1), up)]; })()""")
    check("nobody looks over the zenith", over[0] > 0.9 and over[1] < 0, " ".join(f"{a:.2f}" for a in over))
    page.run("viewer.scene.whole = false; viewer.jump(viewer.scene.views[0], true); idle()")


def check_memory(check, page):
    """Samples as far as the graphics memory goes."""
    page.hold(True)
    page.samples(2)
    asked = page.run("""(() => { const {renderer: r, canvas} = viewer, ask = (width, height, most) => { let asked = null;
            r.drawLight = (camera, side) => { asked = [camera.width, camera.height, side]; }; r.resolve = () => {};
            viewer.canvas = {}; viewer.redrawOverlay = () => {}; viewer.changed = () => {};
            const real = ['innerWidth', 'innerHeight', 'devicePixelRatio'].map((name) => [name, Object.getOwnPropertyDescriptor(window, name)]);
            [width, height, 2].forEach((value, i) => Object.defineProperty(window, real[i][0], {value, configurable: true}));
            const before = viewer.graphics.sideMax; viewer.graphics.sideMax = most;
            viewer.draw(QUALITIES[0]);
            viewer.graphics.sideMax = before;
            real.forEach(([name, was]) => Object.defineProperty(window, name, was));
            viewer.canvas = canvas; delete viewer.redrawOverlay; delete viewer.changed; delete r.drawLight; delete r.resolve;
            return asked; };
        return [ask(960, 540, 16384), ask(1920, 1080, 16384), ask(4320, 2400, 8192), ask(3000, 1000, 4096)]; })()""")
    check("samples are as many as memory and driver allow", asked[0] == [1920, 1080, 2] and asked[1] == [3840, 2160, 1] and
          all(w * s <= most and h * s <= most and w * h * s * s <= 1.01 * 2 ** 24 for (w, h, s), most in zip(asked, (16384, 16384, 8192, 4096))),
          " ".join(f"{w} x {h} x {s}" for w, h, s in asked))
    made = page.run("""(() => { const {graphics: g} = viewer; let made = 0;
        g.target = (...given) => { made++; return Graphics.prototype.target.apply(g, given); };
        const turn = () => { for (const q of [1, 0]) viewer.lastChange++, viewer.setCamera(movePose(viewer.pose, [1e-4, 0, 0])), viewer.draw(QUALITIES[q]); };
        turn(); made = 0; turn(); delete g.target; return made; })()""")
    check("moving and resting keep their memory", made == 0, f"{made} targets made again")
    page.samples(1)
    page.hold(False)
    page.run("""document.getElementById('toast').classList.remove('shown');
        viewer.graphics.gl.checkFramebufferStatus = () => 0; viewer.renderer.view = new GbufferView(viewer.renderer); viewer.invalidate(); idle()""")
    said = page.message()
    check("a driver without room is said", "no room" in said, said)
    page.run("delete viewer.graphics.gl.checkFramebufferStatus; viewer.jump(viewer.scene.views[0], true); idle()")
    lit = sum(page.pixels())
    check("and the page goes on", lit > 0)


def check_contents(check, page, folder):
    page.run("viewer.jump(viewer.scene.views[0], true); viewer.setContent(new TestContent('White'))")
    white = page.pixels()
    page.drop("wide.png", "image/png", png(1920, 1080, lambda x, y: (255, 40, 40) if x < 960 else (40, 40, 255)))
    page.wait("viewer.projector.content.name === 'wide.png'", 30)
    check("a pattern of 1920 x 1080 drops in", change(white, page.pixels()) > 1, f"{change(white, page.pixels()):.2f}")
    wide = page.pixels()
    page.set("fit", "stretch")
    page.run("viewer.updatePatterns()")
    check("Fit stretches it", change(wide, page.pixels()) > 0.1, f"{change(wide, page.pixels()):.2f}")
    page.set("fit", "contain")
    chosen = os.path.join(folder, "chosen.png")
    with open(chosen, "wb") as file:
        file.write(png(64, 64, lambda x, y: (0, 200, 0)))
    root = page.call("DOM.getDocument")["root"]["nodeId"]
    node = page.call("DOM.querySelector", {"nodeId": root, "selector": "#file"})["nodeId"]
    page.call("DOM.setFileInputFiles", {"nodeId": node, "files": [os.path.abspath(chosen)]})
    page.wait("viewer.projector.content.name === 'chosen.png'", 30)
    check("a file is chosen", change(wide, page.pixels()) > 1)
    page.run("""(() => { const transfer = new DataTransfer();
        transfer.items.add(new File([Uint8Array.from(atob('%s'), (c) => c.charCodeAt(0))], 'pasted.png', {type: 'image/png'}));
        window.dispatchEvent(new ClipboardEvent('paste', {clipboardData: transfer, bubbles: true})); })()""" %
             base64.b64encode(png(32, 32, lambda x, y: (250, 0, 250))).decode())
    page.wait("viewer.projector.content.name === 'pasted.png'", 30)
    check("a picture is pasted", change(wide, page.pixels()) > 1)
    svg = b"""<?xml version="1.0" encoding="UTF-8"?>\n<!-- drawn -->\n<svg xmlns="http://www.w3.org/2000/svg" width="40" height="40">""" + \
          b"""<rect width="40" height="40" fill="#00f"/></svg>"""
    page.drop("drawn.svg", "image/svg+xml", svg)
    page.wait("viewer.projector.content.name === 'drawn.svg'", 30)
    check("a drawing with a declaration", change(wide, page.pixels()) > 1)
    film = two_colours()
    if not film:
        print("skipped: ffmpeg is not here")
        return
    gif = two_colours("gif")
    page.drop("two.gif", "image/gif", gif)
    page.wait("viewer.projector.content.name === 'two.gif'", 30)
    halves = page.run("""(() => { const c = viewer.projector.content, canvas = new OffscreenCanvas(8, 8), context = canvas.getContext('2d', {willReadFrequently: true});
        return [0.2, 0.7].map((share) => { c.stopped = share * c.ends.at(-1); c.paint(context, 8, 8);
            return context.getImageData(4, 4, 1, 1).data.join(); }); })()""")
    check("a GIF moves", len(set(halves)) == 2, " ".join(halves))
    page.drop("untyped.webm", "", film)
    page.wait("viewer.projector.content.name === 'untyped.webm'", 30)
    check("a film without a type", page.run("!!viewer.projector.content.video"))
    page.drop("film.webm", "video/webm", film)
    page.wait("viewer.projector.content.name === 'film.webm'", 30)
    page.run("viewer.projector.content.video.pause(); true")
    apart = page.run("""(async () => { const p = viewer.projector, film = p.content; viewer.setLayers([new Layer(film), new Layer(new TestContent('White'))]); p.at = 1;
        await viewer.bring(film);
        const [a, b] = p.layers.map((layer) => layer.source), again = await layersOf(viewer, describeLayers(viewer, p.layers), p.layers);
        const told = [a !== b, a.video !== b.video, a.file === b.file, again.every((layer, k) => layer.source === p.layers[k].source)];
        const fresh = await layersOf(viewer, describeLayers(viewer, p.layers)); told.push(fresh[0].source !== fresh[1].source);
        viewer.release([fresh[1].source]), b.video.pause(), viewer.setLayers([new Layer(film)]), film.video.pause();
        return told; })()""")
    check("two layers of a film have players of their own", apart == [True] * 5, f"{apart}")
    seen = []
    for at in (0.2, 0.9):
        page.run(f"""new Promise((done) => {{ const v = viewer.projector.content.video; v.onseeked = () => done(true); v.currentTime = {at}; }})""")
        seen.append(page.pixels())
    check("a film plays on the object", change(*seen) > 1, f"{change(*seen):.2f} between its halves")
    page.run("viewer.projector.content.video.currentTime = 0.9")
    page.wait("!viewer.projector.content.video.seeking")
    page.click("#film-from-now")
    page.set("volume", "0.25")
    page.run("(() => { const s = document.getElementById('seek'); s.value = 0; s.dispatchEvent(new Event('input')); })()")
    page.wait("!viewer.projector.content.video.seeking && Math.abs(viewer.projector.content.video.currentTime - 0.9) < 0.06", 10)
    part = page.run("(() => { const {volume, muted} = viewer.projector.content.video; return [volume, muted, viewer.projector.layer.film.from]; })()")
    check("a film keeps to its part, as loud as it is set", part == [0.25, False, 0.9], f"{part}")
    page.run("viewer.projector.layer.film = newFilm(); true")
    page.samples(2)
    frames = lambda: page.run("""(async () => { const after = (ms) => new Promise((done) => setTimeout(done, ms));
        await Promise.race([idle(), after(4000)]);
        const before = viewer.frames; await after(300); return viewer.frames - before + viewer.pending; })()""")
    still, side = frames(), page.run("viewer.drawn.side")
    check("stopped, it is drawn once and in full", still == 0 and side == 2, f"{still} more frames, {side} samples a side")
    page.samples(1)
    drawn = page.run("viewer.projector.content.toggle(), viewer.frames")
    page.wait(f"viewer.frames > {drawn + 2}")
    page.set("on", False)
    dark = frames()
    check("a film that lights nothing costs no frames", dark == 0, f"{dark} frames")
    page.set("on", True)
    page.run("document.getElementById('webcam').click()")
    page.wait("viewer.projector.content.name === 'Camera'", 30)
    check("the webcam", change(white, page.pixels()) > 0.3)
    page.run("navigator.mediaDevices.getDisplayMedia = async () => { const c = makeCanvas(64, 64), x = c.getContext('2d'); "
             "setInterval(() => { x.fillStyle = '#00ff00'; x.fillRect(0, 0, 64, 64); }, 40); return c.captureStream(25); }; document.getElementById('screen').click()")
    page.wait("viewer.projector.content.name === 'Screen'", 30)
    tiles = page.run("[viewer.library.entries.filter((e) => e.live).map((e) => e.live), describeContent(viewer, viewer.projector.content).file === viewer.library.entries.at(-1).id]")
    check("a screen, which a stage can name", tiles == [["camera", "screen"], True], f"{tiles}")
    page.run("viewer.setContent(new TestContent('White'))")


def film_of(kind, *arguments):
    """A film of two seconds whose first is black and whose second green."""
    colours = [part for colour in ("black", "0x00ff00") for part in ("-f", "lavfi", "-i", f"color={colour}:s=96x64:d=1:r=20")]
    with tempfile.TemporaryDirectory() as scratch:
        path = os.path.join(scratch, "film." + kind)
        subprocess.run(["ffmpeg", "-loglevel", "error", *colours, "-filter_complex", "concat", *arguments, path], check=True)
        with open(path, "rb") as file:
            return file.read()


def tile(page, name):
    """The middle of a tile, once it has a picture."""
    page.wait(f"[...document.querySelectorAll('#contents button')].some((b) => b.title === {name!r})", 30)
    middle = f"[...bytesOf([...document.querySelectorAll('#contents button')].find((b) => b.title === {name!r}).querySelector('canvas')).subarray(4 * (48 * 96 + 48), 4 * (48 * 96 + 49))]"
    end = time.monotonic() + 30
    while max(page.run(middle)[:3]) < 100 and time.monotonic() < end:
        time.sleep(0.1)
    return page.run(middle)


def check_films(check, page):
    """Tiles of films that begin black, in the codecs that this browser plays; those that it does not play are refused by their names."""
    if not shutil.which("ffmpeg"):
        print("skipped: ffmpeg is not here")
        return
    for name, kind, arguments in (("vp9.webm", "video/webm", ("-c:v", "libvpx-vp9")), ("vp8.webm", "video/webm", ("-c:v", "libvpx")),
                                  ("h264.mp4", "video/mp4", ("-c:v", "libx264", "-pix_fmt", "yuv420p", "-bf", "2"))):
        page.run("document.getElementById('toast').textContent = ''")
        page.drop(name, kind, film_of(name.split(".")[1], *arguments))
        page.wait(f"viewer.projector.content.name === {name!r} || document.getElementById('toast').textContent.includes('cannot play')", 30)
        if "cannot play" in page.run("document.getElementById('toast').textContent"):
            print(f"skipped: {name}: this browser does not play it")
            continue
        seen = tile(page, name)
        check(f"the tile of {name} shows a frame that is not black", seen[1] > 200 and seen[0] < 60, f"{seen}")
    page.run("viewer.setContent(new TestContent('White'))")
    for name, told, arguments in (("cut.mov", "ProRes", ("-c:v", "prores_ks")), ("loop.mov", "HAP", ("-c:v", "hap")), ("cine.avi", "CineForm", ("-c:v", "cfhd", "-pix_fmt", "yuv422p10le")),
                                  ("old.mkv", "MPEG-2", ("-c:v", "mpeg2video")), ("keyed.mov", "ProRes", ("-c:v", "prores_ks", "-pix_fmt", "yuva444p10le", "-profile:v", "4444"))):
        page.drop(name, "video/quicktime" if name.endswith("mov") else "", film_of(name.split(".")[1], *arguments))
        page.wait(f"document.getElementById('toast').classList.contains('shown') && document.getElementById('toast').textContent.includes({name!r})", 60)
        said, wanted = page.message(), "libvpx-vp9" if name == "keyed.mov" else "libx264"
        check(f"{name} is refused by its name, with the line that converts it", f"is {told}," in said and f'ffmpeg -i "{name}" -c:v {wanted}' in said, said)


def check_panel_pixels(check, page):
    """Any page can be told the pixels of the real projector: its window has them, the pattern is as fine."""
    def say(width, height):
        page.run(f"for (const [id, value] of [['pixels-w', '{width}'], ['pixels-h', '{height}']]) Object.assign(document.getElementById(id), {{value}}); "
                 "document.getElementById('pixels-h').dispatchEvent(new Event('change')); idle()")

    page.run("viewer.setContent(new SolidContent('#ffffff'))")
    plain = page.run("viewer.window.picture().width")
    say(1920, 1080)
    shown = page.run("""(() => { const {width, height, bytes} = viewer.window.picture(); let lit = 0;
        for (let x = 0; x < width; x++) lit += bytes[4 * (width * 540 + x)] > 200;
        return [width, height, lit, viewer.projector.pattern.width, stateOf(viewer).projectors[0].pixels]; })()""")
    kept = page.run("checkState(viewer, plainState(stateOf(viewer))).then((state) => state.projectors[0].pixels)")
    wrong = page.run("(() => { const plain = plainState(stateOf(viewer)); plain.projectors[0].pixels = [1920, 'x']; return checkState(viewer, plain).then(() => '', (error) => error.message); })()")
    say("", "")
    back = page.run("viewer.window.picture().width")
    check("a projector's own pixels", shown == [1920, 1080, 1080, 1080, [1920, 1080]] and kept == [1920, 1080] and "pixels" in wrong and back == plain == 800, f"{shown} {kept} {wrong} {back}")


def check_first_text(check, page):
    """A text that nobody has placed lies within the object, larger than in the middle of its bounds."""
    page.run("viewer.jump(viewer.scene.views[0], true); viewer.setLayers([new Layer(new TestContent('White'))]); true")
    page.run("(() => { const text = document.getElementById('text'); text.value = 'Open'; text.dispatchEvent(new Event('input')); })()")
    inside = page.run("""(() => { const {projector, scene} = viewer, {device, layer} = projector, corners = cornersOf(layer.frame(device.width, device.height)), [a, , c] = corners;
        const on = (x, y) => { const {splats} = scene; for (let i = 0; i < splats.count; i++) { const [u, v] = project(device, [0, 1, 2].map((k) => splats.centre[3 * i + k]));
            if (splats.opacity[i] >= 0.5 && Math.hypot(u - x, v - y) < 12) return true; } return false; };
        let hit = 0, all = 0;
        for (let s = 0.05; s < 1; s += 0.1) for (let t = 0.1; t < 1; t += 0.2) all++, hit += on(a[0] + s * (c[0] - a[0]), a[1] + t * (c[1] - a[1]));
        return [hit / all, (c[0] - a[0]) / device.width]; })()""")
    page.run("viewer.setContent(new TestContent('White'))")
    back = page.run("JSON.stringify(viewer.projector.layer.place) === JSON.stringify(newPlace())")
    check("the first text lies on the object where it is widest", inside[0] > 0.97 and inside[1] > 0.25 and back, f"{inside[0]:.2f} of it on the object, {inside[1]:.2f} of the picture wide")


def check_ready(check, page, path):
    """"Drawing..." goes when the graphics driver has drawn, which may be long after the calls."""
    late = page.call("Page.addScriptToEvaluateOnNewDocument", {"source": """{ const {prototype} = WebGL2RenderingContext, real = prototype.clientWaitSync, told = window.told = {};
        prototype.clientWaitSync = function (...given) {
            told.asked = told.asked || performance.now();
            if (performance.now() - told.asked < 1500) return this.TIMEOUT_EXPIRED;
            told.early = document.body.classList.contains('ready'), told.waited = performance.now() - told.asked;
            return real.apply(this, given); }; }"""})["identifier"]
    page.start(path)
    page.call("Page.removeScriptToEvaluateOnNewDocument", {"identifier": late})
    seen = page.run("[told.early, told.waited > 1499, getComputedStyle(document.getElementById('starting')).display]")
    check("the page is ready when its driver has drawn", seen == [False, True, "none"], f"{seen}")


def check_broken(check, page):
    page.run("idle()")
    before = page.pixels()
    giant = png(1, 1, lambda x, y: (0, 0, 0))
    giant = giant[:16] + struct.pack(">II", 30000, 30000) + giant[24:]
    jpeg = b"\xff\xd8" + 3 * (b"\xff\xe1\xff\xff" + bytes(65533)) + b"\xff\xff\xc0\0\x11\x08" + struct.pack(">HH", 30000, 30000) + bytes(12)
    avif = b"\0\0\0\x14ftypavif\0\0\0\0mif1" + b"\0\0\0\x14ispe\0\0\0\0" + struct.pack(">II", 30000, 30000)
    for name, kind, data in (("notes.txt", "text/plain", b"no picture at all"), ("text.png", "image/png", b"no picture either"),
                             ("empty.png", "image/png", b""), ("giant.png", "image/png", giant), ("giant.jpg", "image/jpeg", jpeg),
                             ("giant.avif", "image/avif", avif), ("broken.webm", "video/webm", b"\x1aE\xdf\xa3 no film")):
        page.drop(name, kind, data)
        page.wait("document.getElementById('toast').classList.contains('shown')", 30)
        said = page.message()
        check(f"{name} is refused in words", name in said and ("30000 × 30000" in said) == name.startswith("giant") and
              change(before, page.pixels()) < 0.1, said)


def check_window(check, page):
    """The projector window is a page of its own."""
    page.run("viewer.setContent(new TestContent('Lollipop'))")
    page.click("#send")
    page.wait("viewer.window.isOpen")
    check("the button says that it is open", page.run("document.getElementById('send').textContent") == "The projector window is open")
    page.run("viewer.updatePatterns(); viewer.window.show(); idle()")
    page.wait("!viewer.window.drawing && !viewer.window.stale")
    page.far("window.shown = far.context().getImageData(0, 0, far.canvas.width, far.canvas.height), true")
    size, there = page.far("[[shown.width, shown.height], shown.data.reduce((text, byte) => text + String.fromCharCode(byte), '')]")
    there = there.encode("latin-1")
    same = page.run(f"""(() => {{ const a = Uint8Array.from(atob({base64.b64encode(there).decode()!r}), (c) => c.charCodeAt(0)), b = bytesOf(viewer.projector.canvas);
        let most = a.length === b.length ? 0 : 255, light = 0;
        for (let i = 0; i < a.length; i++) {{ most = Math.max(most, Math.abs(a[i] - b[i])); light += a[i]; }}
        return [most, light / a.length, ...{size}]; }})()""")
    check("the projector window shows the pattern", same[0] <= 1 and same[1] > 20, f"differs by {same[0]} of 255 at most, {same[2]} x {same[3]}")
    mean = page.run("""(() => { const p = viewer.projector, d = p.device, {context} = p;
        context.fillStyle = '#000', context.fillRect(0, 0, d.width, d.height), context.fillStyle = '#fff';
        for (let x = 2; x < d.width; x += 4) context.fillRect(x, 0, 1, d.height);
        p.pattern.set(p.canvas);
        const {data} = panelPicture(viewer.graphics, p, {width: d.width / 4, height: d.height / 4, fx: d.fx / 4, fy: d.fy / 4, cx: d.cx / 4, cy: d.cy / 4, gamma: [1, 1, 1]}, {});
        p.dirty = true;
        let sum = 0; for (let i = 0; i < data.length; i += 4) sum += data[i];
        return 4 * sum / data.length; })()""")
    check("a panel that is coarser takes means", abs(mean - 63.75) < 0.5, f"{mean:.2f} of 255 where a quarter is white")
    page.run("""Object.defineProperty(document, 'hidden', {value: true, configurable: true});
        window.frameOf = requestAnimationFrame; window.requestAnimationFrame = () => 0; document.dispatchEvent(new Event('visibilitychange'));
        viewer.setContent(new SolidContent('#00ff00')); true""")
    colour = "document.body.style.visibility === 'hidden' ? '0,0,0' : String([...far.context().getImageData(0, 0, 1, 1).data].slice(0, 3))"

    def becomes(wanted, number=None):
        """The colour of the projector's window, which follows a moment later."""
        end = time.monotonic() + 10
        while page.far(colour, number) != wanted and time.monotonic() < end:
            time.sleep(0.05)
        return page.far(colour, number)

    seen = becomes("0,255,0")
    check("the projector window goes on when the page is hidden", seen == "0,255,0", seen)
    page.run("delete document.hidden; window.requestAnimationFrame = frameOf; viewer.pending = false; "
             "document.dispatchEvent(new Event('visibilitychange')); viewer.invalidate(); idle()")
    dark = []
    press = "dispatchEvent(new KeyboardEvent('keydown', {key: '.'})), true"
    for work, wanted in ((page.run, "0,0,0"), (page.far, "0,255,0")):
        work(press)
        dark.append(becomes(wanted))
        page.run("viewer.pressed = -1e9")  # not in haste
    for wanted in ("0,0,0", "0,255,0"):
        page.click("#dark")
        dark += [becomes(wanted), page.run("document.getElementById('dark').getAttribute('aria-pressed')")]
        page.run("viewer.pressed = -1e9")
    check("blackout, and back", dark == ["0,0,0", "0,255,0", "0,0,0", "true", "0,255,0", "false"], f"{dark}")
    page.run("document.activeElement.blur(); dispatchEvent(new KeyboardEvent('keydown', {key: 't'}))")
    shown = page.run("""(() => { const {width: w, height: h, bytes} = viewer.window.picture(), at = (x, y) => bytes[4 * (w * y + x) + 1];
        const step = Math.max(16, Math.round(h / 12)), field = [0, 1, 2, 3].map((i) => at(step + 2 + i, step + 2)), colours = new Set();
        for (let i = 0; i < bytes.length; i += 4) colours.add(String(bytes.subarray(i, i + 3)));
        const own = viewer.projector.colour.match(/[0-9a-f]{2}/g).map((v) => parseInt(v, 16)).join();
        return [[at(0, 5), at(1, 5), at(5, h - 1), at(w - 1, 5)], field, colours.has(own)]; })()""")
    page.run("dispatchEvent(new KeyboardEvent('keydown', {key: 't'}))")
    pressed = []
    for wanted in ("255,255,255", "0,255,0"):
        page.click("#test")
        pressed += [becomes(wanted) == wanted, page.run("document.getElementById('test').getAttribute('aria-pressed')")]
    check("the test picture by its button, and back", pressed == [True, "true", True, "false"], f"{pressed}")
    check("a test picture of single pixels, and back", shown == [[255, 0, 255, 255], [0, 255, 0, 255], True] and becomes("0,255,0") == "0,255,0", f"{shown}")
    page.click("#add")
    page.run("viewer.setContent(new SolidContent('#ff0000')); viewer.window.open().then(idle)")
    first, other = page.run("viewer.projectors.map((p) => p.number)")
    before = [becomes("0,255,0", first), becomes("255,0,0", other), page.far("document.title.replace(/[0-9]+$/, '')", other)]
    page.click("#remove")
    end = time.monotonic() + 10
    while page.pages(f"#projector-{other}-") and time.monotonic() < end:
        time.sleep(0.05)
    after = [page.pages(f"#projector-{other}-"), page.run("viewer.window.isOpen"), becomes("0,255,0", first)]
    check("each projector has a window of its own, until it is removed", (before, after) == (["0,255,0", "255,0,0", "Projector "], [[], True, "0,255,0"]), f"{before} and then {after}")
    page.run("""(() => { const d = viewer.projector.device; viewer.scene.panel = {...d, width: 1600, height: 1200, fx: 2 * d.fx, fy: 2 * d.fy, cx: 800, cy: 600};
        viewer.addProjector(); viewer.setContent(new TestContent('White')); return viewer.window.open().then(idle); })()""")
    becomes("255,255,255")
    finer = [page.run("viewer.projector.pattern.width / viewer.projector.device.width"), *page.far("[far.canvas.width, far.canvas.height]")]
    check("a pattern is as fine as the panel", finer == [2, 1600, 1200], f"{finer}")
    placed = page.far("""(() => { const set = (name, value) => Object.defineProperty(window, name, {value, configurable: true});
        return [[1600, 1200, 1], [1280, 960, 1.25], [1300, 960, 1.25], [640, 480, 1]].map(([width, height, ratio]) => {
            set('innerWidth', width), set('innerHeight', height), set('devicePixelRatio', ratio), far.place();
            const {style} = far.canvas;
            return [style.left, style.width, style.height, style.objectFit].join(' ').trim(); }); })()""")
    check("panel pixels are the screen's at any scale", placed == ["0px 1600px 1200px", "0px 1280px 960px", "9.6px 1280px 960px", "0px 100vw 100vh contain"], f"{placed}")
    page.click("#remove")
    page.far("""(() => { const set = (name, value) => Object.defineProperty(window, name, {value, configurable: true});
        set('screenX', 1930), set('screenY', 40), set('innerWidth', 1024), set('innerHeight', 768);
        dispatchEvent(new Event('resize'));
        setTimeout(() => window.close()); return true; })()""")
    page.wait("document.getElementById('toast').textContent.includes('Press W')", 20)
    came = page.run("""(async () => { viewer.window.where.full = true;
        const state = await checkState(viewer, JSON.parse(await stageText(viewer))), real = window.open, {id, ...where} = state.projectors[0].window; let asked = '';
        window.open = (address, name, how) => { asked = how; return real(address, name, how); };
        await viewer.window.open();
        window.open = real;
        return [asked, where]; })()""")
    came.append(page.far("far.hint.textContent.slice(0, 17)"))
    check("a window that was closed comes back where it was", came == ["popup,noopener,width=1024,height=768,left=1930,top=40",
          {"left": 1930, "top": 40, "full": True, "width": 1024, "height": 768}, "Click this window"], f"{came}")
    page.run("viewer.scene.panel = null, viewer.window.close(), idle()")


def check_panel(check, page, program, ply, data, folder):
    """The panel's picture against that of `ffprocams compensate --for-device`, on a panel a third as fine."""
    scene = page.run("(() => { const {views, patterns, centre, radius, intensity} = viewer.scene; "
                     "return {view: views[2], patterns, centre, radius, intensity}; })()")
    view, rig = scene["view"], os.path.join(folder, "rig")
    os.makedirs(rig)
    pictures = {role: f"{view['id']}_all_{role}.png" for role in ("black", "white")}
    for name in pictures.values():
        shutil.copy(os.path.join(data, name), rig)
    rows = lambda pose: [pose[4 * r:4 * r + 4] for r in range(4)]
    flat = lambda device: {key: device[key] for key in ("width", "height", "fx", "fy", "cx", "cy")}
    ideal = view["projector"]
    panel = {"width": 260, "height": 240, "fx": ideal["fx"] / 3, "fy": ideal["fy"] / 3.5, "cx": 130, "cy": 118,
             "lens": [0.1, -0.05, 0.01, -0.005, 0.02], "gamma": [2.2, 2, 1.8]}
    with open(os.path.join(rig, "scene.json"), "w", encoding="utf-8") as file:
        json.dump({"format": "ffprocams-capture", "version": 1, "object": {"centre": scene["centre"], "radius": scene["radius"]},
                   "camera": flat(view["camera"]), "projector": {**flat(ideal), "intensity": scene["intensity"], "device": panel},
                   "patterns": [{"name": role, "role": role} for role in pictures],
                   "views": [{"id": view["id"], "c2w": rows(view["camera"]["pose"]), "p2w": rows(ideal["pose"]), "images": pictures}]}, file)
    for name, more in (("plain", []), ("sent", ["--for-device"])):
        subprocess.run([program, "compensate", ply, "--capture", rig, "--view", view["id"], "--target", os.path.join(data, "..", "sun.png"),
                        "--steps", "0", "--gaussians-only", "-o", os.path.join(folder, name + ".png"), *more], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    with open(os.path.join(folder, "plain.png"), "rb") as file:
        pattern = base64.b64encode(file.read()).decode()
    page.run("viewer.jump(viewer.scene.views[2], true)")
    made = base64.b64decode(page.run(f"""(async () => {{
        const p = viewer.projector, bytes = Uint8Array.from(atob({pattern!r}), (c) => c.charCodeAt(0));
        p.context.drawImage(await createImageBitmap(new Blob([bytes]), {{colorSpaceConversion: 'none'}}), 0, 0);
        p.pattern.set(p.canvas);
        p.dirty = true;
        const {{data}} = panelPicture(viewer.graphics, p, {json.dumps(panel)}, {{}});
        let text = ''; for (let i = 0; i < data.length; i += 8192) text += String.fromCharCode(...data.subarray(i, i + 8192));
        return btoa(text); }})()"""))
    width, height, wanted = read_png(os.path.join(folder, "sent.png"))
    score = psnr(made, wanted, 4)
    check("the panel's picture as compensate --for-device makes it", (width, height) == (260, 240) and score > 45, f"{score:.2f} dB")


STILL = "Promise.all(document.getAnimations().map((a) => a.finished.catch(() => {}))).then(() => true)"

# Tools and panel that leave the window or lie on each other, and controls that leave them.
OUTSIDE = """(() => { const out = [], rect = (e) => e.getBoundingClientRect(), named = (e) => e.id || e.title || e.textContent.trim();
    const within = (e, box) => { const r = rect(e); if (!r.width || r.left < box.left - 0.5 || r.right > box.right + 0.5 ||
        r.top < box.top - 0.5 || r.bottom > box.bottom + 0.5) out.push(named(e)); };
    const page = {left: 0, top: 0, right: innerWidth, bottom: innerHeight}, tools = document.getElementById('tools'), panel = document.getElementById('panel');
    for (const e of [tools, panel, ...tools.querySelectorAll('button')]) if (e.checkVisibility()) within(e, page);
    for (const e of panel.querySelectorAll('button, input, select, .row')) // what lies in strips is scrolled to
        if (e.checkVisibility() && !e.closest('.strip')) within(e, {...{left: rect(panel).left, right: rect(panel).right}, top: -1e9, bottom: 1e9});
    const a = rect(tools), b = rect(panel);
    if (a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom) out.push('tools and panel overlap');
    return out; })()"""

# Parts of the page that a message covers, GO where it is not at hand however far the panel is scrolled, a blackout without its label.
LONGEST = "Armed: Space or Enter is GO. Corrections keep the place that you look from now. No projector window is open."
COVERED = """(() => { const rect = (id) => document.getElementById(id).getBoundingClientRect(), meets = (a, b) => a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
    const toast = rect('toast'), panel = document.getElementById('panel'), out = ['panel', 'tools', 'held'].filter((id) => meets(toast, rect(id)));
    panel.scrollTop = 1e6;
    const {left, top, width, height} = rect('go'), reached = document.elementFromPoint(left + width / 2, top + height / 2);
    if (reached !== document.getElementById('go')) out.push('GO is not at hand');
    panel.scrollTop = 0;
    if (document.getElementById('held').textContent !== 'Blackout, Test picture' || rect('held').width < 40) out.push('no blackout');
    return out; })()"""

# The least contrast of texts, as WCAG 2 counts it.
CONTRAST = """(() => { const style = (e) => getComputedStyle(e), root = style(document.documentElement);
    const probe = document.createElement('i'); document.body.append(probe);
    const light = (colour) => { probe.style.color = colour; const c = style(probe).color.match(/[0-9.]+/g).slice(0, 3).map((v) => v / 255)
        .map((v) => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4); return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]; };
    const ratio = (a, b) => { const [x, y] = [light(a), light(b)]; return (Math.max(x, y) + 0.05) / (Math.min(x, y) + 0.05); };
    const told = (name) => root.getPropertyValue(name).trim(), found = {}, wide = style(document.getElementById('send')), about = style(document.getElementById('about'));
    found.button = ratio(wide.color, wide.backgroundColor);
    for (const name of ['--stage-near', '--stage-far']) found['about on ' + name] = ratio(about.color, told(name));
    const tab = document.querySelector('#projectors .chosen'), dot = tab.style.getPropertyValue('--dot');
    tab.style.transition = 'none';
    for (const colour of PROJECTOR_COLOURS) { tab.style.setProperty('--dot', colour); found['tab ' + colour] = ratio(style(tab).color, style(tab).backgroundColor); }
    tab.style.setProperty('--dot', dot);
    probe.remove();
    return found; })()"""


def check_access(check, page):
    """Names and states for those who do not see them, contrast for those who see little."""
    page.run("viewer.setContent(new TestContent('White')); document.body.classList.add('with-panel'); for (const d of document.querySelectorAll('details')) d.open = true; true")
    nodes = page.call("Accessibility.getFullAXTree")["nodes"]
    value = lambda node, key: node.get(key, {}).get("value", "")
    controls = [n for n in nodes if not n.get("ignored") and
                value(n, "role") in ("button", "checkbox", "slider", "ColorWell", "combobox", "textbox", "switch", "MenuListPopup", "PopUpButton")]
    nameless = [value(n, "role") for n in controls if value(n, "role") != "MenuListPopup" and not value(n, "name")]
    check("every control has a name", len(controls) > 40 and not nameless, f"{len(controls)} controls; without: {' '.join(nameless) or 'none'}")
    pressed = page.run("['views', 'contents', 'projectors'].map((id) => [...document.getElementById(id).children].filter("
                       "(b) => b.getAttribute('aria-pressed') === 'true').length)")
    check("what is chosen is said", pressed == [1, 1, 1], f"{pressed}")
    for scheme in ("dark", "light"):
        page.scheme(scheme)
        found = page.run(CONTRAST)
        least = min(found, key=found.get)
        check(f"contrast, {scheme}", found[least] >= 4.5, f"{found[least]:.2f} at least: {least}")
    page.run("document.body.classList.remove('with-panel'); " + STILL)


def check_looks(check, page, folder):
    for name, width, height, scale, mobile, scheme in (("wide", 1400, 900, 1, False, "dark"), ("phone", 400, 800, 2, True, "light")):
        page.resize(width, height, scale, mobile)
        page.run(f"document.body.classList.toggle('with-panel', {str(not mobile).lower()}); "
                 "document.getElementById('toast').classList.remove('shown')")
        page.scheme(scheme)
        page.run("viewer.invalidate(); idle()")
        page.screenshot(os.path.join(folder, f"{name}-{scheme}.png"))
        page.hold(True)
        page.run("document.body.classList.remove('with-panel')")
        page.run(STILL)
        sliding = page.run("(async () => { togglePanel(viewer); const early = viewer.screenCamera(); await " + STILL +
                           "; const late = viewer.screenCamera(); return Math.hypot(early.cx - late.cx, early.cy - late.cy); })()")
        check(f"the picture stands still while the panel slides in, {name}", sliding < 1e-6, f"moves by {sliding:.1f} pixels")
        page.screenshot(os.path.join(folder, f"{name}-panel.png"))
        outside = page.run(OUTSIDE)
        check(f"the page fits {width} pixels", not outside, "; ".join(outside))
        page.hold(False)
    page.run("viewer.show.add(), viewer.dark = viewer.test = true, viewer.changed('windows')")
    for width, height in ((1400, 900), (980, 760), (400, 800)):  # the second in the studio
        page.resize(width, height, 1, width == 400)
        page.run(f"document.body.classList.add('with-panel'), say({LONGEST!r}), viewer.invalidate(), idle().then(() => {STILL})")
        page.screenshot(os.path.join(folder, f"show-{width}.png"))
        covered = page.run(COVERED)
        check(f"messages cover no control, GO is at hand and a blackout is seen at {width} pixels", not covered, "; ".join(covered))
    page.run("viewer.show.cues = [], viewer.dark = viewer.test = false, viewer.changed('windows'), document.body.classList.remove('with-panel')")
    check("they go", page.run("document.getElementById('held').hidden && document.getElementById('go-bar').hidden"))
    page.resize(520, 400)


def check_no_webgl(check, program, path, folder):
    page = browser.Browser(program, 800, 600, ["--disable-gpu", "--disable-webgl", "--disable-3d-apis"])
    try:
        page.open(path)
        page.wait("document.readyState === 'complete' && !!window.ready")
        page.run("window.ready")
        said = page.run("document.getElementById('failure').hidden ? '' : document.getElementById('failure').textContent.trim()")
        page.screenshot(os.path.join(folder, "no-webgl.png"))
        check("without WebGL 2 the page says so", "WebGL 2" in said, said.replace("\n", " "))
    finally:
        page.close()


def main():
    program, data = sys.argv[1:3]
    chromium = browser.find()
    if not chromium:
        print("skipped: no Chromium here")
        return 77
    check = Checks()
    with tempfile.TemporaryDirectory() as scratch:
        folder = sys.argv[3] if len(sys.argv) > 3 else scratch
        os.makedirs(folder, exist_ok=True)
        ply, path = os.path.join(scratch, "spot.ply"), os.path.join(folder, "spot.html")
        subprocess.run([program, "reconstruct", data, "-o", ply, "--polish", "0"], check=True, stdout=subprocess.DEVNULL)
        subprocess.run([program, "view", ply, "--capture", data, "--poses", os.path.join(data, "targets.json"), "-o", path],
                       check=True, stdout=subprocess.DEVNULL)
        check("the page's size", os.path.getsize(path) < 6e6, f"{os.path.getsize(path) / 1e6:.1f} MB")
        page = Page(chromium, 520, 400) # small: every pixel is drawn in software
        try:
            page.start(path)
            check_pictures(check, page, program, ply, data, scratch)
            check_halves(check, page)
            check_maps(check, page, program, ply, data, scratch)
            check_compensation(check, page, program, ply, data, scratch)
            check_sharing(check, page)
            check_controls(check, page)
            check_photograph(check, page, folder)
            check_comparison(check, page)
            page.samples(1)
            check_keys(check, page)
            check_turning(check, page)
            check_walking(check, page)
            check_targets(check, page)
            check_contents(check, page, folder)
            check_films(check, page)
            check_panel_pixels(check, page)
            check_first_text(check, page)
            check_broken(check, page)
            check_window(check, page)
            check_panel(check, page, program, ply, data, scratch)
            check_memory(check, page)
            check_looks(check, page, folder)
            check_access(check, page)
            check_undo(check, page)
            check_place(check, page)
            check_surfaces(check, page, folder)
            check_cues(check, page)
            check_go_bar(check, page)
            check_midi(check, page)
            check_nudge(check, page)
            check_letters(check, page, folder)
            check_touch(check, page, folder)
            check_same_ids(check, page, path, scratch)
            check_kept(check, page, path, scratch)
            check_ready(check, page, path)
            check("nothing in the console", not page.console, "; ".join(page.console)[:600])
            away = [url for url in page.requests if not url.startswith(("file:", "blob:", "data:", "about:"))]
            check("no request leaves the page", not away, " ".join(away))
        finally:
            page.close()
        check_no_webgl(check, chromium, path, folder)
    print(f"{check.failed} failed" if check.failed else "all passed")
    return 1 if check.failed else 0


if __name__ == "__main__":
    sys.exit(main())
