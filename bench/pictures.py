#!/usr/bin/env python3
"""bench/pictures.py: the pictures of the documents that are rows of panels. Needs python3-pil.

    bench/pictures.py front            docs/pictures/spot.png from what script/demo left in out/demo
    bench/pictures.py compensation REPORT.html
                                       docs/pictures/compensation.png from the first views of a report that compensate_report wrote (-o)
                                       for data/sample with the target data/sun.png
    bench/pictures.py results OUT.png --way "network alone=build/ffprocams --polish 0" --way polished=build/ffprocams SCENE..
                                       rows for docs/lab/results.md. Each SCENE is a folder that `ffprocams generate --split test` made. A row:
                                       a photograph that the reconstruction was given, the truth at a new pose under a pattern, and for each
                                       way, a label with a program and options of its `evaluate`, the prediction and its error x 4.
                                       --across N: N scenes in a row, small and in 128 colours, without the photograph
    bench/pictures.py baselines WORK OUT.png SCENE.. [--program build/ffprocams]
                                       rows for docs/lab/baselines.md from what `bench/baselines WORK` has left: the truth at a new pose under a
                                       pattern, the reconstruction from eight views, the field and Gaussians from scratch on 297, each with its PSNR
    bench/pictures.py sizes TRUTH SMALL LARGE OUT.png
                                       README's picture of two sizes, from a photograph at a new pose and what `render` drew there of
                                       reconstructions of small and of large photographs, cut to the object, each with the PSNR of the
                                       whole picture; the small one is enlarged (bicubic) to the size of the truth
    bench/pictures.py shell            README's first picture, docs/pictures/shell.png, from the photographs of data/shell; prints the PSNR of
                                       the stripes that were held back. --program build/ffprocams"""
import argparse
import base64
import io
import math
import re
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path
from PIL import Image, ImageChops, ImageDraw, ImageStat

ROOT = Path(__file__).resolve().parent.parent
POSE = "novel_02_photograph_2.png"


def over_black(path):
    """Straight alpha over black, in encoded values, as viewers do it."""
    picture = Image.open(path).convert("RGBA")
    return Image.alpha_composite(Image.new("RGBA", picture.size, (0, 0, 0, 255)), picture).convert("RGB")


def psnr(a, b):
    squares = ImageStat.Stat(ImageChops.difference(a, b)).sum2
    return 10 * math.log10(255 ** 2 * 3 * a.width * a.height / sum(squares))


def save_sheet(out, rows, side, band=18, resample=Image.BICUBIC):
    """Rows of (label, picture); a band above a row holds its labels, if it has any."""
    bands = [band if any(label for label, _ in row) else 0 for row in rows]
    sheet = Image.new("RGB", (side * len(rows[0]), side * len(rows) + sum(bands)))
    draw = ImageDraw.Draw(sheet)
    top = 0
    for row, above in zip(rows, bands):
        for i, (label, picture) in enumerate(row):
            sheet.paste(picture.resize((side, side), resample), (i * side, top + above))
            if label:
                draw.text((i * side + 6, top + 4), label, fill=(255, 255, 255))
        top += side + above
    sheet.save(out, optimize=True)


def predicted(program, capture, options):
    """The picture that `evaluate` draws at the new pose."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([program, "evaluate", capture, "--targets", "targets/scene.json", *options, "--save", folder], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        return over_black(next(Path(folder).rglob(POSE)))


def front(_):
    sample, demo, view, pose = ROOT / "data/sample", ROOT / "out/demo", "path_0_theta000", "novel_01"
    panels = {"photographed": sample / f"{view}_lollipop_0.png", "unseen pattern: truth": sample / f"{view}_lollipop_3.png",
              "relit": demo / f"relit/{view}_lollipop_3.png", "new pose: truth": sample / f"{pose}_lollipop_0.png",
              "predicted": demo / f"poses/{pose}_lollipop_0.png", "your own pattern": demo / f"sun/{view}_sun.png"}
    save_sheet(ROOT / "docs/pictures/spot.png", [[(label, over_black(path)) for label, path in panels.items()]], 256)


def compensation(options):
    rows, case = 2, 5  # case: pictures a view
    figure = re.compile(r'<figure class=one><img alt="" src="data:image/png;base64,([^"]*)"><figcaption>([^<]*)</figcaption>')
    figures = figure.findall(Path(options.report).read_text())[:rows * case]
    if len(figures) < rows * case:
        sys.exit(f"pictures: error: fewer than {rows} views ({options.report})")
    panels = [(caption.split(": ", 1)[1], Image.open(io.BytesIO(base64.b64decode(data))).convert("RGB")) for data, caption in figures]
    save_sheet(ROOT / "docs/pictures/compensation.png", [panels[case * i:case * (i + 1)] for i in range(rows)], 256)


def results(options):
    rows = []
    for scene in options.scenes:
        truth = over_black(scene / "targets" / POSE)
        row = [("given (one of 24)", over_black(scene / "path_0_theta000_lollipop_0.png")), ("new pose and pattern: truth" if options.across == 1 else "truth", truth)]
        for name, way in (way.split("=", 1) for way in options.way):
            program, *settings = shlex.split(way)
            picture = predicted(program, scene, settings)
            row += [(name, picture), ("error x 4", ImageChops.difference(picture, truth).point(lambda value: min(4 * value, 255)))]
        rows.append([(None if len(rows) >= options.across else label, picture) for label, picture in row[options.across > 1:]])
    across = options.across
    save_sheet(options.out, [sum(rows[i:i + across], []) for i in range(0, len(rows), across)], 192 if across == 1 else 112)
    if across > 1:
        Image.open(options.out).quantize(128).save(options.out, optimize=True)


def baselines(options):
    methods = {"ours, 8 views": ["--gaussians", "ours_{}.ply"], "neural field, 297 views": ["--field", "field_turntable_297_{}.field"],
               "Gaussians from scratch, 297 views": ["--drawing", "gs-procams", "--gaussians", "gaussians_turntable_297_{}.ply"]}
    rows = []
    for scene in options.scenes:
        capture = options.work / "turntable_8" / f"test_{scene:05d}"
        truth = over_black(capture / "targets" / POSE)
        row = [("truth", truth)]
        for label, arguments in methods.items():
            picture = predicted(options.program, capture, [*arguments[:-1], str(options.work / arguments[-1].format(scene))])
            row.append((f"{label}: {psnr(picture, truth):.1f} dB", picture))
        rows.append(row)
    save_sheet(options.out, rows, 224)


def square_around(picture):
    """The smallest square that shows all that is not black, with a margin, in pixels."""
    left, top, right, bottom = picture.getbbox()
    half = max(right - left, bottom - top) // 2 + 12
    x, y = (left + right) // 2, (top + bottom) // 2
    return (x - half, y - half, x + half, y + half)


def sizes(options):
    truth, small, large = (over_black(path) for path in (options.truth, options.small, options.large))
    enlarged, box = small.resize(truth.size, Image.BICUBIC), square_around(truth)
    row = [(f"photographs of {small.width} x {small.height}: {psnr(enlarged, truth):.1f} dB", enlarged),
           (f"photographs of {large.width} x {large.height}: {psnr(large, truth):.1f} dB", large), ("truth", truth)]
    save_sheet(options.out, [[(label, picture.crop(box)) for label, picture in row]], 400, 20, Image.LANCZOS)


def shell(options):
    """Predictions of the object's pixels in the first view, under stripes that no fit saw (import reads the shape from them) and under our own picture."""
    data, program = ROOT / "data/shell", str(Path(options.program).resolve())

    def run(*arguments):
        return subprocess.run([program, *map(str, arguments)], check=True, capture_output=True, text=True, cwd=folder).stdout

    with tempfile.TemporaryDirectory() as folder:
        run("patterns", "-o", "patterns", "--projector", "1280x800")
        shown = {number: f"patterns/{6 + 2 * number - 2:03}_gray_x_{number:02}.png" for number in (5, 6)}
        photographs = f"{data}/photographs/{{index:3}}"
        run("import", "-c", data / "calibration.yml", "--camera-fit", "scaled", "-t", data / "axis.json", "-m", f"{data}/masks/{{index:3}}.png", "-w", 640,
            "-i", f"black,white={photographs}/{{pattern}}.jpg", "-i", f"given={photographs}/gray/10.jpg", "-i", f"stripes={photographs}/gray/12.jpg",
            "-p", f"given={shown[5]}", "--held-out", f"stripes={shown[6]}", "-g", f"{photographs}/gray/*.jpg", "-o", "capture")
        run("reconstruct", "capture", "-o", "shell.ply")
        print(run("evaluate", "capture", "--gaussians", "shell.ply", "--save", "predicted"))
        run("render", "shell.ply", "-c", "capture", "-p", ROOT / "data/sun.png", "-o", "sun")
        panels = {"photograph, white": "capture/000_white.png", "photograph, stripes held back": "capture/000_stripes.png",
                  "the same, predicted": "predicted/capture/000_stripes.png", "a picture of our own, predicted": "sun/000_sun.png"}
        row = [(label, over_black(Path(folder) / path).crop((42, 82, 322, 362))) for label, path in panels.items()]
    save_sheet(ROOT / "docs/pictures/shell.png", [row], 320, resample=Image.LANCZOS)
    sheet = Image.open(ROOT / "docs/pictures/shell.png")
    sheet.quantize(256, dither=Image.Dither.FLOYDSTEINBERG).save(ROOT / "docs/pictures/shell.png", optimize=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True)

    def command(run, *arguments):
        made = commands.add_parser(run.__name__)
        made.set_defaults(run=run)
        for argument in arguments:
            made.add_argument(argument)
        return made

    command(front)
    command(shell).add_argument("--program", default="build/ffprocams")
    command(compensation, "report")
    command(sizes, "truth", "small", "large", "out")
    made = command(results, "out")
    made.add_argument("--way", action="append", required=True)
    made.add_argument("--across", type=int, default=1)
    made.add_argument("scenes", nargs="+", type=Path)
    made = command(baselines)
    made.add_argument("work", type=Path)
    made.add_argument("out")
    made.add_argument("scenes", nargs="+", type=int)
    made.add_argument("--program", default="build/ffprocams")
    options = parser.parse_args()
    options.run(options)


if __name__ == "__main__":
    main()
