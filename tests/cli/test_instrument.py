"""``sar-tui instrument``: scores entered by hand appear in progress."""

from sar_tui.progress.instruments import INSTRUMENTS
from tests.program import Call


def test_scores_appear_in_progress_with_their_sources(call: Call) -> None:
    assert call("instrument add p01 fma-ue 34 --on 2026-03-01 --new").code == 0
    assert (
        "FMA-UE 45 of P01, 2026-05-01, is saved."
        in call("instrument add P01 FMA-UE 45 --on 2026-05-01").out
    )
    shown = call("progress P01").out
    assert "34 on 2026-03-01, 45 on 2026-05-01; change +11. Reaches MDC 6.8 points" in " ".join(
        shown.split()
    )
    spanish = " ".join(call("progress P01 --note --language es").out.split())
    assert (
        "34 el 2026-03-01, 45 el 2026-05-01; cambio +11. Alcanza MDC 6,8 puntos, 1 a 6 semanas"
        in spanish
    )
    assert "doi:10.1177/15459683231186985" in spanish
    (found,) = call("progress P01 --json").json["instruments"]
    assert (found["instrument"]["name"], found["change"]) == ("FMA-UE", 11.0)
    assert [each["reached"] for each in found["reached"]] == [True] * 5


def test_the_list_has_every_instrument(call: Call) -> None:
    listed = call("instrument list").out
    assert [name for name in INSTRUMENTS if name not in listed] == []
    assert [each["name"] for each in call("instrument list --json").json["instruments"]] == list(
        INSTRUMENTS
    )


def test_a_score_that_cannot_be_is_told_in_a_sentence(call: Call) -> None:
    called = call("instrument add P01 BBT 500 --on 2026-05-01 --new")
    assert (called.code, called.out) == (2, "")
    assert "A score of BBT lies between 0 and 150, not at 500." in called.err


def test_a_score_entered_by_mistake_is_removed(call: Call) -> None:
    call("instrument add P01 BBT 30 --on 2026-05-01 --new")
    removed = call("instrument remove p01 bbt --on 2026-05-01")
    assert removed.out == "BBT 30 of P01, 2026-05-01, is removed, and kept in the database.\n"
    assert call("instrument remove P01 BBT --on 2026-05-01").code == 2
    assert call("progress P01 --json").json["instruments"] == []
