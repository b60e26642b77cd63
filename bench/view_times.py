#!/usr/bin/env python3
"""Milliseconds of the page of `ffprocams view` at 1280 x 720 in a headless Chromium that draws in software, and what
the passes are made of: view_times.py PAGE.html... . Not part of the tests."""
import os
import statistics
import sys

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "..", "tests", "product", "view"))
import browser  # noqa: E402

# Splats that reach a sample, counted by adding ones.
COUNT = """(() => { if (!document.getElementById('reached.frag')) {
    const element = document.createElement('script'); element.type = 'x-shader', element.id = 'reached.frag';
    element.textContent = document.getElementById('shadow.frag').textContent.replace(/o_0 = min.*;/, 'o_0 = vec4(1.0);');
    document.body.append(element); }
  const {renderer, graphics} = viewer, {gl} = graphics, d = renderer.view.device;
  const target = graphics.target(d.width, d.height, [gl.RGBA32F]), blend = gl.blendFunc;
  gl.blendFunc = () => blend.call(gl, gl.ONE, gl.ONE);
  renderer.rasterise(target, d, 0, 'reached.frag');
  delete gl.blendFunc;
  let sum = 0, covered = 0;
  const texels = graphics.readFloats(target);
  for (let i = 0; i < texels.length; i += 4) sum += texels[i], covered += texels[i] > 0;
  graphics.free(target);
  return [sum, covered]; })()"""
STEPS = {
    "sort": "r.putOrder(view.device.pose)",
    "G-buffer": "r.rasterise(view.samples, view.device, view.depth, 'splats.frag')",
    "shadow map": "viewer.projector.shadowKey = '', r.drawShadow(viewer.projector)",
    "light": "r.drawLight(view.camera, view.side, viewer.lit, true)",
    "resolve": "r.resolve(null, 1)",
    "whole frame, camera moved": "view.key = '', viewer.draw(QUALITIES[s])",
}


def main():
    for path in sys.argv[1:]:
        page = browser.Browser(browser.find(), 1280, 720)
        try:
            page.open(path)
            page.wait("document.readyState === 'complete' && !!window.ready", 300)
            page.run("window.ready", timeout=300)
            page.run("document.body.classList.remove('with-panel'), viewer.schedule = () => {}, viewer.draw(QUALITIES[0])", timeout=300)
            print(path, page.run("viewer.scene.splats.count"), "splats", page.run("viewer.canvas.width + ' x ' + viewer.canvas.height"))
            for s, name in ((0, "2 x 2 samples"), (1, "1 sample")):
                page.run(f"viewer.draw(QUALITIES[{s}])", timeout=300)
                reached, covered = page.run(COUNT, timeout=300)
                print(f"  {name}: {page.run('viewer.renderer.view.samples.width * viewer.renderer.view.samples.height'):,} samples, "
                      f"{covered:,.0f} with splats, {reached:,.0f} splats blended in them")
                for step, code in STEPS.items():
                    times = [page.run(f"""(() => {{ const r = viewer.renderer, {{view}} = r, s = {s}, gl = viewer.graphics.gl;
                        const end = () => gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
                        gl.bindFramebuffer(gl.FRAMEBUFFER, null); end();
                        const began = performance.now(); {code};
                        gl.bindFramebuffer(gl.FRAMEBUFFER, null); end(); return performance.now() - began; }})()""", timeout=300)
                             for _ in range(3)]
                    print(f"    {step:28} {statistics.median(times):9.1f} ms")
        finally:
            page.close()


if __name__ == "__main__":
    main()
