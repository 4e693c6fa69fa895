"""Who may ask the server: its own pages, on this machine, with the token."""

from __future__ import annotations

import asyncio
import http.client

import pytest
import websockets

from served import EXAMPLES
from tissue_probe.workbench import uploads
from tissue_probe.workbench.refusal import RequestRefused


def answer(server, path="/", method="GET", body=None, **headers):
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=30)
    named = {name.replace("_", "-"): value for name, value in headers.items()}
    connection.request(method, path, body=body, headers=named)
    told = connection.getresponse()
    told.text = told.read()
    connection.close()
    return told


def test_the_token_opens_the_page_and_leaves_the_address(server):
    told = answer(server, f"/?token={server.token}")
    assert (told.status, told.headers["location"]) == (303, "/")
    cookie = told.headers["set-cookie"]
    assert "HttpOnly" in cookie
    assert "SameSite=strict" in cookie
    assert answer(server, "/", Cookie=server.cookie).status == 200


@pytest.mark.parametrize("path", ["/", "/main.js", "/take/desk.workbench", "/?token=wrong"])
def test_without_the_token_nothing_is_answered(server, path):
    told = answer(server, path)
    assert told.status == 403
    assert b"open the address" in told.text
    assert answer(server, path, Cookie=f"tissue_probe_{server.port}=wrong").status == 403


@pytest.mark.parametrize("host", ["evil.example", "evil.example:80", "127.0.0.1", "0.0.0.0"])
def test_a_name_that_points_here_is_refused(server, host):
    """DNS rebinding: the browser sends the foreign page's own name."""
    assert answer(server, "/", Host=host, Cookie=server.cookie).status == 403


def test_a_page_of_anybody_else_is_refused(server):
    own = f"http://127.0.0.1:{server.port}"
    for origin in ("http://evil.example", "null", f"http://127.0.0.1:{server.port + 1}"):
        assert answer(server, "/", Cookie=server.cookie, Origin=origin).status == 403
    sent = {"method": "POST", "body": b"t,u,F\n", "Cookie": server.cookie}
    assert answer(server, "/upload", **sent).status == 403, "an origin is always told"
    assert answer(server, "/upload", **sent, Origin="http://evil.example").status == 403
    assert answer(server, "/", Cookie=server.cookie, Origin=own).status == 200


def test_a_foreign_page_opens_no_socket(server):
    async def outcome(origin, cookie):
        address = f"ws://127.0.0.1:{server.port}/socket"
        headers = {"Cookie": cookie} if cookie else {}
        try:
            async with websockets.connect(address, origin=origin, additional_headers=headers):
                return "open"
        except websockets.InvalidStatus as error:
            return error.response.status_code

    own = f"http://127.0.0.1:{server.port}"
    assert asyncio.run(outcome(own, server.cookie)) == "open"
    assert asyncio.run(outcome("http://evil.example", server.cookie)) == 403
    assert asyncio.run(outcome(None, server.cookie)) == 403
    assert asyncio.run(outcome(own, "")) == 403


@pytest.mark.parametrize(
    "path",
    [
        "/../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "/vendor/../../desk.py", "//etc/passwd",
        "/take/../token", "/take/%2e%2e%2ftoken", "/jsconfig.json", "/token",
    ],
)  # fmt: skip
def test_no_address_names_a_file_of_the_machine(server, path):
    assert answer(server, path, Cookie=server.cookie).status == 404


def test_every_answer_forbids_what_comes_from_elsewhere(server):
    for told in (answer(server, "/", Cookie=server.cookie), answer(server, "/")):
        policy = told.headers["content-security-policy"]
        assert "default-src 'none'" in policy
        assert "frame-ancestors 'none'" in policy
        assert told.headers["x-content-type-options"] == "nosniff"


def test_the_token_is_nobody_elses_to_read(server):
    kept = server.folder / "tissue_probe" / f"workbench_{server.port}"
    assert kept.stat().st_mode & 0o077 == 0
    assert (kept / "token").stat().st_mode & 0o077 == 0


def parts_of(*parts):
    async def stream():
        for part in parts:
            yield part

    return stream()


def test_an_upload_has_a_name_and_no_place(tmp_path):
    for name in ("../../evil.csv", "C:\\temp\\evil.csv", "/etc/evil.csv", "a/b/evil.csv"):
        path = asyncio.run(uploads.keep(name, parts_of(b"t,u,F\n"), tmp_path))
        assert (path.name, path.parent.parent) == ("evil.csv", tmp_path)
    assert uploads.plain("..") == "recording"


def test_an_upload_that_is_too_large_is_refused_and_leaves_nothing(tmp_path, monkeypatch):
    monkeypatch.setattr(uploads, "LARGEST_UPLOAD", 1000)
    with pytest.raises(RequestRefused, match="more than"):
        asyncio.run(uploads.keep("long.csv", parts_of(*[b"x" * 400] * 3), tmp_path))
    assert list(tmp_path.iterdir()) == []


def test_an_upload_of_the_servers_own_page_is_taken(server):
    told = answer(
        server, "/upload", method="POST", body=(EXAMPLES / "weight_0.csv").read_bytes(),
        Cookie=server.cookie, Origin=f"http://127.0.0.1:{server.port}", x_file_name="weight.csv",
        content_type="application/octet-stream",
    )  # fmt: skip
    assert told.status == 200, told.text
