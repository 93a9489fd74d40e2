"""Settings that every task has, in groups. `parameters.TaskParameters` holds all of them."""
