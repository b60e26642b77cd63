#!/usr/bin/env python3
"""Faults of rooms, put into photographs of a room one at a time: the messages of `import` and `info` on each, and what it does to the masks.

    bench/room_faults.py ROOM FFPROCAMS WORK [--width 240]

ROOM: as `ffprocams generate ROOM --photographs PATTERNS --room --seed N` writes it, with empty/ and masks/; FFPROCAMS: the program; WORK: a new folder.
Prints a table in Markdown: pixels of the true masks that are missing, and those too many, in percent of the object, and the messages that
the sound room does not get. Needs numpy and Pillow.
"""
import argparse
import json
import pathlib
import shutil
import subprocess

import numpy as np
from PIL import Image

parser = argparse.ArgumentParser()
parser.add_argument("room", type=pathlib.Path)
parser.add_argument("program")
parser.add_argument("work", type=pathlib.Path)
parser.add_argument("--width", default="240")
arguments = parser.parse_args()
room, work = arguments.room.resolve(), arguments.work.resolve()
axis = json.loads((room / "axis.json").read_text())
names, stops, odd = ["black", "white", "lollipop_0"], [f"{t:03d}" for t in range(0, 360, 45)], "090"
turntable = ",".join(repr(float(v)) for v in [*axis["axis"], *axis["point"], *map(int, stops)])


def block(picture, colour, left, top, right, bottom):
    """A thing in the picture; its place in shares of the sides."""
    h, w = picture.shape[:2]
    picture[int(top * h):int(bottom * h), int(left * w):int(right * w)] = colour
    return picture


def brighter(picture, factor=1.0, plus=0.0):
    linear = (picture / 255.0)**2.2
    return 255 * np.clip(factor * linear + plus, 0, 1)**(1 / 2.2)


# Each takes the folder ("empty" or a stop), the pattern and the picture.
FAULTS = {
    "none": lambda f, n, p: p,
    "a hand beside the object, one stop under white": lambda f, n, p: block(p, (190, 140, 110), 0, .5, .3, .7) if (f, n) == (odd, "white") else p,
    "the same, under the pattern": lambda f, n, p: block(p, (190, 140, 110), 0, .5, .3, .7) if (f, n) == (odd, "lollipop_0") else p,
    "a hand before the object, one stop under the pattern": lambda f, n, p: block(p, (190, 140, 110), .4, .4, .6, .7) if (f, n) == (odd, "lollipop_0") else p,
    "a hand in the empty stage under white": lambda f, n, p: block(p, (190, 140, 110), .3, .3, .5, .6) if (f, n) == ("empty", "white") else p,
    "a lamp from the fourth stop on": lambda f, n, p: brighter(p, 1, .05) if f != "empty" and f >= "135" else p,
    "one stop exposed for 1.35 times as long": lambda f, n, p: brighter(p, 1.35) if f == odd else p,
    "the empty stage exposed for half as long": lambda f, n, p: brighter(p, .5) if f == "empty" else p,
    "camera bumped at one stop": lambda f, n, p: np.roll(p, (6, 9), (0, 1)) if f == odd else p,
    "empty stage photographed from another place": lambda f, n, p: np.roll(p, (12, 20), (0, 1)) if f == "empty" else p,
    "a bright window in all pictures": lambda f, n, p: block(p, 235, .8, .05, .97, .25),
    "a window that opens after the empty stage": lambda f, n, p: p if f == "empty" else block(p, 235, .8, .05, .97, .25),
    "a mirror that shows the object beside it": lambda f, n, p: p if f == "empty" else mirror(p),
    "a cup put down after the empty stage": lambda f, n, p: p if f == "empty" else block(p, brighter(p, 1.8)[int(.7 * p.shape[0]), int(.8 * p.shape[1])], .8, .6, .87, .75),
}


def mirror(picture):
    w = picture.shape[1]
    out = picture.copy()
    out[:, int(.75 * w):int(.95 * w)] = .7 * picture[:, int(.4 * w):int(.6 * w)][:, ::-1][:, :int(.95 * w) - int(.75 * w)]
    return out


def put(fault, into):
    for folder in ["empty", *stops]:
        source = room / "empty" if folder == "empty" else room / "photographs" / folder
        (into / folder).mkdir(parents=True)
        for name in names:
            found = next(source.glob(f"*{name}.*"))
            picture = np.asarray(Image.open(found).convert("RGB"), float).copy()
            Image.fromarray(np.clip(FAULTS[fault](folder, name, picture), 0, 255).astype(np.uint8)).save(into / folder / f"{name}.png")


def said_by(*command):
    run = subprocess.run([arguments.program, *map(str, command)], capture_output=True, text=True)
    text = run.stdout + run.stderr
    lines = [line.replace("ffprocams: ", "").strip() for line in text.splitlines()]
    return run.returncode, [line for line in lines if line.startswith(("warning", "error", "->"))]


def masks_of(capture):
    out = {}
    for view in json.loads((capture / "scene.json").read_text())["views"]:
        out[view["id"]] = np.asarray(Image.open(capture / view["images"]["white"]).convert("RGBA"))[..., 3] > 127
    return out


def take(photographs, out, *more):
    lollipop = next((room / "patterns").glob("*lollipop_0.png"))
    return said_by("import", "-c", room / "calibration.xml", "-t", turntable, *[x for n in names for x in ("-i", f"{n}={photographs}/{{view}}/{n}.png")],
                   "-p", f"lollipop_0={lollipop}", "-w", arguments.width, "--name", "rig", "-o", out, *more)


work.mkdir(parents=True)
usual, truth = set(), None
print("| fault | missing / surplus | said |\n|---|---|---|")
for fault in FAULTS:
    here = work / "fault"
    shutil.rmtree(here, ignore_errors=True)
    put(fault, here / "photographs")
    if truth is None:
        take(here / "photographs", here / "true", "-m", f"{room}/masks/{{view}}.png")
        truth = masks_of(here / "true")
    status, said = take(here / "photographs", here / "capture", *[x for n in names for x in ("--empty", f"{n}={here}/photographs/empty/{n}.png")])
    share = "refused"
    if status == 0:
        said += said_by("info", here / "capture")[1]
        made = masks_of(here / "capture")
        area = sum(m.sum() for m in truth.values())
        share = " / ".join(f"{100 * sum(pixels) / area:.1f}" for pixels in ([(truth[v] & ~made[v]).sum() for v in truth], [(made[v] & ~truth[v]).sum() for v in truth])) + " %"
    if fault == "none":
        usual = {line[:40] for line in said}
    print(f"| {fault} | {share} | {'; '.join(line for line in said if line[:40] not in usual) or 'nothing'} |", flush=True)
