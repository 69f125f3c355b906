"""The program of the guide *Python* of the manual."""

import re

import sphecs
from scenes import ROOT


def test_the_blocks_of_the_guide_run_in_order(tmp_path, monkeypatch):
    text = (ROOT / "docs" / "book" / "src" / "guides" / "python.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    assert len(blocks) == 4
    (tmp_path / "scenes").symlink_to(ROOT / "scenes")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    names = {}
    for block in blocks:
        exec(block, names)  # noqa: S102 - the text of the manual
    assert (tmp_path / "speed.png").exists()
    report = sphecs.check(names["scene"], timed=False)
    assert report.ok, report.text
