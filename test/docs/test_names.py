"""No name of the package stands for two things."""

import ast
from collections import defaultdict
from pathlib import Path

PACKAGE = Path(__file__).parents[2] / "tissue_probe"
#: Pasted into kernels, of which each has names of its own.
TEMPLATES = PACKAGE / "estimation" / "templates"
#: Declared by each estimator that is written by hand: they are its interface.
OF_EVERY_ESTIMATOR = {"EXTRA", "FOLLOWS"}


def statements():
    """Yield each statement at the top of a module, with the module's path."""
    for path in sorted(PACKAGE.rglob("*.py")):
        if TEMPLATES not in path.parents:
            for statement in ast.parse(path.read_text(encoding="utf-8")).body:
                yield path.relative_to(PACKAGE).as_posix(), statement


def test_no_class_has_the_name_of_another():
    places = defaultdict(list)
    for path, statement in statements():
        if isinstance(statement, ast.ClassDef):
            places[statement.name].append(path)
    assert {name: found for name, found in places.items() if len(found) > 1} == {}


def test_constants_of_one_name_have_one_value():
    values = defaultdict(lambda: defaultdict(list))
    for path, statement in statements():
        targets = statement.targets if isinstance(statement, ast.Assign) else []
        if isinstance(statement, ast.AnnAssign) and statement.value is not None:
            targets = [statement.target]
        for target in targets:
            name = target.id if isinstance(target, ast.Name) else ""
            if name.isupper() and not name.startswith("_") and name not in OF_EVERY_ESTIMATOR:
                values[name][ast.unparse(statement.value)].append(path)
    several = {name: dict(found) for name, found in values.items() if len(found) > 1}
    assert several == {}


#: Participles that do not end in "ed", and are no verbs as they stand.
IRREGULAR = {
    "begun",
    "broken",
    "chosen",
    "done",
    "drawn",
    "driven",
    "felt",
    "forgotten",
    "found",
    "given",
    "gone",
    "heard",
    "held",
    "hidden",
    "kept",
    "known",
    "left",
    "lost",
    "made",
    "meant",
    "seen",
    "sent",
    "shaken",
    "shown",
    "taken",
    "told",
    "torn",
    "worn",
    "written",
}
#: A user's own rig or law imports these, as the documents show.
OF_USERS = {"composed", "driven_by_force", "pushed", "stretched", "tabulated"}


def is_participle(word):
    """Whether a word is one; "need" and "feed" are not."""
    return word in IRREGULAR or (word.endswith("ed") and len(word) > 4)


def test_functions_are_named_by_a_verb_or_a_noun_and_not_by_a_participle():
    named = {
        (path, statement.name)
        for path, statement in statements()
        if isinstance(statement, ast.FunctionDef | ast.AsyncFunctionDef)
    }
    bare = {
        (path, name)
        for path, name in named
        if name not in OF_USERS
        and not name.startswith("_")
        and (
            (first := name.split("_")[0]) in IRREGULAR or (first.endswith("ed") and len(first) > 4)
        )
    }
    assert bare == set()
