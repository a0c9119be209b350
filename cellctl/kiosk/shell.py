"""The frame around every view: name, connection, language, theme, and what spans them all."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from hashlib import sha256
from html import escape
from pathlib import Path
from typing import Final

from nicegui import ui

from cellctl.config import CellConfig
from cellctl.kiosk.bus_link import BusLink
from cellctl.kiosk.components import Text, attribute, box, icon, shown
from cellctl.kiosk.mirror import Mirror
from cellctl.kiosk.words import Words, languages

LOOK: Final = Path(__file__).parent / "look"
SHEETS: Final = ("kiosk", "visitor", "stage", "operator", "operator_panels")


@dataclass(frozen=True)
class Site:
    """What all pages share."""

    config: CellConfig
    link: BusLink

    @property
    def mirror(self) -> Mirror:
        """What is known of the cell."""
        return self.link.mirror


@dataclass
class Page:
    """One open page.

    Attributes:
        site: what it shares with the others.
        words: the labels in its language.
        visitor: the secret by which the cell knows this browser again; empty on a screen of the
            cell's own, where whoever stands before it is the visitor.
        views: what is called after every change.
    """

    site: Site
    words: Words
    visitor: str = ""
    views: list[Callable[[], None]] = field(default_factory=list)

    def follow(self, view: Callable[[], None]) -> None:
        """Have ``view`` called now and after every change, for as long as the page is open."""
        self.views.append(view)
        view()


@contextmanager
def shell(site: Site, language: str, title: str, *, role: str, visitor: str = "") -> Iterator[Page]:
    """A page's frame; the block builds the view inside its main part.

    Args:
        site: what all pages share.
        language: the one who looks wants; empty for the cell's.
        title: key of the view's name.
        role: ``visitor`` or ``operator``; the style sheet's class of the page.
        visitor: the browser's secret, for a page on which a visitor may act.
    """
    words = Words(language or site.config.dialogue.language)
    page = Page(site, words, visitor)
    ui.page_title(f"{words.say(title)} · {site.config.cell.name}")
    _head(words, site.config.kiosk.theme)
    with box("div", f"page page--{role}") as whole:
        Text("a", words.say("page.skip"), "skip").props["href"] = "#content"
        _bar(page)
        # The page library puts all of it into the page's main landmark.
        with box("div", "content", id="content", tabindex="-1"):
            yield page

    def changed() -> None:
        attribute(whole, "data-stale", "true" if site.mirror.stale else "false")
        for view in page.views:
            view()

    changed()
    ui.context.client.on_delete(site.mirror.watch(changed))


def _head(words: Words, theme: str) -> None:
    """Styles, and what must be known before anything is drawn."""
    sheets = "".join(
        f'<link rel="stylesheet" href="/look/{name}.css?{look_key()}">' for name in SHEETS
    )
    ui.add_head_html(
        f'{sheets}<script src="/look/page.js?{look_key()}" data-language="{words.language}" '
        f'data-theme="{theme}" data-lost="{escape(words.say("page.lost"))}" '
        f'data-back="{escape(words.say("page.lost_back"))}"></script>'
    )


@cache
def look_key() -> str:
    """Changes when a file of the look does, so that no browser keeps an old one."""
    digest = sha256()
    for file in sorted(LOOK.iterdir()):
        digest.update(file.read_bytes())
    return digest.hexdigest()[:12]


def _bar(page: Page) -> None:
    """The bar at the top."""
    words, mirror = page.words, page.site.mirror
    with box("header", "bar"):
        with box("div", "bar__name"):
            icon("cell")
            Text("span", page.site.config.cell.name)
        with box("div", "bar__link", role="status") as link:
            box("span", "bar__dot")
            said = Text("span")
        with box("nav", "bar__choices", aria_label=words.say("page.choose_language")):
            for code, name in languages().items():
                choice = Text("a", code.upper(), "bar__choice")
                choice.props.update({"href": f"?lang={code}", "lang": code, "aria-label": name})
                if code == words.language:
                    choice.props["aria-current"] = "true"
        with box(
            "button", "bar__theme", type="button", aria_label=words.say("page.theme")
        ) as theme:
            icon("theme")
        theme.on("click", js_handler="() => cellctl.theme()")

    def connection() -> None:
        known = mirror.snapshot is not None
        attribute(link, "data-link", "lost" if mirror.stale else "live")
        if not mirror.stale:
            said.say(words.say("page.live"))
        elif known:
            said.say(words.say("page.stale", age=duration(words, mirror.age_s)))
        else:
            said.say(words.say("page.connecting"))
        shown(link, True)

    page.follow(connection)


def duration(words: Words, seconds: float) -> str:
    """A length of time as people say it: seconds up to 90, then minutes."""
    if seconds < 90:
        return words.say("page.seconds", n=max(0, round(seconds)))
    return words.say("page.minutes", n=round(seconds / 60))
