"""The ex-Gaussian distribution of reaction times (Luce 1986; Heathcote, Popiel & Mewhort 1991)."""

from random import Random


def ex_gaussian(generator: Random, mean: float, sigma: float, tau: float) -> float:
    """Draw the sum of a normal part with standard deviation ``sigma`` and an exponential tail with
    mean ``tau``.

    ``mean`` is that of the sum.
    """
    return generator.gauss(mean - tau, sigma) + generator.expovariate(1 / tau)
