"""Mistakes of authors: what `sar-tui tasks check` prints on each, with the author's own line."""

import re
from pathlib import Path

import pytest

from sar_tui.checks.task import check
from tests.documented import FILES, PAGES, write_documented
from tests.edit import edit
from tests.examples import first
from tests.program import Call

STIMULUS = "    def stimulus"
SILENT = "    def rehearse(self, stimulus, performance, streams):\n        return []\n\n"
TYPED = "A TextPerceived has seat, at, delay, loop_lag, repeat, stalled, text, began, keys, "
LOADED = "✗ can be loaded. The task {} cannot be loaded: "
USED = "✗ can be loaded. The task {} cannot be used: "
PLAYED = "✗ runs a whole session with a poor participant. "
DETAILS = "✗ stores the details that it declares. "
PROMPTS = "✗ makes the same one-line prompts when asked twice. "
MISTAKES = {
    "syntax": ("arrows", "return Result(", "return Result((",
        LOADED.format("arrows") + "task.py:23: '(' was never closed."),
    "unknown import": ("arrows", "Stimulus, Task\n", "Stimulus, Tasks\n", LOADED.format("arrows")
        + "task.py:1: cannot import name 'Tasks' from 'sar_tui.api.task'. The names of this version"),
    "exit on import": ("arrows", "\n\nclass Arrows", "\n\nraise SystemExit(0)\n\n\nclass Arrows",
        LOADED.format("arrows") + "task.py:4: SystemExit: 0."),
    "other name": ("arrows", 'name = "arrows"', 'name = "arows"',
        "✗ can be loaded. The task in the folder arrows has the name arows; the two must be the same."),
    "missing method": ("arrows", "def instructions", "def instruction",
        "✗ can be loaded. The task arrows does not define instructions."),
    "arguments of a method": ("arrows", "perceived(self, trial, percept)", "perceived(self, trial)",
        USED.format("arrows") + "task.py:22: perceived() takes (trial, percept), found (trial)."),
    "property without @property": ("arrows", "    @property\n", "", USED.format("arrows")
        + "task.py:11: trials_per_attempt is a property: write @property above it."),
    "misspelt method": ("arrows", STIMULUS, "    def timedout(self, trial):\n        return None\n\n    def stimulus",
        "! names its methods as the contract does. task.py:18: timedout is never called. Did you " "mean timed_out?"),
    "empty title": ("arrows", 'title = "Arrows"', 'title = " "',
        "✗ declares its title and metric. task.py:6: Its title is empty."),
    "no plain metric": ("arrows", '"reaction_time"', '"the time"',
        "✗ declares its title and metric. task.py:7: Its metric's name is not a plain word"),
    "parameter without help": ("speed", "    threshold:", "    extra: int = 3\n    threshold:",
        "✗ describes every parameter: title, help, bounds. task.py:10: extra lacks help and bounds"),
    "default out of bounds": ("speed", "] = 10\n", "] = 60\n",
        "✗ has defaults within their own bounds. task.py:7: The default of "
        "prompts_per_attempt breaks its own bounds."),
    "parameter without default": ("speed", "] = 700.0", "]",
        USED.format("speed") + "task.py:10: these parameters have no default: threshold."),
    "sensor without parameter": ("twist", "    imu:", "    sensor:",
        "✗ describes every parameter: title, help, bounds. task.py:31: It has a motion sensor, and no parameter "
        "imu (a str) that names it."),
    "text without translation": ("speed", "Press the arrow key that appears.", "Press the key of the arrow.",
        "✗ has all its texts in each of its languages. task.py:35: words.es.toml has no translation "
        "of 'Press the key of the arrow. There are {count}.'."),
    "no trials": ("arrows", "return 10", "return 0",
        PROMPTS + "task.py:12: It has 0 trials in an attempt at level 1; it needs one."),
    "two lines": ("arrows", 'f"Press: {key}"', 'f"Press:\\n{key}"',
        PROMPTS + "task.py:18: The prompt's text is not one line of plain text at level 1, trial 1:"),
    "random prompt": ("arrows", "situation.streams.choice(",
        "(lambda keys, name: keys[__import__('time').monotonic_ns() // 100 % 4])(",
        PROMPTS + "task.py:18: The prompt differs when asked for again at level 1, trial"),
    "error in a prompt": ("arrows", 'choice(("left", "right", "up", "down"), "order")', 'choice((), "order")',
        PROMPTS + "task.py:19: "),
    "unknown attribute": ("arrows", "percept.key,", "percept.ky,",
        PLAYED + "task.py:24: AttributeError: 'KeyPerceived' object has no attribute 'ky'. A "
        "KeyPerceived has seat, at,"),
    "other kind of percept": ("arrows", "expected=key,", 'expected=key, expects="text",',
        PLAYED + f"task.py:24: AttributeError: 'TextPerceived' object has no attribute 'key'. {TYPED}"),
    "unknown argument": ("arrows", "correct=percept", "corect=percept",
        PLAYED + "task.py:23: TypeError: Unexpected keyword argument 'corect'."),
    "no result": ("arrows", "return Result(", "return True or Result(",
        PLAYED + "task.py:22: TypeError: a trial ended with True, which is no Result"),
    "every trial timed out": ("arrows", "return Result(", "return None and Result(",
        PLAYED + "task.py:22: Every trial timed out: perceived() returned None for each of"),
    "nobody answers": ("arrows", STIMULUS, SILENT + STIMULUS,
        PLAYED + "task.py:18: Every trial timed out: the simulated person never answers, as "
        "rehearse() returned no act."),
    "error in rehearse": ("arrows", STIMULUS, SILENT.replace("[]", "[(1 / 0, 'left')]") + STIMULUS,
        PLAYED + "task.py:19: ZeroDivisionError: division by zero."),
    "no value": ("arrows", "value=trial.latency_ms(percept.at)", "value=None",
        PLAYED + "task.py:22: 10 of 10 attempts have no metric: no trial in them was right and had " "a value."),
    "infinite value": ("arrows", "value=trial.latency_ms(percept.at)", "value=float('inf')", PLAYED + "task.py:22: "),
    "empty goal": ("arrows", STIMULUS, "    def goal(self, level):\n        return ''\n\n" + STIMULUS,
        "✗ gives instructions, and a goal for each level. task.py:18: The goal is empty at level 1."),
    "undeclared detail": ("arrows", "response_at=", 'details={"side": 1}, response_at=',
        DETAILS + "task.py:26: Its Details do not declare side."),
    "detail of another type": ("simon", "agrees: Annotated[bool | None,", "agrees: Annotated[int | None,",
        DETAILS + "task.py:10: Its Details declare agrees otherwise than it is stored,"),
    "percept of a stray key": ("twist", "if not isinstance(percept, ReachPerceived):", "if percept.closed is None:",
        "✗ judges each kind of percept. task.py:47: perceived() is given a KeyPerceived too, "
        "whenever a key is pressed, and raised AttributeError"),
    "state": ("arrows", "        return Result(\n            response=percept.key,",
        "        self.n = getattr(self, 'n', 0) + 1\n"
        "        return Result(\n            response=percept.key + str(self.n),",
        "✗ keeps no state from call to call. task.py:22: In perceived, at attempt "),
    "other result when asked again": ("arrows", "value=trial", "value=__import__('time').monotonic() + trial",
        "✗ keeps no state from call to call. task.py:22: In perceived, at attempt "),
    "goal out of reach": ("speed", "] = 700.0", "] = 101.0",
        "✗ changes its level. task.py:10: The level stays at 1 for every participant. Is the goal (101) within "
        "reach?"),
    "wide line": ("arrows", "Press: {key}", f"Press{'.' * 80}{{key}}",
        "! draws its prompts large. These plain lines are wider than a terminal of 80 columns"),
}  # fmt: skip
"""A task of the page, an edit (what stands there, and what is put in its place), and the line that the
check prints.
"""


@pytest.mark.parametrize("name", first(12, MISTAKES))
def test_a_mistake_is_named_at_the_line_of_the_author(tmp_path: Path, name: str) -> None:
    task, old, new, printed = MISTAKES[name]
    files = ("task", "twists") if task == "twist" else ("task",)
    folder = write_documented(tmp_path, task, *files)
    if (task, "words.es.toml") in FILES:
        words = FILES[task, "words.es.toml"]
        (folder / "words.es.toml").write_text(words, encoding="utf-8")
    edit(folder / "task.py", old, new)
    lines = (done.line for done in check(folder))
    said = next(line for line in lines if not line.startswith("✓"))
    assert said.startswith(printed)


def test_the_page_shows_lines_that_are_printed() -> None:
    shown = re.findall(r"^\| \*(.+?)\*(?: …)? \|", PAGES[0], re.MULTILINE)
    assert shown
    printed = [line for *_, line in MISTAKES.values()]
    assert [line for line in shown if not any(line in each for each in printed)] == []


def test_the_command_prints_the_line_and_no_traceback(tmp_path: Path, call: Call) -> None:
    folder = write_documented(tmp_path, "arrows")
    edit(folder / "task.py", "percept.key,", "percept.ky,")
    called = call("tasks", "check", folder)
    assert called.code == 1
    assert MISTAKES["unknown attribute"][3] in called.out
    assert "Traceback" not in called.out + called.err
