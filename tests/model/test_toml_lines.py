"""Lines of the values of a TOML text, and of the mistakes in it."""

import pytest

from sar_tui.model.toml_lines import Key, TomlError, TomlLines, decode

TEXT = """name = \'\'\'
[not.a.table]
\'\'\'
reasons.1 = "early"
'quoted key' = 2

[arm.left]
reach = [
  [1, 2],
  [3],
]
grip.force = 3

[[steps]]
at = "start"
[[steps]]
at = "end"
[[steps.parts]]
do = 1
"""


@pytest.mark.parametrize(
    ("key", "line"),
    [
        (("name",), 1),
        (("reasons",), 4),
        (("quoted key",), 5),
        (("arm",), 7),
        (("arm", "left", "grip"), 12),
        (("steps",), 14),
        (("steps", 1, "at"), 17),
        (("steps", 1, "parts", 0, "do"), 19),
        (("steps", 1, "missing"), 16),
        (("missing",), 1),
    ],
)
def test_a_value_is_found_at_its_line_or_at_that_of_its_table(key: Key, line: int) -> None:
    assert TomlLines(TEXT).line(key) == line


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a = 1\nb =", "line 2: This is not valid TOML: invalid value."),
        ('a = 1\nb = "c', "line 2: This is not valid TOML: "),
        ("a = " + "[" * 5000, "line 1: This is not valid TOML: it is nested too deeply."),
    ],
)
def test_a_text_that_is_not_toml_is_refused_with_the_line(text: str, said: str) -> None:
    with pytest.raises(TomlError) as refused:
        decode(text)
    assert str(refused.value).startswith(said)
