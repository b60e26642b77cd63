#!/usr/bin/env python3
"""Faults of rooms, put into photographs of a room one at a time: what `import`, `info` and `reconstruct` find in each, by code, and what it costs.

    bench/room_faults.py ROOM PATTERNS FFPROCAMS WORK [--width 240] [--only WORDS]..

ROOM: as `ffprocams generate ROOM --photographs PATTERNS --room --seed N` writes it, with one lollipop; FFPROCAMS: the program; WORK: a new folder.
Prints a table in Markdown: pixels of the true masks that are missing, and those too many, in percent of the object; by how many dB the
object's pixels at two new turns (three patterns, without noise) are worse than in the sound room; and the findings that the sound room
does not get. Where the fault is the object's own look (RENDERED), its truth is the new turns with the same look, and what is printed is
the dB there, and the dB with true masks of the same photographs: another object's dB say nothing next to the sound room's. Where it
moves (SLIPPED), the truth is where it stood first, and views after the slip have the poses that were noted, which are no longer right:
poses that are wrong by the displacement are the same fault as an object that moved, light and all; masks are those of the sound room.
Faults of the void (VOID) have no empty stage and no room, and are compared with the sound void. Needs numpy and Pillow.
"""
import argparse
import functools
import json
import pathlib
import shutil
import subprocess
import tempfile

import numpy as np
from PIL import Image, ImageFilter

parser = argparse.ArgumentParser()
parser.add_argument("room", type=pathlib.Path)
parser.add_argument("patterns", type=pathlib.Path)
parser.add_argument("program")
parser.add_argument("work", type=pathlib.Path)
parser.add_argument("--width", default="240")
parser.add_argument("--only", action="append", default=[], help="faults whose names contain this (and none); may be repeated")
arguments = parser.parse_args()
room, work = arguments.room.resolve(), arguments.work.resolve()
truth = json.loads((room / "truth.json").read_text())
TURNS = ["022", "157"]  # without noise
names, stops, odd = ["black", "white", "lollipop_0"], [f"{t:03d}" for t in range(0, 360, 45)], "090"


def turntable(angles):
    return ",".join(repr(float(v)) for v in [*truth["axis"], *truth["point"], *angles])


@functools.lru_cache(None)
def photograph(folder, name):
    top, place = room / ("truth" if folder in TURNS else ""), folder if folder == "empty" else f"view-{folder}"
    if name not in names:
        place, number = f"held-out/{place}", name
    else:
        number = f"{names.index(name) + 1:03d}"
    return np.asarray(Image.open(next((top / place).glob(f"{number}.*"))).convert("RGB"), float)


@functools.lru_cache(None)
def mask(folder):
    return (np.asarray(Image.open(room / "masks" / f"view-{folder}.png").convert("L"), float) / 255)[..., None]


def block(picture, colour, left, top, right, bottom):
    """A thing in the picture; its place in shares of the sides."""
    h, w = picture.shape[:2]
    picture[int(top * h):int(bottom * h), int(left * w):int(right * w)] = colour
    return picture


def brighter(picture, factor=1.0, plus=0.0):
    linear = (picture / 255.0)**2.2
    return 255 * np.clip(factor * linear + plus, 0, 1)**(1 / 2.2)


def linear(picture):
    return (picture / 255.0)**2.2


def encoded(light):
    return 255 * np.clip(light, 0, 1)**(1 / 2.2)


def blended(folder, thing):
    """The picture with another thing where the object is."""
    return lambda picture: mask(folder) * thing + (1 - mask(folder)) * picture


def like_the_wall(folder, name, picture):
    """The object's colours and shading give way to the wall's mean white: what is left is the pattern on it."""
    black, white = linear(photograph(folder, "black")), linear(photograph(folder, "white"))
    stage = linear(photograph("empty", "white")) - linear(photograph("empty", "black"))
    wall = np.median(stage[stage.mean(-1) > .02], 0)
    lit = white - black > .02
    share = np.where(lit, (linear(picture) - black) / np.maximum(white - black, .02), 0)
    return blended(folder, encoded(black + share * wall * .9))(picture)


def blurred(picture, radius):
    return np.asarray(Image.fromarray(np.clip(picture, 0, 255).astype(np.uint8)).filter(ImageFilter.GaussianBlur(radius)), float)


def noisy(picture):
    return picture + np.random.default_rng(1).normal(0, 1, picture.shape)


def half(picture, factor):
    out = picture.copy()
    w = picture.shape[1]
    out[:, :w // 2] = encoded(factor * linear(picture[:, :w // 2]))
    return out


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
    "the empty stage from a little farther (by half a percent of the width)": lambda f, n, p: np.roll(p, max(1, round(.005 * p.shape[1])), 1) if f == "empty" else p,
    "a lamp switched on after the empty stage": lambda f, n, p: p if f == "empty" else brighter(p, 1, .05),
    "a weak lamp switched on after the empty stage": lambda f, n, p: p if f == "empty" else brighter(p, 1, .01),
    "the room's light out after the empty stage": lambda f, n, p: p if f == "empty" else encoded(linear(p) - .9 * linear(photograph("empty", "black"))),
    "the table not turned before one stop": lambda f, n, p: noisy(photograph("045", n)) if f == odd else p,
    "the object slipped from the fifth stop on, by 3 % of the width": lambda f, n, p: p,
    "a black object": lambda f, n, p: p if f == "empty" else blended(f, encoded(.08 * linear(p)))(p),
    "an object as bright as the wall": lambda f, n, p: p if f == "empty" else like_the_wall(f, n, p),
    "camera out of focus at one stop": lambda f, n, p: blurred(p, .006 * p.shape[1]) if f == odd else p,
    "somebody's shadow over half of one stop": lambda f, n, p: half(p, .4) if f == odd else p,
    "the empty stage's black and white exchanged": lambda f, n, p: photograph(f, {"black": "white", "white": "black"}.get(n, n)) if f == "empty" else p,
    "one stop's angle noted 5 degrees wrong": lambda f, n, p: p,
    "(void) none": lambda f, n, p: mask(f) * p,
    "(void) one stop exposed for 1.2 times as long": lambda f, n, p: mask(f) * (brighter(p, 1.2) if f == odd else p),
    "(void) camera bumped at one stop": lambda f, n, p: np.roll(mask(f) * p, (6, 9), (0, 1)) if f == odd else mask(f) * p,
}
RENDERED = {"a black object", "an object as bright as the wall"}
SLIPPED = {"the object slipped from the fifth stop on, by 3 % of the width": (4, .03)}  # first stop after, and how far
ANGLES = {"one stop's angle noted 5 degrees wrong": [int(s) + 5 * (s == odd) for s in stops]}


def mirror(picture):
    w = picture.shape[1]
    out = picture.copy()
    out[:, int(.75 * w):int(.95 * w)] = .7 * picture[:, int(.4 * w):int(.6 * w)][:, ::-1][:, :int(.95 * w) - int(.75 * w)]
    return out


def put(fault, into):
    for folder in stops if fault.startswith("(void)") else ["empty", *stops]:
        (into / folder).mkdir(parents=True)
        for name in names:
            picture = FAULTS[fault](folder, name, photograph(folder, name).copy())
            Image.fromarray(np.clip(picture, 0, 255).astype(np.uint8)).save(into / folder / f"{name}.png")


def said_by(*command):
    """Its status, and the codes of its doubts and faults with their views; an error without a code in its words."""
    with tempfile.TemporaryFile() as file:
        run = subprocess.run([arguments.program, "--events", str(file.fileno()), *map(str, command)], pass_fds=[file.fileno()], capture_output=True, check=False)
        file.seek(0)
        events = [json.loads(line) for line in file]
    found = [event["finding"] for event in events if event["event"] == "finding"]
    said = [" ".join(["`%s`" % f["code"], *(f[k] for k in ("view", "other") if k in f)]) for f in found if f["severity"] in ("doubt", "fault")]
    return run.returncode, said + ["`%s`" % e["code"] if "code" in e else e["text"] for e in events if e["event"] == "error" and not e["fault"]]


def masks_of(capture):
    return [np.asarray(Image.open(capture / view["images"]["white"]).convert("RGBA"))[..., 3] > 127 for view in json.loads((capture / "scene.json").read_text())["views"]]


def take(photographs, out, angles, *more):
    """Imports the stops, from links that are named by the angles."""
    links = out.parent / f"{out.name}-links"
    links.mkdir()
    for stop, angle in zip(stops, angles):
        (links / f"{angle:03d}").symlink_to(photographs / stop)
    return said_by("import", "-c", room / "truth.json", "-t", turntable(angles), *[x for n in names for x in ("-i", f"{n}={links}/{{view}}/{n}.png")],
                   "-p", f"lollipop_0={arguments.patterns}/003_lollipop_0.png", "-w", arguments.width, "--name", "rig", "-o", out, *more)


def slip(capture, first, share):
    """The object on the platter: from view `first` on, devices are noted where they stand beside the object as it stood before."""
    scene = json.loads((capture / "scene.json").read_text())
    views = scene["views"]
    centres = [np.array(v["c2w"])[:3, 3] for v in views]
    along = centres[len(views) // 2] - centres[0]
    width = int(arguments.width) / scene["camera"]["fx"] * np.linalg.norm(centres[0])  # of the picture, where the object is
    for view in views[first:]:
        for pose in ("c2w", "p2w"):
            matrix = np.array(view[pose])
            matrix[:3, 3] += share * width * along / np.linalg.norm(along)
            view[pose] = matrix.tolist()
    (capture / "scene.json").write_text(json.dumps(scene))


def make_truth(out, fault="none"):
    """Two turns that are not photographed, without noise, under white and two other patterns."""
    held = sorted(f.stem for f in (room / "held-out").glob("*.png"))
    (out / "masks").mkdir(parents=True)
    for turn in TURNS:
        (out / "views" / turn).mkdir(parents=True)
        for pattern in ["black", "white", *held]:
            picture = FAULTS[fault](turn, pattern, photograph(turn, pattern).copy())
            Image.fromarray(np.clip(picture, 0, 255).astype(np.uint8)).save(out / "views" / turn / f"{pattern}.png")
        (out / "masks" / f"{turn}.png").symlink_to(room / "masks" / f"view-{turn}.png")
    status, said = said_by("import", "-c", room / "truth.json", "-t", turntable([22, 157]), *[x for n in ["black", "white", *held] for x in ("-i", f"{n}={out}/views/{{view}}/{n}.png")],
                           "-p", f"{held[0]}={room}/held-out/{held[0]}.png", *[x for n in held[1:] for x in ("--held-out", f"{n}={room}/held-out/{n}.png")],
                           "-m", f"{out}/masks/{{view}}.png", "-w", arguments.width, "--name", "rig", "-o", out / "capture")
    if status:
        raise SystemExit("; ".join(said))


def quality(capture, truth):
    """dB of the object's pixels at the turns of the capture `truth`, or what reconstruct says."""
    status, said = said_by("reconstruct", capture, "-o", capture.parent / "object.ply")
    if status:
        return None, said
    subprocess.run([arguments.program, "evaluate", capture, "--gaussians", capture.parent / "object.ply", "--targets", truth / "capture" / "scene.json",
                    "--json", capture.parent / "scores.json"], capture_output=True, check=True)
    rows = json.loads((capture.parent / "scores.json").read_text())["rows"]
    return next(row["psnr_foreground"] for row in rows if row["protocol"] == "novel_pose"), said


def with_true_masks(photographs, out, angles, truth):
    status, said = take(photographs, out, angles, "-m", f"{room}/masks/view-{{view}}.png")
    if status:
        raise SystemExit("; ".join(said))
    return masks_of(out), quality(out, truth)[0]


def missing_and_surplus(true, made):
    area = sum(m.sum() for m in true)
    return " / ".join(f"{100 * sum((a & ~b).sum() for a, b in pairs) / area:.1f}" for pairs in (list(zip(true, made)), list(zip(made, true)))) + " %"


def lost_by(fault, here, angles, db, sound):
    """The table's cell for `db`; `sound`: that without a fault."""
    if db is None:
        return "reconstruct refuses"
    if fault in RENDERED:
        return f"({db:.1f} dB; true masks: {with_true_masks(here / 'photographs', here / 'true', angles, here / 'truth')[1]:.1f} dB)"
    return f"({db:.1f} dB)" if sound is None else f"{sound - db:.1f} dB"


def try_fault(fault, usual, sound):
    """Prints the table's row; returns messages and dB."""
    here = work / "fault"
    shutil.rmtree(here, ignore_errors=True)
    put(fault, here / "photographs")
    angles = ANGLES.get(fault, list(map(int, stops)))
    if fault in RENDERED:
        make_truth(here / "truth", fault)
    empty = [] if fault.startswith("(void)") else [x for n in names for x in ("--empty", f"{n}={here}/photographs/empty/{n}.png")]
    status, said = take(here / "photographs", here / "capture", angles, *empty)
    share, lost, db = "refused", "–", None
    if status == 0:
        share = missing_and_surplus(true, masks_of(here / "capture"))
        if fault in SLIPPED:
            slip(here / "capture", *SLIPPED[fault])
        said += said_by("info", here / "capture")[1]
        db, more = quality(here / "capture", here / "truth" if fault in RENDERED else work / "truth")
        said += more
        lost = lost_by(fault, here, angles, db, sound)
    new = [one for one in dict.fromkeys(said) if sound is not None and one not in usual]
    print(f"| {fault} | {share} | {lost} | {'; '.join(new) or 'nothing'} |", flush=True)
    return set(said), db


work.mkdir(parents=True)
make_truth(work / "truth")
put("none", work / "sound")
true, best = with_true_masks(work / "sound", work / "true", list(map(int, stops)), work / "truth")
print(f"| fault | missing / surplus | lost | said |\n|---|---|---|---|\n| (true masks) | 0 / 0 % | ({best:.1f} dB) | |")
ordinary = {}
for name in FAULTS:
    kind = name.startswith("(void)")
    if name in ("none", "(void) none"):
        ordinary[kind] = try_fault(name, set(), None)
    elif not arguments.only or any(words in name for words in arguments.only):
        try_fault(name, *ordinary[kind])
