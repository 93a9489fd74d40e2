"""The place of a session in a study."""

import msgspec


class StudyPlace(msgspec.Struct, frozen=True, kw_only=True):
    """The place of a session in a study, stored with it.

    Attributes:
        study, version: of the plan.
        visit, block: names of them.
        condition: its name; in a blind study a neutral code.
        position: of the condition in the person's order, from 1; 1 without an order.
    """

    study: str
    version: int
    visit: str
    block: str
    condition: str
    position: int = 1
