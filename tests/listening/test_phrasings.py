"""Ways to put a wish or a command that no list holds: by the order and the kinds of words alone."""

from __future__ import annotations

import pytest

from cellctl.assembly import Intent
from cellctl.listening.commands import spoken_command
from cellctl.listening.understanding.embedded import EmbeddedInterpreter
from cellctl.listening.understanding.interpreter import DEFAULT_SETTING

THINGS = ("bench", "windmill")


@pytest.mark.parametrize("thing", THINGS)
@pytest.mark.parametrize(
    "sentence",
    [
        "without any paint please a {}",  # what it is like stands in front
        "a {} would fit in that corner",  # it is the subject
        "wouldn't a {} look splendid there",
        "we lack a {} can you make one",  # it was named before
        "there is needed a {}",  # it follows a passive
        "my class has voted for a {}",  # it was decided on
        "I'd be thrilled to bits with a {}",
        "it should be tall and become a {}",
        "not a wardrobe but a {}",
        "a castle scratch that a {}",
        "why don't you build a {}",
        "what we dream of at home is a {}",
        "our guide says you should make a {}",
        "is a {} doable",
        "we shall have the {}",
        "the last one the {}",
        "it would please me if you built a {}",
        "anything for the garden such as a {}",
        "two of us waited for hours so a {} please",
        "a {} small and red",  # it is described from behind
        "need {}",  # no subject, no article
        "urm I ehm want a {}",
        "carve me a {}",
        "if you could do a {} my son would be over the moon",  # a condition comes first
        "does it know how to build a {}",  # what looks like a question
        "anything really a {} perhaps",  # it stands for what was vague
        "it has always been our dream to own a {}",  # no rule knows it; its words tell
        "you wouldn't happen to have a {} would you",
    ],
)
def test_a_wish_in_any_order_is_one(sentence: str, thing: str) -> None:
    request = EmbeddedInterpreter().interpret(sentence.format(thing), DEFAULT_SETTING)
    assert request.intent is Intent.DESIGN
    assert request.objects[0] == thing
    assert request.phrase.split()[0] in (thing, "tall")


@pytest.mark.parametrize(
    "sentence",
    [
        "a {} would have cost us more yesterday",
        "with my uncle I built a {}",
        "they agreed on a {} last week",
        "a {} between hope and despair",
        "a {} and breakfast",
        "a tower of despair",
        "a letter to the editor",
        "nobody wants a {}",
        "I never liked a {}",
        "something to keep my sorrow in",
        "would you rather be a {}",
        "their neighbours keep a {} in the yard",
    ],
)
def test_the_same_order_may_tell_of_something(sentence: str) -> None:
    for thing in THINGS:
        request = EmbeddedInterpreter().interpret(sentence.format(thing), DEFAULT_SETTING)
        assert request.intent is not Intent.DESIGN


@pytest.mark.parametrize(
    ("sentence", "phrase"),
    [
        ("a desk big enough for two of us", "desk"),
        ("a crate fit for apples", "crate"),
        ("a ladder the height of my car", "ladder"),
        ("a stool with three uh four legs", "stool with four legs"),
        ("make a car oh no make a bench", "bench"),
        ("six of those crates", "six crates"),
        ("make a stool with three legs and paint it red", "stool with three legs"),
        ("build a desk. make it one metre wide", "desk"),
        ("a model of the bridge of london", "model of the bridge of london"),
        ("a leather-bound book with gold details", "leather bound book with gold details"),
        ("a white wedding gown", "white wedding gown"),  # nobody called White weds
        ("an umbrella left on a bench", "umbrella"),
        ("a bright red rose", "bright red rose"),  # it did not rise
        ("a guitar painted black", "guitar"),
        ("a plastic watering can filled with water", "plastic watering can"),
        ("some swimming goggles", "swimming goggles"),
    ],
)
def test_a_phrase_ends_where_something_else_is_said(sentence: str, phrase: str) -> None:
    request = EmbeddedInterpreter().interpret(sentence, DEFAULT_SETTING)
    assert (request.intent, request.phrase) == (Intent.DESIGN, phrase)


@pytest.mark.parametrize("quality", ["red", "plain", "three legged", "painted"])
def test_what_describes_a_thing_does_not_hide_how_many(quality: str) -> None:
    request = EmbeddedInterpreter().interpret(f"two {quality} stools", DEFAULT_SETTING)
    assert (request.count, request.objects) == (2, ("stool",))


@pytest.mark.parametrize(
    ("sentence", "what"),
    [
        *(("make it awfully tall", ("height", "+")), ("make it really very tall", ("height", "+"))),
        *(("make the legs thick", ("", "+")), ("cut the legs shorter", ("length", "-"))),
        *(("drop the height by five centimetres", ("height", "-")), ("make it stable", ("", "+"))),
        *(("just like that but lower", ("height", "-")), ("I'd like wider legs", ("width", "+"))),
        *(("increase the width by half", ("width", "+")), ("up by two blocks", ("height", "+"))),
        *(("the legs look odd make it lower", ("height", "-")), ("a little up", ("height", "+"))),
    ],
)
def test_what_changes_a_thing_may_be_said_with_any_verb(
    sentence: str, what: tuple[str, str]
) -> None:
    edits = EmbeddedInterpreter().interpret(sentence, DEFAULT_SETTING).edits
    assert [(edit.axis or "", edit.direction) for edit in edits] == [what]


@pytest.mark.parametrize(
    ("sentence", "command"),
    [
        *(("quit moving", "stop"), ("switch off the robot", "stop"), ("just a sec", "pause")),
        *(("carry on with the build", "resume"), ("call the whole thing off", "cancel")),
        *(("begin again from scratch", "cancel"), ("let's build that one", "yes")),
        *(("that looks just about right to me", "yes"), ("no, that is not what I said", "no")),
        *(("I couldn't hear you", "repeat"), ("do the same thing once more", "again")),
        *(("give me some other idea", "another"), ("can you help me out", "help")),
        *(("stop please it's falling over", "stop"), ("wait, somebody is too near", "pause")),
        *(("break all of it down", "take_apart"), ("no, show me another one", "another")),
    ],
)
def test_commands_vary_in_verb_object_and_haste(sentence: str, command: str) -> None:
    assert spoken_command(sentence) == command


@pytest.mark.parametrize(
    "sentence",
    ["start the car", "drop the ball", "that's a good dog", "take that to grandma", "go to bed",
     "shut the door", "keep on the path", "it's right over there", "a good one"],
)  # fmt: skip
def test_other_sentences_with_their_verbs_command_nothing(sentence: str) -> None:
    assert spoken_command(sentence) is None
