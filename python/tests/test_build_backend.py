"""Choices of the build of the package: which NetCDF library, which profile."""

import importlib.util
import os
import sys
import types

import pytest
from scenes import ROOT

#: Functions of maturin that the backend takes over.
TAKEN = (
    "get_requires_for_build_editable",
    "get_requires_for_build_sdist",
    "get_requires_for_build_wheel",
    "prepare_metadata_for_build_editable",
    "prepare_metadata_for_build_wheel",
)


@pytest.fixture
def backend(monkeypatch):
    """Returns the backend with a maturin that returns the options it would read."""
    maturin = types.ModuleType("maturin")
    for name in TAKEN:
        setattr(maturin, name, lambda settings=None: ["of maturin"])
    maturin.build_wheel = lambda *arguments: os.environ["MATURIN_PEP517_ARGS"]
    monkeypatch.setitem(sys.modules, "maturin", maturin)
    for name in ("MATURIN_PEP517_ARGS", "SPHECS_NETCDF", "SPHECS_PROFILE"):
        # Set first, so that what the backend sets is removed afterwards.
        monkeypatch.setenv(name, "")
        monkeypatch.delenv(name)
    spec = importlib.util.spec_from_file_location("build_backend", ROOT / "python" / "build_backend.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_library_of_the_system_is_linked_where_it_is_installed(backend, monkeypatch):
    monkeypatch.setattr(backend, "has_netcdf", lambda: True)
    assert backend.get_requires_for_build_wheel() == ["of maturin"]
    assert backend.build_wheel("wheels") == "--profile release"


def test_the_library_is_built_where_there_is_none(backend, monkeypatch):
    monkeypatch.setattr(backend, "has_netcdf", lambda: False)
    assert backend.get_requires_for_build_wheel() == ["of maturin", "cmake>=3.26,<4"]
    assert backend.build_wheel("wheels") == "--profile release --features static"


def test_the_environment_chooses(backend, monkeypatch):
    monkeypatch.setattr(backend, "has_netcdf", lambda: True)
    monkeypatch.setenv("SPHECS_NETCDF", "static")
    monkeypatch.setenv("SPHECS_PROFILE", "dev")
    monkeypatch.setenv("MATURIN_PEP517_ARGS", "--offline")
    assert backend.build_wheel("wheels") == "--offline --profile dev --features static"
    monkeypatch.setenv("SPHECS_NETCDF", "none")
    with pytest.raises(SystemExit, match="must be `static` or `system`"):
        backend.is_static()
