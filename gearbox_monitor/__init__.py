"""Condition monitor for robot joint gearboxes."""

__version__ = '0.1.0'
