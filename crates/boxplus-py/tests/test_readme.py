"""The programs of the README run as they stand."""

from __future__ import annotations

import re
from pathlib import Path

import matplotlib as mpl
import pytest

from test_pose_graph import helix

README = Path(__file__).parent.parent / "README.md"


def test_the_programs_of_the_readme_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mpl.use("Agg")
    monkeypatch.chdir(tmp_path)
    helix(60)[1].solve().graph.write("sphere2500.g2o")
    programs = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)
    names: dict[str, object] = {}
    for program in programs[:2]:
        exec(program, names)  # noqa: S102
    assert (tmp_path / "solved.g2o").is_file() and "pose" in names
