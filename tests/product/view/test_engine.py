#!/usr/bin/env python3
"""The page that reconstructs (script/test-wasm) in a headless browser, with the network off: a capture dropped in,
reconstructed, shown and saved; what the program makes of the same capture; what is refused.

    test_engine.py PAGE CAPTURE FOLDER [PROGRAM]     screenshots and files stay in FOLDER

Exits with 77 and a line where there is no browser."""
import json
import os
import re
import resource
import shutil
import subprocess
import sys
import time
import zipfile

import browser

PSNR_MOST = 0.2  # dB on the photographs it was fitted to, between the page and the program; measured: 0.11


def seconds_of(pid):
    """Processor seconds of a process and all below it, from /proc."""
    parents, spent = {}, {}
    for name in filter(str.isdigit, os.listdir("/proc")):
        try:
            fields = open(f"/proc/{name}/stat").read().rpartition(")")[2].split()
        except OSError:
            continue
        parents[int(name)] = int(fields[1])
        spent[int(name)] = int(fields[11]) + int(fields[12])
    family, more = {pid}, True
    while more:
        below = {child for child, parent in parents.items() if parent in family} - family
        family, more = family | below, bool(below)
    return sum(spent.get(one, 0) for one in family) / os.sysconf("SC_CLK_TCK")


class Page(browser.Browser):
    def start(self, page):
        self.open(page)
        self.wait("document.readyState == 'complete' && !!document.getElementById('small.safetensors')", 120)
        self.call("Network.emulateNetworkConditions", {"offline": True, "latency": 0, "downloadThroughput": 0, "uploadThroughput": 0})

    def drop(self, path):
        data = {"items": [], "files": [os.path.abspath(path)], "dragOperationsMask": 1}
        for kind in ("dragEnter", "dragOver", "drop"):
            self.call("Input.dispatchDragEvent", {"type": kind, "x": 400, "y": 300, "data": data})

    def reconstruct(self, path, seconds):
        self.drop(path)
        self.wait("!document.getElementById('result').hidden || !document.getElementById('problem').hidden", seconds)
        assert self.run("document.getElementById('problem').hidden"), self.run("document.getElementById('why').textContent")
        return json.loads(self.run("document.body.dataset.stats"))

    def refuses(self, path, why):
        self.run("document.getElementById('problem').hidden = true")
        self.drop(path)
        self.wait("!document.getElementById('problem').hidden", 300)
        said = self.run("document.getElementById('why').textContent")
        assert why in said, f"{path}: {said}"

    def save(self, kind, folder):
        """The file that the button writes."""
        self.call("Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": folder}, session=None)
        before = set(os.listdir(folder))
        self.run(f"document.querySelector('[data-save={kind}]').click()")
        for _ in range(600):
            new = [name for name in set(os.listdir(folder)) - before if name.endswith("." + kind)]
            if new:
                return os.path.join(folder, new[0])
            time.sleep(0.1)
        raise AssertionError(f"{kind} was not saved")


def native(program, capture, folder):
    """PSNR on the photographs and seconds of one thread, of the program."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    said = subprocess.run([program, "reconstruct", capture, "-o", os.path.join(folder, "native.ply"), "--json", os.path.join(folder, "native.json")],
                          env={**os.environ, "OMP_NUM_THREADS": "1"}, check=True, capture_output=True, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return said.stdout + said.stderr, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, after.ru_maxrss / 1e3


def zipped(capture, path):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for folder, _, names in os.walk(capture):
            for name in names:
                whole = os.path.join(folder, name)
                archive.write(whole, os.path.join("sample", os.path.relpath(whole, capture)))
    return path


def check_files(page, folder):
    for kind, magic in (("ply", b"ply\n"), ("html", b"<!doctype html>")):
        path = page.save(kind, folder)
        with open(path, "rb") as file:
            assert file.read(len(magic)) == magic, path
        print(f"saved {kind}: {os.path.getsize(path) / 1e6:.2f} MB")
    return os.path.join(folder, "sample.ply")


def check_refusals(page, folder):
    empty = os.path.join(folder, "no-scene")
    os.makedirs(empty, exist_ok=True)
    with open(os.path.join(empty, "a.txt"), "w") as file:
        file.write("nothing")
    page.refuses(empty, "no scene.json")
    with open(os.path.join(folder, "bad.zip"), "wb") as file:
        file.write(b"PK\3\4" + bytes(100))
    page.refuses(os.path.join(folder, "bad.zip"), "not a ZIP file")
    broken = os.path.join(folder, "broken")
    os.makedirs(broken, exist_ok=True)
    with open(os.path.join(broken, "scene.json"), "w") as file:
        file.write("{\"views\": 3}")
    page.refuses(broken, "scene.json")


def main():
    source, capture, folder = (os.path.abspath(path) for path in sys.argv[1:4])
    program = browser.find()
    if not program:
        print("skipped: there is no Chromium")
        return 77
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    size = os.path.getsize(source)
    print(f"the page has {size / 1e6:.1f} MB")
    assert size < 25e6
    page = Page(program, arguments=["--js-flags=--max-old-space-size=4096"])
    try:
        page.start(source)
        page.screenshot(os.path.join(folder, "start.png"))
        check_refusals(page, folder)
        before = seconds_of(page.process.pid)
        stats = page.reconstruct(capture, 1800)
        print(f"page: {seconds_of(page.process.pid) - before:.1f} s of processor with the browser's;", json.dumps(stats))
        page.wait("document.getElementById('viewer').contentDocument?.body?.classList.contains('ready')", 600)
        time.sleep(5)  # until it has drawn
        page.screenshot(os.path.join(folder, "result.png"))
        check_files(page, folder)
        page.run("document.getElementById('again').click()")
        page.run("document.getElementById('polish').checked = false")
        again = page.reconstruct(zipped(capture, os.path.join(folder, "sample.zip")), 900)
        print("page, a ZIP file, without polish:", json.dumps(again))
        asked = [url for url in page.requests if not url.startswith(("file:", "blob:", "data:"))]
        assert not asked, asked
        assert not [line for line in page.console if "exception" in line or line.startswith("error")], page.console
    finally:
        page.close()
    if len(sys.argv) > 4:
        said, seconds, megabytes = native(os.path.abspath(sys.argv[4]), capture, folder)
        psnr = float(re.search(r"([0-9.]+) dB", said).group(1))
        print(f"program, one thread: {psnr} dB, {seconds:.2f} s of processor, {megabytes:.0f} MB")
        assert abs(psnr - stats["psnr"]) < PSNR_MOST, (psnr, stats["psnr"])
    print("passed")
    return 0


if __name__ == "__main__":
    sys.exit(main())
