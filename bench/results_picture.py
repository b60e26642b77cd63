#!/usr/bin/env python3
"""bench/results_picture.py: rows of pictures for docs/results.md. Needs python3-pil.

    bench/results_picture.py OUT.png --way "network alone=build/ffprocams --polish 0" --way polished=build/ffprocams SCENE..
    bench/results_picture.py OUT.png --way "version 0.1=old/ffprocams" --way today=build/ffprocams SCENE..

Each SCENE is a folder that `ffprocams generate --split test` made. A row: a photograph that the reconstruction was given, the truth at a new pose under a
pattern, and for each way, a label with a program and options of its `evaluate`, the prediction and its error, four times enlarged."""
import argparse
import shlex
import subprocess
import tempfile
from pathlib import Path
from PIL import Image, ImageChops, ImageDraw

SIDE, BAND = 192, 18
GIVEN, POSE = "path_0_theta000_lollipop_0.png", "novel_02_photograph_2.png"


def over_black(path):
    picture = Image.open(path).convert("RGBA")
    return Image.alpha_composite(Image.new("RGBA", picture.size, (0, 0, 0, 255)), picture).convert("RGB")


def predicted(way, scene):
    program, *options = shlex.split(way)
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([program, "evaluate", scene, "--targets", "targets/scene.json", *options, "--save", folder],
                       check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        return over_black(next(Path(folder).rglob(POSE)))


def row(scene, ways):
    truth = over_black(scene / "targets" / POSE)
    panels = [over_black(scene / GIVEN), truth]
    for way in ways:
        picture = predicted(way, scene)
        panels += [picture, ImageChops.difference(picture, truth).point(lambda value: min(4 * value, 255))]
    return panels


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("out")
    parser.add_argument("--way", action="append", required=True)
    parser.add_argument("scenes", nargs="+", type=Path)
    options = parser.parse_args()
    names, ways = zip(*(way.split("=", 1) for way in options.way))
    labels = ["given (one of 24)", "new pose and pattern: truth", *(label for name in names for label in (name, "error x 4"))]
    sheet = Image.new("RGB", (SIDE * len(labels), BAND + SIDE * len(options.scenes)))
    draw = ImageDraw.Draw(sheet)
    for i, label in enumerate(labels):
        draw.text((i * SIDE + 6, 4), label, fill=(255, 255, 255))
    for j, scene in enumerate(options.scenes):
        for i, panel in enumerate(row(scene, ways)):
            sheet.paste(panel.resize((SIDE, SIDE), Image.BICUBIC), (i * SIDE, BAND + j * SIDE))
    sheet.save(options.out, optimize=True)


if __name__ == "__main__":
    main()
