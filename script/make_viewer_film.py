#!/usr/bin/env python3
"""docs/pictures/view.gif: the page of `ffprocams view` at work, a sunset sweeping over the white head of data/sculpture.

usage: script/make_viewer_film.py [FOLDER]     (needs Chromium and ffmpeg; FOLDER keeps what was computed)
"""
import base64
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests/product/view"))
import browser  # noqa: E402

WIDTH, HEIGHT, FRAMES, RATE = 1000, 620, 24, 8
SHOW = """(() => { const bytes = Uint8Array.from(atob(%r), (c) => c.charCodeAt(0)), transfer = new DataTransfer();
    transfer.items.add(new File([bytes], 'sun.png', {type: 'image/png'}));
    window.dispatchEvent(new DragEvent('drop', {dataTransfer: transfer, bubbles: true, cancelable: true})); })()"""
IDLE = """new Promise((done) => { const look = () => viewer.pending || viewer.stale || viewer.rough || viewer.moving
    ? setTimeout(look, 20) : done(true); look(); })"""
MOVE = """(() => { const turn = 2 * Math.PI * %d / %d;
    viewer.setProjectorPose(orbit(from.projector, viewer.scene.centre, viewer.up, 0.75 * Math.sin(turn), 0.25 * Math.sin(2 * turn)));
    viewer.setCamera(orbit(from.camera, viewer.target, viewer.up, -0.5 * Math.sin(turn) - 0.25, 0.12));
    viewer.invalidate(); })()"""


def make_page(folder):
    page = folder / "sculpture.html"
    if not page.exists():
        program, capture, splats = ROOT / "build/ffprocams", ROOT / "data/sculpture", folder / "sculpture.ply"
        subprocess.run([program, "reconstruct", capture, "-o", splats], check=True)
        subprocess.run([program, "view", splats, "--capture", capture, "-o", page], check=True)
    return page


def main():
    folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp())
    folder.mkdir(parents=True, exist_ok=True)
    page = browser.Browser(browser.find(), WIDTH, HEIGHT)
    try:
        page.open(str(make_page(folder)))
        page.wait("document.readyState === 'complete' && !!window.ready")
        page.scheme("dark")
        page.key("8")  # the face
        page.run(SHOW % base64.b64encode((ROOT / "data/sun.png").read_bytes()).decode())
        page.wait("document.getElementById('content-name').textContent.includes('sun')")
        page.run("""(() => { const exposure = document.getElementById('exposure'); exposure.value = 1;
            exposure.dispatchEvent(new Event('input', {bubbles: true})); })()""")
        page.run(IDLE)
        page.run("document.getElementById('toast').classList.remove('shown');"
                 "window.from = {projector: viewer.projector.device.pose, camera: viewer.pose}; true")
        for frame in range(FRAMES):
            page.run(MOVE % (frame, FRAMES))
            page.run(IDLE)
            page.screenshot(str(folder / f"frame_{frame:03d}.png"))
    finally:
        page.close()
    subprocess.run(["ffmpeg", "-y", "-loglevel", "error", "-framerate", str(RATE), "-i", str(folder / "frame_%03d.png"),
                    "-vf", "scale=800:-1:flags=area,split[a][b];[a]palettegen=max_colors=160:stats_mode=diff[p];"
                    "[b][p]paletteuse=dither=bayer:bayer_scale=4:diff_mode=rectangle", str(ROOT / "docs/pictures/view.gif")],
                   check=True)


main()
