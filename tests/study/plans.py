"""Plans of studies for tests."""

from pathlib import Path

from sar_tui.study.plan import Study, parse_plan

TWO_GROUPS = """
name = "praise"
title = "Praise and reaction time"
sites = ["BERN", "GENF"]
hypothesis = "People are faster with praise."

[groups.praise]
condition = "praised"
[groups.silent]
condition = "unpraised"

[conditions.praised]
task = "keyboard"
settings = { feedback_form = "qualitative", prompts_per_attempt = 4 }
[conditions.unpraised]
task = "keyboard"
settings = { feedback_schedule = "none", prompts_per_attempt = 4 }
[conditions.slow]
task = "keyboard"
settings = { threshold = 1500, prompts_per_attempt = 4 }
[conditions.fast]
task = "keyboard"
settings = { threshold = 800, prompts_per_attempt = 4 }

[outcome]
visit = "second"
block = "training"
compared = "groups, baseline"
baseline = { visit = "first", block = "baseline" }

[[visits]]
name = "first"
[[visits.blocks]]
name = "baseline"
condition = "unpraised"
attempts = 3
level = 3
[[visits.blocks]]
name = "speeds"
conditions = ["slow", "fast"]
order = "latin square"
attempts = 2
[[visits]]
name = "second"
day = 7
window = [2, 2]
[[visits.blocks]]
name = "training"
condition = "as allocated"
attempts = 3
level = "first/baseline"
"""
"""Two groups, two visits, and two conditions within people."""

WITH_FORMS = (
    TWO_GROUPS.replace(
        '[[visits]]\nname = "second"',
        '[[visits.blocks]]\nname = "strain"\nform = "effort"\n[[visits]]\nname = "second"',
    )
    + '[[visits.blocks]]\nname = "usability"\nform = "SUS"\n'
)
"""The same with a form at the end of each visit."""


def plan(text: str = TWO_GROUPS) -> Study:
    """Return the plan in a text."""
    return parse_plan(text, "study.toml")


def written(folder: Path, text: str = TWO_GROUPS) -> Path:
    """Write a plan into a file."""
    path = folder / "study.toml"
    path.write_text(text)
    return path
