"""Requests that no page of ours sends: each is refused in words, and the server goes on."""

from __future__ import annotations

import asyncio
import copy
import http.client
import io
import json
import socket
import time
import zipfile
from contextlib import contextmanager
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory
from urllib.parse import quote

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from websockets.exceptions import ConnectionClosedError
from websockets.sync.client import connect

from served import EXAMPLES, PATIENCE, serving
from tissue_probe.workbench import uploads
from tissue_probe.workbench.app import BYTES_TYPE

LOOK = {
    "rung": 1, "source": "fitted", "stretch": 0, "width": 500, "height": 300,
    "brush": {"axis": "time", "low": 0.5, "high": 1.5},
}  # fmt: skip
GRID = {"origin": [0.5, 0.5, 0.5], "spacing": 0.5, "rows": 2, "columns": 2, "dwell_time": 1.5}
#: Requests as pages of ours send them, with all that each may hold.
SENT = [
    *({"do": name} for name in ("cancel", "compare", "undo", "rank", "raster", "next")),
    *({"do": name, "file": 1} for name in ("forget", "map")),
    *({"do": name, **LOOK} for name in ("spectrum", "brush", "where")),
    {"do": "define", "file": 1, "layout": {"sample_rate": 500.0, "position": "u"}},
    {"do": "use", "fitted": 1, "second": 2},
    {"do": "ask", "asked": {"lowpass": 30.0, "known_rig": False, "site": 3, "rig": "rigid_probe",
                            "constants": {"mass": [0.5, 0.5]}, "prior": {"relaxation": 2.5}}},
    {"do": "add", "effect": "backlash", "after": 1},
    {"do": "site", "site": 0},
    {"do": "effects", "text": "X = 1", "name": "own.py", "consent": True},
    {"do": "example", "name": "sweep"},
    {"do": "recorded", "file": 1, "part": 0, "width": 500},
    {"do": "lines", **LOOK, "from": 0.5, "to": 1.5, "values": {"stiffness": 100.5},
     "effect": "backlash"},
    {"do": "dots", **LOOK, "axis": "speed"},
    {"do": "command", "command": "scan", "given": GRID},
    {"do": "command", "command": "excite", "given": {"kind": "sine", "amplitude": 0.5}},
]  # fmt: skip
#: What none of these can do without.
NEEDED = [
    ("forget", "file"), ("map", "file"), ("define", "file"), ("define", "layout"),
    ("use", "fitted"), ("ask", "asked"), ("add", "effect"), ("site", "site"), ("example", "name"),
    ("recorded", "file"), ("lines", "rung"), ("dots", "axis"), ("where", "rung"),
    ("command", "command"),
]  # fmt: skip
JSON = st.recursive(
    st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=4,
)


OF_TYPE = {
    int: st.integers(), str: st.text(), bool: st.booleans(),
    float: st.floats(allow_nan=False, allow_infinity=False),
}  # fmt: skip


def places(held, path=()):
    """Yield where each value of a request stands, and the value."""
    for key, value in held.items() if isinstance(held, dict) else enumerate(held):
        yield (*path, key), value
        if isinstance(value, (dict, list)):
            yield from places(value, (*path, key))


PLACES = [(sent, path, value) for sent in SENT for path, value in places(sent)]
NUMBERS = [(sent, path) for sent, path, value in PLACES if isinstance(value, float)]


def put(sent, path, value):
    """Return a request with another value at a place."""
    found = inner = copy.deepcopy(sent)
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] = value
    return found


def of_another_type(path, value):
    """Return values of which none has the type that belongs at a place."""
    taken = {type(value), int} if isinstance(value, float) else {type(value)}
    # Forms state numbers as texts, too; and whole ones with a point.
    if path[0] in ("layout", "asked") and type(value) in (int, float):
        taken |= {str, int, float}
    # A form states odds as a pair, too: a number and its error.
    if "prior" in path:
        taken |= {list}
    return JSON.filter(lambda other: type(other) not in taken)


class Talk:
    """A page that asks one thing after the other."""

    def __init__(self, socket):
        self.socket, self._numbers = socket, count(1)

    def ask(self, asked):
        number = next(self._numbers)
        answer = self.send(json.dumps({"id": number, **asked}))
        assert answer["id"] == number
        return answer

    def send(self, text):
        self.socket.send(text)
        return self.heard("id")

    def heard(self, key):
        while True:
            told = self.socket.recv(timeout=60)
            if isinstance(told, str) and key in (head := json.loads(told)):
                return head


@contextmanager
def talking(server):
    own = f"127.0.0.1:{server.port}"
    with connect(
        f"ws://{own}/socket", origin=f"http://{own}", max_size=None,
        additional_headers={"Cookie": server.cookie},
    ) as socket:  # fmt: skip
        yield Talk(socket)


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    """A server that ends as it should, and shows no trace of the program on its terminal."""
    with serving(tmp_path_factory.mktemp("state")) as found:
        yield found
        assert found.process.poll() is None
    assert "Traceback" not in (found.folder / "log").read_text()


@pytest.fixture
def talk(server):
    with talking(server) as found:
        yield found


@pytest.fixture(scope="module")
def page(server):
    """One page for all examples of a property."""
    with talking(server) as found:
        yield found


def refusal(answer):
    """Return the sentence in which something is refused."""
    told = answer["refused"].strip()
    assert told
    assert "error of the program" not in told
    return told


@given(st.data())
@settings(max_examples=200)
def test_a_value_of_another_type_is_refused_at_its_name(page, data):
    sent, path, value = data.draw(st.sampled_from(PLACES))
    told = refusal(page.ask(put(sent, path, data.draw(of_another_type(path, value)))))
    assert any(str(key) in told for key in path)


@given(st.data())
@settings(max_examples=100)
def test_a_request_that_names_what_there_is_not_is_answered_as_any_other(page, data):
    """Of its type, and in its bounds or not; the program of an effect is not run on a whim."""
    sent, path, value = data.draw(st.sampled_from(
        [each for each in PLACES if type(each[2]) in OF_TYPE and each[0]["do"] != "effects"]
    ))  # fmt: skip
    answer = page.ask(put(sent, path, data.draw(OF_TYPE[type(value)])))
    assert answer.get("ok", ...) is None or refusal(answer)


@given(st.sampled_from(NUMBERS), st.sampled_from(["NaN", "Infinity", "-Infinity", "1e999"]))
@settings(max_examples=100)
def test_a_number_that_is_not_finite_is_refused(page, place, number):
    sent, path = place
    text = json.dumps({"id": 1, **put(sent, path, "HERE")}).replace('"HERE"', number)
    refusal(page.send(text))


@pytest.mark.parametrize(("name", "key"), NEEDED)
def test_what_is_missing_is_named(page, name, key):
    sent = next(each for each in SENT if each["do"] == name)
    told = refusal(page.ask({other: value for other, value in sent.items() if other != key}))
    assert f"`{key}` is missing" in told
    assert f"`{key}` is None" in refusal(page.ask({**sent, key: None}))


@given(st.sampled_from(SENT), st.text(min_size=1), JSON)
@settings(max_examples=50)
def test_what_is_in_no_declaration_is_refused(page, sent, key, value):
    refusal(page.ask({**sent, f"not_{key}": value}))


@given(JSON)
@settings(max_examples=50)
def test_any_other_request_is_refused(page, name):
    assert "`do`" in refusal(page.ask({"do": name}))


@given(JSON | st.none())
@settings(max_examples=50)
def test_json_that_is_no_request_is_refused(page, whole):
    refusal(page.send(json.dumps(whole)))


@pytest.mark.parametrize(
    "text",
    [
        "", " ", "{", "undo", '{"id": 1} {"id": 2}', "[" * 100_000, '{"id":' * 50_000,
        '{"id": 1, "do": "add", "effect": "\\ud800"}', "9" * 6000, "x" * (2**20 + 1),
        '{"id": {}, "do": "undo"}', '{"do": "undo"}', b'{"id": 1, "do": "undo"}',
    ],
    ids=range(13),
)  # fmt: skip
def test_a_text_that_is_no_request_is_refused(page, text):
    refusal(page.send(text))


@pytest.mark.parametrize(("content", "code"), [(b'{"id": "\xff"}', 1007), (b"x" * 2**24, 1009)])
def test_bytes_that_are_no_text_or_too_many_close_that_page_alone(talk, page, content, code):
    talk.socket.send(content, text=True)
    with pytest.raises(ConnectionClosedError) as closed:
        talk.heard("id")
    assert closed.value.rcvd.code == code
    refusal(page.ask({"do": "undo"}))


def post(server, path, body=b"", method="POST", **headers):
    """Return status and words of the answer to a request of the server's own page."""
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=60)
    named = {name.replace("_", "-"): value for name, value in headers.items()}
    own = {"Cookie": server.cookie, "Origin": f"http://127.0.0.1:{server.port}"}
    connection.request(method, path, body=body, headers={**own, **named})
    told = connection.getresponse()
    content = told.read()
    connection.close()
    return told.status, content


def upload(server, name, content):
    return post(server, "/upload", content, content_type=BYTES_TYPE, x_file_name=quote(name))


@given(
    st.sampled_from(["POST", "PUT", "DELETE", "PATCH", "OPTIONS", "BREW"]),
    st.sampled_from(["/", "/main.js", "/take/model.yaml", "/upload"]),
)
@settings(max_examples=24)
def test_a_method_that_an_address_does_not_take_is_refused_in_words(server, method, path):
    if (method, path) != ("POST", "/upload"):
        status, told = post(server, path, method=method)
        assert status == 405
        assert f"and not {method}".encode() in told


@given(
    st.lists(st.sampled_from(["..", ".", "take", "token", "desk.json", "etc", "a b"]) | st.text(),
             min_size=1, max_size=5),
    st.booleans(),
)  # fmt: skip
@settings(max_examples=60)
def test_an_address_at_which_nothing_is_says_so(server, parts, quoted):
    path = "/".join(quote(part, safe="" if quoted else "/") for part in parts)
    status, told = post(server, f"/take/nothing/{path}", method="GET")
    assert (status, told) == (404, b"there is nothing at this address; the page is at /\n")


@pytest.mark.parametrize("kind", ["multipart/form-data; boundary=x", "text/csv", ""])
def test_an_upload_that_is_wrapped_in_anything_is_refused(server, kind):
    status, told = post(server, "/upload", b"t,u,F\n", content_type=kind, x_file_name="a.csv")
    assert status == 415
    assert BYTES_TYPE.encode() in told


def test_an_upload_without_a_name_asks_for_it(server):
    status, told = post(server, "/upload", b"t,u,F\n", content_type=BYTES_TYPE)
    assert status == 400
    assert b"X-File-Name" in told


@given(st.text(max_size=400))
def test_any_name_of_an_upload_is_a_name_that_a_file_may_have(name):
    async def parts():
        yield b"t,u,F\n"

    with TemporaryDirectory() as folder:
        path = asyncio.run(uploads.keep(name, parts(), Path(folder)))
        assert path.read_bytes() == b"t,u,F\n"
        assert path.parent.parent == Path(folder)


def test_an_upload_that_is_dropped_leaves_nothing(server):
    before = set(kept(server).iterdir())
    with socket.create_connection(("127.0.0.1", server.port)) as line:
        head = [
            "POST /upload HTTP/1.1", f"Host: 127.0.0.1:{server.port}",
            f"Origin: http://127.0.0.1:{server.port}", f"Cookie: {server.cookie}",
            f"Content-Type: {BYTES_TYPE}", "X-File-Name: half.csv", "Content-Length: 1000000",
        ]  # fmt: skip
        line.sendall("\r\n".join([*head, "", "t,u,F\n"]).encode())
        until(lambda: set(kept(server).iterdir()) - before)  # it is under way
    until(lambda: set(kept(server).iterdir()) == before)


def kept(server):
    return server.folder / "tissue_probe" / f"workbench_{server.port}"


def until(condition):
    end = time.monotonic() + PATIENCE / 1000
    while not condition():
        assert time.monotonic() < end


STATE = {
    "version": 1, "fitted": None, "second": 0, "asked": {"starts": "auto"}, "effects": ["own.py"],
    "files": [{"name": "a.csv", "path": "a.csv", "layout": {"time": "t"}, "owned": True}],
    "added": ["backlash"],
}  # fmt: skip
STATE_PLACES = [(path, value) for path, value in places(STATE) if value is not None]


def state_of(told):
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        archive.writestr("a.csv", "t,u,F\n")
        archive.writestr("own.py", "X = 1")
        archive.writestr("desk.json", told)
    return packed.getvalue()


@given(st.data())
@settings(max_examples=60)
def test_a_state_that_does_not_fit_its_declaration_is_refused(server, data):
    path, value = data.draw(st.sampled_from(STATE_PLACES))
    told = put(STATE, path, data.draw(of_another_type(path, value)))
    status, words = upload(server, "a.workbench", state_of(json.dumps(told)))
    assert status == 409, (told, words)
    assert words.strip()


@given(st.binary(max_size=200), st.integers(0, 400), st.integers(0, 255))
@settings(max_examples=60)
def test_a_state_that_is_damaged_is_refused(server, noise, place, byte):
    whole = bytearray(state_of("["))
    whole[place % len(whole)] = byte
    for content in (noise, bytes(whole), whole[:place], state_of("[" * 10_000)):
        status, words = upload(server, "a.workbench", bytes(content))
        assert status == 409
        assert words.strip()


def test_a_state_that_is_none_leaves_the_desk_as_it_is(server, talk):
    assert upload(server, "weight.csv", (EXAMPLES / "weight_0.csv").read_bytes())[0] == 200
    for told in (b"PK", state_of(json.dumps({**STATE, "added": [3]}))):
        assert upload(server, "a.workbench", told)[0] == 409
    while not (files := talk.heard("desk")["desk"]["files"]):
        pass
    assert "ok" in talk.ask({"do": "forget", "file": files[0]["number"]})
