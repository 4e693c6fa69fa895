"""A server of the workbench, and Debian's Chromium in front of it."""

from __future__ import annotations

import shutil

import pytest

from served import PATIENCE, serving


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    with serving(tmp_path_factory.mktemp("state")) as found:
        yield found


@pytest.fixture(scope="session")
def chromium():
    """Chromium without a window, and without a network."""
    path = shutil.which("chromium")
    if path is None:
        pytest.skip("there is no chromium: apt-get install chromium")
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    with playwright.sync_playwright() as driver:
        # The sandbox needs rights that a container does not give.
        browser = driver.chromium.launch(executable_path=path, args=["--no-sandbox"])
        yield browser
        browser.close()


@pytest.fixture
def open_page(chromium):
    """Open pages; at the end none may have complained, nor asked for anything elsewhere."""
    contexts, complaints = [], []

    def opened(address: str, size=(1280, 720), **more):
        context = chromium.new_context(
            viewport={"width": size[0], "height": size[1]}, accept_downloads=True, **more
        )
        contexts.append(context)
        page = context.new_page()
        page.set_default_timeout(PATIENCE)
        page.on("console", lambda m: complaints.append(m.text) if m.type == "error" else None)
        page.on("pageerror", lambda error: complaints.append(str(error)))
        host = address.split("/?")[0]

        def foreign(request):
            if not request.url.startswith((host, host.replace("http", "ws"), "blob:", "data:")):
                complaints.append(f"asked for {request.url}")

        page.on("request", foreign)
        page.goto(address)
        page.wait_for_selector("#stage > *")
        return page

    opened.complaints = complaints
    yield opened
    for context in contexts:
        context.close()
    assert complaints == []
