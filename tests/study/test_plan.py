"""A mistake in a plan is told with its line and the reason."""

import re
from itertools import pairwise
from pathlib import Path

import pytest

from sar_tui.model.toml_lines import TomlLines
from sar_tui.plugins import Catalogue
from sar_tui.study.conditions import problems_here, warnings
from sar_tui.study.new_plan import new_plan
from sar_tui.study.plan import PlanError, orders, parse_plan, read_plan
from tests.study.plans import TWO_GROUPS, plan

MISTAKES = (
    ('condition = "praised"', 'condition = "prised"', 8, "no condition 'prised'"),
    ("[groups.silent]\n", "[groups.Silent]\n", 9, "A name begins with a letter a to z"),
    ("attempts = 3\nlevel = 3", "attempts = 0\nlevel = 3", 36, "1 to 200, not 0"),
    ("attempts = 3\nlevel = 3", 'attempts = "many"\nlevel = 3', 36, "This must be a whole number"),
    ("level = 3", "levle = 3", 37, "nothing named levle here. Did you mean level?"),
    ('level = "first/baseline"', 'level = "second/training"', 51, "It is one of: first/baseline"),
    ('order = "latin square"', 'order = "greek"', 41, "'williams', not 'greek'"),
    ('conditions = ["slow", "fast"]', 'conditions = ["slow"]', 40, "two or more"),
    ("day = 7", "day = 0", 45, "not after that of the visit first"),
    ("window = [2, 2]", "window = [2]", 46, "length 2"),
    ('block = "training"\ncompared', 'block = "play"\ncompared', 27, "no block 'play'"),
    ('title = "Praise', "title = Praise", 3, "not valid TOML"),
    ('name = "second"\nday', 'name = "first"\nday', 44, "Two visits are named 'first'"),
    ("baseline = {", "base = {", 29, "nothing named base"),
)


@pytest.mark.parametrize(("old", "new", "line", "reason"), MISTAKES)
def test_a_mistake_is_told_with_its_line(old: str, new: str, line: int, reason: str) -> None:
    assert TWO_GROUPS.count(old) >= 1
    with pytest.raises(PlanError) as told:
        parse_plan(TWO_GROUPS.replace(old, new, 1), "study.toml")
    assert str(told.value).startswith(f"study.toml, line {line}: ")
    assert reason in str(told.value)
    assert str(told.value).endswith((".", "?"))


def test_several_mistakes_are_told_each_with_its_line() -> None:
    changed = (
        ('task = "keyboard"', 'tsk = "keyboard"'),
        ("level = 3", "level = []"),
        ("window = [2, 2]", "window = [2]"),
        ('compared = "groups, baseline"', 'compared = "group"'),
    )
    text = TWO_GROUPS
    for old, new in changed:
        text = text.replace(old, new, 1)
    with pytest.raises(PlanError) as told:
        parse_plan(text, "study.toml")
    lines = sorted(int(line) for line in re.findall(r"line (\d+)", str(told.value)))
    assert lines == [13, 28, 37, 46]


@pytest.mark.parametrize("named", ["retest = 4", "sizes = [1]", "efect = 3"])
def test_a_mistake_in_the_assumptions_is_told_with_its_own_line(named: str) -> None:
    text = f"{TWO_GROUPS}[power]\neffect = 20\n{named}\n"
    with pytest.raises(PlanError, match=r"line 54: \[power\]"):
        parse_plan(text, "study.toml")


@pytest.mark.parametrize("within", [True, False])
@pytest.mark.parametrize("names", [["a", "b"], ["a", "b", "c"]])
def test_a_new_plan_can_be_used_as_it_is(names: list[str], within: bool) -> None:
    text = new_plan("new", "keyboard", names, within=within, days=[0, 7])
    study = parse_plan(text, "study.toml")
    assert not [*problems_here(study, Catalogue(())), *warnings(study, Catalogue(()))]


HERE = (
    ('task = "keyboard"', 'task = "keybord"', 13, "keybord"),
    ("threshold = 1500", "treshold = 1500", 20, "no setting treshold"),
    ("threshold = 1500", "threshold = -5", 20, "Goal"),
    ("level = 3", "level = 99", 33, "no level 99"),
)


@pytest.mark.parametrize(("old", "new", "line", "reason"), HERE)
def test_what_is_not_here_is_told_with_its_line(old: str, new: str, line: int, reason: str) -> None:
    text = TWO_GROUPS.replace(old, new, 1)
    (key, said), *_ = problems_here(parse_plan(text, "study.toml"), Catalogue(()))
    told = TomlLines(text, "study.toml").at(key, said)
    assert told.startswith(f"study.toml, line {line}: ")
    assert reason in told


def test_a_plan_without_mistakes_can_be_used_here() -> None:
    assert not [*problems_here(plan(), Catalogue(()))]


def test_a_file_that_cannot_be_read_is_refused(tmp_path: Path) -> None:
    with pytest.raises(PlanError, match="cannot be read"):
        read_plan(tmp_path / "none.toml")
    (tmp_path / "latin.toml").write_bytes(b"name = '\xe4'")
    with pytest.raises(PlanError, match="not a text in UTF-8"):
        read_plan(tmp_path / "latin.toml")


@pytest.mark.parametrize("count", range(2, 9))
def test_each_condition_is_once_at_each_position(count: int) -> None:
    names = tuple("abcdefgh"[:count])
    for order in ("latin square", "williams"):
        square = orders_of(names, order)
        for position in range(count):
            column = [row[position] for row in square]
            assert all(column.count(name) == len(square) // count for name in names)


@pytest.mark.parametrize("count", range(2, 9))
def test_in_a_williams_design_each_condition_follows_each_other_equally_often(count: int) -> None:
    names = tuple("abcdefgh"[:count])
    square = orders_of(names, "williams")
    pairs = [pair for row in square for pair in pairwise(row)]
    counts = {pair: pairs.count(pair) for pair in set(pairs)}
    assert len(counts) == count * (count - 1)
    assert len(set(counts.values())) == 1


def orders_of(names: tuple[str, ...], order: str) -> tuple[tuple[str, ...], ...]:
    """Return the orders of a plan with these conditions."""
    conditions = "".join(f'[conditions.{name}]\ntask = "keyboard"\n' for name in names)
    block = f'name = "all"\nconditions = {list(names)}\norder = "{order}"\n'
    text = f'name = "orders"\n{conditions}[[visits]]\nname = "only"\n[[visits.blocks]]\n{block}'
    return orders(plan(text), names)


def test_the_orders_of_a_plan_are_those_of_its_square() -> None:
    assert orders(plan(), ("slow", "fast")) == (("slow", "fast"), ("fast", "slow"))


def test_the_plan_on_the_page_can_be_used() -> None:
    page = Path("docs/run-a-study.md").read_text(encoding="utf-8")
    (text,) = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    study = parse_plan(text, "study.toml")
    assert not [*problems_here(study, Catalogue(())), *warnings(study, Catalogue(()))]
    moving = parse_plan(text.replace('"fixed"', '"one-up-one-down"'), "study.toml")
    assert len([*warnings(moving, Catalogue(()))]) == 2


@pytest.mark.parametrize(
    ("change", "line", "said"),
    [
        (("[2, 2]", "[9, 2]"), "window", "opens on day -2, before the visit first can have been"),
        (("[outcome]", '[prereg]\nexclusion = "None."\n[outcome]'), "exclusion", "no question"),
    ],
)
def test_windows_and_answers_that_cannot_be_are_refused_before_a_plan_is_frozen(
    change: tuple[str, str], line: str, said: str
) -> None:
    ((key, problem),) = problems_here(plan(TWO_GROUPS.replace(*change)), Catalogue(()))
    assert key[-1] == line
    assert said in problem


def test_a_code_that_can_be_read_is_told() -> None:
    def told(text: str) -> list[str]:
        return [each for each in warnings(plan(text), Catalogue(())) if "code" in each]

    blind = TWO_GROUPS.replace("[outcome]", "[allocation]\nblind = true\n[outcome]", 1)
    (one,) = told(blind)
    assert "first/baseline names the condition unpraised" in one
    assert told(TWO_GROUPS) == []
    assert told(blind.replace('"unpraised"\nattempts', '"slow"\nattempts')) == []
