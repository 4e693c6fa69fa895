"""The workbench: a local page on which a model is compared, seen to fail, and mended.

What belongs here: a server for one user on this machine, the page that it serves, and what both say
to one another. What does not: anything that a script would want to call; that is the Python
interface (``analysis``), the only thing this package asks.

It runs in these processes: the server, which answers at once; one worker, in which everything runs
that may take long (``worker``), and which is ended where a user cancels; with ``--live`` one that
listens to ROS (``nodes.watch``).
"""
