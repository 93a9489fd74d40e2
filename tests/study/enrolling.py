"""Enrols people one after another, and prints each: run as a program, to be killed."""

import sys
from contextlib import closing
from pathlib import Path

from sar_tui.store.database import connect
from sar_tui.study import enrolment, ledger


def enrol(folder: Path, key: Path, prefix: str, number: int) -> None:
    with closing(connect(folder)) as db:
        frozen = ledger.find(db)
        for at in range(number):
            enrolled = enrolment.enrol(db, frozen, f"{prefix}{at:03}", key)
            print(enrolled.participant, enrolled.group, flush=True)


if __name__ == "__main__":
    enrol(Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3], int(sys.argv[4]))
