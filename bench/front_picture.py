#!/usr/bin/env python3
"""bench/front_picture.py: docs/spot.png from what script/demo left in out/demo. Needs python3-pil."""
from pathlib import Path
from PIL import Image, ImageDraw

SIDE, BAND = 256, 18
root = Path(__file__).resolve().parent.parent
sample, demo = root / "data/sample", root / "out/demo"
VIEW, POSE = "path_0_theta000", "novel_01"
PANELS = [
    ("photographed", sample / f"{VIEW}_lollipop_0.png"),
    ("unseen pattern: truth", sample / f"{VIEW}_lollipop_3.png"),
    ("relit", demo / f"relit/{VIEW}_lollipop_3.png"),
    ("new pose: truth", sample / f"{POSE}_lollipop_0.png"),
    ("predicted", demo / f"poses/{POSE}_lollipop_0.png"),
    ("your own pattern", demo / f"sun/{VIEW}_sun.png"),
]


def over_black(path):
    """Straight alpha over black, in encoded values, as viewers do it."""
    picture = Image.open(path).convert("RGBA")
    black = Image.new("RGBA", picture.size, (0, 0, 0, 255))
    return Image.alpha_composite(black, picture).convert("RGB").resize((SIDE, SIDE), Image.BICUBIC)


sheet = Image.new("RGB", (SIDE * len(PANELS), SIDE + BAND))
draw = ImageDraw.Draw(sheet)
for i, (label, path) in enumerate(PANELS):
    sheet.paste(over_black(path), (i * SIDE, BAND))
    draw.text((i * SIDE + 6, 4), label, fill=(255, 255, 255))
sheet.save(root / "docs/spot.png", optimize=True)
