"""Orders of conditions between which people differ, so that no order favours a condition."""

from typing import Literal

Order = Literal["fixed", "latin square", "williams"]


def rows(conditions: tuple[str, ...], order: Order) -> tuple[tuple[str, ...], ...]:
    """Return the orders, a row each.

    - ``fixed``: as they are listed.
    - ``latin square``: each condition is once at each position.
    - ``williams``: and follows each other one equally often (Williams 1949, Aust J Sci Res A
      2:149-168). With an odd number of conditions there are twice as many rows.
    """
    count = len(conditions)
    match order:
        case "fixed":
            first_rows: list[list[int]] = [list(range(count))]
        case "latin square":
            first_rows = [[(start + at) % count for at in range(count)] for start in range(count)]
        case "williams":
            first_rows = _williams(count)
    return tuple(tuple(conditions[index] for index in row) for row in first_rows)


def _williams(count: int) -> list[list[int]]:
    """Return the rows as indices: a zigzag 0, 1, n-1, 2, n-2, …, and the same moved on by one."""
    zigzag = [0, *((at + 1) // 2 if at % 2 else count - at // 2 for at in range(1, count))]
    square = [[(index + start) % count for index in zigzag] for start in range(count)]
    return square + [row[::-1] for row in square] if count % 2 else square
