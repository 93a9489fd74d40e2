"""Statistical claims of this project, and the simulations that they are tested by."""
