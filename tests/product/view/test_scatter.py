#!/usr/bin/env python3
"""The page of splats that scatter light, under a projector whose light spreads: its pictures against those of `ffprocams render`,
its corrections against `compensate`'s.

    test_scatter.py PROGRAM DATA

Exits with 77 and a line where there is no browser."""
import json
import os
import re
import struct
import subprocess
import sys
import tempfile

import browser
from test_view import LEAST, Checks, Page, check_closed_form, png, psnr, read_png

VIEWS = ("path_0_theta000", "path_0_theta135")
SPREAD = {"share": [0.25, 0.2, 0.1], "deviation": 26.0}


def run(*command):
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)


def scattering(ply, out):
    """The same Gaussians with scattered light, more of it towards one side, and reddish."""
    data = open(ply, "rb").read()
    end = data.index(b"end_header\n")
    head, rows = data[:end], data[end + 11:]
    n, width = int(re.search(rb"element vertex (\d+)", head)[1]), 4 * head.count(b"property float")
    with open(out, "wb") as file:
        file.write(head + b"".join(b"property float scattered_%d\n" % k for k in range(3)) + b"end_header\n")
        for i in range(n):
            row = rows[width * i:width * (i + 1)]
            x, y, z = struct.unpack_from("<3f", row)
            strength = max(0.0, 0.04 + 0.04 * z + 0.03 * (x if i % 2 else y))
            file.write(row + struct.pack("<3f", strength, 0.8 * strength, 0.5 * strength))


def scene_of(page):
    return json.loads(re.search(r'id="scene">(.*?)</script>', open(page, encoding="utf-8").read(), re.DOTALL)[1])


def capture_with_spread(scene, data, out):
    """The sample's views as scene.json, with a projector whose light spreads."""
    os.symlink(os.path.abspath(data), os.path.join(out, "sample"))
    device = lambda d, *keys: {key: d[key] for key in ("width", "height", "fx", "fy", "cx", "cy", *keys)}
    rows = lambda pose: [pose[4 * k:4 * k + 4] for k in range(4)]
    first = scene["views"][0]
    roles = [{"name": p["name"], "role": p["role"], **({} if p["role"] in ("black", "white") else {"file": f"sample/patterns/{p['name']}.png"})}
             for p in scene["patterns"]]
    views = [{"id": v["id"], "c2w": rows(v["camera"]["pose"]), "p2w": rows(v["projector"]["pose"]),
              "images": {p["name"]: f"sample/{v['id']}_{p['name']}.png" for p in scene["patterns"]}} for v in scene["views"] if v["id"] in VIEWS]
    with open(os.path.join(out, "scene.json"), "w", encoding="utf-8") as file:
        json.dump({"format": "ffprocams-capture", "version": 1, "name": "spot", "object": {"centre": scene["centre"], "radius": scene["radius"]},
                   "camera": device(first["camera"]), "patterns": roles, "views": views,
                   "projector": {**device(first["projector"]), "intensity": scene["intensity"], "device": {**device(first["projector"]), "spread": SPREAD}}}, file)


def check_pictures(check, page, program, ply, capture, sharp):
    """Under patterns that hold the spread, and under a picture that does not; then what is missing without either."""
    run(program, "render", ply, "--capture", capture, "-o", capture, "--pattern=all_white", "--pattern=lollipop_3", f"--pattern={sharp}")
    page.hold(True)
    scores = {}
    for view in VIEWS:
        page.run(f"viewer.jump(viewer.scene.views.find((v) => v.id === {view!r}), true)")
        for name in ("all_white", "lollipop_3", "sharp"):
            if name != "sharp":
                page.run(f"(async () => viewer.setContent(await patternContent(viewer.scene, viewer.scene.patterns.findIndex((p) => p.name === {name!r}))))()")
            else:
                page.drop("sharp.png", "image/png", open(sharp, "rb").read())
                page.wait("viewer.projector.content.name === 'sharp.png'")
            width, height, wanted = read_png(os.path.join(capture, f"{view}_{name}.png"))
            seen = page.pixels(width, height)
            scores[view, name] = psnr(seen, wanted, 4)
    check("pictures as ffprocams render draws them", min(scores.values()) >= LEAST, " ".join(f"{name} {s:.1f}" for (_, name), s in scores.items()) + " dB")
    page.run("viewer.projector.spread = null")
    flat = page.pixels(width, height)
    check("a user's picture spreads", psnr(flat, wanted, 4) < 45, f"{psnr(flat, wanted, 4):.1f} dB without")
    page.run(f"viewer.projector.spread = {json.dumps(SPREAD)}; viewer.projector.dirty = true")
    without = page.run("(() => { const r = viewer.renderer; r.scatters = false; viewer.graphics.defines = ''; viewer.graphics.programs.clear(); r.view = new GbufferView(r); return true; })()")
    flat = page.pixels(width, height)
    check("scattered light is seen", without and psnr(flat, wanted, 4) < 40, f"{psnr(flat, wanted, 4):.1f} dB without")
    page.run("(() => { const r = viewer.renderer; r.scatters = true; viewer.graphics.defines = '#define SCATTERS\\n'; viewer.graphics.programs.clear(); r.view = new GbufferView(r); viewer.projector.spreadKey = ''; })()")
    check("and is there again", psnr(page.pixels(width, height), wanted, 4) >= LEAST)
    found = page.run("""(() => { const r = viewer.renderer, g = viewer.graphics, {gl} = g, {draws} = g, {sumFormat} = r, found = [];
        for (const most of [64, 40, 0]) { // bytes of a pixel that a driver draws into at most
            g.draws = (formats) => formats.reduce((sum, f) => sum + (f === gl.RGBA32F ? 16 : 8), 0) <= most;
            found.push([r.findFifth(), r.sumFormat === gl.RGBA16F]), r.sumFormat = sumFormat; }
        g.draws = draws;
        return found; })()""")
    check("drivers that draw into less", found == [[True, True], [True, True], [False, False]], found)
    page.hold(False)


def check_compensation(check, page, program, ply, capture, folder):
    """Both forms against compensate's, which subtracts scattered light and takes the spread back, of a target without edges."""
    target, view = os.path.join(folder, "sky.png"), VIEWS[0]
    with open(target, "wb") as file:
        file.write(png(128, 128, lambda x, y: (90 + x, 100 + y, 220 - (x + y) // 2)))
    page.run(f"viewer.jump(viewer.scene.views.find((v) => v.id === {view!r}), true)")
    option = page.run(f"[...document.getElementById('watcher').options].find((o) => o.textContent === viewName(viewer.scene.views.find((v) => v.id === {view!r}))).value")
    page.drop("sky.png", "image/png", open(target, "rb").read())
    page.wait("viewer.projector.content.name === 'sky.png'")
    page.hold(True)
    for how, least in (("paint", 40), ("colours", 28)):
        page.set("correction", how)
        page.set("watcher", option)
        check_closed_form(check, page, program, ply, capture, folder, view, target, how, least)
    seen, (_, _, wanted) = page.pixels(128, 128), read_png(target)
    page.run("viewer.projector.correction = 'none'; viewer.setContent(new SolidContent('#fff'))")
    white = page.pixels(128, 128)
    page.run("viewer.setContent(new SolidContent('#000'))")
    black = page.pixels(128, 128)
    off = sorted(abs(seen[4 * i + k] - wanted[3 * i + k]) for i in range(128 * 128) for k in range(3)
                 if seen[4 * i + 3] == 255 and black[4 * i + k] + 40 < wanted[3 * i + k] < white[4 * i + k] - 10)
    check("what is asked for is seen", len(off) > 500 and off[len(off) // 2] < 4, f"off by {off[len(off) // 2]} of 255 in the median, {off[9 * len(off) // 10]} at the 90th percentile, {len(off)} values")
    page.hold(False)


def main():
    program, data = sys.argv[1:3]
    chromium = browser.find()
    if not chromium:
        print("skipped: no Chromium here")
        return 77
    check = Checks()
    with tempfile.TemporaryDirectory() as scratch:
        plain, ply, path, capture = (os.path.join(scratch, name) for name in ("plain.ply", "spot.ply", "spot.html", "capture"))
        os.mkdir(capture)
        run(program, "reconstruct", data, "-o", plain, "--polish", "0")
        run(program, "view", plain, "--capture", data, "-o", path)
        capture_with_spread(scene_of(path), data, capture)
        scattering(plain, ply)
        run(program, "view", ply, "--capture", capture, "-o", path)
        sharp = os.path.join(scratch, "sharp.png")
        with open(sharp, "wb") as file:
            file.write(png(800, 800, lambda x, y: (255, 255, 255) if (x // 40 + y // 40) % 2 else (20, 60 + x // 8, 0)))
        page = Page(chromium, 520, 400)
        try:
            page.start(path)
            check_pictures(check, page, program, ply, capture, sharp)
            check_compensation(check, page, program, ply, capture, scratch)
            check("nothing in the console", not page.console, "; ".join(page.console)[:600])
        finally:
            page.close()
    print(f"{check.failed} failed" if check.failed else "all passed")
    return 1 if check.failed else 0


if __name__ == "__main__":
    sys.exit(main())
