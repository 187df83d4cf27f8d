"""Whatever the file: a report, in bounded time, true, with places, in every format.

Each kind of input has its own seed, so every run tries the same ones: a few, or as many as
`pytest tests/test_fuzz.py --fuzz 1000` asks for. `--fuzz-seed` tries others.
"""

from __future__ import annotations

import os
import random
from pathlib import Path

import pytest

from conftest import ROOT
from fuzzing import KINDS, Seeds, judged, keep, seeds_of

pytestmark = pytest.mark.skipif(os.name == "nt", reason="no CPU time limits")

FEW = 16


@pytest.fixture(scope="module")
def seeds(tmp_path_factory: pytest.TempPathFactory) -> Seeds:
    folders = (ROOT / "fixtures" / name for name in ("bad", "clean"))
    texts = sorted(file for folder in folders for file in folder.glob("*.usda"))
    return seeds_of(texts, tmp_path_factory.mktemp("seeds") / "whole")


@pytest.mark.parametrize("kind", KINDS)
def test_any_file(kind: str, seeds: Seeds, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    count, seed = request.config.getoption("--fuzz"), request.config.getoption("--fuzz-seed")
    chance = random.Random(f"{kind} {seed}")  # noqa: S311 the same each time
    outcome = judged([KINDS[kind](chance, seeds, tmp_path, n) for n in range(count or FEW)])
    if count:
        print(f"\n{kind}: {count} inputs, {len(outcome.died)} that USD dies of or hangs on")
        keep(outcome, Path("fuzz-found") / kind)
    assert outcome.complaints == {}
