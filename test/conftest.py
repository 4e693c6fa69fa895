"""Messages to record: their definitions, and their bytes as ROS would send them."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings
from matplotlib.figure import Figure
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from tissue_probe.recording.bags.definitions import message_definition
from tissue_probe.recording.writing.writer import McapWriter
from tissue_probe.signals import NANOSECONDS

# No test asserts a time, and a first example may load a library or compile a kernel.
settings.register_profile("untimed", deadline=None)
settings.load_profile("untimed")

REPOSITORY = Path(__file__).parents[1]
FOREIGN = {
    "builtin_interfaces": {"Time": "int32 sec\nuint32 nanosec\n"},
    "geometry_msgs": dict.fromkeys(("Point", "Vector3"), "float64 x\nfloat64 y\nfloat64 z\n"),
    "std_msgs": {
        "Header": "builtin_interfaces/Time stamp\n\n# the frame\nstring frame_id\n",
        "Float64": "float64 data\n",
    },
}


@pytest.fixture(scope="session", autouse=True)
def state_of_the_tests_own(tmp_path_factory):
    """Nodes keep what they must know after a restart in the user's state folder."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_STATE_HOME", str(tmp_path_factory.mktemp("state")))
        yield


@pytest.fixture
def sketched(request, monkeypatch):
    """Write empty pictures, where a test is not marked ``drawn``.

    To lay out and draw what a command shows takes ten times as long as all else that it does.
    """
    if request.node.get_closest_marker("drawn") is None:
        write = Figure.savefig
        empty = Figure(figsize=(0.1, 0.1))
        monkeypatch.setattr(Figure, "savefig", lambda _, *to, **how: write(empty, *to, **how))


@pytest.fixture(scope="session")
def share(tmp_path_factory):
    """A share folder with this suite's definitions and those they use."""
    folder = tmp_path_factory.mktemp("share")
    shutil.copytree(REPOSITORY / "msg_defs" / "msg", folder / "tissue_probe_msgs" / "msg")
    for package, types in FOREIGN.items():
        (folder / package / "msg").mkdir(parents=True)
        for name, text in types.items():
            (folder / package / "msg" / f"{name}.msg").write_text(text)
    return folder


class Messages:
    """This suite's messages as CDR, made by rosbags."""

    SAMPLES = "tissue_probe_msgs/msg/ProbeSamples"
    SITE = "tissue_probe_msgs/msg/PalpationSite"
    ESTIMATE = "tissue_probe_msgs/msg/TissueEstimate"
    MODEL = "tissue_probe_msgs/msg/EstimatorModel"
    MAP = "tissue_probe_msgs/msg/StiffnessMap"
    FLOAT = "std_msgs/msg/Float64"

    def __init__(self, share):
        self._store = get_typestore(Stores.EMPTY)
        self.definitions = {}
        for name in (self.SAMPLES, self.SITE, self.ESTIMATE, self.MODEL, self.MAP, self.FLOAT):
            self.definitions[name] = message_definition(name, [share])
            self._store.register(get_types_from_msg(self.definitions[name], name))

    def cdr(self, typename, *values):
        message = self._store.types[typename](*values)
        return bytes(self._store.serialize_cdr(message, typename))

    def header(self, stamp):
        types = self._store.types
        time = types["builtin_interfaces/msg/Time"](*divmod(stamp, NANOSECONDS))
        return types["std_msgs/msg/Header"](time, "probe")

    def samples(self, block):
        return self.cdr(
            self.SAMPLES,
            self.header(block.stamp),
            block.sequence,
            block.sample_period,
            block.position,
            block.force,
            block.command,
        )

    def site(self, site):
        point = self._store.types["geometry_msgs/msg/Point"](*site.position)
        normal = self._store.types["geometry_msgs/msg/Vector3"](*site.normal)
        phase, leaving = int(site.phase), int(site.leaving)
        return self.cdr(
            self.SITE, self.header(site.stamp), site.site, point, normal, phase, leaving
        )

    def estimate(self, stamp, sequence, name, values, status):
        values = (*values, status, "a model")
        return self.cdr(self.ESTIMATE, self.header(stamp), sequence, name, *values)

    def model(self, model):
        told = (model.sequence, model.estimator, model.model, model.file, model.content)
        return self.cdr(self.MODEL, self.header(model.stamp), *told, list(model.effects))

    def map(self, stamp, stiffness):
        rows, columns = stiffness.shape
        origin = self._store.types["geometry_msgs/msg/Point"](0.1, 0.2, 0.3)
        flat = stiffness.ravel()
        verdict = np.arange(flat.size, dtype=np.uint8)
        places = self.header(stamp), origin, 2e-3, rows, columns
        begin = verdict.astype(np.int64)
        return self.cdr(self.MAP, *places, flat, flat, flat, flat, verdict, begin)


@pytest.fixture(scope="session")
def messages(share):
    return Messages(share)


@pytest.fixture(scope="session")
def record(messages):
    """Write (topic, type, log time, CDR) to a new file, a chunk every ``chunk`` messages."""

    def write(path, entries, metadata=None, chunk=10):
        channels = {}
        with McapWriter(path, metadata or {}) as writer:
            for number, (topic, typename, time, data) in enumerate(entries, start=1):
                if topic not in channels:
                    definition = messages.definitions[typename]
                    channels[topic] = writer.add_topic(topic, typename, definition, "")
                writer.write(channels[topic], time, time, data)
                if number % chunk == 0:
                    writer.flush()
        return path

    return write
