"""The shape of a force that no law of the library has, learnt from a model's residual."""
