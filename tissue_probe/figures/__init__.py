"""Pictures of maps and estimates, as Matplotlib figures.

Contents: functions that take measurements and return a Figure; saving it is the caller's.
Nothing here touches Matplotlib's global state, so any thread may call it.
"""
