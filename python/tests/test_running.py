"""Runs and checks of scenes: results, messages, Ctrl-C."""

import os
import signal
import subprocess
import sys
import textwrap
import time

import numpy as np
import pytest
import sphecs
from conftest import binary
from scenes import QUICKSTART, box, channel


def test_a_run_has_the_results_of_the_command_line(run_folder, tmp_path):
    # `run_folder` is the same run by the program.
    run = sphecs.run(QUICKSTART, smoke=True, until=0.25, out=tmp_path / "run")
    with sphecs.open(run_folder).particles as expected:
        assert run.particles.drop_attrs().equals(expected.drop_attrs())
    assert run.status == "completed"
    assert run.folder == tmp_path / "run"
    assert "completed" in repr(run)
    assert run.scene.startswith("//")


def test_options_reach_the_run(tmp_path):
    run = sphecs.run(
        channel(), set={"spacing": 0.1, "precision": "F32"}, steps=7, threads=1, out=tmp_path / "run", name="plain"
    )
    assert run.summary["steps"] == 7
    assert run.summary["threads"] == 1
    assert run.summary["run"]["scene"] == "plain"
    assert run.particles.attrs["precision"] == "f32"
    assert run.particles.attrs["spacing"] == 0.1


def test_the_results_do_not_depend_on_the_ranks(tmp_path):
    one, two = (
        sphecs.run(channel(), steps=30, ranks=ranks, threads=1, out=tmp_path / str(ranks), name="shared")
        for ranks in (1, 2)
    )
    assert one.particles.drop_attrs().equals(two.particles.drop_attrs())
    with pytest.raises(sphecs.RunError, match="one rank"):
        sphecs.run(channel(), forces=lambda t, x, v: [0.0, 0.0], ranks=2, out=tmp_path / "forced")


def test_forces_act_in_a_run_which_is_not_resumed_without_them(tmp_path):
    run = sphecs.run(box(), forces=lambda t, x, v: [0.03, -0.01], until=0.2, out=tmp_path / "run")
    last = run.particles.isel(time=-1)
    moving = last.zone == 0
    np.testing.assert_allclose(last.u.where(moving, drop=True), 0.03 * float(last.time), rtol=1e-5)
    np.testing.assert_allclose(last.v.where(moving, drop=True), -0.01 * float(last.time), rtol=1e-5)
    resumed = subprocess.run(
        [binary(), "resume", run.folder, "--until", "0.3"], capture_output=True, text=True, check=False
    )
    assert resumed.returncode == 2
    assert "plugins of the program" in resumed.stderr


def test_an_exception_of_a_force_ends_the_run(tmp_path):
    def late(time, position, velocity):
        if time > 0.15:
            raise KeyError("from the force")
        return 0 * velocity

    with pytest.raises(KeyError, match="from the force"):
        sphecs.run(channel(), forces=[late], out=tmp_path / "run")
    run = sphecs.open(tmp_path / "run")
    assert run.status == "failed"
    assert "from the force" in run.summary["message"]
    # No frame has a step that lacks a part of its forces.
    assert float(run.particles.time[-1]) < 0.15
    with pytest.raises(TypeError, match="must be functions"):
        sphecs.run(channel(), forces=[3.0], out=tmp_path / "other")


def test_a_folder_in_use_is_kept(tmp_path):
    sphecs.run(channel(), steps=2, out=tmp_path)
    with pytest.raises(sphecs.RunError, match="holds an earlier run") as raised:
        sphecs.run(channel(), steps=2, out=tmp_path)
    assert raised.value.reason == "exists"
    assert sphecs.run(channel(), steps=3, out=tmp_path, force=True).summary["steps"] == 3


def test_the_folder_of_a_scene_has_its_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert sphecs.run(channel(), steps=1, name="plain").folder.resolve() == tmp_path / "runs" / "plain"
    with pytest.raises(sphecs.RunError, match="cannot be the name of a folder"):
        sphecs.run(channel(), steps=1, name="..")


def test_faults_are_those_of_the_command_line(tmp_path):
    scene = tmp_path / "faulty.ron"
    scene.write_text(QUICKSTART.read_text().replace("density:", "densiti:").replace("end: 2.0", "end: -2.0"))
    printed = subprocess.run([binary(), "run", scene], capture_output=True, text=True, check=False, cwd=tmp_path).stderr
    with pytest.raises(sphecs.SceneError) as raised:
        sphecs.run(scene)
    assert str(raised.value).split() == printed.split()
    assert isinstance(raised.value, ValueError)
    first, *_, last = raised.value.faults
    assert (first.line, first.file) == (19, str(scene))
    assert "unknown field `densiti`" in first.message
    assert "density" in first.help
    assert last.line == 32
    assert str(first).startswith(f"{scene}:19:")


def test_a_missing_file_is_a_fault_without_a_place():
    with pytest.raises(sphecs.SceneError, match="No such file") as raised:
        sphecs.run("nowhere.ron")
    assert raised.value.faults[0].line is None


def test_a_flow_that_diverges_is_a_run_error(tmp_path):
    with pytest.raises(sphecs.RunError, match="diverged at step") as raised:
        sphecs.run(box(body_force=("1e9*x", 0)), out=tmp_path / "run", until=1)
    assert raised.value.reason == "diverged"
    assert raised.value.step > 0
    assert "divergence.nc" in str(raised.value)
    assert sphecs.open(tmp_path / "run").status == "diverged"


def test_a_file_that_cannot_be_written_is_a_run_error(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(sphecs.RunError) as raised:
        sphecs.run(channel(), steps=1, out=tmp_path / "file" / "run")
    assert raised.value.reason in ("files", "foreign")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"until": -1}, "until: is -1"),
        ({"threads": 0}, "threads: is 0"),
        ({"ranks": -1}, "ranks: is -1"),
        ({"steps": 1.5}, "steps: is 1.5"),
        ({"verbosity": "loud"}, "`loud`"),
    ],
)
def test_arguments_out_of_range_are_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        sphecs.run(channel(), **arguments)


def test_a_scene_of_another_type_is_refused():
    with pytest.raises(TypeError, match="of type int"):
        sphecs.run(3)
    with pytest.raises(TypeError, match="has its own"):
        sphecs.run(QUICKSTART, name="other")


def test_check_returns_faults_and_notes():
    report = sphecs.check(QUICKSTART, smoke=True, timed=False)
    assert report.ok
    assert any("narrowest passage" in note for note in report.notes)
    assert all(note in str(report) for note in report.notes)
    assert "memory" in report.text

    faulty = sphecs.check(QUICKSTART, set={"fluid.densiti": 1})
    assert not faulty.ok
    assert "densiti" in faulty.faults[0].message
    assert faulty.text.count("unknown field") == 1


PROGRAM = """
import sys, time, sphecs
print("started", flush=True)
try:
    {call}
except KeyboardInterrupt:
    print("interrupted", flush=True)
    {after}
"""


@pytest.mark.parametrize(
    ("call", "after", "expected"),
    [
        # The run closes its files; the program reads them.
        (
            "sphecs.run(sys.argv[1], until=50, out=sys.argv[2])",
            "print(sphecs.open(sys.argv[2]).status)",
            "interrupted",
        ),
        # A simulation continues.
        (
            "s = sphecs.Simulation(sys.argv[1], smoke=True); s.run_until(1000)",
            "before = s.step_count; s.step(); print(s.step_count - before, len(s.state.position) == len(s.state))",
            "1 True",
        ),
    ],
)
def test_ctrl_c_stops_within_a_second(tmp_path, call, after, expected):
    program = textwrap.dedent(PROGRAM).format(call=call, after=after)
    started = subprocess.Popen(
        [sys.executable, "-c", program, str(QUICKSTART), str(tmp_path / "run")], stdout=subprocess.PIPE, text=True
    )
    assert started.stdout.readline() == "started\n"
    time.sleep(1.5)
    sent = time.monotonic()
    os.kill(started.pid, signal.SIGINT)
    assert started.stdout.readline() == "interrupted\n"
    # A busy machine may hold the process back for longer than the engine does.
    assert time.monotonic() - sent < 5
    assert started.stdout.read().strip() == expected
    assert started.wait() == 0


def test_the_command_line_is_a_module():
    shown = subprocess.run([sys.executable, "-m", "sphecs", "--version"], capture_output=True, text=True, check=True)
    assert shown.stdout.strip() == f"sphecs {sphecs.__version__}"
    refused = subprocess.run(
        [sys.executable, "-m", "sphecs", "run", "nowhere.ron"], capture_output=True, text=True, check=False
    )
    assert refused.returncode == 2
    assert "nowhere.ron" in refused.stderr
