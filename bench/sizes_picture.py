#!/usr/bin/env python3
"""bench/sizes_picture.py TRUTH SMALL LARGE OUT.png: README's picture of two sizes, from a photograph at a new pose and what `render` drew there of
reconstructions of small and of large photographs. Needs python3-pil.

The small picture is enlarged (bicubic) to the size of the truth; all three are cut to the object. Each prediction has its PSNR over the whole picture."""
import argparse
from PIL import Image, ImageDraw
from baselines_picture import over_black, psnr

SIDE, BAND, MARGIN = 400, 20, 12


def square_around(picture):
    """The smallest square that shows all that is not black, with a margin, in pixels."""
    left, top, right, bottom = picture.getbbox()
    half = max(right - left, bottom - top) // 2 + MARGIN
    x, y = (left + right) // 2, (top + bottom) // 2
    return (x - half, y - half, x + half, y + half)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("truth", "small", "large", "out"):
        parser.add_argument(name)
    options = parser.parse_args()
    truth, small, large = (over_black(path) for path in (options.truth, options.small, options.large))
    labels = [f"photographs of {small.width} x {small.height}: {psnr(small.resize(truth.size, Image.BICUBIC), truth):.1f} dB",
              f"photographs of {large.width} x {large.height}: {psnr(large, truth):.1f} dB", "truth"]
    box = square_around(truth)
    sheet = Image.new("RGB", (3 * SIDE, SIDE + BAND))
    draw = ImageDraw.Draw(sheet)
    for i, (picture, label) in enumerate(zip((small.resize(truth.size, Image.BICUBIC), large, truth), labels)):
        sheet.paste(picture.crop(box).resize((SIDE, SIDE), Image.LANCZOS), (i * SIDE, BAND))
        draw.text((i * SIDE + 6, 4), label, fill=(255, 255, 255))
    sheet.save(options.out, optimize=True)


if __name__ == "__main__":
    main()
