"""SHA-256 sums of the data in the files of a run, independent of the names of columns and fields."""

import hashlib
import json
import re
import struct
from pathlib import Path

import netCDF4
import numpy

# Columns of a checkpoint that hold a stored resource in MessagePack.
RECORD_PREFIXES = ("record.", "resource.")
# Columns that hold the progress of a run, with its wall-clock times; its rows are in the output.
PROGRESS_PREFIX = "run."
# Numbers that depend on the machine, the moment or the wording, by the name of their field.
UNSTEADY = re.compile(r"wall_?(time|clock).*|(.*_)?(seconds|bytes|stages|threads|pid|host|version)")


def sha256(*parts: bytes) -> str:
    digest = hashlib.sha256()
    for part in parts:
        digest.update(part)
    return digest.hexdigest()


class MessagePack:
    """Reads the numbers of a MessagePack value in their order; names of fields and texts are passed over."""

    SIZES = {0xCA: ">f", 0xCB: ">d", 0xCC: ">B", 0xCD: ">H", 0xCE: ">I", 0xCF: ">Q"}
    SIZES |= {0xD0: ">b", 0xD1: ">h", 0xD2: ">i", 0xD3: ">q"}

    def __init__(self, data: bytes, skip):
        self.data, self.skip, self.at, self.leaves = data, skip, 0, []

    @classmethod
    def numbers(cls, data: bytes, skip=lambda name: False) -> bytes:
        reader = cls(data, skip)
        reader.value(True)
        if reader.at != len(data):
            raise ValueError("bytes are left over after the value")
        return b"".join(reader.leaves)

    def take(self, count: int) -> bytes:
        taken = self.data[self.at : self.at + count]
        if len(taken) != count:
            raise ValueError("the value is cut off")
        self.at += count
        return taken

    def unsigned(self, width: int) -> int:
        return int.from_bytes(self.take(width), "big")

    def leaf(self, kind: bytes, data: bytes, keep: bool):
        if keep:
            self.leaves.append(kind + data)

    def value(self, keep: bool):
        tag = self.unsigned(1)
        if tag <= 0x7F or tag >= 0xE0:
            self.leaf(b"i", struct.pack(">q", tag if tag <= 0x7F else tag - 256), keep)
        elif tag in (0xC0, 0xC2, 0xC3):
            self.leaf({0xC0: b"n", 0xC2: b"f", 0xC3: b"t"}[tag], b"", keep)
        elif tag in (0xCA, 0xCB):
            self.leaf(b"r", self.take(struct.calcsize(self.SIZES[tag])), keep)
        elif tag in self.SIZES:
            (number,) = struct.unpack(self.SIZES[tag], self.take(struct.calcsize(self.SIZES[tag])))
            # MessagePack chooses the width by the value.
            self.leaf(b"i", number.to_bytes(8 if number < 2**63 else 9, "big", signed=True), keep)
        elif 0xA0 <= tag <= 0xBF or tag in (0xD9, 0xDA, 0xDB):
            self.text(tag)
            self.leaf(b"s", b"", keep)
        elif tag in (0xC4, 0xC5, 0xC6):
            self.leaf(b"b", self.take(self.unsigned(1 << (tag - 0xC4))), keep)
        elif 0x90 <= tag <= 0x9F or tag in (0xDC, 0xDD):
            count = tag & 0x0F if tag <= 0x9F else self.unsigned(2 if tag == 0xDC else 4)
            for _ in range(count):
                self.value(keep)
        elif 0x80 <= tag <= 0x8F or tag in (0xDE, 0xDF):
            count = tag & 0x0F if tag <= 0x8F else self.unsigned(2 if tag == 0xDE else 4)
            for _ in range(count):
                self.value(keep and not self.skip(self.key()))
        else:
            raise ValueError(f"MessagePack type {tag:#x} is not known here")

    def text(self, tag: int) -> str:
        length = tag & 0x1F if tag <= 0xBF else self.unsigned(1 << (tag - 0xD9))
        return self.take(length).decode(errors="replace")

    def key(self) -> str:
        tag = self.data[self.at]
        if 0xA0 <= tag <= 0xBF or tag in (0xD9, 0xDA, 0xDB):
            self.at += 1
            return self.text(tag)
        # A key that is data: counts as a number.
        self.value(True)
        return ""


def checkpoint(path: Path) -> dict[str, str]:
    """Sums of the columns of a checkpoint: time and step, particles, stored resources."""
    data = path.read_bytes()
    if data[:8] != b"\x89sphecs\n":
        raise ValueError(f"{path} does not begin as a checkpoint does")
    at = 12  # mark and version

    def take(count: int) -> bytes:
        nonlocal at
        at += count
        return data[at - count : at]

    def unsigned(width: int) -> int:
        return int.from_bytes(take(width), "little")

    sums = {"facts": sha256(MessagePack.numbers(take(unsigned(4)), UNSTEADY.fullmatch))}
    take(4)
    for _ in range(unsigned(4)):
        name = take(unsigned(2)).decode()
        kind = take(unsigned(1))
        values = take(unsigned(8))
        take(4)
        if name.startswith(PROGRESS_PREFIX):
            continue
        if name.startswith(RECORD_PREFIXES):
            sums[name] = sha256(b"record", MessagePack.numbers(values, UNSTEADY.fullmatch))
        else:
            sums[name] = sha256(kind, b"\0", values)
    if at != len(data) - 32:
        raise ValueError(f"{path} has another layout than this script knows")
    return sums


def netcdf(path: Path) -> dict[str, str]:
    """Sums of the numeric variables of a NetCDF file."""
    sums = {}

    def group(node, prefix):
        for name, variable in node.variables.items():
            variable.set_auto_maskandscale(False)
            variable.set_auto_chartostring(False)
            if variable.dtype is str or numpy.dtype(variable.dtype).kind not in "iufb":
                continue
            if UNSTEADY.fullmatch(name):
                continue
            values = numpy.ascontiguousarray(variable[...])
            about = f"{values.dtype.newbyteorder('<').str} {values.shape}".encode()
            sums[prefix + name] = sha256(about, values.astype(values.dtype.newbyteorder("<")).tobytes())
        for name, child in node.groups.items():
            group(child, f"{prefix}{name}/")

    with netCDF4.Dataset(path) as dataset:
        group(dataset, "")
    return sums


def csv(path: Path) -> dict[str, str]:
    """Sums of the columns of a CSV file below its header, texts left out."""
    rows = [line.split(",") for line in path.read_text().splitlines() if line and not line.startswith("#")]
    if not rows:
        return {}
    sums = {}
    header, rows = rows[0], rows[1:]
    for column, name in enumerate(header):
        if UNSTEADY.fullmatch(name):
            continue
        cells = [row[column] if column < len(row) else "" for row in rows]
        numeric = [cell for cell in cells if re.fullmatch(r"-?([0-9.]+([eE][-+]?[0-9]+)?|inf)|NaN|nan", cell)]
        # Columns of names have no number.
        if numeric or not any(cells):
            sums[f"{name}#{column}"] = sha256("\n".join(cells).encode())
    return sums


def summary(path: Path) -> dict[str, str]:
    """Sums of the numbers of summary.json, one for each field of the top level."""

    def numbers(value, into):
        if isinstance(value, dict):
            for name, child in value.items():
                if not UNSTEADY.fullmatch(name):
                    numbers(child, into)
        elif isinstance(value, list):
            for child in value:
                numbers(child, into)
        elif isinstance(value, bool) or value is None:
            into.append(str(value))
        elif isinstance(value, (int, float)):
            into.append(repr(value))

    sums = {}
    for name, value in json.loads(path.read_text()).items():
        into = []
        if not UNSTEADY.fullmatch(name):
            numbers(value, into)
        if into:
            sums[name] = sha256("\n".join(into).encode())
    return sums


def combined(sums: dict[str, str]) -> str:
    """One sum of all columns, whatever their names and order."""
    return sha256("\n".join(sorted(sums.values())).encode())


def run_folder(folder: Path) -> dict[str, dict[str, str]]:
    """The sums of each file of a run, by the name of the file."""
    found = {}
    for path in sorted(folder.glob("*.nc")):
        found[path.name] = netcdf(path)
    for path in sorted([*folder.glob("*.csv"), *folder.glob("probes/*.csv")]):
        found[path.relative_to(folder).as_posix()] = csv(path)
    for path in sorted(folder.glob("summary.json")):
        found[path.name] = summary(path)
    # The last one is of the last step; wall-clock time may have chosen the step of another.
    for path in sorted(folder.glob("checkpoints/*.checkpoint"))[-1:]:
        found["checkpoint"] = checkpoint(path)
    return found
