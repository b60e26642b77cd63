#!/usr/bin/env python3
"""bench/compensation_picture.py REPORT.html: docs/compensation.png from the first views of a report that compensate_report
wrote (-o) for data/sample with the target data/sun.png. Needs python3-pil."""
import base64
import io
import re
import sys
from pathlib import Path
from PIL import Image, ImageDraw

SIDE, BAND, ROWS, CASE = 256, 18, 2, 5  # CASE: pictures a view
FIGURE = re.compile(r'<figure class=one><img alt="" src="data:image/png;base64,([^"]*)"><figcaption>([^<]*)</figcaption>')

figures = FIGURE.findall(Path(sys.argv[1]).read_text())[:ROWS * CASE]
if len(figures) < ROWS * CASE:
    sys.exit(f"compensation_picture: error: fewer than {ROWS} views ({sys.argv[1]})")
sheet = Image.new("RGB", (SIDE * CASE, (SIDE + BAND) * ROWS))
draw = ImageDraw.Draw(sheet)
for i, (data, caption) in enumerate(figures):
    x, y = i % CASE * SIDE, i // CASE * (SIDE + BAND)
    picture = Image.open(io.BytesIO(base64.b64decode(data))).convert("RGB").resize((SIDE, SIDE), Image.BICUBIC)
    sheet.paste(picture, (x, y + BAND))
    draw.text((x + 6, y + 4), caption.split(": ", 1)[1], fill=(255, 255, 255))
sheet.save(Path(__file__).resolve().parent.parent / "docs/compensation.png", optimize=True)
