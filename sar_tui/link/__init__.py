"""The session's topics between processes and machines: discovery, certificates, admission and
transport.
"""
