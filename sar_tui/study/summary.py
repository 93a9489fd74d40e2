"""A summary of a plan, in a few lines."""

from collections.abc import Iterator

from sar_tui.study.plan import Block, Study, orders


def summary(plan: Study) -> Iterator[str]:
    """Yield lines on a plan: name, groups, conditions, visits and their blocks."""
    yield f"{plan.title or plan.name}: version {plan.version} of the study {plan.name} is fine."
    if plan.groups:
        named = ", ".join(f"{name} ({each.condition})" for name, each in plan.groups.items())
        blind = ", blind" if plan.allocation.blind else ""
        yield f"Groups: {named}; allocated by {plan.allocation.method}{blind}."
    conditions = ", ".join(f"{name} ({each.task})" for name, each in plan.conditions.items())
    yield f"Conditions: {conditions}."
    for visit in plan.visits:
        before, after = visit.window
        days = f" ({before} days before to {after} after)" if before or after else ""
        yield f"Visit {visit.name}, day {visit.day}{days}:"
        for block in visit.blocks:
            yield f"  {block.name}: {_block(plan, block)}"
    if plan.consent:
        yield f"Nobody begins without consent to version {plan.consent.version} of the text."


def _block(plan: Study, block: Block) -> str:
    if block.form:
        return f"the form {block.form}"
    what = block.condition or ", ".join(block.conditions)
    if block.conditions and block.order != "fixed":
        what += f" in {len(orders(plan, block.conditions))} orders ({block.order})"
    attempts = f", {block.attempts} attempts" if block.attempts else ""
    purpose = "" if block.purpose == "training" else f", {block.purpose}"
    level = "" if block.level is None else f", level {block.level}"
    return f"{what}{attempts}{level}{purpose}"
