"""Configuration with which LSL finds streams of this machine only, for benchmarks and tests."""

ON_THIS_MACHINE = """[ports]
IPv6 = disable
[multicast]
ResolveScope = machine
[lab]
KnownPeers = {127.0.0.1}
"""
