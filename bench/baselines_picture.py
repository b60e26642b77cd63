#!/usr/bin/env python3
"""bench/baselines_picture.py WORK OUT.png SCENE.. [--program build/ffprocams]: the picture of docs/baselines.md from what `bench/baselines WORK` has left.
Needs python3-pil. A row a scene: the truth at a new pose under a pattern, ours from eight views, the field and Gaussians from scratch on 297, each with its PSNR."""
import argparse
import math
import subprocess
import tempfile
from pathlib import Path
from PIL import Image, ImageChops, ImageDraw, ImageStat

SIDE, BAND = 224, 18
POSE = "novel_02_photograph_2.png"
METHODS = [("ours, 8 views", ["--gaussians", "ours_{}.ply"]), ("neural field, 297 views", ["--field", "field_turntable_297_{}.field"]),
           ("Gaussians from scratch, 297 views", ["--drawing", "gs-procams", "--gaussians", "gaussians_turntable_297_{}.ply"])]


def over_black(path):
    picture = Image.open(path).convert("RGBA")
    return Image.alpha_composite(Image.new("RGBA", picture.size, (0, 0, 0, 255)), picture).convert("RGB")


def psnr(a, b):
    squares = ImageStat.Stat(ImageChops.difference(a, b)).sum2
    return 10 * math.log10(255 ** 2 * 3 * a.width * a.height / sum(squares))


def drawn(options, scene, arguments):
    capture = options.work / "turntable_8" / f"test_{scene:05d}"
    named = [*arguments[:-1], str(options.work / arguments[-1].format(scene))]
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([options.program, "evaluate", capture, "--targets", "targets/scene.json", *named, "--save", folder], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        return over_black(next(Path(folder).rglob(POSE))), over_black(capture / "targets" / POSE)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("work", type=Path)
    parser.add_argument("out")
    parser.add_argument("scenes", type=int, nargs="+")
    parser.add_argument("--program", default="build/ffprocams")
    options = parser.parse_args()
    sheet = Image.new("RGB", (SIDE * (len(METHODS) + 1), (SIDE + BAND) * len(options.scenes)))
    draw = ImageDraw.Draw(sheet)
    for j, scene in enumerate(options.scenes):
        y = j * (SIDE + BAND)
        draw.text((6, y + 4), "truth", fill=(255, 255, 255))
        for i, (label, arguments) in enumerate(METHODS, 1):
            picture, truth = drawn(options, scene, arguments)
            sheet.paste(truth.resize((SIDE, SIDE), Image.BICUBIC), (0, y + BAND))
            sheet.paste(picture.resize((SIDE, SIDE), Image.BICUBIC), (i * SIDE, y + BAND))
            draw.text((i * SIDE + 6, y + 4), f"{label}: {psnr(picture, truth):.1f} dB", fill=(255, 255, 255))
    sheet.save(options.out, optimize=True)


if __name__ == "__main__":
    main()
