"""Files about the whole data set: its description, participants, and README."""

from collections import Counter
from collections.abc import Iterable
from pathlib import Path

from sar_tui import __version__
from sar_tui.export.dataset_name import dataset_name
from sar_tui.export.formats.bids.study import Study
from sar_tui.export.formats.bids.tsv import described, write_json, write_rows

VERSION = "1.10.0"
"""The version of BIDS that the files follow."""
SOURCE = "sourcedata/sar-tui"
"""The folder of the tables that BIDS has no place for."""
_BESIDE = ("timing.json", "methods.md", "sar-tui-export.json")
"""Files that every export has beside those of its format."""
_README = """\
# {name}

Exported by sar-tui {version} as a BIDS {bids} data set. {modes}

- `sub-*/ses-*/beh/*_beh.tsv`: a row for each trial, practice included (column `practice`). `run` in a file name is the
  run of the program: a session that was resumed has several.
- `*_events.tsv`: trials, attempts, the agent's actions, notes, and faults of sensors. In `beh/`, onsets count from
  `acq_time` in `_scans.tsv`; in `motion/`, from the first sample.
- `sub-*/ses-*/motion/`: the samples of motion sensors. Where samples are missing, a row of n/a stands.
- `sub-*/*_sessions.tsv`: each session with its status. Interrupted, dismissed and empty sessions are included;
  those that are discarded (started by mistake) or refused belong into no analysis of training.
- `phenotype/`: scores of instruments, and answers about pain and tiredness.
- `{source}/`: all tables that BIDS has no place for, as CSV with `datapackage.json`: parameters of the sessions,
  programmes, attempts, all actions with the decisions on them, adverse events, and others.
- `methods.md`, `timing.json`, `sar-tui-export.json`: methods in words, the measured timing of the machine, and the
  SHA-256 of every file. BIDS has no place for them: they are named in `.bidsignore`.

In a text, a tab, a line end, a backslash, and a quote at its beginning are written as in JSON: `\\t`, `\\n`, `\\r`,
`\\\\`, `\\"`. A value that is missing is n/a.

Age, sex and handedness are not in the database, so `participants.tsv` does not have them. Add them, and the authors and
the licence in `dataset_description.json`, before you publish.
"""


def write_dataset(
    study: Study, left_out: Iterable[str], notices: Iterable[str], folder: Path
) -> None:
    """Write the description, the participants, the README, and the names of the files that BIDS
    does not know.

    Args:
        left_out: sentences on what is not in the data set.
        notices: sentences on what is not described.
    """
    name = dataset_name({session.row["mode"] for session in study.sessions})
    write_json(
        folder / "dataset_description.json",
        {
            "Name": name,
            "BIDSVersion": VERSION,
            "DatasetType": "raw",
            "GeneratedBy": [
                {
                    "Name": "sar-tui",
                    "Version": __version__,
                    "Description": "Sessions were recorded by sar-tui, and exported from its "
                    "database.",
                }
            ],
        },
    )
    columns = study.columns("participants")
    rows = [
        (f"sub-{study.subjects[code]}", *row)
        for code in study.owners("participants")
        for row in study.values("participants", code)
    ]
    write_rows(
        folder / "participants.tsv", ("participant_id", *(column.name for column in columns)), rows
    )
    write_json(folder / "participants.json", described(columns))
    said = [
        _README.format(
            name=name, version=__version__, bids=VERSION, modes=_modes(study), source=SOURCE
        )
    ]
    for title, told in (("Not described", notices), ("Left out", left_out)):
        if sentences := [f"- {sentence}\n" for sentence in dict.fromkeys(told)]:
            said.append("".join([f"## {title}\n\n", *sentences]))
    (folder / "README.md").write_text("\n".join(said), encoding="utf-8")
    (folder / ".bidsignore").write_text("".join(f"{name}\n" for name in _BESIDE), encoding="utf-8")


def _modes(study: Study) -> str:
    """Return a sentence on how many sessions are live, and how many are not."""
    counts = Counter({session.id: session.row["mode"] for session in study.sessions}.values())
    told = ", ".join(f"{number} {mode}" for mode, number in sorted(counts.items()))
    return f"Sessions: {told or 'none'} (column `mode` of `_sessions.tsv` and `_beh.tsv`)."
