"""The BIDS validator as a judge, and the warnings that an export is allowed."""

import json
import shutil
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

ALLOWED = {
    "NO_AUTHORS Authors": "The program does not know the authors.",
    "TOO_FEW_AUTHORS": "The same.",
    "JSON_KEY_RECOMMENDED License": "The researcher decides.",
    "JSON_KEY_RECOMMENDED HEDVersion": "Events have no HED tags.",
    "JSON_KEY_RECOMMENDED SourceDatasets": "The data have no source but this program.",
    "SIDECAR_KEY_RECOMMENDED CogAtlasID": "The tasks are in no atlas.",
    "SIDECAR_KEY_RECOMMENDED CogPOID": "The same.",
    "SIDECAR_KEY_RECOMMENDED Instructions": "What the agent says may name participants.",
    "SIDECAR_KEY_RECOMMENDED InstitutionName": "The program does not know the institution.",
    "SIDECAR_KEY_RECOMMENDED InstitutionAddress": "The same.",
    "SIDECAR_KEY_RECOMMENDED InstitutionalDepartmentName": "The same.",
    "SIDECAR_KEY_RECOMMENDED Manufacturer": "The sensor reports its model only.",
    "SIDECAR_KEY_RECOMMENDED SoftwareVersions": "The same.",
    "SIDECAR_KEY_RECOMMENDED DeviceSerialNumber": "Serial numbers never leave.",
    "SIDECAR_KEY_RECOMMENDED SubjectArtefactDescription": "Nobody has looked for artefacts yet.",
    "SIDECAR_KEY_RECOMMENDED SamplingFrequencyEffective": "A recording of one sample has none.",
}
"""Warnings, each with the reason. The same list is in docs/archive-in-bids.md."""
_READABLE = "/tmp" if Path("/tmp").is_dir() else None
"""The validator's runtime never reads below /dev, where tests have their files if there is
/dev/shm.
"""


class Issue(NamedTuple):
    """An issue: "error" or "warning", what it is, and where."""

    severity: str
    what: str
    where: str


def judge(folder: Path) -> list[Issue]:
    """Return the issues that the BIDS validator finds in all rows of a data set."""
    validator = Path(sys.executable).with_name("bids-validator-deno")
    with TemporaryDirectory(dir=_READABLE) as place:
        copied = shutil.copytree(folder, Path(place) / "dataset")
        command = [validator, "--format", "json", "--max-rows", "-1", copied]
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=120, check=False
        )  # 16: errors
    assert done.stdout, done.stderr
    issues = json.loads(done.stdout)["issues"]["issues"]
    return [
        Issue(
            each["severity"],
            " ".join(filter(None, (each["code"], each.get("subCode")))),
            each["location"],
        )
        for each in issues
    ]


def complaints(folder: Path) -> list[Issue]:
    """Return all errors, and the warnings that are not allowed."""
    return [
        issue for issue in judge(folder) if issue.severity != "warning" or issue.what not in ALLOWED
    ]
