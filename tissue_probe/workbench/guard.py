"""Who may ask the server anything: a page of its own, on this machine, that knows the token.

Contents: the checks of every request, and the prohibitions in every answer to the browser.

A page of somebody else's, open in the same browser, can send requests to any port of this machine.
It is kept out three times: its ``Origin`` is another; a name that it makes point here (DNS
rebinding) is no ``Host`` of ours; and it has no token, which is in a cookie that no other site's
page can send (``SameSite=Strict``) or read (``HttpOnly``).
"""

from __future__ import annotations

import secrets
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse, RedirectResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

#: Headers of every answer for the browser: nothing from elsewhere, in nobody's frame, nothing kept.
FORBIDDEN = {
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
        "connect-src 'self'; font-src 'self'; base-uri 'none'; form-action 'none'; "
        "frame-ancestors 'none'"
    ),
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "Cache-Control": "no-store",
}
#: WebSocket's code for who is not let in.
REFUSED = 1008


class Guard:
    """Lets through requests from a page of the server's own.

    Parameters
    ----------
    app : ASGI application
        The application that answers.
    token : str
        The secret that a page must know.
    port : int
        Where the server listens.
    """

    def __init__(self, app: ASGIApp, token: str, port: int) -> None:
        self._app, self._token = app, token
        self._hosts = {f"{name}:{port}" for name in ("127.0.0.1", "localhost")}
        # Cookies know no port: two servers on this machine need two names.
        self._cookie = f"tissue_probe_{port}"

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or refuse it."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        if told := self._foreign(scope, headers):
            await _refuse(scope, receive, send, told)
        elif self._same(_read_asked(scope)) and scope["type"] == "http" and scope["path"] == "/":
            await self._let_in()(scope, receive, send)
        elif self._same(_find_cookie(headers, self._cookie)):
            await self._app(scope, receive, _forbid_framing(send))
        else:
            told = "open the address that `tissue_probe workbench` printed: it has the token"
            await _refuse(scope, receive, send, told)

    def _foreign(self, scope: Scope, headers: Headers) -> str:
        """Name the foreign part of a request; empty if there is none."""
        host, origin = headers.get("host", ""), headers.get("origin")
        if host not in self._hosts:
            return "this server answers to 127.0.0.1 and localhost only"
        # A browser always tells the origin of a WebSocket, and of each request that changes
        # something.
        needed = scope["type"] == "websocket" or scope["method"] not in ("GET", "HEAD")
        if (origin is None and needed) or (origin is not None and origin != f"http://{host}"):
            return "only pages of this server may ask it"
        return ""

    def _same(self, given: str) -> bool:
        return secrets.compare_digest(given.encode(), self._token.encode())

    def _let_in(self) -> RedirectResponse:
        """Keep the token in a cookie, and take it out of the address."""
        answer = RedirectResponse("/", status_code=303, headers=FORBIDDEN)
        answer.set_cookie(self._cookie, self._token, httponly=True, samesite="strict")
        return answer


def _read_asked(scope: Scope) -> str:
    query = parse_qs(scope.get("query_string", b"").decode("latin-1"))
    token: str = query.get("token", [""])[0]
    return token


def _find_cookie(headers: Headers, name: str) -> str:
    try:
        cookies = SimpleCookie(headers.get("cookie", ""))
    except CookieError:
        return ""
    return cookies[name].value if name in cookies else ""


def _forbid_framing(send: Send) -> Send:
    async def send_with_headers(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            for name, value in FORBIDDEN.items():
                headers[name] = value
        await send(message)

    return send_with_headers


async def _refuse(scope: Scope, receive: Receive, send: Send, told: str) -> None:
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.close", "code": REFUSED, "reason": told})
        return
    answer = PlainTextResponse(f"tissue_probe: {told}\n", status_code=403, headers=FORBIDDEN)
    await answer(scope, receive, send)
