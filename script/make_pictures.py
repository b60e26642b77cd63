#!/usr/bin/env python3
"""The pictures of README.md's walk-through: docs/pictures/castle.png and docs/pictures/walk/, from a generated castle.

usage: script/make_pictures.py [FOLDER]      (needs Pillow; FOLDER keeps the results; without it a temporary one is used)

The commands are those of README.md; only the pictures are drawn at four times the size of the photographs, by a
pose file with a larger camera.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parent.parent
SCENE, VIEW, LARGER = 3408, "path_0_theta180", 4
BOX = (48, 44, 460, 428)  # of the castle, in a picture of 512 x 512
SIDE = 320                # width of a picture of the walk-through


def ffprocams(*arguments):
    subprocess.run([ROOT / "build/ffprocams", *map(str, arguments)], check=True, stdout=subprocess.DEVNULL)


def larger_camera(capture, out):
    scene = json.loads((capture / "scene.json").read_text())
    for field in ("width", "height", "fx", "fy", "cx", "cy"):
        scene["camera"][field] *= LARGER
    for view in scene["views"]:
        view["images"] = {}
        for truth in ("coverage", "depth", "normal", "albedo", "roughness", "direct_white"):
            view.pop(truth, None)
    out.write_text(json.dumps(scene))


def over_black(path):
    picture = Image.open(path).convert("RGBA")
    black = Image.new("RGBA", picture.size, (0, 0, 0, 255))
    black.alpha_composite(picture)
    return black.convert("RGB")


def cut(path, width=SIDE):
    picture = over_black(path).crop(BOX)
    return picture.resize((width, width * picture.height // picture.width), Image.LANCZOS)


def fitted(picture, height):
    return picture.resize((picture.width * height // picture.height, height), Image.LANCZOS)


def row(pictures, gap=8):
    out = Image.new("RGB", (sum(p.width for p in pictures) + gap * (len(pictures) - 1),
                            max(p.height for p in pictures)), (255, 255, 255))
    left = 0
    for picture in pictures:
        out.paste(picture, (left, 0))
        left += picture.width + gap
    return out


def photographs(capture, width):
    """All 24: a column a view, black, white and the lollipop below each other."""
    box = (4, 10, 124, 114)
    height = width * (box[3] - box[1]) // (box[2] - box[0])
    out = Image.new("RGB", (8 * width, 3 * height))
    for column in range(8):
        for line, pattern in enumerate(("all_black", "all_white", "lollipop_0")):
            picture = over_black(capture / f"path_0_theta{45 * column:03d}_{pattern}.png").crop(box)
            out.paste(picture.resize((width, height), Image.LANCZOS), (column * width, line * height))
    return out


def compute(folder):
    capture, gaussians, poses = folder / f"all_{SCENE:05d}", folder / "castle.ply", folder / "larger.json"
    if not gaussians.exists():
        ffprocams("generate", folder, "--first", SCENE, "--count", 1)
        ffprocams("reconstruct", capture, "-o", gaussians)
    larger_camera(capture, poses)
    here = ("--capture", capture, "--view", VIEW)
    if (folder / "turn").exists():
        return capture
    ffprocams("compensate", gaussians, *here, "--target", ROOT / "data/sun.png", "--paint", "-o", folder / "pattern.png")
    ffprocams("map", gaussians, *here, "-o", folder / "maps")
    large = (*here, "--poses", poses)
    ffprocams("render", gaussians, *large, "--pattern", ROOT / "data/sun.png", "--pattern", folder / "pattern.png",
              "--maps", "-o", folder / "relit")
    ffprocams("render", gaussians, *large, "--pattern", ROOT / "data/sun.png", "--orbit", "projector,36",
              "-o", folder / "turn")
    return capture


def turn(folder, out):
    frames = [cut(folder / f"turn/frame_{i:04d}.png", 240) for i in range(36)]
    palette = row(frames[::4], 0).quantize(96)
    frames = [f.quantize(palette=palette, dither=Image.Dither.NONE) for f in frames]
    frames[0].save(out, save_all=True, append_images=frames[1:], duration=90, loop=0)


def save(picture, name, colours=256):
    picture.quantize(colours).save(ROOT / "docs/pictures" / name, optimize=True)


def main(folder):
    folder.mkdir(parents=True, exist_ok=True)
    capture = compute(folder)
    (ROOT / "docs/pictures/walk").mkdir(exist_ok=True)
    relit, maps = folder / "relit", folder / "maps"
    sun, corrected = cut(relit / f"{VIEW}_sun.png"), cut(relit / f"{VIEW}_pattern.png")
    height = sun.height
    pattern = fitted(over_black(folder / "pattern.png"), height)
    save(row([fitted(photographs(capture, 96), height), sun, corrected]), "castle.png")
    save(photographs(capture, 84), "walk/photographs.png")
    save(row([cut(relit / f"{VIEW}_{name}.png", 220) for name in ("albedo", "normal", "depth")]), "walk/gaussians.png")
    save(row([fitted(over_black(ROOT / "data/sun.png"), height), sun]), "walk/relit.png")
    turn(folder, ROOT / "docs/pictures/walk/turn.gif")
    save(row([pattern, corrected]), "walk/compensated.png")
    save(row([fitted(over_black(maps / f"{VIEW}_{name}.png"), 240)
              for name in ("projector_sees", "illuminance", "projector_to_camera")]), "walk/maps.png")


if __name__ == "__main__":
    if len(sys.argv) > 2 or sys.argv[1:] in (["-h"], ["--help"]):
        sys.exit(__doc__.strip())
    if len(sys.argv) == 2:
        main(pathlib.Path(sys.argv[1]))
    else:
        with tempfile.TemporaryDirectory() as temporary:
            main(pathlib.Path(temporary))
