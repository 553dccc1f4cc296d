"""Who is let in: programs of this machine that know the token, and no page of another site."""

import secrets
from collections.abc import Mapping

#: What a browser says of a request that the page itself makes, or of an address that a person typed.
_OWN = ("same-origin", "none")


class Guard:
    """Looks at every request before anything is done with it.

    Parameters
    ----------
    port : int
        The server's own.

    Attributes
    ----------
    token : str
        32 characters that nobody can guess: the first part of every path.
    """

    def __init__(self, port: int) -> None:
        self.token = secrets.token_urlsafe(24)
        self._hosts = tuple(f"{name}:{port}" for name in ("127.0.0.1", "localhost"))

    def refusal(self, path: str, headers: Mapping[str, str]) -> str:
        """Return why a request is not let in; empty if it is.

        A page of another site could name this server by a host name of its own that leads here (then ``Host`` is that
        name), send it a form or a script (then the browser names its ``Origin``), or show it in a frame.

        Parameters
        ----------
        path : str
            As the request has it, with the token.
        headers : mapping of str to str
            Looked up in whatever spelling of upper and lower case.
        """
        if headers.get("Host", "") not in self._hosts:
            return f"The host must be {' or '.join(self._hosts)}."
        origin = headers.get("Origin")
        if origin is not None and origin not in [f"http://{host}" for host in self._hosts]:
            return "Pages of other sites are not answered."
        if headers.get("Sec-Fetch-Site", "none") not in _OWN and not self._is_opened(path, headers):
            return "Pages of other sites are not answered."
        given = path.split("/")[1] if path.startswith("/") else ""
        if not secrets.compare_digest(given.encode(), self.token.encode()):
            return "The address needs the token that eulerdisk explore has printed."
        return ""

    def _is_opened(self, path: str, headers: Mapping[str, str]) -> bool:
        """Whether a link or a frame of another page, a notebook for instance, opens the page itself."""
        return headers.get("Sec-Fetch-Mode") == "navigate" and path == f"/{self.token}/"
