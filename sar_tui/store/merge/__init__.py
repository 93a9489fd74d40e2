"""Brings what another database has into this one."""
