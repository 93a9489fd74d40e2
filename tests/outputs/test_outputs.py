"""Outputs by name: nodes for a session, or a clear error."""

from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.task import Task
from sar_tui.loop.topics import OUTPUT
from sar_tui.model.units import MS
from sar_tui.outputs.output import Output, OutputError, Report
from sar_tui.outputs.outputs import check_outputs, open_outputs, output_names
from sar_tui.plugins import Catalogue
from sar_tui.rules.declaration import ParameterError
from sar_tui.runs.plan import Plan, make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import sessions
from sar_tui.store.database import connect
from tests.outputs.contract import THEME as PLAIN_THEME
from tests.outputs.fake_outputs import FakeOutput, Speaker
from tests.plugged_in import offer

PlugIn = Callable[..., None]


NO_SET = "The can of the output lamp is not a frozenset of: say, show, gesture, gaze, tone."


def entry(name: str, make: Any) -> Any:
    return SimpleNamespace(name=name, value=f"somewhere:{name}", load=lambda: make)


@pytest.fixture
def plug_in(monkeypatch: pytest.MonkeyPatch) -> PlugIn:
    """Install an output with its factory."""
    entries: list[Any] = []
    offer(monkeypatch, "sar_tui.outputs", entries)
    return lambda name, make: entries.append(entry(name, make))


def made(*addresses: str) -> list[tuple[str, tuple[str, ...]]]:
    """Return the names and parts of the outputs of some addresses."""
    nodes = open_outputs(addresses, "sound", PLAIN_THEME)
    return [(node.name, tuple(sorted(node._can))) for node in nodes]


def problem(*addresses: str, speech: str = "sound") -> str:
    with pytest.raises(OutputError) as caught:
        check_outputs(addresses, speech)
    return str(caught.value)


# --- by name


def test_each_output_is_made_with_its_abilities_and_the_screen_by_others() -> None:
    assert made("screen") == []
    assert made("screen", "speech") == [("speech", ("say",))]
    for address, name, abilities in (
        ("servo", "servo", {"gesture"}),
        ("ros://localhost:9090", "ros", {"say", "gesture"}),
        ("ros4hri://localhost", "ros4hri", {"say", "gesture", "gaze"}),
        ("furhat://localhost?wave=Wink", "furhat", {"say", "gesture", "gaze"}),
        ("reachy://localhost:8000", "reachy", {"say", "gesture", "gaze"}),
    ):
        ((output, can),) = made(address)
        assert output == name
        assert abilities <= set(can)


@pytest.mark.parametrize(
    ("address", "can"),
    [
        ("tones", ("tone",)),
        ("tones:success", ("tone",)),
        ("tones:go+end", ()),
        ("tones:", ("tone",)),
    ],
)
def test_tones_accompany_praise_only_on_request(address: str, can: tuple[str, ...]) -> None:
    assert made(address) == [("tones", can)]


def test_tones_precede_speech_in_any_order_of_names() -> None:
    for names in (("speech", "tones"), ("tones", "speech")):
        assert [name for name, _ in made(*names)] == ["tones", "speech"]


# --- what cannot be


@pytest.mark.parametrize(
    ("addresses", "says"),
    [
        ("speach", 'There is no output "speach". Did you mean speech? Choose one of: '),
        ("", 'There is no output ""'),
        ("speech speech", "The output speech is named twice"),
        ("tones:go screen tones:end", "The output tones is named twice"),
        ("tones:gong", 'There is no tone "gong". Choose one of: go, success, end'),
        ("speech:loud", "belongs to the setting speech"),
        ("screen:big", 'it was given "big"'),
        *((address, "") for address in ("servo:?joint=", "servo:x")),
        *((address, "") for address in ("ros", "ros:", "ros://", "ros://host:port")),
        *((f"{name}://", f"Use {name}://HOST") for name in ("ros4hri", "furhat", "reachy")),
        ("reachy://robot?wave=hello", "wave"),
        ("furhat://robot?sing=la", "sing"),
        ("ros4hri://robot?eyes=tall", "eyes"),
    ],
)
def test_an_invalid_address_is_reported_in_a_sentence(addresses: str, says: str) -> None:
    sentence = problem(*addresses.split(" "))
    assert says in sentence
    assert sentence.endswith(".")
    assert "Error" not in sentence


def test_the_destination_of_speech_must_exist(tmp_path: Path) -> None:
    check_outputs(["speech"], f"file:{tmp_path / 'not yet'}")
    (tmp_path / "taken").write_text("")
    assert "is a file" in problem("speech", speech=f"file:{tmp_path / 'taken'}")
    assert problem("speech", speech="somewhere").endswith(".")


# --- plug-ins


def test_an_output_of_a_plug_in_is_made_with_its_options(plug_in: PlugIn) -> None:
    plug_in("lamp", FakeOutput)
    assert output_names() == [
        *("furhat", "lamp", "reachy", "ros", "ros4hri", "screen", "servo", "speech", "tones")
    ]
    (node,) = open_outputs(["lamp:red:3"], "sound", PLAIN_THEME)
    assert node.name == "red:3"


def raising(error: Exception) -> Callable[[str], Output]:
    def make(_: str) -> Output:
        raise error

    return make


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (
            raising(RuntimeError("no lamp")),
            "(somewhere:lamp) cannot be loaded: RuntimeError: no lamp.",
        ),
        (raising(OutputError("There is no such lamp.")), "There is no such lamp."),
        (lambda text: text, "The output lamp is not an Output."),
        (lambda text: Output(), "The output lamp has no name."),
        (lambda text: FakeOutput(7), "The output lamp has no name."),
        (lambda text: FakeOutput("lamp", None), NO_SET),
        (lambda text: FakeOutput("lamp", frozenset({"fly"})), NO_SET),
    ],
)
def test_an_unusable_plug_in_is_reported_in_a_sentence(
    plug_in: PlugIn, make: Any, says: str
) -> None:
    plug_in("lamp", make)
    assert problem("lamp").endswith(says)


def test_an_output_made_for_a_check_is_opened_once_and_then_a_new_one_is_made(
    plug_in: PlugIn,
) -> None:
    lamps: list[FakeOutput] = []

    def lamp(text: str) -> Output:
        lamps.append(FakeOutput(text))
        return lamps[-1]

    plug_in("lamp", lamp)
    for session in (1, 2):
        check_outputs(["lamp:red"])
        check_outputs(["screen", "lamp:red"])
        (node,) = open_outputs(["lamp:red"], "sound", PLAIN_THEME)
        assert node.output is lamps[-1]
        assert len(lamps) == session
    check_outputs(["lamp:red"])
    check_outputs(["lamp:blue"])
    assert [lamp.name for lamp in lamps] == ["red", "red", "red", "blue"]


def test_a_reinstalled_plug_in_makes_its_own_output(
    plug_in: PlugIn, monkeypatch: pytest.MonkeyPatch
) -> None:
    plug_in("lamp", lambda text: FakeOutput("old"))
    check_outputs(["lamp"])
    offer(monkeypatch, "sar_tui.outputs", [entry("lamp", lambda text: FakeOutput("new"))])
    assert [name for name, _ in made("lamp")] == ["new"]


@pytest.mark.parametrize(
    ("name", "beside"), [("servo", "servo"), ("screen", "screen"), ("twin", "other")]
)
def test_two_plug_ins_of_one_name_are_refused(plug_in: PlugIn, name: str, beside: str) -> None:
    plug_in("lamp", lambda text: FakeOutput(name))
    plug_in("other", lambda text: FakeOutput("twin"))
    assert f'is called "{name}" as well as ' in problem(beside, "lamp")
    check_outputs(["speech", "lamp"])


def test_a_plug_in_cannot_replace_a_shipped_output(plug_in: PlugIn) -> None:
    plug_in("speech", lambda text: FakeOutput("mine"))
    assert made("speech") == [("speech", ("say",))]


# --- in a session


def plan(keyboard: type[Task], **parameters: Any) -> Plan:
    settings = {"attempts": 1, "prompts_per_attempt": 2, **parameters}
    return make_plan(Catalogue(), keyboard, ["P01"], settings, seed=1, mode="simulated")


def test_a_session_does_not_start_with_an_invalid_output(keyboard: type[Task]) -> None:
    with pytest.raises(ParameterError) as caught:
        plan(keyboard, outputs=("speach",))
    assert set(caught.value.problems) == {"outputs"}


def test_a_simulated_session_uses_and_records_its_outputs(
    keyboard: type[Task], data: Path, catalogue: Catalogue, plug_in: PlugIn
) -> None:
    speaker = Speaker(700)
    plug_in("voice", lambda text: speaker)
    settings = {"outputs": ["screen", "voice:low"], "attempts": 2, "encouragement": False}
    session = simulate(plan(keyboard, **settings), PEOPLE["average"], data, catalogue)
    with closing(connect(data)) as database:
        actions = sessions.rows(database, "actions", session)
        history = list(sessions.history(database, session))
        row = sessions.find(database, data, session)
    opened = [record.message for record in history if record.topic is OUTPUT]
    assert [(one.output, one.address, one.can) for one in opened] == [
        ("speech", "voice:low", ("say",))
    ]
    assert row["parameters"]["outputs"] == ["screen", "voice:low"]
    accepted = [action for action in actions if action["decision"] == "accepted"]
    assert [text for _, text in speaker.said] == [one["final"]["spoken"] for one in accepted]
    assert actions[-1]["kind"] == "goodbye"
    lasted = {one["kind"]: (one["ended_ns"] - one["started_ns"]) / MS for one in accepted}
    assert lasted == {"greeting": 700, "instruction": 500, "feedback": 700, "goodbye": 700}, (
        "the instruction is left after 1200 ms, and the goodbye heard to its end"
    )


# --- outputs of earlier versions


def test_an_output_with_the_method_wear_is_refused_in_a_sentence(plug_in: PlugIn) -> None:
    plug_in("lamp", lambda text: type("Lamp", (Output,), {"name": "lamp", "wear": print}))
    assert "rename its method wear to apply_theme" in problem("lamp")


def test_an_output_may_report_by_the_earlier_name() -> None:
    reports: list[Report] = []
    output = FakeOutput()
    output.open(PLAIN_THEME, VirtualClock(), reports.append)
    output.tell("a1", "say", "started")
    assert [(report.action, report.part, report.state) for report in reports] == [
        ("a1", "say", "started")
    ]
