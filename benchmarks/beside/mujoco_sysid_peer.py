"""A peer: a slide joint with a polynomial spring, damping and dry friction, by MuJoCo's sysid.

    PYTHON benchmarks/beside/mujoco_sysid_peer.py TRAIN.csv TEST.csv ...

Prints one line of JSON: the root mean square error of each test in the file's unit, and the seconds
of the processor. It imports nothing of this project. MuJoCo's joint has no hysteresis.
"""

import json
import sys
import time

import mujoco
import numpy as np
from mujoco import sysid
from scipy.interpolate import make_interp_spline
from scipy.optimize import least_squares

#: Steps of the simulation in a sample, samples that start a test, and degree of the splines by
#: which a record is read between its samples.
STEPS, STARTING, DEGREE = 4, 50, 5
#: How far a value may be, over its size by regression.
FARTHEST = 10.0
MODEL = """<mujoco><option timestep="{step}" gravity="0 0 0" integrator="RK4"/><worldbody>
<body name="tip"><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
<joint name="slide" type="slide" axis="1 0 0"/></body></worldbody>
<actuator><motor name="push" joint="slide"/></actuator></mujoco>"""
#: The position of the joint, which is no sensor's: a sensor is read at the start of a step.
SEEN = ("slide_qpos", sysid.SignalType.MjStateQPos)


class Record:
    """A record, its courses between the samples, and MuJoCo's tools on it."""

    def __init__(self, path):
        seconds, self.position, force = np.loadtxt(path, delimiter=",", skiprows=1, unpack=True)
        period = float(np.median(np.diff(seconds)))
        self.samples = period * np.arange(force.size)
        self.course = make_interp_spline(self.samples, self.position, DEGREE)
        self.step = period / STEPS
        self.times = self.step * np.arange(STEPS * (force.size - 1) + 1)
        # A force is held for a step: that of its middle.
        put = make_interp_spline(self.samples, force, DEGREE)(self.times + self.step / 2)
        self.force, self.put = force, sysid.TimeSeries(self.times, put[:, None])
        self.spec = mujoco.MjSpec.from_string(MODEL.format(step=self.step))

    def regress(self):
        """Return mass, stiffness and damping by the derivatives of the position's course."""
        columns = [self.course(self.samples, each) for each in (2, 0, 1)]
        columns.append(np.ones(self.samples.size))
        return np.linalg.lstsq(np.stack(columns, 1), self.force, rcond=None)[0][:3]

    def begin(self):
        """Return the state at the first sample."""
        return np.array([self.course(0.0), self.course(0.0, 1)])

    def residual(self, state, stop=None):
        """Return the function that gives the residual of values, from a state at the start."""
        stop = stop or self.samples.size
        last = STEPS * (stop - 1) + 1
        seen = sysid.TimeSeries.from_custom_map(
            self.samples[:stop], self.position[:stop, None], [(SEEN[0], 1, SEEN[1])]
        )
        put = sysid.TimeSeries(self.put.times[:last], self.put.data[:last])
        start = np.concatenate([[0.0], state])
        sequences = sysid.ModelSequences("tip", self.spec, "record", start, put, seen, True)
        return sysid.build_residual_fn(models_sequences=[sequences], enabled_observations=[SEEN])


def list_values(record):
    """Return the values that are free, each over its size, and how it is set in the model."""
    mass, stiffness, damping = map(abs, record.regress())
    size, speed = np.std(record.position), np.std(record.course(record.samples, 1))
    slide = {
        "stiffness": stiffness / size ** np.arange(3),
        "damping": damping / speed ** np.arange(3),
    }
    values = sysid.ParameterDict()

    def set_mass(spec, each):
        spec.body("tip").mass = mass * each.value[0]

    def set_zero(spec, each):
        spec.joint("slide").springref = size * each.value[0]

    values.add(sysid.Parameter("mass", 1.0, 0.1, FARTHEST, modifier=set_mass))
    values.add(sysid.Parameter("zero", 0.0, -FARTHEST, FARTHEST, modifier=set_zero))
    for name, sizes in slide.items():

        def set_slide(spec, each, name=name, sizes=sizes):
            setattr(spec.joint("slide"), name, sizes * each.value)

        start, most = np.array([1.0, 0.0, 0.0]), np.full(3, FARTHEST)
        values.add(sysid.Parameter(name, start, -most, most, modifier=set_slide))
    return values


def predict(record, values):
    """Return what is left of a test, from the state at the start that the first samples tell."""
    sizes = np.array([np.std(record.position), np.std(record.course(record.samples, 1))])

    def left(start):
        return subtract(record.residual(start * sizes, STARTING), values)

    start = least_squares(left, record.begin() / sizes, diff_step=1e-4).x
    # The first sample is the start itself, and in no residual.
    return subtract(record.residual(start * sizes), values)[STARTING - 1 :]


def subtract(residual, values):
    """Return the position less the predicted one."""
    _, predicted, measured = residual(values.as_vector(), values)
    return np.ravel(measured[0][0].data - predicted[0][0].data)


def main(train, *tests):
    """Learn, predict, and print."""
    begun = time.process_time()
    record = Record(train)
    start = list_values(record)
    values, _ = sysid.optimize(start, record.residual(record.begin()), verbose=False)
    seconds = time.process_time() - begun
    left = [predict(Record(test), values) for test in tests]
    errors = [float(np.sqrt(np.mean(each**2))) for each in left]
    print(json.dumps({"errors": errors, "seconds": seconds}))


if __name__ == "__main__":
    main(*sys.argv[1:])
