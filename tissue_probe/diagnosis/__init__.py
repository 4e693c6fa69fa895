"""What a model of tissue misses: where it fails, which effect explains it, what adding it gains.

What belongs here: judging models by measurements, as pure functions on arrays. What does not:
the equations of models and effects (``physics``), reading files (``recording``), pictures
(``figures``).
"""
