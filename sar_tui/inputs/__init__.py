"""Sensor interfaces, one for each device. Each turns a device into messages, stamped at the
source.
"""
