"""The documents' examples as they stand."""

from __future__ import annotations

import os
import re
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]


def blocks(document: str) -> list[str]:
    return re.findall(
        r"^```python\n(.*?)^```$", (ROOT / document).read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE
    )


@pytest.mark.parametrize("document", ["README.md", "docs/reference/python.md"])
def test_the_short_example_runs(document: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "data").symlink_to(ROOT / "data")
    monkeypatch.chdir(tmp_path)
    short = next(b for b in blocks(document) if b.startswith("import ffprocams as ffp"))
    names: dict[str, object] = {}
    exec(compile(short, document, "exec"), names)  # noqa: S102
    picture = names["picture"]
    assert isinstance(picture, np.ndarray) and picture.shape == (128, 128, 3) and picture.max() > 50
    assert (document == "README.md") or os.path.getsize("darker.ply") > 100000


def test_the_comparison_is_the_script() -> None:
    script = (ROOT / "python" / "examples" / "compare_methods.py").read_text(encoding="utf-8")
    assert script in blocks("docs/reference/python.md")
