"""Build backend of `pip install ./python`: maturin, with the NetCDF library that the machine offers.

The system's libnetcdf is linked where it is installed, which saves minutes. Elsewhere netcdf-c and HDF5 are built from
source, with a CMake from PyPI, and linked statically. `SPHECS_NETCDF=static` or `system` chooses; `SPHECS_PROFILE` is the
profile of cargo, `release` unless it is set.
"""

import os
import shutil
import subprocess
from pathlib import Path

import maturin
from maturin import (  # noqa: F401
    get_requires_for_build_sdist,
    prepare_metadata_for_build_editable,
    prepare_metadata_for_build_wheel,
)


def is_static():
    """Returns true if netcdf-c is built from source."""
    choice = os.environ.get("SPHECS_NETCDF", "")
    if choice not in ("", "static", "system"):
        raise SystemExit(f"SPHECS_NETCDF is `{choice}`, must be `static` or `system`")
    return choice == "static" or (choice == "" and not has_netcdf())


def has_netcdf():
    """Returns true if the system has libnetcdf with its headers."""
    if shutil.which("nc-config") is None:
        return False
    shown = subprocess.run(["nc-config", "--includedir"], capture_output=True, text=True, check=False)
    return (Path(shown.stdout.strip()) / "netcdf.h").exists()


def requirements(of_maturin):
    """Returns the packages that the build needs; Debian 12 has no CMake as new as netcdf-c wants."""
    return of_maturin + (["cmake>=3.26,<4"] if is_static() else [])


def get_requires_for_build_wheel(config_settings=None):
    return requirements(maturin.get_requires_for_build_wheel(config_settings))


def get_requires_for_build_editable(config_settings=None):
    return requirements(maturin.get_requires_for_build_editable(config_settings))


def with_options():
    """Hands features and profile to maturin, which reads them from its environment."""
    options = os.environ.get("MATURIN_PEP517_ARGS", "").split()
    options += ["--profile", os.environ.get("SPHECS_PROFILE", "release")]
    if is_static():
        options += ["--features", "static"]
    os.environ["MATURIN_PEP517_ARGS"] = " ".join(options)


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    with_options()
    return maturin.build_wheel(wheel_directory, config_settings, metadata_directory)


def build_editable(wheel_directory, config_settings=None, metadata_directory=None):
    with_options()
    return maturin.build_editable(wheel_directory, config_settings, metadata_directory)


def build_sdist(sdist_directory, config_settings=None):
    return maturin.build_sdist(sdist_directory, config_settings)
