"""Logging in and out: plain forms, so that passphrase managers and every browser know them."""

from __future__ import annotations

from typing import Annotated, Final, Self
from urllib.parse import urlencode

from fastapi import Form, Request, Response
from fastapi.responses import RedirectResponse
from nicegui import app

from cellctl.config import CellConfig
from cellctl.credentials import find_credential
from cellctl.errors import RefusedError
from cellctl.kiosk.components import Text, box, icon
from cellctl.kiosk.operator.access import COOKIE, Access, Session, TooSoonError
from cellctl.kiosk.origin import address_of, device_of, is_here
from cellctl.kiosk.shell import Page
from cellctl.passphrase import OPERATOR_CREDENTIAL, PassphraseHash

LOG_IN: Final = "/operator/log-in"
LOG_OUT: Final = "/operator/log-out"
_SEE_OTHER: Final = 303


class FrontDoor:
    """The operator's view for those who come by the network.

    Args:
        access: decides on passphrases and sessions.
        from_network: whether others than this computer may log in.
    """

    def __init__(self, access: Access, *, from_network: bool) -> None:
        self.access = access
        self._from_network = from_network

    @classmethod
    def of(cls, config: CellConfig) -> Self:
        """With the passphrase that the page was given, if it was.

        Raises:
            ConfigError: the credential is not what it should be.
        """
        found = find_credential(OPERATOR_CREDENTIAL)
        passphrase = PassphraseHash.read(found.secret) if found is not None else None
        kiosk = config.kiosk
        access = Access(passphrase, kiosk.operator_idle_s)
        return cls(access, from_network=kiosk.operator_from == "network")

    def session(self, request: Request) -> Session | None:
        """Who asks; None before the log-in."""
        return self.access.session(request.cookies.get(COOKIE))

    def closed_to(self, request: Request) -> str:
        """Key of the reason why nobody can log in from there; empty when they can."""
        if not self.access.is_open:
            return "login.no_passphrase"
        if not self._from_network and not is_here(request):
            return "login.not_from_here"
        return ""

    def add_routes(self) -> None:
        """Take what the forms send."""

        @app.post(LOG_IN)
        async def log_in(
            request: Request, passphrase: Annotated[str, Form(max_length=500)] = ""
        ) -> Response:
            back = _back(request)
            if _is_foreign(request) or self.closed_to(request):
                return back
            try:
                token = await self.access.log_in(passphrase, device_of(address_of(request)))
            except TooSoonError:
                return _back(request, refused="wait")
            except RefusedError:
                return _back(request, refused="wrong")
            back.set_cookie(
                COOKIE,
                token,
                httponly=True,
                samesite="strict",
                secure=request.url.scheme == "https",
            )
            return back

        @app.post(LOG_OUT)
        def log_out(request: Request) -> Response:
            back = _back(request)
            if not _is_foreign(request):
                self.access.log_out(request.cookies.get(COOKIE))
                back.delete_cookie(COOKIE)
            return back

    def form(self, page: Page, request: Request, refused: str) -> None:
        """Build the page before the log-in.

        Args:
            page: where.
            request: for it.
            refused: ``wrong`` or ``wait`` after a passphrase that was not taken.
        """
        words = page.words
        closed = self.closed_to(request)
        refusal = words.say(f"login.{refused}") if refused in {"wrong", "wait"} else ""
        with box("section", "login card"):
            Text("h1", words.say("operator.title"), "title")
            Text("p", words.say(closed or "login.what"), "small")
            if closed:
                return
            language = words.language
            with box("form", "login__form", method="post", action=f"{LOG_IN}?lang={language}"):
                Text("label", words.say("login.passphrase")).props["for"] = "passphrase"
                line = box("input", "field", id="passphrase", name="passphrase", type="password")
                line.props.update(
                    {"autocomplete": "current-password", "required": True, "autofocus": True}
                )
                if refusal:
                    line.props.update({"aria-invalid": "true", "aria-describedby": "refusal"})
                    with box("p", "login__refusal", id="refusal", role="alert"):
                        icon("warn")
                        Text("span", refusal)
                with box("button", "button button--strong", type="submit"):
                    Text("span", words.say("login.enter"))


def _back(request: Request, refused: str = "") -> RedirectResponse:
    language = request.query_params.get("lang", "")
    query = {"lang": language if language.isalpha() else "", "refused": refused}
    wanted = urlencode({name: value for name, value in query.items() if value})
    return RedirectResponse(f"/operator?{wanted}", status_code=_SEE_OTHER)


def _is_foreign(request: Request) -> bool:
    """Whether no page of this site sent the form. The guard has refused every other site's; what
    does not say where it comes from is no browser's form."""
    return "origin" not in request.headers
