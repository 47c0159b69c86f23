"""HTTP to an IPALM object database: verified TLS, no password in the clear, the server's addresses put right."""

from __future__ import annotations

import base64
import ipaddress
import json
import re
import ssl
import urllib.error
import urllib.parse
import urllib.request
import uuid
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from dynamics.errors import InvalidInput, PalpateError

MAX_ANSWER = 64 * 2**20  # bytes
MAX_PAGES = 100_000


class ServerUnreachable(PalpateError):
    """There was no answer: what was sent may or may not have arrived."""


class ServerRefused(PalpateError):
    """The server understood and said no.

    Attributes:
        status: of HTTP.
    """

    def __init__(self, status: int, message: str) -> None:
        self.status = status
        super().__init__(message)


class ServerFailed(PalpateError):
    """The server broke while it answered: what was sent may have been stored in part."""


@dataclass(frozen=True)
class Part:
    """A file to upload.

    Attributes:
        field: what it is to the server, such as ``measurement png`` or ``measurement robotiq_2f85``.
        name: its file name.
        content: its bytes.
    """

    field: str
    name: str
    content: bytes


class _NoRedirects(urllib.request.HTTPRedirectHandler):
    """A redirect would carry the password elsewhere."""

    def redirect_request(self, *_: Any) -> None:
        return None


class Connection:
    """An object database under a base address.

    Args:
        base: such as ``https://host/ipalm``; with or without ``/rest``.
        user, password: for Basic authentication; needed to upload.
        timeout: for an answer [s].
        context: of TLS; by default certificates are verified against the system's authorities.

    Raises:
        InvalidInput: for an address that is none, or a password over plain HTTP to another machine.
    """

    def __init__(
        self,
        base: str,
        user: str = "",
        password: str = "",
        timeout: float = 30.0,
        context: ssl.SSLContext | None = None,
    ) -> None:
        address = urllib.parse.urlsplit(base)
        if address.scheme not in ("http", "https") or not address.hostname:
            raise InvalidInput("database: address", base, "https://host/path")
        if address.username or address.password:
            raise InvalidInput(
                "database: address", f"//...@{address.hostname}", "an address without a password in it"
            )
        if user and address.scheme == "http" and not _is_loopback(address.hostname):
            raise InvalidInput("database: address", base, "https: a password never goes over plain HTTP")
        if (
            user
            and context is not None
            and not (context.verify_mode == ssl.CERT_REQUIRED and context.check_hostname)
        ):
            raise InvalidInput(
                "database: TLS", "a context that verifies too little", "one that verifies certificates and names"
            )
        path = re.sub(r"/rest/?$", "", address.path).rstrip("/")
        self.base = urllib.parse.urlunsplit((address.scheme, address.netloc, path, "", ""))
        self.can_upload = bool(user)
        self._timeout = timeout
        self._headers = {"Accept": "application/json"}
        if user:
            token = base64.b64encode(f"{user}:{password}".encode()).decode()
            self._headers["Authorization"] = f"Basic {token}"
        handlers: list[urllib.request.BaseHandler] = [_NoRedirects()]
        handlers.append(urllib.request.HTTPSHandler(context=context or ssl.create_default_context()))
        if _is_loopback(address.hostname):
            handlers.append(urllib.request.ProxyHandler({}))
        self._opener = urllib.request.build_opener(*handlers)

    def get(self, address: str) -> Any:
        """Return the JSON at an address: one that the server gave, or a path under ``rest``."""
        return self._json(urllib.request.Request(self.rewrite(address), headers=self._headers))

    def post(self, path: str, fields: Mapping[str, str], parts: Sequence[Part] = ()) -> Any:
        """Send a form; return the answer's JSON."""
        boundary = uuid.uuid4().hex
        body = b"".join(_form(boundary, fields, parts))
        headers = {**self._headers, "Content-Type": f"multipart/form-data; boundary={boundary}"}
        return self._json(urllib.request.Request(self.rewrite(path), data=body, headers=headers, method="POST"))

    def pages(self, kind: str, newest_first: bool = False) -> Iterator[Mapping[str, Any]]:
        """Yield every row of a kind, page by page; only the page number means something to the server."""
        first = self._page(kind, 1)
        size = max(len(first["results"]), 1)
        last = -(-int(first["count"]) // size) if first.get("next") else 1
        if last > MAX_PAGES:
            raise ServerFailed(f"{self.base}: {last} pages of {kind}")
        if newest_first:
            for number in range(last, 1, -1):
                yield from reversed(self._page(kind, number)["results"])
            yield from reversed(first["results"])
            return
        page, number = first, 1
        while True:
            yield from page["results"]
            if not page.get("next") or number >= MAX_PAGES:
                return
            number += 1
            page = self._page(kind, number)

    def rewrite(self, address: str) -> str:
        """Return where an address of the server really is: it may prefix its own with a path it is not under."""
        parts = urllib.parse.urlsplit(address)
        query = f"?{parts.query}" if parts.query else ""
        for root in ("/rest/", "/media/"):
            place = parts.path.find(root)
            if place >= 0:
                return f"{self.base}{parts.path[place:]}{query}"
        return f"{self.base}/rest/{parts.path.lstrip('/')}{query}"

    def _page(self, kind: str, number: int) -> Mapping[str, Any]:
        page = self.get(f"{kind}/?page={number}")
        whole = isinstance(page, Mapping) and isinstance(page.get("results"), list) and "count" in page
        if not whole or not all(isinstance(row, Mapping) for row in page["results"]):
            raise ServerFailed(f"{self.base}: page {number} of {kind} is no page of rows")
        found: Mapping[str, Any] = page
        return found

    def _json(self, request: urllib.request.Request) -> Any:
        try:
            with self._opener.open(request, timeout=self._timeout) as answer:
                text = answer.read(MAX_ANSWER + 1)
        except urllib.error.HTTPError as error:
            with error:
                self._raise(error, request)
        except (urllib.error.URLError, OSError, ValueError, EOFError) as error:
            reason = getattr(error, "reason", error)
            raise ServerUnreachable(f"{self.base}: {reason}") from None
        except Exception as error:  # http.client's own errors: an answer that breaks off
            raise ServerUnreachable(f"{self.base}: {type(error).__name__}: {error}") from None
        if len(text) > MAX_ANSWER:
            raise ServerFailed(f"{request.full_url}: an answer of more than {MAX_ANSWER} bytes")
        try:
            return json.loads(text)
        except (ValueError, RecursionError):
            raise ServerFailed(f"{request.full_url}: the answer is no JSON") from None

    def _raise(self, error: urllib.error.HTTPError, request: urllib.request.Request) -> None:
        try:
            text = error.read(20_000).decode("utf-8", "replace")
        except Exception:
            text = ""
        message = f"{request.get_method()} {request.full_url}: {error.code}: {_reason(text) or error.reason}"
        if error.code >= 500:
            raise ServerFailed(message) from None
        raise ServerRefused(error.code, message) from None


def _verifies(context: ssl.SSLContext) -> bool:
    return context.verify_mode == ssl.CERT_REQUIRED and context.check_hostname


def _is_loopback(host: str) -> bool:
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def _form(boundary: str, fields: Mapping[str, str], parts: Sequence[Part]) -> Iterator[bytes]:
    for name, value in fields.items():
        head = f'--{boundary}\r\nContent-Disposition: form-data; name="{_quoted(name)}"\r\n\r\n'
        yield head.encode() + value.encode() + b"\r\n"
    for part in parts:
        disposition = f'form-data; name="{_quoted(part.field)}"; filename="{_quoted(part.name)}"'
        head = (
            f"--{boundary}\r\nContent-Disposition: {disposition}\r\nContent-Type: application/octet-stream\r\n\r\n"
        )
        yield head.encode() + part.content + b"\r\n"
    yield f"--{boundary}--\r\n".encode()


def _quoted(text: str) -> str:
    return re.sub(r'[\r\n"\\]', "_", text)


def _reason(text: str) -> str:
    """Return what an error's body says, be it JSON or a page for people."""
    try:
        return json.dumps(json.loads(text))[:300]
    except (ValueError, RecursionError):
        title = re.search(r"<title>\s*(.*?)\s*</title>", text, re.DOTALL | re.IGNORECASE)
        return " ".join((title.group(1) if title else re.sub(r"<[^>]*>", " ", text)).split())[:300]
