"""Samples of any robot that carries a force sensor, out of what it publishes: live and in bags."""
