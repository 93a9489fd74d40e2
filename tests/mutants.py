"""Deliberate faults of the loop, scoring, the store and exports, each of which a test must notice.

``python -m tests.mutants`` makes a copy of the checkout, puts one fault after the other into it, and
runs the tests that may notice it until the first fails. It prints a line for each fault, and ends
with the number that went unnoticed. A fault is found by its text, wherever that stands.
"""
# ruff: noqa: E501  each fault on a line

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

CHECKOUT = Path(__file__).parent.parent


class Mutant(NamedTuple):
    """A fault: ``right`` becomes ``wrong`` in the one file that has it. ``tests``: looked at."""

    what: str
    right: str
    wrong: str
    tests: str


MUTANTS = (
    # --- the loop
    Mutant(
        "A key does not restart the foreperiod",
        "                case m.KeyPerceived() | m.Pasted():\n                    self.trial.false_starts += 1\n                    return False",
        "                case m.KeyPerceived() | m.Pasted():\n                    self.trial.false_starts += 1",
        "loop",
    ),
    Mutant(
        "A response after the time-out counts",
        "if seen.latency_ms(percept.at) > trial.timeout_ms:",
        "if False:",
        "loop",
    ),
    Mutant(
        "An early response is no anticipation",
        "if latency is None or latency >= self.task.parameters.min_rt_ms:",
        "if latency is None or latency >= 0:",
        "loop",
    ),
    Mutant("Keys count before anybody can have read the screen", "UNREAD = 600 * MS", "UNREAD = 60 * MS", "rules loop"),
    Mutant(
        "The next prompt does not wait for the disk",
        "        if not self.status.is_last_trial_stored:\n            self.announce(Phase.STORING)\n        while not self.status.is_last_trial_stored:",
        "        while False:",
        "loop",
    ),
    Mutant(
        "A session goes on without its sensor",
        "if status.blockers.is_sensor_lost and self.needs_sensor:",
        "if False:",
        "loop",
    ),
    Mutant(
        "A stalled prompt is not presented again",
        'case TimeUp("frame" | "timeout", late) if late > STALLED:',
        'case TimeUp("never", late) if late > STALLED:',
        "loop",
    ),
    Mutant("Attempts since the last rest are not counted anew", "self._attempts_since_rest = 0\n\n    def end_rest", "pass\n\n    def end_rest", "loop runs"),
    # --- scoring
    Mutant(
        "A result that equals the goal succeeds",
        'return value < than if self.better == "lower" else value > than',
        'return value <= than if self.better == "lower" else value >= than',
        "rules model loop",
    ),
    Mutant(
        "The minimum accuracy is not enough",
        "accurate = score.accuracy is None or score.accuracy >= min_accuracy",
        "accurate = score.accuracy is None or score.accuracy > min_accuracy",
        "rules loop",
    ),
    Mutant(
        "Of two participants, one success is enough",
        "outcome = min(\n        (judgement.outcome for judgement in judgements.values()), key=_FAILURE_FIRST.index\n    )",
        "outcome = max(\n        (judgement.outcome for judgement in judgements.values()), key=_FAILURE_FIRST.index\n    )",
        "loop tasks",
    ),
    Mutant("A level rises beyond the highest", "min(state.level + 1, bounds.highest)", "state.level + 1", "rules loop"),
    Mutant("A streak survives a change of outcome", "before.length + 1 if before and before.outcome == attempt.outcome else 1", "before.length + 1 if before else 1", "rules loop"),
    # --- the store
    Mutant("A commit is not synced to the disk", '        database.execute("PRAGMA synchronous=FULL")\n        database', '        database.execute("PRAGMA synchronous=OFF")\n        database', "store"),
    Mutant(
        "The hash of a message leaves out its text",
        'hashed.update(f"{row.seq} {row.run} {row.at} {row.text}".encode())',
        'hashed.update(f"{row.seq} {row.run} {row.at}".encode())',
        "store",
    ),
    Mutant("Discarded sessions count", 'SET_ASIDE = ("discarded", "refused")', 'SET_ASIDE = ("refused",)', "store app reports"),
    Mutant(
        "Trials are acknowledged before they are written",
        "        self._queue.append(cascade)\n        if self._inline:",
        "        self._queue.append(cascade)\n        for one in cascade:\n            if isinstance(one.message, m.TrialEnded) and not self._inline:\n                self._bus.post(STORED, _stored(one.message))\n        if self._inline:",
        "store end_to_end",
    ),
    # --- exports
    Mutant("Typed texts leave unasked", 'return column.treatment != "text" or self.with_notes', "return True", "export"),
    Mutant(
        "Dates of a recoded export are the true ones",
        "found[index] = lambda value, _: shifted(value, days)",
        "found[index] = lambda value, _: shifted(value, 0)",
        "export",
    ),
    Mutant("A formula in a text leaves as one", "return f\"'{shown}\" if _FORMULA.match(value) and not _NUMBER.fullmatch(value) else shown", "return shown", "export"),
    # --- letters
    Mutant("A letter to another reader is believed", "    if letter.reader != bytes(secret.public_key):", "    if False:", "letterbox"),
    Mutant("A letter of a number that was taken is taken again", "        if (before := known.get(letter.number)) is not None:", "        if (before := known.get(-1)) is not None:", "letterbox"),
    Mutant("A home may change a session of another person", '"FROM other.sessions AS there WHERE EXISTS "', '"FROM other.sessions AS there WHERE 0 AND EXISTS "', "letterbox"),
    Mutant("A letter that was lost is not put there again", "\"UPDATE letters SET put_at='' WHERE", "\"UPDATE letters SET put_at=put_at WHERE", "letterbox"),
    Mutant("A letter that nobody acknowledges is never put there again", "        return not -PUT_AGAIN_AFTER < age < PUT_AGAIN_AFTER", "        return False", "letterbox"),
    Mutant("A revoked home is believed", 'if one.state == "revoked":\n                    raise Forged', 'if one.state == "nothing":\n                    raise Forged', "letterbox"),
    Mutant("An invitation is valid for ever", 'return "expired" if is_late else ""', 'return ""', "letterbox"),
    Mutant("A letter is not padded", "sodium_pad(signed, size)", "sodium_pad(signed, 16)", "letterbox"),
    Mutant("Sessions of letters stay in the order of their arrival", "put_in_order(db, sessions.added if is_letter else ())", "put_in_order(db)", "letterbox"),
    Mutant("An earlier state writes under numbers that were used", "stored.change(db, sender.id, least_number=farther + 1)", "pass", "letterbox"),
)  # fmt: skip


def main() -> None:
    names = sys.argv[1:]
    unnoticed = 0
    with tempfile.TemporaryDirectory() as name:
        copy = Path(name) / "checkout"
        ignored = shutil.ignore_patterns(".git", ".venv", "__pycache__", "*.db", "results")
        shutil.copytree(CHECKOUT, copy, ignore=ignored)
        for number, mutant in enumerate(MUTANTS, 1):
            if names and str(number) not in names:
                continue
            noticed_by = _try(copy, mutant)
            unnoticed += not noticed_by
            print(f"{number:2} {mutant.what}: {noticed_by or 'UNNOTICED'}", flush=True)
    print(f"{unnoticed} unnoticed")
    sys.exit(unnoticed)


def _try(copy: Path, mutant: Mutant) -> str:
    """Return the first test that fails with a fault; empty if none does."""
    found = [path for path in (copy / "sar_tui").rglob("*.py") if mutant.right in path.read_text()]
    if len(found) != 1:
        return f"NOT FOUND in {len(found)} files"
    (path,) = found
    before = path.read_text()
    path.write_text(before.replace(mutant.right, mutant.wrong))
    try:
        folders = [f"tests/{name}" for name in mutant.tests.split()]
        run = subprocess.run(
            [sys.executable, "-m", "pytest", "-q", "-x", "-m", "not slow", "-p", "no:cacheprovider", *folders],
            cwd=copy,
            env={**os.environ, "PYTHONPATH": str(copy), "SAR_TUI_TEST_EXAMPLES": "few"},
            capture_output=True,
            text=True,
            check=False,
        )  # fmt: skip
    finally:
        path.write_text(before)
    failed = [line for line in run.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
    return (
        failed[0].split(" - ")[0] if failed else ("" if run.returncode == 0 else run.stdout[-200:])
    )


if __name__ == "__main__":
    main()
