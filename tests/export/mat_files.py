"""Reads MATLAB files of an export, with Octave or with scipy, by their codebook."""

import csv
import math
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import scipy.io

MISSING_NS = -(2**63)
Columns = dict[str, list[Any]]
"""The values of a table's fields, None for a missing one."""

_DUMP = """
function dump(path, value)
  printf("%s %s", path, class(value));
  if iscell(value)
    for c = 1:numel(value) printf(" .%s", sprintf("%02x", uint8(value{c}))); end
  elseif isa(value, "int64") && numel(value)
    printf(" %d", value);
  elseif numel(value)
    printf(" %.17g", value);
  end
  printf("\\n");
end
files = glob("*.mat");
for f = 1:numel(files)
  file = load(files{f});
  name = fieldnames(file){1};
  tables = rmfield(file.(name), "units");
  names = fieldnames(tables);
  for t = 1:numel(names)
    table = tables.(names{t});
    for s = 1:numel(table)
      columns = fieldnames(table(s));
      for c = 1:numel(columns)
        value = table(s).(columns{c});
        if strcmp(columns{c}, "data") value = value'; end
        dump(sprintf("%s %s %s", files{f}, names{t}, columns{c}), value);
      end
    end
  end
end
"""


def with_octave(folder: Path) -> Iterator[tuple[str, str, str, list[Any]]]:
    """Yield file, table, field and its values, as Octave reads them; samples of all sensors one
    after the other.
    """
    command = ["octave-cli", "--eval", _DUMP]
    done = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, check=True, timeout=120
    )
    for line in done.stdout.splitlines():
        file, table, name, kind, *values = line.split(" ")
        read: Callable[[str], Any] = _OCTAVE[kind]
        yield file, table, name, [read(value) for value in values]


def with_scipy(folder: Path) -> Iterator[tuple[str, str, str, list[Any]]]:
    """Yield the same as scipy reads it, without the samples."""
    for path in sorted(folder.glob("*.mat")):
        found = scipy.io.loadmat(path)
        (tables,) = found["session" if path.name.startswith("session_") else "participants"][0]
        for table in set(tables.dtype.names) - {"units", "imu"}:
            (fields,) = tables[table][0]
            for name in fields.dtype.names:
                values = fields[name][:, 0].tolist()
                yield path.name, table, name, [_value(value) for value in values]


def _value(value: Any) -> Any:
    if isinstance(value, int | float):
        return None if value == MISSING_NS or math.isnan(value) else value
    if value.dtype.kind == "U":
        return "".join(value.tolist()) or None
    return bytes(value[0].tolist()).decode() or None


def _number(text: str) -> float | None:
    return None if text == "NaN" else float(text)


_OCTAVE: dict[str, Callable[[str], Any]] = {
    "double": _number,
    "int64": lambda text: None if int(text) == MISSING_NS else int(text),
    "cell": lambda text: bytes.fromhex(text[1:]).decode() or None,
}


def columns(folder: Path, read: Callable[[Path], Any] = with_octave) -> dict[str, Columns]:
    """Return the values of each table, by the names that the columns have in the other formats."""
    full = {(line["table"], line["name"]): line["full_name"] for line in codebook(folder)}
    tables: dict[str, Columns] = {}
    for _, table, name, values in read(folder):
        tables.setdefault(table, {}).setdefault(full[table, name], []).extend(values)
    return tables


def rows(
    folder: Path, table: str, read: Callable[[Path], Any] = with_octave
) -> list[dict[str, Any]]:
    """Return the rows of a table."""
    found = columns(folder, read)[table]
    return [dict(zip(found, values, strict=True)) for values in zip(*found.values(), strict=True)]


def codebook(folder: Path) -> list[dict[str, str]]:
    with (folder / "codebook.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))
