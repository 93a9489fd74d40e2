"""The rules of Psych-DS in code, with the names of its errors (psych-ds.github.io, schema)."""

import csv
import json
import re
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

_NAME = re.compile(r"([a-z]+-[a-zA-Z0-9]+)(_[a-z]+-[a-zA-Z0-9]+)*_data\.csv")
_KEYWORDS = set("study site subject session task condition trial stimulus description".split())
_ROOT = {"dataset_description.json", "README.md", "README.txt", "CHANGES.md", "CHANGES.txt",
         ".psychdsignore"}  # fmt: skip
_SCHEMA_ORG = [f"http{s}://schema.org{end}" for s in ("s", "") for end in ("/", "")]


def complaints(folder: Path) -> list[str]:
    """Return the rules that a data set breaks; those for warnings about files and keywords, too."""
    about = json.loads((folder / "dataset_description.json").read_text("utf-8"))
    found = [] if about.get("@context") in _SCHEMA_ORG else ["INVALID_JSONLD_FORMATTING"]
    if about.get("@type") != "Dataset":
        found.append("INCORRECT_DATASET_TYPE")
    found += [
        f"JSON_KEY_REQUIRED {key}"
        for key in ("name", "description", "variableMeasured")
        if not about.get(key)
    ]
    tables = sorted((folder / "data").rglob("*_data.csv"))
    if not tables:
        found.append("MISSING_DATAFILE")
    for path in tables:
        found += _of_table(path, about)
    ignored = (folder / ".psychdsignore").read_text("utf-8").split()
    for path in folder.rglob("*"):
        name = path.relative_to(folder).as_posix()
        if path.is_dir() or any(fnmatch(name, pattern) for pattern in ignored):
            continue
        is_known = name in _ROOT or path in tables or path.with_suffix(".csv") in tables
        found += [] if is_known else [f"FILE_NOT_CHECKED {name}"]
    return found


def _of_table(path: Path, about: dict[str, Any]) -> list[str]:
    found = []
    if not _NAME.fullmatch(path.name):
        found.append(f"FILENAME_KEYWORD_FORMATTING_ERROR {path.name}")
    if {part.partition("-")[0] for part in path.stem.split("_")[:-1]} - _KEYWORDS:
        found.append(f"FILENAME_UNOFFICIAL_KEYWORD_WARNING {path.name}")
    beside = path.with_suffix(".json")
    compiled = {**about, **(json.loads(beside.read_text("utf-8")) if beside.exists() else {})}
    variables = compiled.get("variableMeasured", [])
    names = [each if isinstance(each, str) else each["name"] for each in variables]
    if any(isinstance(each, dict) and "@type" not in each for each in variables):
        found.append("OBJECT_TYPE_MISSING")
    with path.open(encoding="utf-8", newline="") as file:
        head, *rows = csv.reader(file, strict=True)
    if not head:
        found.append(f"CSV_HEADER_MISSING {path.name}")
    if len(set(head)) < len(head):
        found.append(f"CSV_HEADER_REPEATED {path.name}")
    if any(len(row) != len(head) for row in rows):
        found.append(f"CSV_HEADER_LENGTH_MISMATCH {path.name}")
    found += [
        f"CSV_COLUMN_MISSING_FROM_METADATA {path.name} {name}" for name in head if name not in names
    ]
    if "row_id" in head and len({row[head.index("row_id")] for row in rows}) < len(rows):
        found.append(f"ROWID_VALUES_NOT_UNIQUE {path.name}")
    return found
