"""Statistical claims of this project, each a simulation."""
