#!/usr/bin/env python3
"""The documents are what docs/lab/measured.json says, and script/measure check notices where they are not."""
import json
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "script"))
from measure_tables import PAGES  # noqa: E402

FIGURES = "docs/lab/measured.json"


class Documents(unittest.TestCase):
    """A copy of the pages and of the figures."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name)
        for name in [*PAGES, FIGURES]:
            (self.root / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, self.root / name)

    def run_measure(self, what):
        done = subprocess.run([sys.executable, ROOT / "script/measure", what, "--root", self.root], capture_output=True, text=True, check=False)
        return done.returncode, done.stderr

    def pages(self):
        return [(self.root / name).read_text(encoding="utf-8") for name in PAGES]

    def change(self, name, old, new):
        text = (self.root / name).read_text(encoding="utf-8")
        self.assertIn(old, text)
        (self.root / name).write_text(text.replace(old, new, 1), encoding="utf-8")

    def test_documents_are_what_was_measured(self):
        self.assertEqual(self.run_measure("check"), (0, ""))

    def test_write_changes_nothing_where_nothing_is_new(self):
        before = self.pages()
        self.assertEqual(self.run_measure("write"), (0, ""))
        self.assertEqual(self.pages(), before)

    def test_a_figure_changed_by_hand_is_found_and_written_back(self):
        before = self.pages()
        shipped = json.loads((self.root / FIGURES).read_text(encoding="utf-8"))["scenes"]["shipped"][0]
        self.change("README.md", f"{shipped:.2f} / ", "99.99 / ")
        status, said = self.run_measure("check")
        self.assertEqual(status, 1)
        self.assertIn("README.md is not what docs/lab/measured.json says", said)
        self.assertIn("99.99", said)
        self.assertEqual(self.run_measure("write")[0], 0)
        self.assertEqual(self.pages(), before)

    def test_new_figures_want_new_documents(self):
        figures = json.loads((self.root / FIGURES).read_text(encoding="utf-8"))
        figures["quality"]["shipped"]["psnr"][2] += 1
        (self.root / FIGURES).write_text(json.dumps(figures), encoding="utf-8")
        self.assertIn("docs/lab/results.md is not what", self.run_measure("check")[1])

    def test_tables_of_decibels_belong_into_blocks(self):
        for name in ("README.md", "docs/lab/results.md"):
            with (self.root / name).open("a", encoding="utf-8") as page:
                page.write("\n| of dB | 31.5 |\n|---|---|\n| shipped | 45.31 / 45.22 |\n")
        status, said = self.run_measure("check")
        self.assertEqual((status, said.count("outside of a block")), (1, 4))

    def test_every_table_has_its_page(self):
        self.change("docs/design/performance.md", "<!-- measured: cores -->", "")
        self.assertIn("no page has the table cores", self.run_measure("check")[1])
        self.change("docs/lab/results.md", "<!-- measured: truth -->", "<!-- measured: lies -->")
        self.assertIn("no table is called lies", self.run_measure("check")[1])


if __name__ == "__main__":
    unittest.main()
