"""Movement science in numpy: detects reaches and repetitions in a sensor's samples, and measures
them.
"""
