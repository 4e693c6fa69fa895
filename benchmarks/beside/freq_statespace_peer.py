"""A peer: a linear system with a static polynomial in its feedback, by freq-statespace.

    PYTHON benchmarks/beside/freq_statespace_peer.py TRAIN.csv TEST.csv ...

Prints one line of JSON: the root mean square error of each test in the file's unit, and the seconds
of the processor. It imports nothing of this project. The order of its steps is that of the tool's
own example of the Silverbox (M. Floren, J.-P. Noel, J. Swevers, IEEE Control Systems Letters 9
(2025)), of a third degree and one internal signal there, too.
"""

import json
import sys
import time

import jax
import numpy as np
from scipy.optimize import least_squares

jax.config.update("jax_enable_x64", True)
import freq_statespace as fss  # noqa: E402 (after the precision is set)

STATES, SIGNALS, DEGREE, STARTING = 2, 1, 3, 50
#: Lines of the input that have less than this share of its largest one are not excited.
EXCITED = 1e-2


def read(path):
    """Return the period of the samples, the driving force and the position."""
    seconds, position, force = np.loadtxt(path, delimiter=",", skiprows=1, unpack=True)
    return float(np.median(np.diff(seconds))), force, position


def learn(period, force, position):
    """Return the model of one period of a multisine."""
    lines = np.abs(np.fft.rfft(force - force.mean()))
    excited = np.flatnonzero(lines > EXCITED * lines.max())
    shape = (-1, 1, 1, 1)
    data = fss.create_data_object(
        force.reshape(shape), position.reshape(shape), excited, 1.0 / period
    )
    straight = fss.lin.optimize(fss.lin.subspace_id(data, STATES), data, print_every=-1)
    powers = fss.static.basis.Polynomial(SIGNALS, degree=DEGREE)
    begun = fss.nonlin.inference_and_learning(straight, data, powers, SIGNALS, print_every=-1)
    return fss.nonlin.optimize(begun, data, print_every=-1)


def predict(model, force, position):
    """Return the position, from the state at the start that the first samples tell."""

    def left(start):
        return simulate(model, force[:STARTING], start) - position[:STARTING]

    start = least_squares(left, np.zeros(STATES), x_scale="jac").x
    return simulate(model, force, start)


def simulate(model, force, start):
    """Return the position that a force makes, from a state."""
    found = model.simulate(force.reshape(-1, 1, 1), x0=start.reshape(-1, 1))
    return np.asarray(found[0]).ravel()


def main(train, *tests):
    """Learn, predict, and print."""
    begun = time.process_time()
    model = learn(*read(train))
    seconds = time.process_time() - begun
    errors = []
    for test in tests:
        _, force, position = read(test)
        left = (position - predict(model, force, position))[STARTING:]
        errors.append(float(np.sqrt(np.mean(left**2))))
    print(json.dumps({"errors": errors, "seconds": seconds}))


if __name__ == "__main__":
    main(*sys.argv[1:])
