"""What the tests share: the root of the project, and a muscle that runs for a short time."""

import os
import sys
from pathlib import Path

import efam
import pytest

ROOT = Path(os.environ.get("EFAM_ROOT", Path(__file__).resolve().parents[3]))
EFAM = [sys.executable, "-m", "efam"]


@pytest.fixture
def scenario() -> Path:
    return ROOT / "scenarios" / "release-15psi.toml"


@pytest.fixture
def model(scenario: Path) -> efam.Model:
    return efam.Model(scenario, duration="2 s")
