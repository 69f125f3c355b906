"""The programs of the guides of the manual."""

import re
import shutil

import pytest
import sphecs
from conftest import sphecs as program
from scenes import ROOT


def blocks_of(guide):
    text = (ROOT / "docs" / "book" / "src" / "guides" / f"{guide}.md").read_text(encoding="utf-8")
    return re.findall(r"```python\n(.*?)```", text, re.DOTALL)


def run_in_order(blocks):
    names = {}
    for block in blocks:
        exec(block, names)  # noqa: S102 - the text of the manual
    return names


def test_the_blocks_of_the_guide_run_in_order(tmp_path, monkeypatch):
    blocks = blocks_of("python")
    assert len(blocks) == 4
    (tmp_path / "scenes").symlink_to(ROOT / "scenes")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    names = run_in_order(blocks)
    assert (tmp_path / "speed.png").exists()
    report = sphecs.check(names["scene"], timed=False)
    assert report.ok, report.text


@pytest.mark.parametrize(("guide", "option", "count"), [("tracks", "--tracks", 3), ("paraview", "--vtkhdf", 1)])
def test_the_blocks_of_the_guides_of_exports_run(guide, option, count, run_folder, tmp_path, monkeypatch, capsys):
    shutil.copytree(run_folder, tmp_path / "runs" / "quickstart")
    program("export", tmp_path / "runs" / "quickstart", option)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    blocks = blocks_of(guide)
    assert len(blocks) == count
    run_in_order(blocks)
    assert capsys.readouterr().out
    assert (tmp_path / "pathlines.png").exists() == (guide == "tracks")
