"""Records: all that a person enters or answers beside the trials, each of a declared kind."""
