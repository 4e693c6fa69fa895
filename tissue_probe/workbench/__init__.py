"""The workbench: a local page on which a model is compared, seen to fail, and mended.

Contents: a server for one user on this machine, the page that it serves, and the messages between
both.

It runs in these processes: the server, which answers at once; one worker, in which everything runs
that may take long (``worker``), and which is ended where a user cancels; with ``--live`` one that
listens to ROS (``nodes.watch``).
"""
