"""Device and protocol code that inputs and outputs share."""
