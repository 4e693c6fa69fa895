"""Pictures of maps and estimates, as Matplotlib figures.

What belongs here: functions that take what was measured and return a Figure; saving it is the
caller's. What does not: computing anything that is not merely drawn, and the live web page
(``workbench``). Nothing here touches Matplotlib's global state, so any thread may call it.
"""
