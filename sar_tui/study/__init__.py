"""Studies: the plan, who is enrolled, what is due, and what came of it."""
