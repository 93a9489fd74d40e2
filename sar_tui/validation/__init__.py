"""What the thesis claims, and what we do, tried out: each file one claim's experiment, listed in ``registry``."""
