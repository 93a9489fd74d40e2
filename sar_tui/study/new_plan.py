"""The text of a new plan, from the answers to five questions."""

from collections.abc import Sequence

from sar_tui.store.database import StoreError


def new_plan(
    name: str, task: str, conditions: Sequence[str], *, within: bool, days: Sequence[int]
) -> str:
    """Return a plan as TOML, to be filled in.

    Args:
        name: of the study.
        task: of all conditions.
        conditions: their names.
        within: True if each person does all conditions, in an order of their own; False if people
            are allocated to groups.
        days: of the visits, the first of which is day 0.

    Raises:
        StoreError: there are fewer than two conditions, or the days are not in order.
    """
    if len(set(conditions)) < 2:
        raise StoreError("A study compares two conditions or more.", bad_input=True)
    if not days or days[0] != 0 or sorted(set(days)) != list(days):
        raise StoreError("Days are in order, and begin with 0: 0, 7, 14.", bad_input=True)
    lines = [
        f'name = "{name}"',
        "version = 1",
        f'title = "{name}"',
        'hypothesis = ""',
        "",
        "# What is compared: the mean of the task's measure in the last block.",
        "[outcome]",
        f'visit = "visit-{len(days)}"',
        'block = "training"',
        f'compared = "{"within" if within else "groups"}"',
    ]
    if within and len(conditions) > 2:
        lines.append(f"conditions = {_list(conditions[:2])}")
    if not within:
        lines += ["", "[allocation]", 'method = "blocks"', "blind = false"]
        for condition in conditions:
            lines += ["", f"[groups.{condition}]", f'condition = "{condition}"']
    lines += [
        "",
        f"# Each setting that is not named has its default; `sar-tui tasks show {task}` lists all.",
        "# The level is fixed, as results depend on it.",
    ]
    for condition in conditions:
        lines += [
            f"[conditions.{condition}]",
            f'task = "{task}"',
            'theme = "calm"',
            'settings = { difficulty_policy = "fixed" }',
            "",
        ]
    lines.pop()
    for number, day in enumerate(days, 1):
        lines += ["", "[[visits]]", f'name = "visit-{number}"', f"day = {day}"]
        lines.append(f"window = [{2 if day else 0}, {2 if day else 0}]")
        lines += ["", "[[visits.blocks]]", 'name = "training"']
        if within:
            order = "williams" if len(conditions) % 2 == 0 else "latin square"
            lines += [f"conditions = {_list(conditions)}", f'order = "{order}"']
        else:
            lines.append('condition = "as allocated"')
        lines.append("attempts = 10")
    return "\n".join(lines) + "\n"


def _list(names: Sequence[str]) -> str:
    return f"[{', '.join(f'{chr(34)}{name}{chr(34)}' for name in names)}]"
