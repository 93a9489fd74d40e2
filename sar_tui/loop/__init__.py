"""The closed loop: sense, judge, adapt, answer. Pure Python: no screen, no device, no SQL, no
network.
"""
