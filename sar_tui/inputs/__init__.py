"""Sensor interfaces: one a device. Each turns a device into messages, stamped at the source."""
