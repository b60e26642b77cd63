from __future__ import annotations

from pathlib import Path

import ffprocams
import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def sample() -> Path:
    return ROOT / "data" / "sample"


@pytest.fixture(scope="session")
def capture(sample: Path) -> ffprocams.Capture:
    return ffprocams.Capture.open(sample)


@pytest.fixture(scope="session")
def gaussians(capture: ffprocams.Capture) -> ffprocams.Reconstructed:
    """The sample without a polish; tests that write to it take a copy."""
    return ffprocams.reconstruct(capture, polish=0)
