"""Samples of any robot that carries a force sensor, out of its messages: live and in bags."""
