"""A peer: a small neural state-space model, by jax-sysid, in an environment of its own.

    PYTHON benchmarks/beside/jax_sysid_peer.py TRAIN.csv TEST.csv ...

Prints one line of JSON: the root mean square error of each test in the file's unit, and the seconds
of the processor. It imports nothing of this project.
"""

import json
import sys
import time

import jax
import jax.numpy as jnp
import numpy as np

jax.config.update("jax_enable_x64", True)
from jax_sysid.models import Model  # noqa: E402 (after the precision is set)

STATES, NEURONS, STARTING = 4, 8, 50
ADAM, LBFGS = 500, 1500


def read(path):
    """Return the driving force and the position, a column each."""
    _, position, force = np.loadtxt(path, delimiter=",", skiprows=1, unpack=True)
    return force[:, None], position[:, None]


@jax.jit
def state(x, u, params):
    """Return the next state: straight in state and input, and one layer beside."""
    a, b, c, d, e, _ = params
    both = jnp.concatenate([x, u])
    return a @ x + b @ u + c @ jnp.tanh(d @ both + e)


@jax.jit
def output(x, u, params):
    """Return the output, straight in the state."""
    return params[5] @ x


def main(train, *tests):
    """Learn, predict, and print."""
    begun = time.process_time()
    force, position = read(train)
    scales = force.std(), position.std()
    offsets = force.mean(), position.mean()
    random = np.random.default_rng(0)
    model = Model(STATES, 1, 1, state_fcn=state, output_fcn=output)
    sizes = ((STATES, STATES), (STATES, 1), (STATES, NEURONS), (NEURONS, STATES + 1), (NEURONS,))
    params = [0.1 * random.standard_normal(size) for size in (*sizes, (1, STATES))]
    params[0] += 0.8 * np.eye(STATES)
    model.init(params=params)
    model.loss(rho_x0=1e-4, rho_th=1e-6)
    model.optimization(adam_epochs=ADAM, lbfgs_epochs=LBFGS, iprint=-1)
    model.fit((position - offsets[1]) / scales[1], (force - offsets[0]) / scales[0])
    seconds = time.process_time() - begun
    errors = []
    for test in tests:
        force, position = read(test)
        put = (force - offsets[0]) / scales[0]
        asked = (position - offsets[1]) / scales[1]
        start = model.learn_x0(put[:STARTING], asked[:STARTING], RTS_epochs=10, verbosity=False)
        found = np.asarray(model.predict(start, put)[0]).reshape(-1, 1)
        left = scales[1] * (asked - found)[STARTING:]
        errors.append(float(np.sqrt(np.mean(left**2))))
    print(json.dumps({"errors": errors, "seconds": seconds}))


if __name__ == "__main__":
    main(*sys.argv[1:])
