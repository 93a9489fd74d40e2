"""Roles of people, which leave in place of their names."""

ROLES = ("agent", "operator", "participant", "therapist", "stop", "other")
"""``stop`` is the participant's stop key, ``other`` anybody whose role is not known."""


def role(actor: str | None) -> str | None:
    """Return the role of an actor: "operator" for "operator.op1"."""
    if not actor:
        return None
    found = actor.partition(".")[0]
    return found if found in ROLES else "other"
