"""A clinic and the home of P01, which has joined, with the letterbox between them."""

import shutil
from collections.abc import Callable
from contextlib import closing
from datetime import UTC, datetime, timedelta
from pathlib import Path

import msgspec
import pytest

from sar_tui.letterbox import identity, letterbox, post
from sar_tui.letterbox.exchange import Exchanged, exchange
from sar_tui.store import participants, passphrase, programmes
from sar_tui.store.database import StoreConnection, connect
from sar_tui.store.passphrase import Passphrase
from sar_tui.store.programmes import Programme

RIGHT = "quiet river"
CLINIC = "Klinik Bern"
SHORT = {"attempts": 2, "prompts_per_attempt": 2}


class Pair(msgspec.Struct, frozen=True):
    """The data folders, and the letterbox."""

    clinic: Path
    home: Path
    box: Path

    def exchange(self) -> None:
        """Exchange letters until both sides know all."""
        for _ in range(2):
            for data in (self.home, self.clinic):
                exchanged(data)

    def at_clinic(self, do: Callable[[StoreConnection], object]) -> None:
        """Do something with the database of the clinic, and send it."""
        with closing(connect(self.clinic)) as database:
            do(database)
        exchanged(self.clinic)

    def write(self, *texts: str) -> None:
        """Send messages, each a minute after the one before."""
        now = datetime.now(UTC) - timedelta(hours=1)

        def written(database: StoreConnection) -> None:
            for minute, text in enumerate(texts):
                at = now + timedelta(minutes=minute)
                post.write_message(database, "P01", text, author="Ana", now=at)

        self.at_clinic(written)

    def ask(self, form: str) -> None:
        """Ask for a form."""
        now = datetime.now(UTC) - timedelta(hours=1)
        self.at_clinic(lambda db: post.request_form(db, "P01", form, author="Ana", now=now))

    def set_programme(self, task: str = "keyboard", **parameters: object) -> None:
        """Save a programme at the clinic, and send it; of the keyboard task a short one."""
        values = (SHORT if task == "keyboard" else {}) | parameters
        self.at_clinic(lambda db: _save(db, "P01", task, values))


def exchanged(data: Path) -> Exchanged:
    """Exchange letters; nothing is refused, and nothing waits."""
    done = exchange(data)
    assert (done.refused, done.troubles) == ([], []), done
    return done


def _save(
    database: StoreConnection, code: str, task: str, parameters: dict[str, object]
) -> Programme:
    before = programmes.newest(database, code, task).version
    return programmes.save(database, code, task, Programme(parameters), after=before)


@pytest.fixture(scope="session")
def _joined(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("joined")
    clinic, home, box = root / "clinic", root / "home", root / "box"
    letterbox.new(clinic, CLINIC, box)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(passphrase, "_COST", 16)
        Passphrase(clinic).set(RIGHT)
    with closing(connect(clinic)) as database:
        for code in ("P01", "P02"):
            participants.add(database, code)
            _save(database, code, "keyboard", SHORT)
    invited = letterbox.invite(clinic, "P01")
    letterbox.join(home, letterbox.read_invitation(invited.file), invited.code, box)
    Pair(clinic, home, box).exchange()
    return root


@pytest.fixture
def pair(_joined: Path, tmp_path: Path) -> Pair:
    """A clinic and a home of the test's own."""
    root = tmp_path / "pair"
    shutil.copytree(_joined, root)
    found = Pair(root / "clinic", root / "home", root / "box")
    for data in (found.clinic, found.home):
        me = identity.require(data)
        identity.write(data, msgspec.structs.replace(me, folder=str(found.box)))
    return found
