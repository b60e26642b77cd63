#!/usr/bin/env python3
"""bench/results_picture.py PROGRAM OUT.png SCENE..: rows of pictures for docs/results.md. Needs python3-pil.

Each SCENE is a folder that `ffprocams generate --split test` made. A row: a photograph that the reconstruction was given,
the truth at a new pose under a pattern, the prediction of the network alone and the polished one, and their errors, four times
enlarged."""
import subprocess
import sys
import tempfile
from pathlib import Path
from PIL import Image, ImageChops, ImageDraw

SIDE, BAND = 192, 18
GIVEN, POSE = "path_0_theta000_lollipop_0.png", "novel_02_photograph_2.png"
LABELS = ["given (one of 24)", "new pose and pattern: truth", "network alone", "error x 4", "polished", "error x 4"]


def over_black(path):
    picture = Image.open(path).convert("RGBA")
    return Image.alpha_composite(Image.new("RGBA", picture.size, (0, 0, 0, 255)), picture).convert("RGB")


def predicted(program, scene, options, folder):
    subprocess.run([program, "evaluate", scene, "--targets", "targets/scene.json", *options, "--save", folder],
                   check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return over_black(next(Path(folder).rglob(POSE)))


def row(program, scene):
    truth = over_black(scene / "targets" / POSE)
    panels = [over_black(scene / GIVEN), truth]
    for options in (["--polish", "0"], []):
        with tempfile.TemporaryDirectory() as folder:
            picture = predicted(program, scene, options, folder)
        panels += [picture, ImageChops.difference(picture, truth).point(lambda value: min(4 * value, 255))]
    return panels


program, out, *scenes = sys.argv[1:]
sheet = Image.new("RGB", (SIDE * len(LABELS), BAND + SIDE * len(scenes)))
draw = ImageDraw.Draw(sheet)
for i, label in enumerate(LABELS):
    draw.text((i * SIDE + 6, 4), label, fill=(255, 255, 255))
for j, scene in enumerate(scenes):
    for i, panel in enumerate(row(program, Path(scene))):
        sheet.paste(panel.resize((SIDE, SIDE), Image.BICUBIC), (i * SIDE, BAND + j * SIDE))
sheet.save(out, optimize=True)
